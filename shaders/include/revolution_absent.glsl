// What kernels call of revolution.glsl, for scenes that have no such bodies: nothing is
// called, and drivers see no code.

struct RevolutionRay {
    uint body;
};

struct Profile {
    vec4 ends;
};

struct ProfilePoint {
    vec2 p;
    vec2 d;
};

RevolutionRay revolution_ray(uint body, Ray ray) {
    return RevolutionRay(body);
}

float k_of(RevolutionRay ray, float t) {
    return t;
}

bool misses_ring(RevolutionRay ray, vec4 ends, float k_min, float k_max) {
    return true;
}

bool intersect_revolution(uint piece, RevolutionRay ray, float t_min, inout float t_max, inout float hit_x) {
    return false;
}

bool meet_segment(uint segment, Ray ray, inout Hit hit, inout uint primitive) {
    return false;
}

Profile load_profile(uint piece) {
    return Profile(vec4(0.0));
}

ProfilePoint evaluate(Profile profile, float x) {
    return ProfilePoint(vec2(0.0), vec2(0.0));
}

vec2 profile_direction(Profile profile, ProfilePoint point) {
    return vec2(0.0);
}
