// Primitives and the hierarchy over them. Lengths are in render units: the scene is moved to the
// origin and scaled to about unit size (src/gpu_scene/pack.rs), so that fp32 serves every scene alike.
#include "scene/features.glsl"

// A primitive reference has its kind in the bits from this one on, and an index below them.
export const uint KIND_SHIFT = 29u;
// The index of a primitive reference.
export const uint INDEX_MASK = 0x1fffffffu;
export const uint TRIANGLE = 0u;   // index into triangles
export const uint SPHERE = 1u;     // index into quadrics
export const uint DISK = 2u;       // index into quadrics
export const uint REVOLUTION = 3u; // index into revolution_pieces
export const uint INSTANCE = 4u;   // index into instances; only in hierarchies: hits are of what is in it

// The material of a primitive: its index in these bits, and above it a bit for the layer that the
// primitive has among surfaces in contact (contact.glsl), or none.
export const uint MATERIAL_MASK = 0x000fffffu;
export const uint SHEET_LAYERS = 0x03f00000u;    // layers from front to back
export const uint BOUNDARY_LAYERS = 0xfc000000u; // layers of dielectrics, which have an inside

// The deepest hierarchy that a ray can walk; the host builds no deeper one.
export const uint MAX_BVH_DEPTH = 64u;

// Inner nodes of a bounding volume hierarchy have up to WIDTH children, each with a box and a reference.
// From the bits of COUNT_SHIFT on, a reference has 0 for an inner node, the number of its triangles for a
// leaf of triangles, or one of the numbers below for a leaf of one primitive of another kind; and below
// those bits an index: of the node, of the first triangle, or of that primitive. Where there is no child,
// the reference is NONE and no ray enters the box.
export const uint BVH_WIDTH = 4u;
export const uint COUNT_SHIFT = 28u;        // of a reference to a child
export const uint FIRST_MASK = 0x0fffffffu; // the index in a reference to a child
export const uint MAX_LEAF_COUNT = 12u;     // triangles of a leaf
export const uint QUADRIC_LEAF = 13u;       // its index is that of a quadric
export const uint REVOLUTION_LEAF = 14u;    // of a body of revolution, or of a segment for the classical solver
export const uint INSTANCE_LEAF = 15u;      // of an instance
export const uint MAX_PRIMITIVES = 0x0ffffff0u; // no reference to an instance is NONE
export const uint MAX_BVH_NODES = 16777216u; // inner nodes: geometry/hierarchy.glsl stores them in 24 bits
// Planes of an inner node: of all children the lower x, y, z, then the upper x, y, z.
export const uint BVH_PLANES = 6u;

// The front side is where p0, p1, p2 run counter-clockwise.
struct Triangle {
    vec3 p0;      // first corner, render units
    uint material; // index into materials, and its layer
    vec3 p1;      // second corner
    uint light;   // index into lights, or NONE
    vec3 p2;      // third corner
    uint normals; // index into triangle_normals, or NONE
};

// Shading normals at p0, p1, p2; w is unused.
struct TriangleNormals {
    vec4 n0; // at p0
    vec4 n1; // at p1
    vec4 n2; // at p2
};

// Texture coordinates at p0, p1, p2.
struct TriangleUvs {
    vec2 uv0; // at p0
    vec2 uv1; // at p1
    vec2 uv2; // at p2
    vec2 pad;
};

// A unit sphere about the origin, or a unit disk in the plane z = 0, in object space.
struct Quadric {
    vec4 object_from_render[3]; // rows
    vec4 render_from_object[3]; // rows
    uint material;      // index into materials, and its layer
    uint light;         // index into lights, or NONE
    uint flipped;       // 1 where the normal is reversed
    float z_min;        // lower cut of a sphere, in [-1, 1]
    float z_max;        // upper cut of a sphere, in [-1, 1]
    float phi_max;      // the angle about z that there is of it, radians
    float inner_radius; // of a disk
    float determinant;  // of render_from_object, positive
    uint kind;          // SPHERE or DISK
    float size;         // the longest of render_from_object's rows
    uint pad0;
    uint pad1;
};

// A place where an object stands. The object has a hierarchy and a space of its own, made as
// render space is.
struct Instance {
    vec4 object_from_render[3]; // rows
    vec4 render_from_object[3]; // rows
    uint root;    // of the object's hierarchy: an inner node
    float error;  // of a ray's way in and a point's way out, render units
    float growth; // the most by which an error in object space grows
    uint pad;
};

// Whether a reference is of a kind; decided at compile time where it can be. Ask in this order.
bool is_instance(uint kind) {
    return HAS_INSTANCES && kind == INSTANCE;
}

bool is_triangle(uint kind) {
    if (HAS_CURVED) {
        return HAS_TRIANGLES && kind == TRIANGLE;
    }
    return true;
}

bool is_revolution(uint kind) {
    if (HAS_QUADRICS) {
        return HAS_REVOLUTIONS && kind == REVOLUTION;
    }
    return HAS_REVOLUTIONS;
}

bool is_sphere(uint kind) {
    if (HAS_DISKS) {
        return HAS_SPHERES && kind == SPHERE;
    }
    return HAS_SPHERES;
}
