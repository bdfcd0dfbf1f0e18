// Rays against what is there of the surfaces.

#ifndef WITHOUT_HAS_TEXTURES
// Surfaces that a ray passes where they are cut away, at most; the next one stops it.
const uint MAX_CUT_SURFACES = 64u;

// Whether a surface lets a ray pass. By a hash of the ray, as in pbrt: the next surface gets
// another number, since the ray begins elsewhere then.
bool lets_pass(Surface surface, Ray ray) {
    uvec3 bits = pcg3d(floatBitsToUint(ray.origin));
    bits = pcg3d(bits ^ floatBitsToUint(ray.direction));
    return to_unit(bits.x) >= opacity(surface);
}

// The nearest hit with t < t_max on what is there. A ray goes on behind a surface that lets it
// pass.
Hit intersect_opaque(Ray ray, float t_max) {
    Hit hit = traverse(ray, t_max, false);
    vec3 begin = ray.origin;
    bool passes = hit.primitive != NONE;
    for (uint i = 0u; i < MAX_CUT_SURFACES && passes; i++) {
        Surface surface = surface_at(ray, hit);
        passes = lets_pass(surface, ray);
        if (passes) {
            ray.origin = offset_origin(surface, ray.direction);
            float passed = dot(ray.origin - begin, ray.direction) / dot(ray.direction, ray.direction);
            hit = traverse(ray, t_max - passed, false);
            passes = hit.primitive != NONE;
        }
    }
    // In lengths of the direction from where the ray began.
    hit.t += dot(ray.origin - begin, ray.direction) / dot(ray.direction, ray.direction);
    return hit;
}

#endif

Hit intersect(Ray ray) {
#ifndef WITHOUT_HAS_TEXTURES
    if (HAS_ALPHA) {
        return intersect_opaque(ray, INFINITY_T);
    }
#endif
    return traverse(ray, INFINITY_T, false);
}

// Whether anything stands between a point and another; both already offset.
bool occluded(vec3 from, vec3 to) {
    Ray ray = Ray(from, to - from);
#ifndef WITHOUT_HAS_TEXTURES
    if (HAS_ALPHA) {
        return intersect_opaque(ray, 1.0).primitive != NONE;
    }
#endif
    return traverse(ray, 1.0, true).primitive != NONE;
}
