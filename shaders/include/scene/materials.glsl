// Materials and textures.

export const uint DIFFUSE = 0u;              // Lambertian
export const uint CONDUCTOR = 1u;            // a metal
export const uint DIELECTRIC = 2u;           // glass and liquids, which have an inside
export const uint THIN_DIELECTRIC = 3u;      // a pane without thickness
export const uint DIFFUSE_TRANSMISSION = 4u; // Lambertian on both sides
export const uint COATED_DIFFUSE = 5u;       // a coat over a Lambertian base
export const uint COATED_CONDUCTOR = 6u;     // a coat over a metal
export const uint MIX = 7u;                  // one of two materials, by chance
export const uint COAT = 8u;                 // the upper side of a coat: a lobe, never a whole material
export const uint INTERFACE = 9u;            // nothing: a surface that only bounds media
export const uint MEASURED = 10u;            // measured, by tables

// Flags of materials.
export const uint HAS_LAMBERTIAN = 1u; // some lobe is Lambertian, so that photons are recorded
export const uint BY_REFLECTANCE = 2u; // a metal whose color is its reflectance
export const uint REMAPPED = 4u;       // textures of alpha hold its square
export const uint REMAPPED_COAT = 8u;  // textures of the coat's alpha hold its square
export const uint BEHIND = 16u;        // of a lobe: on the side away from wo
export const uint DISPLACED = 32u;     // bump_texture is a height, which bends the shading normal
export const uint NORMAL_MAPPED = 64u; // bump_texture is the shading normal
export const uint SCATTERING_COAT = 128u; // a coat that scatters light inside
export const uint HAS_FACETS = 256u;   // HAS_ROUGH_GATHER: some lobe is rough, so that photons are recorded for it
export const uint DISPERSIVE = 512u;   // eta, or a coat's coat_eta, is a mean: the index depends on the wavelength

// A surface's material. Textures are indices or NONE; where there is one, it takes the place of the value.
struct Material {
    vec3 color;  // albedo; dielectric: transmittance of one crossing; metal: reflectance
    uint kind;   // DIFFUSE, CONDUCTOR, ..
    vec3 eta;    // conductor: per channel; dielectric: inside over outside, in x; scattering coat: coat_table.glsl
    float alpha_u; // roughness of GGX along the tangent; 0 is smooth
    vec3 k;      // conductor: absorption coefficient per channel; scattering coat: coat_table.glsl
    float alpha_v; // roughness across the tangent
    vec3 second; // diffuse transmission: albedo on the other side; scattering coat: its inside's albedo
    float amount; // mix: chance of the second material; diffuse transmission, coat: factor of textures; scattering
                  // coat: mean cosine of the angle of scattering
    float coat_eta; // inside over outside
    float coat_thickness; // optical
    float coat_alpha_u; // roughness of the coat along the tangent
    float coat_alpha_v; // roughness of the coat across the tangent
    float coat_sent_back; // of light that leaves what is under the coat: the part that comes back
    uint color_texture;   // of color
    uint second_texture;  // of second
    uint alpha_u_texture; // of alpha_u
    uint alpha_v_texture; // of alpha_v
    uint amount_texture;  // of amount; coat: of coat_thickness
    uint coat_u_texture;  // of coat_alpha_u
    uint coat_v_texture;  // of coat_alpha_v
    uint flags;           // HAS_LAMBERTIAN | ..
    uint first;         // mix: index of the first material; measured: first of its elements in texture_texels;
                        // scattering coat: texture of amount
    uint second_part;   // mix: index of the second material; measured: 1 if it is anisotropic; coat: first element
                        // of its table
    uint alpha_texture; // how much of the surface is there, or NONE: all
    uint bump_texture;  // where DISPLACED or NORMAL_MAPPED
    float bump_scale;   // render units of a unit of the height
    uint indices;       // DISPERSIVE: first element of the indices of refraction in texture_texels
    uint pad0;
};

// Ranges of wavelengths of the same chance, for dispersion: wavelength.glsl.
export const uint BANDS = 512u;

// Tables of coats by their thickness: the first entry is for 0.
export const uint COAT_FINEST = 8u;   // the second entry is for a thickness of 2^-COAT_FINEST
export const uint COAT_OCTAVES = 12u; // from there to the last entry
export const uint COAT_STEPS = 4u;    // entries in each octave
export const uint COAT_ALBEDOS = 12u; // by a textured albedo
export const uint COAT_PHASES = 13u;  // by a textured mean cosine of the angle of scattering

// Kinds of nodes of a texture. Some give a value,
export const uint TEXTURE_CONSTANT = 0u;  // the first of its values
export const uint TEXTURE_BILINEAR = 1u;  // a blend of its values by the coordinates
export const uint TEXTURE_CHECKS = 2u;    // one of the first two values, by the parity of the coordinates' cell
export const uint TEXTURE_DIRECTION = 3u; // a blend of the first two values, by the cosine of the normal to a direction
export const uint TEXTURE_IMAGE = 4u;     // texels of an image
// others take values from the stack.
export const uint TEXTURE_MULTIPLY = 5u;  // multiplies two values from the stack
export const uint TEXTURE_MIX = 6u;       // blends two values from the stack by an amount, the third
// Noise gives values, too.
export const uint TEXTURE_DOTS = 7u;      // the second of its values in a disc, the first around it
export const uint TEXTURE_FBM = 8u;       // the sum of octaves; kinds from here on have octaves
export const uint TEXTURE_WRINKLED = 9u;  // the sum of the magnitudes of octaves
export const uint TEXTURE_WIND = 10u;     // the magnitude of the sum of octaves
export const uint TEXTURE_MARBLE = 11u;   // a color by the sine of a coordinate plus the sum of octaves

// Values that a texture may have on its stack.
export const uint TEXTURE_STACK = 8u;

export const uint FROM_SURFACE = 0u;  // texture coordinates of the surface
export const uint FROM_SPACE = 1u;    // coordinates by the position
export const uint FROM_ANGLES = 2u;   // coordinates by the position's polar angle and azimuth
export const uint FROM_CYLINDER = 3u; // coordinates by the position's azimuth and height

export const uint WRAP_REPEAT = 0u; // outside of [0, 1] an image repeats
export const uint WRAP_CLAMP = 1u;  // outside of [0, 1] an image goes on as at its edge
export const uint WRAP_BLACK = 2u;  // outside of [0, 1] an image is 0

// A texture is a run of nodes, each after what it is made of.
struct TextureNode {
    uint kind;    // TEXTURE_CONSTANT, ..
    uint from;    // where coordinates come from: FROM_SURFACE, ..
    uint last;    // 1 where the texture ends
    uint first;   // image: index of its first texel; noise: index of the first element of its table
    uint width;   // image: texels in a row; noise: number of octaves
    uint height;  // image: rows
    uint wrap;    // image: WRAP_REPEAT, ..
    uint nearest; // 1 where texels are not interpolated
    vec4 to_coordinates[3]; // rows; direction: the first is it
    // At (0, 0), (1, 0), (0, 1), (1, 1); image: offset, factor, least, most; noise: roughness, variation.
    vec4 values[4];
};
