// What the scene requires. Kernels are compiled for the scene at hand: what it has
// not, costs nothing. Set in src/gpu_scene/pack.rs. naga reads no operation on specialization
// constants alone, so their combinations are constants too, and `!X` is an else.
layout(constant_id = 0) const bool HAS_TRIANGLES = true;
layout(constant_id = 1) const bool HAS_SPHERES = true;
layout(constant_id = 2) const bool HAS_DISKS = true;
layout(constant_id = 3) const bool HAS_CUT_SPHERES = true;
layout(constant_id = 4) const bool HAS_SHADING_NORMALS = true;
layout(constant_id = 5) const bool HAS_CONDUCTORS = true;
layout(constant_id = 6) const bool HAS_DIELECTRICS = true;
#ifdef WITHOUT_HAS_REVOLUTIONS
const bool HAS_REVOLUTIONS = false;
#else
layout(constant_id = 7) const bool HAS_REVOLUTIONS = true;
#endif
layout(constant_id = 8) const bool HAS_SPOT_LIGHTS = true;
layout(constant_id = 9) const bool HAS_DISTANT_LIGHTS = true;
layout(constant_id = 10) const bool HAS_INFINITE_LIGHTS = true; // constant ones or skies
layout(constant_id = 11) const bool HAS_AREA_LIGHTS = true;
layout(constant_id = 12) const bool HAS_QUADRICS = true;        // spheres or disks
layout(constant_id = 13) const bool HAS_SPECULAR = true;        // conductors or dielectrics
layout(constant_id = 14) const bool HAS_LOCATABLE_LIGHTS = true; // any but constant infinite ones
layout(constant_id = 15) const bool HAS_HITTABLE_LIGHTS = true; // area or infinite ones
layout(constant_id = 16) const bool HAS_CURVED = true;          // any but triangles
layout(constant_id = 17) const uint REVOLUTION_PAIRS = 5u;      // of powers in the highest polynomial of any profile
layout(constant_id = 18) const bool REVOLUTION_NEWTON = false;  // rays meet whole segments, by the classical solver
layout(constant_id = 19) const bool DIRECT_NEE = true;          // direct light is not the photons' affair
layout(constant_id = 22) const bool IS_FLAT = false;            // so few primitives that a hierarchy costs more than it saves
layout(constant_id = 23) const uint FLAT_TRIANGLES = 0u;        // how many, then
layout(constant_id = 24) const uint FLAT_QUADRICS = 0u;
layout(constant_id = 25) const bool HAS_TRIANGLE_LIGHTS = true;
layout(constant_id = 26) const bool HAS_SPHERE_LIGHTS = true;
layout(constant_id = 27) const bool HAS_DISK_LIGHTS = true;
layout(constant_id = 28) const bool HAS_REVOLUTION_LIGHTS = true;
layout(constant_id = 29) const uint FLAT_REVOLUTIONS = 0u;
#ifdef WITHOUT_HAS_CONTACTS
const bool HAS_CONTACTS = false;
#else
layout(constant_id = 72) const bool HAS_CONTACTS = true;        // surfaces of different bodies that coincide
#endif
// What plain scenes have none of, all at once: see SEPARATE in shaders/build.rs. The GLSL compiler
// keeps branches on constants: code that is long is left out by the macro.
#ifdef WITHOUT_IS_RICH
const bool IS_RICH = false;
const bool HAS_ROUGH = false;
const bool HAS_COATS = false;
const bool HAS_THIN = false;
const bool HAS_DIFFUSE_TRANSMISSION = false;
const bool HAS_MIXES = false;
const bool HAS_LAYERS = false;
const bool HAS_ANISOTROPIC = false;
const bool HAS_SKIES = false;
const bool HAS_GONIOMETRIC_LIGHTS = false;
const bool HAS_PROJECTION_LIGHTS = false;
const bool HAS_INSTANCES = false;
const bool IS_ORTHOGRAPHIC = false;
const bool IS_SPHERICAL = false;
const bool IS_EQUAL_AREA = false;
#else
layout(constant_id = 70) const bool IS_RICH = true; // any of these:
layout(constant_id = 30) const bool HAS_ROUGH = false;          // conductors, dielectrics or coats that are
layout(constant_id = 31) const bool HAS_COATS = false;
layout(constant_id = 32) const bool HAS_THIN = false;           // panes of glass without thickness
layout(constant_id = 33) const bool HAS_DIFFUSE_TRANSMISSION = false;
layout(constant_id = 34) const bool HAS_MIXES = false;
layout(constant_id = 36) const bool HAS_LAYERS = false;         // any material of several lobes: coats, mixes, diffuse transmission
layout(constant_id = 50) const bool HAS_SKIES = true;
layout(constant_id = 51) const bool HAS_GONIOMETRIC_LIGHTS = true;
layout(constant_id = 52) const bool HAS_PROJECTION_LIGHTS = true;
layout(constant_id = 67) const bool IS_ORTHOGRAPHIC = false;   // of the camera
layout(constant_id = 68) const bool IS_SPHERICAL = false;      // it sees all directions ..
layout(constant_id = 69) const bool IS_EQUAL_AREA = false;     // .. by equal areas, not by angles
layout(constant_id = 60) const bool HAS_INSTANCES = true;
layout(constant_id = 35) const bool HAS_ANISOTROPIC = true;      // roughness that differs by direction
#endif
#ifdef WITHOUT_HAS_TEXTURES
const bool HAS_TEXTURES = false;
#else
layout(constant_id = 40) const bool HAS_TEXTURES = true;         // and what only textures bring:
layout(constant_id = 41) const bool HAS_ALPHA = true;            // surfaces that are cut away in part
layout(constant_id = 42) const bool HAS_IMAGE_EMITTERS = true;
layout(constant_id = 43) const bool HAS_IMAGE_TEXTURES = true;
layout(constant_id = 44) const bool HAS_TEXTURE_TREES = true;    // textures of more than one node
#endif
// Kernels that follow paths: invocations go on in further dispatches where a driver limits
// loops. Not of the scene: see interruption.glsl.
#ifdef WITHOUT_IS_RESUMABLE
const bool IS_RESUMABLE = false;
#else
layout(constant_id = 71) const bool IS_RESUMABLE = false;
#endif

// Which kind of primitive a reference names; decided at compile time where it can be. Ask
// in this order.
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
