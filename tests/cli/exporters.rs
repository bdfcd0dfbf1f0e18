//! Scenes as exporters write them. `tests/exporters` holds one for each exporter that docs/exporters.md names.

use std::ops::Range;
use std::path::Path;

use goblet::image::film::Image;

use crate::aov::channel;
use crate::support::command::Bench;
use crate::support::place;

/// Copies an exporter's scene and the files that it names.
fn copy(from: &Path, bench: &Bench, below: &str) {
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{below}{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            copy(&path, bench, &format!("{name}/"));
        } else {
            bench.write(&name, std::fs::read(&path).unwrap());
        }
    }
}

/// Checks that `info` has nothing against an exporter's scene, and renders it. Returns the folder and the image.
fn rendered(exporter: &str) -> (Bench, Image) {
    let bench = Bench::new();
    copy(&place::root().join("tests/exporters").join(exporter), &bench, "");
    let info = bench.run(&["info", "scene.pbrt"]);
    assert_eq!(info.code, 0, "{info:?}");
    bench.rendered(&["--iterations", "4", "--photons", "5000", "-q", "-o", "x.exr"]);
    let image = bench.image("x.exr");
    assert!(image.pixels.iter().flatten().all(|value| value.is_finite()));
    (bench, image)
}

/// The mean colour of a part of an image of 64 x 48 pixels: its columns and rows from the upper left corner.
fn colour(image: &Image, columns: Range<usize>, rows: Range<usize>) -> [f32; 3] {
    assert_eq!([image.width, image.height], [64, 48]);
    let pixels: Vec<[f32; 3]> =
        rows.flat_map(|y| columns.clone().map(move |x| y * 64 + x)).map(|at| image.pixels[at]).collect();
    [0, 1, 2].map(|channel| pixels.iter().map(|pixel| pixel[channel]).sum::<f32>() / pixels.len() as f32)
}

/// Juice in a glass ball, and the layers of a gbuffer film.
#[test]
fn a_scene_from_blender_is_rendered() {
    let (bench, image) = rendered("blender");
    let [red, _, blue] = colour(&image, 33..38, 22..26);
    assert!(red > 1.5 * blue, "{red} {blue}");
    for layer in ["Albedo.R", "N.X", "Ns.X", "P.X", "Variance.R"] {
        assert!(channel(&bench, "x.exr", layer).iter().any(|value| *value != 0.0), "{layer}");
    }
}

/// Smoke that only absorbs, in a ball without a surface.
#[test]
fn a_scene_from_houdini_is_rendered() {
    let (_, image) = rendered("houdini");
    let [red, _, blue] = colour(&image, 26..33, 16..23);
    assert!(blue > 1.3 * red, "{red} {blue}");
}

#[test]
fn a_scene_from_freecad_is_rendered() {
    let (_, image) = rendered("freecad");
    let [red, green, _] = colour(&image, 18..20, 24..26);
    assert!(green > 1.3 * red, "{red} {green}");
}

/// A leaf cut out by alpha, before a wall of sky.
#[test]
fn a_scene_from_assimp_is_rendered() {
    let (_, image) = rendered("assimp");
    let [red, green, _] = colour(&image, 35..39, 23..28);
    assert!(green > 1.5 * red, "{red} {green}");
}
