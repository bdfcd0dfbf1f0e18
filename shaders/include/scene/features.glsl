// The features: what kernels are specialised to. Before a driver sees a kernel, the host takes out the
// code that needs a feature which the scene does not have (host/src/specialize.rs): it costs nothing.
// So code asks `if (HAS_X)`, and nothing else leaves it out.
//
// A block is decided in one place, which has to say all of it; each line says what a scene without
// the feature leaves out. Values are those of Specialization::DECLARED, for kernels that can do
// everything. naga reads no operation on specialization constants alone, so their combinations are
// constants too, and `!X` is an else.

// Of shapes, lights, and textures: src/gpu_scene/pack.rs.
FEATURES SceneFeatures {
    bool HAS_TRIANGLES = true;          // surfaces that are triangles
    bool HAS_SPHERES = true;            // surfaces that are spheres
    bool HAS_DISKS = true;              // surfaces that are disks
    bool HAS_CUT_SPHERES = true;        // quadrics of which a part is cut away
    bool HAS_REVOLUTIONS = true;        // bodies of revolution
    bool HAS_QUADRICS = true;           // spheres or disks
    bool HAS_CURVED = true;             // any shape but triangles
    bool HAS_INSTANCES = true;          // objects with hierarchies of their own
    bool HAS_SHADING_NORMALS = true;    // shading normals: at corners of triangles, or by bumps
    bool HAS_CONTACTS = true;           // surfaces of different bodies that coincide
    uint REVOLUTION_PAIRS = 5u;         // pairs of powers in the highest polynomial of any profile
    bool REVOLUTION_NEWTON = false;     // rays meet whole segments, by the classical solver
    bool IS_FLAT = false;               // few primitives, for which a hierarchy costs more than it saves
    uint FLAT_TRIANGLES = 0u;           // triangles of a flat scene
    uint FLAT_QUADRICS = 0u;            // quadrics of a flat scene
    uint FLAT_REVOLUTIONS = 0u;         // bodies of revolution of a flat scene
    bool HAS_SPOT_LIGHTS = true;        // points with a cone
    bool HAS_DISTANT_LIGHTS = true;     // parallel light
    bool HAS_INFINITE_LIGHTS = true;    // constant ones or skies
    bool HAS_AREA_LIGHTS = true;        // primitives that emit
    bool HAS_SKIES = true;              // infinite lights of an image
    bool HAS_PORTALS = true;            // infinite lights of an image that is seen through a rectangle
    bool HAS_GONIOMETRIC_LIGHTS = true; // points whose intensity is an image
    bool HAS_PROJECTION_LIGHTS = true;  // points that project an image
    bool HAS_LOCATABLE_LIGHTS = true;   // any light but constant infinite ones
    bool HAS_HITTABLE_LIGHTS = true;    // area or infinite lights
    bool HAS_TRIANGLE_LIGHTS = true;    // triangles that emit
    bool HAS_SPHERE_LIGHTS = true;      // spheres that emit
    bool HAS_DISK_LIGHTS = true;        // disks that emit
    bool HAS_REVOLUTION_LIGHTS = true;  // bodies of revolution that emit
    bool HAS_TEXTURES = true;           // values that vary over surfaces
    bool HAS_ALPHA = true;              // surfaces that are cut away in part, by a texture
    bool HAS_LIGHT_SPECTRA = false;     // lights whose color depends on the wavelength that a path has taken
    bool HAS_IMAGE_EMITTERS = true;     // area lights with a texture
    bool HAS_IMAGE_TEXTURES = true;     // textures that are images
    bool HAS_TEXTURE_TREES = true;      // textures of more than one node
    bool HAS_NOISE = false;             // textures that sum octaves of noise
    bool HAS_DOTS = false;              // textures of discs, of which noise says where they are
    bool HAS_MEDIA = false;             // media that absorb light
    bool HAS_INTERFACES = false;        // surfaces that only bound media
    bool HAS_PASSABLE = true;           // surfaces that rays pass: cut away in part, or that only bound media
    bool HAS_ROUGH_GATHER = false;      // rough surfaces that only photons bring the light of some lamp to: rough.glsl
};

// Of materials: src/gpu_scene/pack/material.rs.
FEATURES MaterialFeatures {
    bool HAS_CONDUCTORS = true;         // metals, coated ones too
    bool HAS_DIELECTRICS = true;        // bodies of glass or of a liquid
    bool HAS_THIN = false;              // panes of glass without thickness
    bool HAS_COATS = false;             // coated Lambertian surfaces or metals
    bool HAS_DIFFUSE_TRANSMISSION = false;// surfaces that are Lambertian on both sides
    bool HAS_MIXES = false;             // materials that are one of two by chance
    bool HAS_MEASURED = false;          // measured materials
    bool HAS_TEXTURED_COATS = false;    // coats whose thickness is a texture
    bool HAS_SCATTERING_COATS = false;  // coats that scatter light inside
    bool HAS_LAYERS = false;            // materials of several lobes: coats, mixes, diffuse transmission
    bool HAS_SPECULAR = true;           // any lobe that is not Lambertian
    bool HAS_ROUGH = false;             // conductors, dielectrics or coats that are rough
    bool HAS_ANISOTROPIC = true;        // roughness that differs by direction
    bool HAS_DISPERSION = false;        // glass that splits light by wavelength, so that sums of light have a sign
    bool HAS_BUMPS = false;             // shading normals that textures bend
    bool HAS_DISPLACEMENTS = false;     // by heights
    bool HAS_NORMAL_MAPS = false;       // by images of normals
};

// Of the camera: src/gpu_scene/camera.rs.
FEATURES CameraFeatures {
    bool HAS_SIGNED_FILTER = false;     // the pixel filter has negative lobes, and so has the radiance that an iteration adds
    bool IS_ORTHOGRAPHIC = false;       // parallel lines of sight
    bool IS_SPHERICAL = false;          // sees all directions
    bool IS_EQUAL_AREA = false;         // sees all directions, by equal areas and not by angles
};

// Of a render's options: src/render/options.rs.
FEATURES RenderFeatures {
    bool DIRECT_NEE = true;             // next-event estimation finds direct light, photons do not
    uint LOW_DISCREPANCY_PAIRS = 8u;    // pairs of random numbers of a path that are a sequence: random.glsl
    float CELL_SCALE = 1.0;             // width of a cell of the hash grid, in diameters of the largest disc
    bool HAS_GUIDE = false;             // photons begin by a density that a pilot has learned: guide.glsl
    bool HAS_CAUSTIC_LAYER = false;     // photons that have met nothing diffuse are marked, and summed once more
    bool HAS_DATA_RADII = false;        // photons on the inner halves of discs are counted, and radii follow: data_radius.glsl
};

// Of a device and its workgroups: src/render/device.rs.
FEATURES DeviceFeatures {
    bool FEW_REGISTERS = false;         // what rays do not need is in memory while they are traced
    bool KNOWS_LANES = false;           // each subgroup has LANES lanes; without it, each invocation finds the number
    uint LANES = 1u;                    // lanes of a subgroup: subgroup.glsl
};

// Of a pass: src/render/passes/path.rs and src/render/lookup.
FEATURES PassFeatures {
    bool IS_RESUMABLE = false;          // invocations go on in further dispatches: interruption.glsl
    bool IS_QUEUE = false;              // the lanes of a subgroup work together on a queue of rays: trace.glsl
    bool GATHERS_CAUSTICS = false;      // of photons, only those are gathered that are marked: caustic.glsl
    bool SORTS_ROUGH = false;           // photons on rough surfaces are sorted: rough.glsl
};
