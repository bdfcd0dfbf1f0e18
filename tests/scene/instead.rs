//! Types that are not supported yet are refused by name, with what to write instead.

use goblet::scene::{FAMILIES, Scene, Support};

/// Directives, their types, a scene that has them, and a part of the advice.
const REFUSED: [(&str, &str, &str, &str); 9] = [
    ("Camera", "realistic", "Camera \"realistic\" WorldBegin", "write \"perspective\" with the lens's \"float fov\""),
    ("Integrator", "function", "Integrator \"function\" WorldBegin", "write \"sppm\""),
    ("Material", "hair", "WorldBegin Material \"hair\" Shape \"disk\"", "write \"coatedconductor\" or"),
    ("Material", "subsurface", "WorldBegin Material \"subsurface\" Shape \"disk\"", "write \"coateddiffuse\" with"),
    ("MakeNamedMedium", "cloud", CLOUD, "write \"homogeneous\" with"),
    ("MakeNamedMedium", "nanovdb", GRID, "write \"homogeneous\" with"),
    ("MakeNamedMedium", "rgbgrid", COLOURED_GRID, "write \"homogeneous\" with"),
    ("MakeNamedMedium", "uniformgrid", UNIFORM_GRID, "write \"homogeneous\" with"),
    ("Shape", "curve", "WorldBegin Shape \"curve\"", "write \"plymesh\" with the curve as a strip"),
];

const CLOUD: &str = "WorldBegin MakeNamedMedium \"m\" \"string type\" \"cloud\" MediumInterface \"m\" Shape \"disk\"";
const GRID: &str = "WorldBegin MakeNamedMedium \"m\" \"string type\" \"nanovdb\" MediumInterface \"m\" Shape \"disk\"";
const COLOURED_GRID: &str =
    "WorldBegin MakeNamedMedium \"m\" \"string type\" \"rgbgrid\" MediumInterface \"m\" Shape \"disk\"";
const UNIFORM_GRID: &str =
    "WorldBegin MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" MediumInterface \"m\" Shape \"disk\"";

#[test]
fn refused_types_say_what_to_write_instead() {
    for (directive, name, text, advice) in REFUSED {
        let error = Scene::parse(text, "t", "").expect_err("an error").to_string();
        let refused = format!("{directive} \"{name}\" is not supported yet; supported here: ");
        assert!(error.contains(&refused) && error.contains(&format!("; instead, {advice}")), "{error}");
    }
    let refused = FAMILIES.iter().flat_map(|family| family.types.iter().map(|kind| (family.directive, kind)));
    for (directive, kind) in refused.filter(|(_, kind)| kind.support == Support::Later) {
        // Ptex says what to write in place of what is supported.
        let has_advice = REFUSED.iter().any(|(of, name, ..)| *of == directive && *name == kind.name);
        assert!(has_advice || kind.name == "ptex", "{directive} \"{}\"", kind.name);
    }
}
