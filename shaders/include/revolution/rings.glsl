// Finds the pieces of a body of revolution that a ray may meet, by their bounding rings.
#include "kernel/invocation.glsl"
#include "revolution/ray.glsl"
#include "scene/revolutions.glsl"
#include "scene/scene.glsl"

// The part of a ray between two parameters, in the half plane of the profile.
struct RingRay {
    float k_min;
    float k_max;
    float p;       // height at k = 0
    float inverse; // 1 / slope of the height by k
    float a;       // the squared distance from the axis is a k^2 + b k + c
    float b;
    float c;
    float closest; // k of the closest approach to the axis
    float least;   // squared distance there
};

RingRay ring_ray(RevolutionRay ray, float t_min, float t_max) {
    // Bodies have k in [-1.5, 1.5]; the t_offset of a distant origin adds a rounding error.
    float most_k = 1.5 + 1.0e-6 * abs(k_of(ray, 0.0));
    float c = dot(ray.p.xy, ray.p.xy);
    return RingRay(max(k_of(ray, t_min), -most_k), min(k_of(ray, t_max), most_k), ray.p.z, ray.inverse, ray.a,
                   2.0 * ray.b, c, ray.closest, c + ray.closest * ray.b);
}

bool enters_ring(RingRay ray, vec4 ring) {
    bool rises = ray.inverse > 0.0;
    float near = ((rises ? ring.x : ring.y) - ray.p) * ray.inverse;
    float far = ((rises ? ring.y : ring.x) - ray.p) * ray.inverse;
    near = near > ray.k_min ? near : ray.k_min;
    far = far < ray.k_max ? far : ray.k_max;
    // The squared distance from the axis is convex in k.
    float rho2_near = near * (ray.a * near + ray.b) + ray.c;
    float rho2_far = far * (ray.a * far + ray.b) + ray.c;
    bool inside = rho2_near < ring.z && rho2_far < ring.z;
    bool passes = near >= ray.closest || far <= ray.closest || ray.least > ring.w;
    bool outside = rho2_near > ring.w && rho2_far > ring.w && passes;
    return near <= far && !inside && !outside;
}

// A set of pieces: a bit for each, counted from `first`.
struct Pieces {
    uint first;
    uvec4 mask;
};

bool is_empty(Pieces pieces) {
    return (pieces.mask.x | pieces.mask.y | pieces.mask.z | pieces.mask.w) == 0u;
}

// Removes the next piece of the set and returns it.
uint take_piece(inout Pieces pieces) {
    uint word = pieces.mask.x != 0u ? 0u : pieces.mask.y != 0u ? 1u : pieces.mask.z != 0u ? 2u : 3u;
    uint bits = word == 0u ? pieces.mask.x : word == 1u ? pieces.mask.y : word == 2u ? pieces.mask.z : pieces.mask.w;
    uvec4 words = uvec4(0u, 1u, 2u, 3u);
    pieces.mask = mix(pieces.mask, uvec4(bits & (bits - 1u)), equal(words, uvec4(word)));
    return pieces.first + 32u * word + findLSB(bits);
}

// The pieces of a body whose rings a ray enters. It tests the rings of all groups first, then the rings in
// the groups that the ray enters, where each lane visits its own groups.
Pieces pieces_met(RevolutionRay ray, uint first, uint count, float t_min, float t_max) {
    RingRay rings = ring_ray(ray, t_min, t_max);
    uint groups = 0u;
    for (uint i = 0u; GROUP * i < count; i++) {
        groups |= enters_ring(rings, revolution_pieces_at(first + GROUP * i).group_ring) ? 1u << i : 0u;
    }
    Pieces pieces = Pieces(first, uvec4(0u));
    while (groups != 0u) {
        uint piece = GROUP * findLSB(groups);
        groups &= groups - 1u;
        uint bits = 0u;
        [[unroll]] for (uint i = 0u; i < GROUP; i++) {
            bits |= enters_ring(rings, revolution_pieces_at(first + piece + i).ring) ? 1u << i : 0u;
        }
        // Pieces behind the last one belong to another body.
        bits = piece + GROUP > count ? bits & (1u << (count - piece)) - 1u : bits;
        pieces.mask |= mix(uvec4(0u), uvec4(bits << (piece & 31u)),
                           equal(uvec4(0u, 1u, 2u, 3u), uvec4(piece >> 5u)));
    }
    return pieces;
}
