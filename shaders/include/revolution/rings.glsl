// Which pieces of a body of revolution a ray may meet: by the rings that they turn in.
#include "kernel/invocation.glsl"
#include "revolution/ray.glsl"
#include "scene/revolutions.glsl"
#include "scene/scene.glsl"

// A ray's stretch between two parameters, as rings see it.
struct RingRay {
    float k_min;
    float k_max;
    float p;       // height
    float inverse; // of the rise
    float a;       // squared distance from the axis by k: a k^2 + b k + c
    float b;
    float c;
    float closest;
    float least;   // of the squared distance
};

RingRay ring_ray(RevolutionRay ray, float t_min, float t_max) {
    // Of a far origin, t_offset has a rounding error.
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

// Pieces from a first one: a bit for each.
struct Pieces {
    uint first;
    uvec4 mask;
};

bool is_empty(Pieces pieces) {
    return (pieces.mask.x | pieces.mask.y | pieces.mask.z | pieces.mask.w) == 0u;
}

// Takes the next one out.
uint take_piece(inout Pieces pieces) {
    uint word = pieces.mask.x != 0u ? 0u : pieces.mask.y != 0u ? 1u : pieces.mask.z != 0u ? 2u : 3u;
    uint bits = word == 0u ? pieces.mask.x : word == 1u ? pieces.mask.y : word == 2u ? pieces.mask.z : pieces.mask.w;
    uvec4 words = uvec4(0u, 1u, 2u, 3u);
    pieces.mask = mix(pieces.mask, uvec4(bits & (bits - 1u)), equal(words, uvec4(word)));
    return pieces.first + 32u * word + findLSB(bits);
}

// The pieces of a body whose rings a ray enters: of all groups first, then of those that it
// meets, where each lane goes over its own.
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
        // What comes behind the last one is another body's.
        bits = piece + GROUP > count ? bits & (1u << (count - piece)) - 1u : bits;
        pieces.mask |= mix(uvec4(0u), uvec4(bits << (piece & 31u)),
                           equal(uvec4(0u, 1u, 2u, 3u), uvec4(piece >> 5u)));
    }
    return pieces;
}
