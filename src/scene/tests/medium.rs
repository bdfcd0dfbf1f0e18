//! Tests of media that the parser makes.

use super::{message, parse};
use crate::scene::*;

/// Returns a scene with directives before and after its `WorldBegin`, and a sphere.
fn scene(before: &str, world: &str) -> Scene {
    parse(&format!("{before}\nCamera \"perspective\"\nWorldBegin LightSource \"point\"\n{world}\nShape \"sphere\""))
        .unwrap()
}

/// The start of a medium that does not scatter.
fn clear(name: &str) -> String {
    format!("MakeNamedMedium \"{name}\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [0 0 0] ")
}

fn error(world: &str) -> String {
    message(parse(&format!(
        "WorldBegin LightSource \"infinite\"\n{world} MediumInterface \"m\" \"\"\nShape \"sphere\""
    )))
}

fn absorption(params: &str) -> Rgb {
    scene("", &format!("{}{params} MediumInterface \"m\" \"\"", clear("m"))).media[0].absorption
}

#[test]
fn media_are_those_in_force_and_may_be_made_later() {
    let made = clear("a") + "\"rgb sigma_a\" [1 0 0]\n" + &clear("b") + "\"rgb sigma_a\" [0 1 0]";
    let world = format!(
        "MediumInterface \"a\" AttributeBegin MediumInterface \"\" \"a\" Shape \"disk\" AttributeEnd Shape \"disk\"
        LightSource \"point\" LightSource \"distant\" MediumInterface \"b\" \"\" LightSource \"point\"
        ObjectBegin \"o\" MediumInterface \"b\" \"a\" Shape \"disk\" ObjectEnd\n{made}"
    );
    let scene = scene("MediumInterface \"a\" \"b\"", &world);
    let colors: Vec<Rgb> = scene.media.iter().map(|medium| medium.absorption).collect();
    let index = |color: Rgb| colors.iter().position(|known| *known == color);
    let (a, b) = (index(Rgb::X), index(Rgb::Y));
    assert!(colors.len() == 2 && a.is_some() && b.is_some(), "{colors:?}");
    let media: Vec<_> = scene.shapes.iter().map(|shape| (shape.media.inside, shape.media.outside)).collect();
    assert_eq!(media, [(None, a), (a, a), (b, a), (b, None)]);
    // The first light has the medium in force at WorldBegin; light from far away starts in a vacuum.
    assert_eq!((scene.camera_medium, scene.light_media), (b, vec![b, a, None, None]));
}

#[test]
fn absorption_is_scaled_and_of_any_spectrum() {
    assert_eq!(absorption("\"rgb sigma_a\" [1 2 30] \"float scale\" 2 \"float g\" .5"), Rgb::new(2.0, 4.0, 60.0));
    assert_eq!(absorption("\"rgb Le\" [0 0 0] \"float Lescale\" 9"), Rgb::new(0.0011, 0.0024, 0.014));
    assert_eq!(absorption("\"rgb Le\" [1 1 1] \"float Lescale\" 0"), Rgb::new(0.0011, 0.0024, 0.014));
    let flat = absorption("\"spectrum sigma_a\" [300 5 900 5]");
    assert!((flat - 5.0).abs().max_element() < 1e-9, "{flat}");
    let red = absorption("\"spectrum sigma_a\" [300 0 580 0 600 9 900 9]");
    assert!(red.x > 5.0 && red.z < 1.0, "{red}");
    assert!(absorption("\"blackbody sigma_a\" 3000").x > 0.5);
    let defaults = scene(
        "",
        &format!(
            "Attribute \"medium\" \"float scale\" 3 {}MediumInterface \"m\" \"\"",
            clear("m") + "\"rgb sigma_a\" [1 1 1] "
        ),
    );
    assert_eq!(defaults.media[0].absorption, Rgb::splat(3.0));
    let wide =
        scene("", &format!("ColorSpace \"rec2020\" {}\"rgb sigma_a\" [2 2 2] MediumInterface \"m\" \"\"", clear("m")));
    assert!((wide.media[0].absorption - 2.0).abs().max_element() < 1e-9);
    // What absorbs nothing is a vacuum.
    assert!(scene("", &format!("{}\"rgb sigma_a\" [0 0 0] MediumInterface \"m\" \"\"", clear("m"))).media.is_empty());
    assert!(
        scene("", "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"float scale\" 0 MediumInterface \"m\" \"\"")
            .media
            .is_empty()
    );
}

#[test]
fn interfaces_stay_where_they_bound_a_medium() {
    let interface = |names: &str| {
        let world = format!(
            "{}MediumInterface {names} Material \"none\" AreaLightSource \"diffuse\" Shape \"disk\"",
            clear("m")
        );
        let scene = scene("", &world);
        (scene.shapes.len(), scene.warnings.len(), scene.shapes.iter().all(|shape| shape.emission.is_none()))
    };
    assert_eq!(interface("\"m\" \"\""), (2, 2, true));
    assert_eq!(interface("\"\" \"m\""), (2, 2, true));
    assert_eq!(interface("\"m\"").0, 0);
    assert_eq!(interface("\"\" \"\"").0, 0);
}

#[test]
fn what_media_cannot_do_yet_is_said_where_it_stands() {
    let homogeneous = "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" ";
    for (world, expected) in [
        (
            format!("{homogeneous}\"rgb sigma_s\" [0 0 .1]"),
            "2:49: \"rgb sigma_s\" above 0: scattering is not supported yet",
        ),
        (
            homogeneous.to_owned(),
            "2:17: MakeNamedMedium \"m\" without sigma_s scatters: scattering is not supported yet",
        ),
        (
            format!("{homogeneous}\"string preset\" \"Merlot\""),
            "\"rgb sigma_a\" [ 0.11632 0.25191 0.29434 ] \"rgb sigma_s\"",
        ),
        (clear("m") + "\"rgb Le\" [0 .1 0]", "2:71: \"rgb Le\" above 0: emission of a medium is not supported yet"),
        (
            "MakeNamedMedium \"m\" \"string type\" \"cloud\"".to_owned(),
            "2:17: MakeNamedMedium \"cloud\" is not supported yet; supported here: \"homogeneous\"",
        ),
        (
            "MakeNamedMedium \"m\" \"string type\" \"nanovdb\" \"string filename\" \"x\"".to_owned(),
            "\"nanovdb\" is not supported yet",
        ),
    ] {
        let found = error(&world);
        assert!(found.contains(expected), "{world}: {found}");
        // It is no error where nothing is in it.
        scene("", &world);
    }
    for (world, expected) in [
        (
            "MakeNamedMedium \"n\" \"string type\" \"homogeneous\"".to_owned(),
            "2:49: unknown medium \"m\"; expected one that MakeNamedMedium has made, or \"\" for a vacuum",
        ),
        ("MakeNamedMedium \"m\"".to_owned(), "MakeNamedMedium \"m\" has no \"string type\"; expected one"),
        (
            "MakeNamedMedium \"m\" \"string type\" \"gas\"".to_owned(),
            "unknown MakeNamedMedium \"gas\"; expected one of: \"homogeneous\"",
        ),
        (
            clear("m") + "\"rgb sigma_a\" [0 -1 0]",
            "\"rgb sigma_a\" is [0.0, -1.0, 0.0]; expected channels of 0 or more",
        ),
        (clear("m") + "\"float scale\" -1", "\"float scale\" is -1; expected 0 or a number above it"),
        (clear("m") + "\"rgb sigma_a\" [1e300 0 0] \"float scale\" 1e300", "expected a smaller value"),
        (clear("m") + "\"float sigma_a\" 1", "\"float sigma_a\" has the wrong type"),
        (clear("m") + &clear("m"), "a medium \"m\" exists already; expected a new name"),
    ] {
        let found = error(&world);
        assert!(found.contains(expected), "{world}: {found}");
    }
    let warned = scene("", &format!("{}\"string preset\" \"Water\" MediumInterface \"m\" \"\"", clear("m"))).warnings;
    assert!(warned.iter().any(|warning| warning.contains("there is no \"string preset\" \"Water\"")), "{warned:?}");
}
