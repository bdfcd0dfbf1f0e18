// Rays in the unit space of a body of revolution.
#include "geometry/contact.glsl"
#include "geometry/quadric.glsl"
#include "scene/constants.glsl"
#include "scene/scene.glsl"

// A ray whose direction has a smaller z component is horizontal.
const float SMALLEST_RISE = 1.0e-15;

// A ray in a body's unit space, with its origin p moved to the point closest to the body's centre. The
// ray parameter k counts from p, in units of length.
struct RevolutionRay {
    uint body;      // index into revolutions
    Ray whole;      // in the space that contains the body
    float size;     // length of the ray's direction in unit space
    vec3 p;
    vec3 d;         // direction, a unit vector
    float t_offset; // t of p; the t of another point is t_offset + k / size
    float a;        // |d.xy|^2
    float root_a;
    float inverse_a;
    float b;        // p.xy . d.xy
    float closest;  // k of the closest approach to the axis
    float moment;   // |p.xy x d.xy|
    float inverse;  // 1 / d.z, finite also where d.z is 0
    float border;   // radius that separates the domains: A below it, B above it
};

// The exact rounding error of products a * b (Dekker 1971), with or without fused multiply-adds.
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
    // A distant origin must cost no digits: the rounding of the product is added back, and the direction
    // is not normalised before it is multiplied by the distance.
    precise vec3 way = ray.t_offset * d;
    precise vec3 p = (o + way) + product_error(d, ray.t_offset, way);
    ray.p = p;
    ray.d = d / ray.size;
    // Squares of smaller components would underflow.
    ray.d.xy = dot(ray.d.xy, ray.d.xy) < 1.0e-24 ? vec2(0.0) : ray.d.xy;
    ray.d.z = abs(ray.d.z) < SMALLEST_RISE ? 0.0 : ray.d.z;
    ray.a = dot(ray.d.xy, ray.d.xy);
    ray.root_a = sqrt(ray.a);
    ray.inverse_a = ray.a > 0.0 ? 1.0 / ray.a : 0.0;
    ray.b = dot(ray.p.xy, ray.d.xy);
    ray.moment = abs(ray.p.x * ray.d.y - ray.p.y * ray.d.x);
    ray.closest = -ray.b * ray.inverse_a;
    ray.inverse = 1.0 / (ray.d.z == 0.0 ? SMALLEST_RISE : ray.d.z);
    // The slope of the hyperbola is 1 at the border. A ray without such a point has equation A only.
    float rest = ray.a - ray.d.z * ray.d.z;
    ray.border = rest > 0.0 ? ray.moment * inversesqrt(rest) : INFINITY_T;
    return ray;
}

// The ray parameter k of a t.
float k_of(RevolutionRay ray, float t) {
    return (t - ray.t_offset) * ray.size;
}
