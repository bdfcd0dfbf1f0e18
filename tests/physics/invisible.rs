//! Lamps that are not there: an alpha of 0 takes away the surface and leaves its light, as in pbrt.

use goblet::image::film::Image;
use goblet::{ByPass, Tally};

use super::{EYE_ONLY, Shot, assert_near, camera, square};
use crate::support::{Rendered, is_full, mean, work};

/// One of each kind of shape, and such as are cut or touch an axis, above a floor.
const SHAPES: [(&str, &str); 9] = [
    (
        "triangles",
        "ReverseOrientation Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-.3 -.3 0 .3 -.3 0 .3 .3 0 -.3 .3 0]",
    ),
    ("bilinear patch", "ReverseOrientation Shape \"bilinearmesh\" \"point3 P\" [-.3 -.3 0 .3 -.3 0 -.3 .3 0 .3 .3 .1]"),
    ("sphere", "Shape \"sphere\" \"float radius\" .3"),
    ("cap", "Shape \"sphere\" \"float radius\" .3 \"float zmax\" -.1"),
    ("disk", "ReverseOrientation Shape \"disk\" \"float radius\" .3 \"float innerradius\" .1"),
    ("cylinder", "Shape \"cylinder\" \"float radius\" .2 \"float zmin\" -.2 \"float zmax\" .2"),
    (
        "half cylinder",
        "Rotate 90 1 0 0 Shape \"cylinder\" \"float radius\" .2 \"float zmin\" -.2 \"float zmax\" .2 \"float phimax\" 180",
    ),
    ("body", "Shape \"revolution\" \"integer degree\" 2 \"point2 P\" [0 -.2 .4 -.2 .3 .2]"),
    ("cone", "Shape \"revolution\" \"integer degree\" 1 \"point2 P\" [0 -.3 .3 .1]"),
];

fn lamp(shape: &str, alpha: &str) -> String {
    format!(
        "AttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\nTranslate .1 .2 1.2\n\
         AreaLightSource \"diffuse\" \"rgb L\" [4 3 2]\n{shape} {alpha}\nAttributeEnd\n"
    )
}

const INVISIBLE: &str = "\"float alpha\" 0";
const FLOOR: &str = "Material \"diffuse\"\n";
const METAL: &str = "Material \"conductor\" \"float roughness\" .05\n";

/// Of nothing that is lost for a value that is not finite.
fn take(shot: &Shot, look_at: &str, fov: f64, world: &str) -> Image {
    let Rendered { image, tally: Tally { non_finite, .. }, .. } = shot.take(&camera(look_at, fov), world);
    assert_eq!(non_finite, ByPass::default(), "{world}");
    image
}

/// A floor from below the lamp.
fn lit(shot: &Shot, world: &str) -> [f64; 3] {
    mean(&take(shot, "0 0 .6  0 0 0  0 1 0", 110.0, world))
}

#[test]
fn invisible_lamps_light_what_visible_ones_do() {
    let by_eye = Shot { resolution: [8; 2], iterations: 24, ..EYE_ONLY };
    let by_photons = Shot { resolution: [8; 2], photons: 65_536, iterations: 3, radius: 0.2, alpha: 1.0, depth: 10 };
    // Rays of the eye find no light through glass that refracts next to nothing.
    let dome = "Material \"dielectric\" \"float eta\" 1.0001\nScale 2 2 .8\nShape \"sphere\"";
    let floor = square(1.5, 0.0);
    let agree = |how: &str, name: &str, shape: &str, shot: &Shot, under: &str| {
        let [there, gone] = ["", INVISIBLE].map(|alpha| lit(shot, &(lamp(shape, alpha) + under)));
        assert_near(&format!("{name} by {how}"), gone, there, 0.02);
    };
    // In the quick form, shapes take turns.
    for (i, (name, shape)) in SHAPES.into_iter().enumerate() {
        if is_full() || i % 2 == 0 {
            agree("eye", name, shape, &by_eye, &format!("{FLOOR}{floor}"));
        }
        if is_full() || i % 2 == 1 {
            agree("photons", name, shape, &by_photons, &format!("{FLOOR}{floor}\n{dome}"));
        }
    }
    // Metal has rays of the bsdf look for lamps, too: not for such as they cannot meet.
    let by_eye = Shot { iterations: 256, ..by_eye };
    for (name, shape) in work(&[SHAPES[0]][..], &[SHAPES[0], SHAPES[2], SHAPES[7]]) {
        agree("rays that metal reflects", name, shape, &by_eye, &format!("{METAL}{floor}"));
    }
}

#[test]
fn invisible_lamps_are_not_seen() {
    let shot = Shot { resolution: [8; 2], iterations: 2, ..EYE_ONLY };
    for (name, shape) in SHAPES {
        // At the lamp from below and aside.
        let seen =
            |alpha| mean(&take(&shot, ".8 .2 .7  .1 .2 1.2  0 0 1", 60.0, &(lamp(shape, alpha) + &square(9.0, 0.0))));
        assert!(seen("")[0] > 0.1, "{name} is in the picture: {:?}", seen(""));
        assert_eq!(seen(INVISIBLE), [0.0; 3], "{name}");
    }
}

/// Some photons begin where the image is black: they carry nothing, and are no fault.
#[test]
fn black_parts_of_a_lamp_are_no_fault() {
    let pixels = vec![[0.0; 3], [1.0; 3], [1.0; 3], [0.0; 3]];
    let file = crate::support::ImageFile::new(&Image::from_pixels(2, 2, pixels).expect("an image"));
    let world = format!(
        "AttributeBegin\nAreaLightSource \"diffuse\" \"string filename\" \"{}\"\nTranslate 0 0 1\nReverseOrientation\n\
         {}\nAttributeEnd\n{FLOOR}{}",
        file.path().display(),
        square(0.4, 0.0),
        square(1.5, 0.0)
    );
    let rendered = Shot { resolution: [8; 2], photons: 4096, iterations: 1, ..EYE_ONLY }
        .take(&camera("0 0 .6  0 0 0  0 1 0", 110.0), &world);
    super::assert_closed(&rendered.tally, 4096);
    assert!(rendered.tally.absorbed > 100, "{:?}", rendered.tally);
}
