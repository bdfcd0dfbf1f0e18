// Equal-area map between the sphere and the unit square (Clarberg 2008), in pbrt's orientation. The upper
// hemisphere is the diamond in the middle; the lower hemisphere is folded out into the corners.
#include "math/circle.glsl"
#include "math/sampling.glsl"

// The unit direction of a point of the square.
vec3 equal_area_direction(vec2 point) {
    vec2 p = 2.0 * point - 1.0;
    vec2 q = abs(p);
    float inside = 1.0 - (q.x + q.y); // negative in the corners
    float r = 1.0 - abs(inside);
    float phi = r == 0.0 ? 0.0 : ((q.y - q.x) / r + 1.0) * (PI / 4.0);
    float z = inside < 0.0 ? r * r - 1.0 : 1.0 - r * r;
    float radius = r * sqrt(max(2.0 - r * r, 0.0));
    vec2 around = radius * circle_point(phi);
    return vec3(p.x < 0.0 ? -around.x : around.x, p.y < 0.0 ? -around.y : around.y, z);
}

// Moves a point slightly outside of the square to the point inside with the same direction: each edge of
// the square is folded at its middle.
vec2 wrap_equal_area(vec2 point) {
    if (point.x < 0.0 || point.x > 1.0) {
        point = vec2(point.x < 0.0 ? -point.x : 2.0 - point.x, 1.0 - point.y);
    }
    if (point.y < 0.0 || point.y > 1.0) {
        point = vec2(1.0 - point.x, point.y < 0.0 ? -point.y : 2.0 - point.y);
    }
    return point;
}
