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
    colored(shape, alpha, [4.0, 3.0, 2.0], [0.1, 0.2, 1.2])
}

/// A lamp at a place.
fn colored(shape: &str, alpha: &str, [r, g, b]: [f64; 3], [x, y, z]: [f64; 3]) -> String {
    format!(
        "AttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\nTranslate {x} {y} {z}\n\
         AreaLightSource \"diffuse\" \"rgb L\" [{r} {g} {b}]\n{shape} {alpha}\nAttributeEnd\n"
    )
}

const INVISIBLE: &str = "\"float alpha\" 0";
/// Pixels that are points.
const STILL: &str = "Option \"bool disablepixeljitter\" true\n";
const FLOOR: &str = "Material \"diffuse\"\n";
const METAL: &str = "Material \"conductor\" \"float roughness\" .05\n";

/// Of nothing that is lost for a value that is not finite.
fn take(shot: &Shot, look_at: &str, fov: f64, world: &str) -> Image {
    let Rendered { image, tally: Tally { non_finite, .. }, .. } = shot.take(&camera(look_at, fov), world);
    assert_eq!(non_finite, ByPass::default(), "{world}");
    image
}

/// Floors, far apart, each with three lamps above it and under one dome.
const BAYS: usize = 3;

/// What the floor of a bay shows of each of its lamps, of which one is red, one green and one blue.
fn lit(shot: &Shot, bay: usize, world: &str) -> [f64; 3] {
    let x = 20 * bay;
    mean(&take(shot, &format!("{x} 0 .6  {x} 0 0  0 1 0"), 110.0, world))
}

/// All lamps, of which the floor of one bay sees three.
fn bays(alpha: &str, ground: &str, dome: &str) -> String {
    let place = |i: usize| (i / 3, i % 3);
    let lamps = SHAPES.iter().enumerate().map(|(i, (_, shape))| {
        let ((bay, color), mut radiance) = (place(i), [0.0; 3]);
        radiance[color] = 4.0;
        colored(shape, alpha, radiance, [20.0 * bay as f64 + 0.7 * (color as f64 - 1.0), 0.2, 1.2])
    });
    let rest = (0..BAYS).map(|bay| {
        format!("AttributeBegin\nTranslate {} 0 0\n{ground}{}{dome}\nAttributeEnd\n", 20 * bay, square(1.5, 0.0))
    });
    lamps.chain(rest).collect()
}

/// Lamps of other bays are 20 away and low above the horizon: they add less than a hundredth. All shapes are in one scene, which has one set of kernels.
#[test]
fn invisible_lamps_light_what_visible_ones_do() {
    let by_eye = Shot { resolution: [8; 2], iterations: 4, ..EYE_ONLY };
    let by_photons =
        Shot { resolution: [16; 2], photons: 1 << 17, iterations: 2, radius: 0.2, alpha: 1.0, depth: 10, eye_paths: 1 };
    // Rays of the eye find no light through glass that refracts next to nothing.
    let dome = "Material \"dielectric\" \"float eta\" 1.0001\nScale 2 2 .8\nShape \"sphere\"";
    for (how, shot, dome) in [("eye", by_eye, ""), ("photons", by_photons, dome)] {
        let [there, gone] = ["", INVISIBLE].map(|alpha| bays(alpha, FLOOR, dome));
        for bay in 0..BAYS {
            let [there, gone] = [&there, &gone].map(|world| lit(&shot, bay, world));
            let names: Vec<&str> = SHAPES[3 * bay..][..3].iter().map(|(name, _)| *name).collect();
            assert_near(&format!("{names:?} by {how}"), gone, there, 0.02);
        }
    }
    // Metal has rays of the bsdf look for lamps, too: not for such as they cannot meet. Of a lamp that is gone only the
    // noisier technique is left.
    let by_eye = Shot { iterations: work(4, 256), ..by_eye };
    for (name, shape) in work(&[SHAPES[0]][..], &[SHAPES[0], SHAPES[2], SHAPES[7]]) {
        let [there, gone] =
            ["", INVISIBLE].map(|alpha| lit(&by_eye, 0, &(lamp(shape, alpha) + METAL + &square(1.5, 0.0))));
        assert_near(&format!("{name} by rays that metal reflects"), gone, there, 0.02);
    }
}

/// Lamps in two rows, each of a radiance of its own, as pixels show that are points. In the long form, each
/// shape is in a scene of its own, too.
#[test]
fn invisible_lamps_are_not_seen() {
    let shot = Shot { resolution: [64; 2], iterations: 1, eye_paths: 1, ..EYE_ONLY };
    // At the lamps from below and aside.
    let see = |alpha: &str, shapes: &[usize]| {
        let lamp = |&i: &usize| {
            let at = [0.0, 0.8 * ((i % 5) as f64 - 2.0), 1.2 + 0.9 * (i / 5) as f64];
            colored(SHAPES[i].1, alpha, [i as f64 + 1.0; 3], at)
        };
        let lamps: String = shapes.iter().map(lamp).collect();
        let view = format!("{STILL}{}", camera("3 0 .3  0 0 2.3  0 0 1", 60.0));
        let Rendered { image, tally, .. } = shot.take(&view, &(lamps + &square(9.0, 0.0)));
        assert_eq!(tally.non_finite, ByPass::default());
        image
    };
    let all: Vec<usize> = (0..SHAPES.len()).collect();
    let alone = if is_full() { all.chunks(1) } else { [].chunks(1) };
    for shapes in alone.chain([&all[..]]) {
        let seen = see("", shapes);
        for &i in shapes {
            let count = seen.pixels.iter().filter(|pixel| **pixel == [i as f32 + 1.0; 3]).count();
            assert!(count > 4, "{} is in the picture: {count} pixels", SHAPES[i].0);
        }
        assert_eq!(mean(&see(INVISIBLE, shapes)), [0.0; 3], "{shapes:?}");
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
