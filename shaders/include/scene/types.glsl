// Every struct that crosses to the GPU. The build script writes its Rust twin.
// Lengths are in render units: the scene is moved to the origin and scaled to about
// unit size (src/upload.rs), so that fp32 serves every scene alike.

const uint NONE = 0xffffffffu;
const float INFINITY_T = 3.0e38; // t of a ray that nothing bounds
// Half a unit in the last place of 1: the largest relative rounding error.
const float ROUNDING = 5.9604644775390625e-8; // 2^-24

// Arrays that are read at random are in images of so many texels a row.
const uint TEXELS_PER_ROW = 4096u;

// Kinds of primitive: the top three bits of a primitive reference, the rest is an index.
const uint KIND_SHIFT = 29u;
const uint INDEX_MASK = 0x1fffffffu;
const uint TRIANGLE = 0u;
const uint SPHERE = 1u;
const uint DISK = 2u;
const uint REVOLUTION = 3u; // a piece of its profile
const uint INSTANCE = 4u;   // only in hierarchies; hits are of what is in it

// The material of a primitive: its index, and above it a bit for the layer that the primitive has
// among surfaces in contact (contact.glsl), or none.
const uint MATERIAL_MASK = 0x000fffffu;
const uint SHEET_LAYERS = 0x03f00000u;    // from front to back
const uint BOUNDARY_LAYERS = 0xfc000000u; // of dielectrics, which have an inside

// The deepest hierarchy that a ray can walk; the host builds no deeper one.
const uint MAX_BVH_DEPTH = 64u;

// References to children: a leaf's count of primitives in the top bits, below it the index
// of its first one; for an inner node count 0 and the index of its pair.
const uint COUNT_SHIFT = 28u;
const uint FIRST_MASK = 0x0fffffffu;
const uint MAX_LEAF_COUNT = 15u;
// No leaf: the end of the walk through an instance.
const uint LEAVE = 0xfffffffeu;

// The two children of an inner node of the bounding volume hierarchy. The references are
// bits in w of the lower corners: drivers load four components in one go.
struct BvhPair {
    vec4 left_lower;
    vec4 left_upper;
    vec4 right_lower;
    vec4 right_upper;
};

// The front side is where p0, p1, p2 run counter-clockwise.
struct Triangle {
    vec3 p0;
    uint material; // and its layer
    vec3 p1;
    uint light;   // index into lights, or NONE
    vec3 p2;
    uint normals; // index into triangle_normals, or NONE
};

// Shading normals at p0, p1, p2; w is unused.
struct TriangleNormals {
    vec4 n0;
    vec4 n1;
    vec4 n2;
};

// Texture coordinates at p0, p1, p2.
struct TriangleUvs {
    vec2 uv0;
    vec2 uv1;
    vec2 uv2;
    vec2 pad;
};

// A unit sphere about the origin, or a unit disk in the plane z = 0, in object space.
struct Quadric {
    vec4 object_from_render[3]; // rows
    vec4 render_from_object[3]; // rows
    uint material;      // and its layer
    uint light;         // index into lights, or NONE
    uint flipped;       // 1 where the normal is reversed
    float z_min;        // cuts of a sphere
    float z_max;
    float phi_max;      // radians
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
    uint root;    // pair of the object's hierarchy
    float error;  // of a ray's way in and a point's way out, render units
    float growth; // the most by which an error in object space grows
    uint pad;
};

// Pieces come in groups with a ring around all. Masks have a bit for each group and each
// piece of a body.
const uint GROUP = 4u;
const uint MAX_PIECES = 128u;

// A body of revolution about z, in unit space: radii up to 1, heights in [-1, 1]; or a part
// of one, where its profile has many pieces.
struct Revolution {
    vec4 unit_from_render[3]; // rows
    vec4 render_from_unit[3]; // rows
    uint first_piece;  // into revolution_pieces
    uint piece_count;  // up to MAX_PIECES
    uint material;     // and its layer
    uint flipped;      // 1 where the normal is reversed
    vec3 lower;        // corners of its box
    float determinant; // of render_from_unit, positive
    vec3 upper;
    uint pad;
};

// A stretch of a profile (u, v) = (radius, height) on which both are monotone, as
// polynomials in x in [-1, 1].
struct RevolutionPiece {
    vec4 ring;       // least and most height, squares of least and most radius; all widened
    vec4 group_ring; // the same of the group that begins here, if one does
    vec4 ends;       // u, v at x = -1 and at x = 1; neighbours share them to the bit
    vec2 curvature;  // bounds of |u''| and |v''|
    vec2 along;      // parameter of the whole profile at x = -1 and at x = 1, in [0, 1]
    uint body;       // index into revolutions
    uint light;      // index into lights, or NONE
    vec2 pad;
    vec4 coefficients[5]; // of u, v by powers of x: 0 and 1, 2 and 3, .., 8
};

// Coefficients of the square of a radius or height of degree 8.
const uint NEWTON_COEFFICIENTS = 17u;

// A whole segment of a profile, for the classical solver: revolution_newton.glsl.
struct RevolutionSegment {
    uint body;        // index into revolutions
    uint degree;      // of u^2 and v^2: twice the segment's own
    uint first_piece; // its pieces in revolution_pieces
    uint piece_count;
    uint first_start; // its vertices in newton_starts
    uint start_count;
    vec2 along;       // parameter of the whole profile at t = 0 and at t = 1, in [0, 1]
    vec4 powers[NEWTON_COEFFICIENTS]; // by powers of t in [0, 1]: coefficients of u^2, v^2, u, v
};

// A vertex of a piecewise linear approximation of a segment. Where t falls from one vertex
// to the next, another approximation begins.
struct NewtonStart {
    vec2 point; // u, v
    float t;    // parameter of the segment, in [0, 1]
    float pad;
};

const uint DIFFUSE = 0u;
const uint CONDUCTOR = 1u;
const uint DIELECTRIC = 2u;
const uint THIN_DIELECTRIC = 3u;
const uint DIFFUSE_TRANSMISSION = 4u;
const uint COATED_DIFFUSE = 5u;
const uint COATED_CONDUCTOR = 6u;
const uint MIX = 7u;
// The upper side of a coat: a lobe, never a whole material.
const uint COAT = 8u;

// Flags of materials.
const uint HAS_LAMBERTIAN = 1u; // some lobe is, so that photons are recorded
const uint BY_REFLECTANCE = 2u; // a metal whose color is its reflectance
const uint REMAPPED = 4u;       // textures of alpha hold its square
const uint REMAPPED_COAT = 8u;
const uint BEHIND = 16u;        // of a lobe: on the side away from wo

// Textures are indices or NONE; where there is one, it takes the place of the value.
struct Material {
    vec3 color;  // albedo; dielectric: transmittance of one crossing; metal: reflectance
    uint kind;
    vec3 eta;    // conductor: per channel; dielectric: inside over outside, in x
    float alpha_u; // roughness of GGX along the tangent; 0 is smooth
    vec3 k;      // conductor: absorption coefficient per channel
    float alpha_v; // and across
    vec3 second; // diffuse transmission: albedo on the other side
    float amount; // mix: chance of the second material; diffuse transmission: factor of textures
    float coat_eta; // inside over outside
    float coat_thickness; // optical
    float coat_alpha_u;
    float coat_alpha_v;
    float coat_sent_back; // of light that leaves what is under the coat: the part that comes back
    uint color_texture;
    uint second_texture;
    uint alpha_u_texture;
    uint alpha_v_texture;
    uint amount_texture;
    uint coat_u_texture;
    uint coat_v_texture;
    uint flags;
    uint first; // mix: indices of the two
    uint second_part;
    uint alpha_texture; // how much of the surface is there, or NONE: all
};

// What a node of a texture gives: a blend of its values,
const uint TEXTURE_CONSTANT = 0u;
const uint TEXTURE_BILINEAR = 1u;  // by the coordinates
const uint TEXTURE_CHECKS = 2u;    // of the first two, by the parity of the coordinates' cell
const uint TEXTURE_DIRECTION = 3u; // of the first two, by the cosine of the normal to a direction
// or texels of an image; or what it makes of values that it takes from the stack:
const uint TEXTURE_IMAGE = 4u;
const uint TEXTURE_MULTIPLY = 5u; // two
const uint TEXTURE_MIX = 6u;      // two, and an amount

// Values that a texture may have on its stack.
const uint TEXTURE_STACK = 8u;

// What texture coordinates come from: the surface's own, or its place.
const uint FROM_SURFACE = 0u;
const uint FROM_SPACE = 1u;
const uint FROM_ANGLES = 2u;   // of the place: polar angle and azimuth
const uint FROM_CYLINDER = 3u; // azimuth and height

const uint WRAP_REPEAT = 0u;
const uint WRAP_CLAMP = 1u;
const uint WRAP_BLACK = 2u;

// A texture is a run of nodes, each after what it is made of.
struct TextureNode {
    uint kind;
    uint from;
    uint last;    // 1 where the texture ends
    uint first;   // image: of its texels
    uint width;
    uint height;
    uint wrap;
    uint nearest; // 1 where texels are not interpolated
    vec4 to_coordinates[3]; // rows; direction: the first is it
    vec4 values[4]; // at (0, 0), (1, 0), (0, 1), (1, 1); image: offset, factor, least, most
};

const uint POINT = 0u;
const uint SPOT = 1u;
const uint DISTANT = 2u;
const uint INFINITE = 3u;
const uint AREA = 4u;
const uint SKY = 5u;         // infinite, of an image
const uint GONIOMETRIC = 6u; // a point whose intensity is an image
const uint PROJECTION = 7u;  // a point that projects an image

struct Light {
    vec3 emission;      // points: W/sr; distant: W/m^2; area, infinite: W/(m^2 sr); an image multiplies it
    uint kind;
    vec3 position;      // points; area: its middle
    uint primitive;     // area: a primitive reference; of an image: index into light_images
    vec3 direction;     // spot: axis; distant: the way the light travels
    float emission_pmf; // chance that a photon starts here
    float falloff_start; // spot: 1 - cos of the angle of full intensity; smooth falloff outside
    float falloff_end;  // spot: 1 - cos of the angle outside which it is dark
    float area;         // triangle and disk: area
    uint two_sided;     // area: emits on both sides
    float reach2;       // area: squared distance from there, within which it is large; 0 if no ray meets it
    uint image;         // area: a texture that the emission is times, or NONE
    float pad;
    float direct_pmf;   // chance that next-event estimation picks it
};

// What a light shows in each direction. Its texels are in light_texels: first one for each row,
// which choose a row, then row by row those that have a color.
struct LightImage {
    vec3 x_axis;      // of the image's space, in render space; unit vectors
    uint first;       // into light_texels
    vec3 y_axis;
    uint width;
    vec3 z_axis;
    uint height;
    vec2 half_extent; // projection: of the window that the image fills on the plane z = 1
    float average;    // of the texels' means of channels, as they are chosen
    float pad;
};

struct LightTexel {
    vec3 color;
    uint choice; // an entry of its row's alias table: alias in the top half, below it threshold
};

// One entry of an alias table (Vose 1991).
struct AliasEntry {
    float threshold; // below it take keep, above it alias
    uint keep;       // index into lights
    uint alias;      // index into lights
    uint pad;
};

struct SceneInfo {
    vec3 center;         // of the bounding sphere and box, render units
    float radius;        // of the bounding sphere
    vec3 infinite;       // radiance from infinitely far away, W/(m^2 sr)
    float mean_power;    // power of all lights, mean of channels, W: the unit of photon weight
    uint emission_count; // entries of emission_table
    uint direct_count;   // entries of direct_table
    uint max_depth;      // segments of a path
    uint seed;
    vec3 lights_center;  // a sphere around all places from which any area light is large
    float lights_reach2;
    vec3 contact_lower;  // corners of a box around all places where surfaces are in contact
    float contact_error; // the largest error of a position on such a surface
    vec3 contact_upper;
    uint sky_count;      // skies are the first of the lights
    vec3 half_extent;    // of the bounding box about the centre, widened
    uint pad;
};

// Cells of the pixel filter along an axis, of which a sample takes any with the same chance: so
// many that a few are in the negative lobes of a filter.
const uint FILTER_CELLS = 1023u;

// A camera with a thin lens. Camera space: x right, y up, z forward.
struct Camera {
    vec4 render_from_camera[3]; // rows
    vec2 image_lower;           // where the image begins: left, top; see projection.glsl
    vec2 image_extent;          // where it ends, less the beginning
    float lens_radius;
    float focal_distance;
    uint width;
    uint height;
};

// What happened, since it was last cleared. Each photon path ends in one of the five.
struct Counters {
    uint recorded;      // photons stored for the gather pass
    uint emitted;       // photon paths begun
    uint deposited;     // ended: absorbed where photons are stored
    uint absorbed;      // ended: absorbed at a specular surface or at emission
    uint escaped;       // ended: left the scene
    uint truncated;     // ended: reached the maximum depth
    uint lost_in_glass; // ended: found no way out of a dielectric
    uint eye_lost_in_glass;
    uint immersed;      // photon and eye paths that met something opaque in a dielectric
    uint non_finite;    // paths and pixels dropped for a value that is not finite
    uint saturated;     // sums and terms of sums that would not fit
    uint interrupted;   // invocations that the driver ended before they were done
    uint unfinished;    // invocations that wait for another dispatch
    uint stuck;         // invocations that wait for a dispatch in which they are alone
    uint cut;           // paths ended because the driver cannot follow them
};

// What is next for an invocation that follows paths: see interruption.glsl.
const uint FINISHED = 0u;
const uint UNFINISHED = 1u;
const uint STUCK = 2u;

// Where an invocation of the photon pass has got to.
struct PhotonPlace {
    vec3 origin; // of the path's next ray
    float index; // of the medium, over the one where the path began
    vec3 direction;
    uint depth;
    vec3 weight;
    uint photon; // to be started next; the path's own is the one before
    uint state;  // FINISHED, UNFINISHED or STUCK
    uint alive;  // 1 if there is a path
    float begin;   // of the ray, see contact.glsl
    uint contacts;
};

// Where an invocation of the eye pass has got to: a path that has met no diffuse surface yet.
struct EyePlace {
    vec3 origin;
    float index; // of the medium, over the camera's
    vec3 direction;
    float travelled; // length so far
    vec3 throughput;
    uint depth;
    vec3 radiance; // emission met so far, W/(m^2 sr)
    uint path;     // of the pixel
    vec3 last_position; // see rough_path.glsl
    float last_pdf;
    uint state;    // FINISHED, UNFINISHED or STUCK
    float begin;   // of the ray, see contact.glsl
    uint contacts;
    uint pad0;
};

// Where a pixel's eye path ended.
struct VisiblePoint {
    vec3 position;
    uint normal; // packed
};

// What a pixel remembers between iterations, besides the image.
struct PixelState {
    uint found_low;  // photons found so far, 64 bits
    uint found_high;
    float shrink;    // of the squared radius so far ..
    float rest;      // .. less what its rounding has left out
};

// A photon where it met a diffuse surface.
struct PhotonRecord {
    vec3 position;
    uint normal;  // packed, on the side that the photon came from
    vec3 weight;  // flux over the mean flux of a photon
    uint cell;    // of the hash grid: cell_mark
};

// A cell of the hash grid over photons.
struct Cell {
    uint first; // into grid_photons
    uint count;
};

// Where an invocation of gather_grid has got to. Those of a subgroup differ in the first
// only.
struct GridPlace {
    uint served; // 1 if its point has met all photons
    uint cell;   // of the neighbourhood: the first of those that the lanes look up together
    uint lane;   // whose cell is next
    uint entry;  // of that cell
};

// A node of the kd-tree: the pixel of its visible point, and above it the axis it splits.
const uint AXIS_SHIFT = 28u;
const uint PIXEL_MASK = 0x0fffffffu;

// A visible point as a node of the kd-tree.
struct TreePoint {
    vec3 position;
    float radius2;
    uint normal; // packed
    uint owner;  // pixel, and the axis above it
    uint pad0;
    uint pad1;
};

// Where an invocation of gather_tree has got to.
struct TreePlace {
    uint photon;
    uint node;    // to be taken next, counted from 1; 0 where the photon has none left
    uint pending; // see tree.glsl
};

// How a window shows radiance.
const uint CURVE_LINEAR = 0u; // as it is
const uint CURVE_SRGB = 1u;   // as a PNG has it
const uint CURVE_ACES = 2u;
const uint CURVE_AGX = 3u;
