// A ray as bodies of revolution see it.
#include "geometry/contact.glsl"
#include "geometry/quadric.glsl"
#include "scene/constants.glsl"
#include "scene/scene.glsl"

// A ray that rises by less keeps its height.
const float SMALLEST_RISE = 1.0e-15;

// A ray about its closest approach to a body's centre, in the body's unit space.
struct RevolutionRay {
    uint body;      // index into revolutions
    Ray whole;      // in the space that the body stands in
    float size;     // length of the ray's direction before it was made a unit vector
    vec3 p;
    vec3 d;         // of unit length
    float t_offset; // ray parameter of p; another point's is t_offset + k / size
    float a;        // |d.xy|^2
    float root_a;
    float inverse_a;
    float b;        // p.xy . d.xy
    float closest;  // k of the closest approach to the axis
    float moment;   // |p.xy x d.xy|
    float inverse;  // of d.z, or of next to nothing
    float border;   // the radius up to which A is solved, and from which on B
};

// What rounding takes from products a * b, exactly (Dekker 1971), with or without fused
// multiplication and addition.
vec3 product_error(vec3 a, float b, vec3 product) {
    precise vec3 a_big = 4097.0 * a;
    precise vec3 a_high = a_big - (a_big - a);
    precise vec3 a_low = a - a_high;
    precise float b_big = 4097.0 * b;
    precise float b_high = b_big - (b_big - b);
    precise float b_low = b - b_high;
    precise vec3 error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    return error;
}

RevolutionRay revolution_ray(uint body, Ray world) {
    vec3 o = transform_point(revolutions_at(body).unit_from_render, world.origin);
    vec3 d = transform_vector(revolutions_at(body).unit_from_render, world.direction);
    RevolutionRay ray;
    ray.body = body;
    ray.whole = world;
    ray.size = length(d);
    ray.t_offset = -dot(o, d) / dot(d, d);
    // A far origin must not cost digits: neither the product nor a unit vector's rounding may
    // be multiplied by its distance.
    precise vec3 way = ray.t_offset * d;
    precise vec3 p = (o + way) + product_error(d, ray.t_offset, way);
    ray.p = p;
    ray.d = d / ray.size;
    // Squares of less would be nothing.
    ray.d.xy = dot(ray.d.xy, ray.d.xy) < 1.0e-24 ? vec2(0.0) : ray.d.xy;
    ray.d.z = abs(ray.d.z) < SMALLEST_RISE ? 0.0 : ray.d.z;
    ray.a = dot(ray.d.xy, ray.d.xy);
    ray.root_a = sqrt(ray.a);
    ray.inverse_a = ray.a > 0.0 ? 1.0 / ray.a : 0.0;
    ray.b = dot(ray.p.xy, ray.d.xy);
    ray.moment = abs(ray.p.x * ray.d.y - ray.p.y * ray.d.x);
    ray.closest = -ray.b * ray.inverse_a;
    ray.inverse = 1.0 / (ray.d.z == 0.0 ? SMALLEST_RISE : ray.d.z);
    // The hyperbola's slope is 1 there. A ray that is steeper everywhere has A alone.
    float rest = ray.a - ray.d.z * ray.d.z;
    ray.border = rest > 0.0 ? ray.moment * inversesqrt(rest) : INFINITY_T;
    return ray;
}

// Where a ray parameter is, from the closest approach and as a length.
float k_of(RevolutionRay ray, float t) {
    return (t - ray.t_offset) * ray.size;
}
