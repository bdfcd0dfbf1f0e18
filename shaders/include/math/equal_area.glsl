// The sphere on the unit square, by equal areas: Clarberg 2008, in pbrt's orientation. The
// upper half is the diamond in the middle, the corners are the lower half folded out.
#include "math/sampling.glsl"

// Unit length, for a point of the square.
vec3 equal_area_direction(vec2 place) {
    vec2 p = 2.0 * place - 1.0;
    vec2 q = abs(p);
    float inside = 1.0 - (q.x + q.y); // negative in the corners
    float r = 1.0 - abs(inside);
    float phi = r == 0.0 ? 0.0 : ((q.y - q.x) / r + 1.0) * (PI / 4.0);
    float z = inside < 0.0 ? r * r - 1.0 : 1.0 - r * r;
    float radius = r * sqrt(max(2.0 - r * r, 0.0));
    vec2 around = radius * vec2(cos(phi), sin(phi));
    return vec3(p.x < 0.0 ? -around.x : around.x, p.y < 0.0 ? -around.y : around.y, z);
}

// A point a little outside of the square, in the square: its edges are folded halfway.
vec2 wrap_equal_area(vec2 place) {
    if (place.x < 0.0 || place.x > 1.0) {
        place = vec2(place.x < 0.0 ? -place.x : 2.0 - place.x, 1.0 - place.y);
    }
    if (place.y < 0.0 || place.y > 1.0) {
        place = vec2(1.0 - place.x, place.y < 0.0 ? -place.y : 2.0 - place.y);
    }
    return place;
}
