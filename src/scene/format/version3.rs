//! Names that pbrt-v3 had and pbrt-v4 does not have, so that error messages can say how to convert a scene.

/// The advice that is appended to error messages.
const HINT: &str = "; this is of pbrt-v3: convert the scene with pbrt-v4's `pbrt --upgrade OLD.pbrt > NEW.pbrt`";

/// Directives; the last ones are of pbrt-v2.
const DIRECTIVES: &[&str] = &["WorldEnd", "Renderer", "SurfaceIntegrator", "Volume", "VolumeIntegrator"];

/// Types of parameters.
const PARAMETER_TYPES: &[&str] = &["color", "point", "vector", "xyz"];

/// Directives and their types.
const TYPES: &[(&str, &[&str])] = &[
    ("AreaLightSource", &["area"]),
    ("Camera", &["environment"]),
    ("Film", &["image"]),
    ("Integrator", &["ao", "directlighting", "whitted"]),
    ("LightSource", &["exinfinite", "infinitesample"]),
    (
        "Material",
        &[
            "disney",
            "fourier",
            "glass",
            "kdsubsurface",
            "matte",
            "metal",
            "mirror",
            "plastic",
            "shinymetal",
            "substrate",
            "translucent",
            "uber",
        ],
    ),
    ("Sampler", &["02sequence", "adaptive", "bestcandidate", "lowdiscrepancy", "maxmindist", "random"]),
    ("Shape", &["cone", "heightfield", "hyperboloid", "nurbs", "paraboloid"]),
    ("Texture", &["uv"]),
];

/// Directives and their parameters.
const PARAMETERS: &[(&str, &[&str])] = &[
    ("AreaLightSource", &["samples"]),
    ("Camera", &["aperturediameter_mm", "halffov", "simpleweighting"]),
    ("Film", &["maxsampleluminance", "scale"]),
    ("Integrator", &["imagewritefrequency", "lightsamplestrategy", "numiterations", "strategy"]),
    ("LightSource", &["mapname", "nsamples", "samples"]),
    ("Material", &["Kd", "Kr", "Ks", "Kt", "bumpmap", "index", "namedmaterial1", "namedmaterial2", "opacity", "sigma"]),
    ("PixelFilter", &["alpha", "xwidth", "ywidth"]),
    ("Sampler", &["dimensions", "scramble"]),
    ("Shape", &["ST", "shadowalpha", "st", "nlevels", "discarddegenerateUVs"]),
    ("Texture", &["aamode", "gamma", "trilinear"]),
];

/// Returns the hint for a directive of this name, or an empty string.
pub(in crate::scene) fn hint_at_directive(name: &str) -> &'static str {
    hint(DIRECTIVES.contains(&name))
}

/// Returns the hint for a parameter that is declared with this type, or an empty string.
pub(in crate::scene) fn hint_at_type(name: &str) -> &'static str {
    hint(PARAMETER_TYPES.contains(&name))
}

/// Returns the hint for a directive with this type, as in `Film "image"`, or an empty string.
pub(in crate::scene) fn hint_at(directive: &str, name: &str) -> &'static str {
    hint(is_listed(TYPES, directive, name))
}

/// Returns the hint for a parameter of this name of a directive, or an empty string.
pub(in crate::scene) fn hint_at_parameter(directive: &str, name: &str) -> &'static str {
    hint(is_listed(PARAMETERS, directive, name))
}

/// Returns the hint for a `Texture` of values of this type, or an empty string.
pub(in crate::scene) fn hint_at_values(name: &str) -> &'static str {
    hint(name == "color")
}

/// Returns the hint for a `blackbody` with this number of values, or an empty string: pbrt-v3 had a scale
/// as the second value.
pub(in crate::scene) fn hint_at_blackbody(values: usize) -> &'static str {
    hint(values == 2)
}

fn hint(applies: bool) -> &'static str {
    if applies { HINT } else { "" }
}

fn is_listed(list: &[(&str, &[&str])], directive: &str, name: &str) -> bool {
    list.iter().any(|(listed, names)| *listed == directive && names.contains(&name))
}
