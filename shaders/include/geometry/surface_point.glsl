// A point of a surface.

struct Surface {
    vec3 position;
    float error;         // bound of the position's error, and of a ray that starts there
    vec3 normal;         // geometric, on the surface's front side
    vec3 shading_normal; // on the same side as the geometric one
    uint material;
    uint layer;          // of the primitive among surfaces in contact, or 0
    bool from_behind;    // the ray comes from a surface in contact that is behind this one
    uint light;          // index into lights, or NONE
    float area_pdf;      // of light from a body of revolution: with which this point is sampled
    vec2 uv;             // texture coordinates; only under HAS_TEXTURES
    vec3 tangent;        // the position's derivative by u, of any length; only under HAS_ANISOTROPIC
};

// Bound of the position's error along the normal: all three axes add up.
float normal_error(Surface surface) {
    return dot(abs(surface.normal), vec3(surface.error));
}
