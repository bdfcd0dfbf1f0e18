// What kernels need to know of a scene besides its arrays.

// A scene as a whole. Lengths are in render units.
struct SceneInfo {
    vec3 center;         // of the bounding sphere and box, render units
    float radius;        // of the bounding sphere
    vec3 infinite;       // radiance from infinitely far away, W/(m^2 sr)
    float mean_power;    // power of all lights, mean of channels, W: the unit of photon weight
    uint emission_count; // entries of emission_table
    uint direct_count;   // entries of direct_table
    uint max_depth;      // segments of a path
    uint seed;           // of the random numbers
    vec3 lights_center;  // center of a sphere around all places from which any area light is large
    float lights_reach2; // its squared radius
    vec3 contact_lower;  // lower corner of a box around all places where surfaces are in contact
    float contact_error; // the largest error of a position on such a surface
    vec3 contact_upper;  // upper corner of that box
    uint sky_count;      // skies are the first of the lights
    vec3 half_extent;    // of the bounding box about the centre, widened
    uint camera_medium;  // index into media
    uint colors;         // HAS_DISPERSION: first element in texture_texels of the colors of wavelengths
    uint infinite_colors; // HAS_DISPERSION: of their colors in `infinite`
    uint light_colors;   // HAS_LIGHT_SPECTRA: of the first elements of the colors of each light, four to an element
    uint pad0;
};
