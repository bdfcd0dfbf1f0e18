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

struct Pieces {
    uint none;
};

RevolutionRay revolution_ray(uint body, Ray ray) {
    return RevolutionRay(body);
}

bool intersect_revolution(uint piece, RevolutionRay ray, float t_min, inout float t_max, inout float hit_x) {
    return false;
}

Pieces pieces_met(RevolutionRay ray, uint first, uint count, float t_min, float t_max) {
    return Pieces(0u);
}

bool intersect_pieces(Pieces candidates, RevolutionRay ray, float t_min, bool any_hit, inout float t_max,
                      inout float hit_x, out uint piece) {
    return false;
}

bool meet_segment(uint segment, Ray ray, inout Hit hit, inout uint primitive) {
    return false;
}

Profile load_profile(uint piece) {
    return Profile(vec4(0.0));
}

ProfilePoint evaluate_profile(Profile profile, float x) {
    return ProfilePoint(vec2(0.0), vec2(0.0));
}

vec2 profile_direction(Profile profile, ProfilePoint point) {
    return vec2(0.0);
}
