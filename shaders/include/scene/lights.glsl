// Lights.

export const uint POINT = 0u;       // a point of constant intensity
export const uint SPOT = 1u;        // a point with a cone
export const uint DISTANT = 2u;     // parallel light
export const uint INFINITE = 3u;    // constant radiance from all directions
export const uint AREA = 4u;        // a primitive that emits
export const uint SKY = 5u;         // infinite, of an image
export const uint GONIOMETRIC = 6u; // a point whose intensity is an image
export const uint PROJECTION = 7u;  // a point that projects an image
export const uint PORTAL = 8u;      // infinite, of an image that is seen through a rectangle

// A light. Lengths are in render units.
struct Light {
    vec3 emission;      // points: W/sr; distant: W/m^2; area, infinite: W/(m^2 sr); an image multiplies it
    uint kind;          // POINT, SPOT, ..
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
    uint medium;        // points: index into media
    float direct_pmf;   // chance that next-event estimation picks it
};

// What a light shows in each direction. Its texels are in light_texels: first one for each row,
// which choose a row, then row by row those that have a color. A portal's: portal.glsl.
struct LightImage {
    vec3 x_axis;      // x axis of the image's space, in render space; of unit length
    uint first;       // into light_texels
    vec3 y_axis;      // y axis
    uint width;       // texels in a row
    vec3 z_axis;      // z axis
    uint height;      // rows
    vec2 half_extent; // projection: of the window that the image fills on the plane z = 1
    float average;    // of the texels' means of channels, as they are chosen
    float pad;
};

// A texel of a light's image.
struct LightTexel {
    vec3 color;  // linear RGB
    uint choice; // an entry of its row's alias table: alias in the top half, below it threshold; with a guide, the
                 // chance of this texel and those before it in the row, times 2^32
};

// One entry of an alias table (Vose 1991).
struct AliasEntry {
    float threshold; // below it take keep, above it alias
    uint keep;       // index into lights
    uint alias;      // index into lights
    float chance;    // of the index of this entry, in a table with a guide that has an entry for each light
};
