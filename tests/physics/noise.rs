//! Textures of noise: renders against the f64 twin, integrated over each pixel.

use glam::{DAffine3, DVec3};
use goblet::scene::{Rgb, Scene};

use super::{EYE_ONLY, Shot, camera, square};
use crate::support::noise::{fbm, is_in_dot, marble, octaves, place_on_marble, windy, wrinkled};
use crate::support::random::Rng;

/// Pixels of a side, and points of a side of a pixel that the twin takes.
const SIDE: usize = 16;
const FINE: usize = 24;

/// Renders a square with a texture in a white furnace, from -1 to 1 in x and y, and compares it with the reflectance
/// at points of the texture's own space.
fn assert_shown(textures: &str, tolerance: f64, reflectance: impl Fn(DVec3) -> Rgb) {
    let transform = "Translate .3 -.2 .15 Scale .4 .3 .5 Rotate 30 0 0 1";
    let world = format!(
        "LightSource \"infinite\"\nAttributeBegin\n{transform}\n{textures}\nAttributeEnd\n\
         Material \"diffuse\" \"texture reflectance\" \"t\"\n{}",
        square(1.0, 0.0)
    );
    let rendered =
        Shot { resolution: [SIDE as u32; 2], depth: 2, ..EYE_ONLY }.take(&camera("0 0 1  0 0 0  0 1 0", 90.0), &world);
    let world_from_texture = DAffine3::from_translation(DVec3::new(0.3, -0.2, 0.15))
        * DAffine3::from_scale(DVec3::new(0.4, 0.3, 0.5))
        * DAffine3::from_rotation_z(30.0_f64.to_radians());
    let texture_from_world = world_from_texture.inverse();
    let mut mean_off = Rgb::ZERO;
    for (i, pixel) in rendered.image.pixels.iter().enumerate() {
        let point = |j: usize| {
            // As seen from above, x grows to the left.
            let at = |pixel: usize, part: usize| {
                1.0 - 2.0 * (pixel as f64 + (part as f64 + 0.5) / FINE as f64) / SIDE as f64
            };
            texture_from_world.transform_point3(DVec3::new(at(i % SIDE, j % FINE), at(i / SIDE, j / FINE), 0.0))
        };
        let expected = (0..FINE * FINE).map(|j| reflectance(point(j))).sum::<Rgb>() / (FINE * FINE) as f64;
        let off = Rgb::from(pixel.map(f64::from)) - expected;
        assert!(off.abs().max_element() < tolerance, "{textures}: pixel {i} is {pixel:?}, not {expected}");
        mean_off += off / (SIDE * SIDE) as f64;
    }
    // The noise of the mean over 256 pixels is a sixteenth of that of one.
    assert!(mean_off.abs().max_element() < tolerance / 8.0, "{textures}: {mean_off}");
}

/// A texture of numbers as a grey reflectance of 0.5 + 0.4 times it, so that none is outside of [0, 1].
fn grey(class: &str) -> String {
    format!(
        "Texture \"n\" \"float\" {class}\nTexture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [.5 .5 .5] \
         \"rgb tex2\" [.9 .9 .9] \"texture amount\" \"n\""
    )
}

/// A pixel has 256 paths. Its values differ by less than 0.1, those of marble and dots by less than 0.5.
#[test]
fn each_texture_of_noise_is_seen_as_the_twin_says() {
    let shade = |value: f64| Rgb::splat(0.5 + 0.4 * value);
    let fbm_text = grey("\"fbm\" \"integer octaves\" 5 \"float roughness\" .4");
    assert_shown(&fbm_text, 0.03, |p| shade(fbm(&octaves(p, 5), 0.4)));
    let wrinkled_text = grey("\"wrinkled\" \"integer octaves\" 4");
    assert_shown(&wrinkled_text, 0.03, |p| shade(wrinkled(&octaves(p, 4), 0.5)));
    assert_shown(&grey("\"windy\""), 0.03, |p| shade(windy(p)));
    let marble_text = "Texture \"t\" \"spectrum\" \"marble\" \"float scale\" 2.5 \"float variation\" 1.5 \
        \"integer octaves\" 3";
    assert_shown(marble_text, 0.1, |p| marble(place_on_marble(2.5 * p.y + 1.5 * fbm(&octaves(2.5 * p, 3), 0.5))));
    // pbrt-v4 looks up "outside" in the discs.
    let dots_text = "Texture \"t\" \"spectrum\" \"dots\" \"string mapping\" \"planar\" \"rgb outside\" [.9 .5 .1] \
        \"rgb inside\" [.2 .5 .7]";
    let dots = |p: DVec3| match is_in_dot(p.truncate()) {
        Some(true) => Rgb::new(0.9, 0.5, 0.1),
        _ => Rgb::new(0.2, 0.5, 0.7),
    };
    assert_shown(dots_text, 0.2, dots);
}

/// The mean of a texture of colours, as a warning tells it where the coat of a metal takes the mean.
fn told_mean(texture: &str) -> f64 {
    let metal = "Material \"coatedconductor\" \"float thickness\" 0 \"texture albedo\" \"t\"";
    let world = format!("WorldBegin {texture} {metal} LightSource \"infinite\" Shape \"disk\"");
    let scene = Scene::parse(&world, "t.pbrt", "").expect("a scene");
    let told = scene.warnings.iter().find_map(|warning| warning.split_once("as its mean, ")).expect("a mean").1;
    told.split(':').next().and_then(|number| number.parse().ok()).expect("a number")
}

/// The means that stand for textures where a value must be constant. Of n values that deviate by less than 1/2, six
/// standard errors of the mean are 3 / sqrt(n).
#[test]
fn means_of_noise_are_those_of_the_twin() {
    let mut rng = Rng(8);
    let points: Vec<DVec3> = (0..60_000).map(|_| 128.0 * rng.cube(1.0)).collect();
    let assert_mean = |texture: &str, of: &dyn Fn(DVec3) -> f64| {
        let (found, expected) = (told_mean(texture), points.iter().map(|p| of(*p)).sum::<f64>());
        let expected = expected / points.len() as f64;
        let bound = 3.0 / (points.len() as f64).sqrt();
        assert!((found - expected).abs() < bound, "{texture}: {found} is not {expected}");
    };
    let grey = |class: &str| {
        format!(
            "Texture \"n\" \"float\" {class}\nTexture \"t\" \"spectrum\" \"scale\" \"rgb tex\" [1 1 1] \
             \"texture scale\" \"n\""
        )
    };
    let dots = "Texture \"t\" \"spectrum\" \"dots\" \"rgb outside\" [1 1 1] \"rgb inside\" [0 0 0]";
    assert_mean(dots, &|p| if is_in_dot(p.truncate()) == Some(true) { 1.0 } else { 0.0 });
    assert_mean(&grey("\"wrinkled\" \"integer octaves\" 3"), &|p| wrinkled(&octaves(p, 3), 0.5));
    assert_mean(&grey("\"fbm\""), &|p| fbm(&octaves(p, 8), 0.5));
    assert_mean(&grey("\"windy\""), &windy);
    assert_mean("Texture \"t\" \"spectrum\" \"marble\"", &|p| {
        marble(place_on_marble(p.y + 0.2 * fbm(&octaves(p, 8), 0.5))).element_sum() / 3.0
    });
}
