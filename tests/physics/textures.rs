//! What varies over surfaces: reflectance, emission, and how much of the surface is there.

use std::path::Path;

use goblet::image::file;
use goblet::image::film::Image;

use super::{EYE_ONLY, Shot, assert_near, camera, square};
use crate::support::mean;
use crate::support::random::Rng;

/// A file of these pixels, row by row from the top; its path.
fn image_file(folder: &Path, name: &str, width: u32, pixels: Vec<[f32; 3]>) -> String {
    let path = folder.join(name);
    let image = Image::from_pixels(width, pixels.len() as u32 / width, pixels).expect("an image");
    file::write(&path, &image, &[]).expect("a file");
    path.display().to_string()
}

/// A square in z = 0, as seen from above, where screen right is -x: its texture stands upright.
const UPRIGHT: &str = "\"point2 uv\" [1 0 0 0 0 1 1 1]";

#[test]
fn an_image_in_a_white_furnace_is_itself() {
    let folder = tempfile::tempdir().unwrap();
    let pixels: Vec<_> = (0..16u16).map(|i| [f32::from(i) / 16.0, 0.5, 1.0 - f32::from(i % 4) / 4.0]).collect();
    let file = image_file(folder.path(), "steps.exr", 4, pixels.clone());
    let world = format!(
        "LightSource \"infinite\"\nTexture \"steps\" \"spectrum\" \"imagemap\" \"string filename\" \"{file}\" \
         \"string filter\" \"point\"\nMaterial \"diffuse\" \"texture reflectance\" \"steps\"\n{} {UPRIGHT}",
        square(1.0, 0.0)
    );
    let rendered = Shot { resolution: [16; 2], iterations: 1, depth: 2, ..EYE_ONLY }
        .take(&camera("0 0 1  0 0 0  0 1 0", 90.0), &world);
    for (i, pixel) in rendered.image.pixels.iter().enumerate() {
        let expected = pixels[i / 16 / 4 * 4 + i % 16 / 4];
        let off = (0..3).map(|c| (pixel[c] - expected[c]).abs()).fold(0.0, f32::max);
        assert!(off < 2e-3, "pixel {i} is {pixel:?}, expected {expected:?}");
    }
}

/// Each pixel sees a whole image, of black and white texels in disorder. 64 independent samples would have a
/// relative squared error of 1 / 64.
#[test]
fn paths_average_a_texture_that_is_finer_than_a_pixel() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Rng(20);
    let texels: Vec<_> = (0..256).map(|_| [f32::from(u8::from(rng.chance(0.5))); 3]).collect();
    let expected = texels.iter().map(|texel| f64::from(texel[0])).sum::<f64>() / 256.0;
    let file = image_file(folder.path(), "disorder.exr", 16, texels);
    let world = format!(
        "LightSource \"infinite\"\nTexture \"disorder\" \"spectrum\" \"imagemap\" \"string filename\" \"{file}\" \
         \"string filter\" \"trilinear\" \"float uscale\" 16 \"float vscale\" 16\n\
         Material \"diffuse\" \"texture reflectance\" \"disorder\"\n{} {UPRIGHT}",
        square(1.0, 0.0)
    );
    let shot = Shot { resolution: [16; 2], iterations: 64, depth: 2, eye_paths: 1, ..EYE_ONLY };
    let image = shot.take(&camera("0 0 1  0 0 0  0 1 0", 90.0), &world).image;
    let squares: f64 = image.pixels.iter().map(|pixel| (f64::from(pixel[0]) / expected - 1.0).powi(2)).sum();
    let error = squares / image.pixels.len() as f64;
    println!("a texture in disorder after 64 iterations: relative squared error {error:.5}");
    assert!(error < 0.5 / 64.0, "{error}");
}

/// In a sphere all light but the first is even, so that it knows of the mean albedo alone.
#[test]
fn photons_take_the_albedo_of_where_they_are() {
    let world = "Texture \"checks\" \"spectrum\" \"checkerboard\" \"float uscale\" 40 \"float vscale\" 20 \
        \"rgb tex1\" [.9 .5 .2] \"rgb tex2\" [.1 .5 .6]\nMaterial \"diffuse\" \"texture reflectance\" \"checks\"\n\
        ReverseOrientation\nAreaLightSource \"diffuse\"\nShape \"sphere\" \"float radius\" 2";
    let shot =
        Shot { resolution: [16; 2], photons: 16_384, iterations: 16, radius: 0.5, alpha: 1.0, depth: 60, eye_paths: 4 };
    let rendered = shot.take(&camera("0.3 0.2 0.1  1 0.5 2  0 1 0", 90.0), world);
    let expected = [0.5, 0.5, 0.4].map(|albedo| 1.0 / (1.0 - albedo));
    // The checks that are seen are not quite as many of both colours.
    assert_near("checked sphere", mean(&rendered.image), expected, 0.02);
}

#[test]
fn a_card_hides_as_much_as_there_is_of_it() {
    let holes = "Texture \"holes\" \"float\" \"checkerboard\" \"float uscale\" 4 \"float vscale\" 4 \
        \"float tex1\" .25 \"float tex2\" .75";
    let cards = [("\"float alpha\" .25", 0.75), ("\"float alpha\" 0", 1.0), ("\"texture alpha\" \"holes\"", 0.5)];
    for (alpha, seen) in cards {
        let world = format!(
            "LightSource \"infinite\"\n{holes}\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
             {} {alpha} {UPRIGHT}\nTranslate 0 0 -20\nShape \"sphere\"",
            square(1.5, 0.0)
        );
        let rendered = Shot { resolution: [16; 2], ..EYE_ONLY }.take(&camera("0 0 1  0 0 0  0 1 0", 60.0), &world);
        // The ball in the back, which gives the scene a size, fills a thousandth of the view.
        assert_near(alpha, mean(&rendered.image), [seen; 3], 0.01);
    }
}

/// Mean radiance of a floor under lights, by eye and by photons: under a dome of glass that
/// refracts next to nothing, the eye finds no light.
fn lit_floors(lights: &str) -> [[f64; 3]; 2] {
    let world = format!("{lights}\nMaterial \"diffuse\"\n{}\n", square(1.5, 0.0));
    let dome = format!("{world}Material \"dielectric\" \"float eta\" 1.0001\nScale 2 2 .8\nShape \"sphere\"");
    let look = camera("0 0 .6  0 0 0  0 1 0", 120.0);
    let by_eye = Shot { resolution: [8; 2], iterations: 2, ..EYE_ONLY };
    let by_photons =
        Shot { resolution: [8; 2], photons: 196_608, iterations: 1, radius: 0.2, alpha: 1.0, depth: 10, eye_paths: 4 };
    [(by_eye, world), (by_photons, dome)].map(|(shot, world)| mean(&shot.take(&look, &world).image))
}

fn assert_ratio(what: &str, lights: &str, base: [[f64; 3]; 2], ratio: [f64; 3]) {
    for ((lit, base), how) in lit_floors(lights).into_iter().zip(base).zip(["eye", "photons"]) {
        assert_near(&format!("{what} by {how}"), lit, [0, 1, 2].map(|c| base[c] * ratio[c]), 0.025);
    }
}

fn lamp(emission: &str, shape: &str) -> String {
    format!(
        "AttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\nTranslate .1 .2 0\nReverseOrientation\n\
         AreaLightSource \"diffuse\" {emission}\n{} {shape}\nAttributeEnd\n",
        square(0.4, 1.1)
    )
}

#[test]
fn lamps_shine_as_much_as_there_is_of_them() {
    let base = lit_floors(&lamp("", ""));
    assert_ratio("a quarter of a lamp", &lamp("", "\"float alpha\" .25"), base, [0.25; 3]);
    // As in pbrt, none of it is there, and all of its light.
    assert_ratio("an invisible lamp", &lamp("", "\"float alpha\" 0"), base, [1.0; 3]);
}

#[test]
fn lamps_shine_as_their_images_say() {
    let base = lit_floors(&lamp("", ""));
    let folder = tempfile::tempdir().unwrap();
    let file = image_file(folder.path(), "even.exr", 1, vec![[0.5, 0.25, 2.0]]);
    let shown = format!("\"string filename\" \"{file}\" \"float scale\" .5");
    assert_ratio("an even image", &lamp(&shown, ""), base, [0.25, 0.125, 1.0]);
    let file = image_file(folder.path(), "checks.exr", 2, vec![[0.0; 3], [1.0; 3], [1.0; 3], [0.0; 3]]);
    let shown = format!("\"string filename\" \"{file}\"");
    assert_ratio("a symmetric image", &lamp(&shown, UPRIGHT), base, [0.5; 3]);
}

#[test]
fn the_power_of_a_lamp_is_that_of_its_image() {
    let folder = tempfile::tempdir().unwrap();
    let file = image_file(folder.path(), "dim.exr", 1, vec![[0.1; 3]]);
    let shown = |emission: &str| {
        let world = lamp(&format!("\"float power\" 3 {emission}"), "") + &square(1.5, 0.0);
        mean(&Shot { resolution: [8; 2], ..EYE_ONLY }.take(&camera("0 0 .6  0 0 0  0 1 0", 120.0), &world).image)
    };
    assert_near("power", shown(&format!("\"string filename\" \"{file}\"")), shown(""), 0.015);
}

#[test]
fn cards_that_are_half_there_cast_half_a_shadow() {
    let light = "LightSource \"point\" \"point3 from\" [0 0 2]\n";
    let card = format!(
        "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n{} \"float alpha\" .3\n{} \"float alpha\" .5\n",
        square(1.4, 1.2),
        square(1.4, 1.0)
    );
    let base = lit_floors(light);
    assert_ratio("two cards", &format!("{light}{card}"), base, [0.35; 3]);
}

#[test]
fn an_emitter_shows_its_image_upright() {
    let folder = tempfile::tempdir().unwrap();
    let file = image_file(folder.path(), "corner.exr", 2, vec![[1.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]]);
    let world = format!("AreaLightSource \"diffuse\" \"string filename\" \"{file}\"\n{} {UPRIGHT}", square(1.0, 0.0));
    let image = Shot { resolution: [8; 2], iterations: 1, depth: 1, ..EYE_ONLY }
        .take(&camera("0 0 1  0 0 0  0 1 0", 90.0), &world)
        .image;
    assert!(image.pixels[0][0] > 0.99, "{:?}", image.pixels[0]);
    assert!(image.pixels[7][0] < 0.01 && image.pixels[56][0] < 0.01 && image.pixels[63][0] < 0.01);
}
