// Media, which absorb light on its way.

export const uint VACUUM = 0u; // index of the medium that absorbs nothing

// A homogeneous medium.
struct Medium {
    vec3 absorption; // coefficient per channel, 1/render unit
    uint spectrum;   // first element of the coefficient by wavelength in texture_texels, or NONE
};

// The media on both sides of the surfaces of a material.
struct MediumInterface {
    uint inside;  // index into media: behind the surface
    uint outside; // index into media: in front of the surface
    uint passes;  // 1 where the surface does nothing but bound them: rays go straight on
    uint pad;
};
