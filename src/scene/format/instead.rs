//! Suggestions for error messages: what to write instead of a type that is not supported.

/// The end of the sentence for media that are not the same everywhere.
const HOMOGENEOUS: &str = "; instead, write \"homogeneous\" with a \"rgb sigma_a\" and \"rgb sigma_s\" [ 0 0 0 ], inside \
                           a shape of \"interface\" that is as large";

/// Directives, their types, and the sentence's end.
const INSTEAD: &[(&str, &str, &str)] = &[
    (
        "Camera",
        "realistic",
        "; instead, write \"perspective\" with the lens's \"float fov\", \"float lensradius\" and \"float focaldistance\"",
    ),
    ("Integrator", "function", "; instead, write \"sppm\": \"function\" renders no image of the scene"),
    (
        "Material",
        "hair",
        "; instead, write \"coatedconductor\" or \"coateddiffuse\" with a \"rgb reflectance\" and a \"float roughness\"",
    ),
    (
        "Material",
        "subsurface",
        "; instead, write \"coateddiffuse\" with a \"rgb reflectance\" for a dense body, \"diffusetransmission\" for a \
         thin one, \"dielectric\" for a clear one",
    ),
    ("MakeNamedMedium", "cloud", HOMOGENEOUS),
    ("MakeNamedMedium", "nanovdb", HOMOGENEOUS),
    ("MakeNamedMedium", "rgbgrid", HOMOGENEOUS),
    ("MakeNamedMedium", "uniformgrid", HOMOGENEOUS),
    (
        "Shape",
        "curve",
        "; instead, write \"plymesh\" with the curve as a strip of triangles, or \"cylinder\" for a straight one",
    ),
];

/// Returns the end of the error that a directive's type is not supported: what to write instead, or nothing.
pub(in crate::scene) fn of(directive: &str, name: &str) -> &'static str {
    let found = INSTEAD.iter().find(|(listed, of, _)| *listed == directive && *of == name);
    found.map_or("", |(_, _, instead)| instead)
}
