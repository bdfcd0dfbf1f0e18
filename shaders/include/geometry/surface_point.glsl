// A point of a surface.

// Derivatives of a surface by its texture coordinates, render units. On triangles with normals at their corners,
// those of the position are in the plane of the shading normal.
struct Derivatives {
    vec3 dp_du; // of the position
    vec3 dp_dv;
    vec3 dn_du; // of the shading normal
    vec3 dn_dv;
};

struct Surface {
    vec3 position;
    float error;         // bound of the position's error per axis, also for a ray that starts there, render units
    vec3 normal;         // geometric normal, on the front side of the surface
    vec3 shading_normal; // on the same side as the geometric normal
    uint material;
    uint layer;          // of the primitive among surfaces in contact, or 0
    bool from_behind;    // the ray started at a sheet in contact that is behind this one
    uint light;          // index into lights, or NONE
    float area_pdf;      // body of revolution that is a light: pdf by area of sampling this point
    vec2 uv;             // texture coordinates; only under HAS_TEXTURES
    uvec2 media;         // on the front and on the back; only under HAS_MEDIA, once it is set: medium.glsl
    vec3 tangent;        // along the derivative of the position by u, of any length; only under HAS_ANISOTROPIC
    Derivatives by_uv;   // only under HAS_BUMPS
};

// Bound of the position's error along the normal: the sum of the errors of all three axes.
float normal_error(Surface surface) {
    return dot(abs(surface.normal), vec3(surface.error));
}
