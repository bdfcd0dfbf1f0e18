//! Skies that are seen through a portal.

use goblet::image::film::Image;
use goblet::{DirectLight, Guidance, Options};

use super::{assert_near, camera, scene_text, square};
use crate::support::{self, ImageFile, Rendered, mean};

/// A room of 2 x 2 x 2 about the origin, whose window at x = 1 is -0.5 to 0.5 in y and in z.
fn room() -> String {
    let wall =
        |points: &str| format!("Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [{points}]\n");
    let walls = [
        "-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1",
        "-1 -1 1  1 -1 1  1 1 1  -1 1 1",
        "-1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1",
        "-1 1 -1  1 1 -1  1 1 1  -1 1 1",
        "-1 -1 -1  -1 1 -1  -1 1 1  -1 -1 1",
        // Around the window.
        "1 -1 -1  1 1 -1  1 1 -.5  1 -1 -.5",
        "1 -1 .5  1 1 .5  1 1 1  1 -1 1",
        "1 -1 -.5  1 -.5 -.5  1 -.5 .5  1 -1 .5",
        "1 .5 -.5  1 1 -.5  1 1 .5  1 .5 .5",
    ];
    walls.map(wall).concat()
}

/// In the order in which light comes from +x: (p3 - p0) x (p1 - p0).
const PORTAL: &str = "\"point3 portal\" [1 -.5 -.5  1 -.5 .5  1 .5 .5  1 .5 -.5]";
const REVERSED: &str = "\"point3 portal\" [1 -.5 -.5  1 .5 -.5  1 .5 .5  1 -.5 .5]";

/// A sky whose colours differ, with a sun on the side of the window.
fn sky_image() -> ImageFile {
    let mut pixels = Vec::new();
    for i in 0..256_u16 {
        let (x, y) = (f32::from(i % 16) / 16.0, f32::from(i / 16) / 16.0);
        let sun = if i == 8 * 16 + 15 { 60.0 } else { 0.0 };
        pixels.push([0.2 + x + sun, 0.5 + sun, 1.2 - y + 0.5 * sun]);
    }
    ImageFile::new(&Image::from_pixels(16, 16, pixels).expect("an image"))
}

struct Look {
    direct: DirectLight,
    depth: u32,
    photons: u64,
    eye_paths: u32,
    iterations: u32,
}

const EYE: Look = Look { direct: DirectLight::Nee, depth: 1, photons: 1, eye_paths: 64, iterations: 32 };
const PHOTONS: Look = Look { direct: DirectLight::Photons, depth: 1, photons: 60_000, eye_paths: 1, iterations: 32 };

impl Look {
    /// Looks at the wall opposite to the window, far from its edges.
    fn take(&self, light: &str, objects: &str) -> Rendered {
        let options = Options {
            resolution: Some([16; 2]),
            photons: Some(self.photons),
            radius: Some(0.05),
            alpha: Some(1.0),
            max_depth: Some(self.depth),
            eye_paths: Some(self.eye_paths),
            direct: self.direct,
            // What a portal alone does for photons.
            guidance: Guidance::Off,
            ..Options::default()
        };
        let world = format!("{light}\nMaterial \"diffuse\" \"rgb reflectance\" [.7 .7 .7]\n{}{objects}", room());
        let text = scene_text(&camera(".6 0 0  -1 0 0  0 0 1", 30.0), &world);
        support::render(&text, &options, self.iterations)
    }
}

/// The walls stop all other light, too.
#[test]
fn a_portal_in_a_window_changes_noise_only() {
    let file = sky_image();
    let sky = format!("LightSource \"infinite\" \"string filename\" \"{}\"", file.path().display());
    let even = "LightSource \"infinite\" \"rgb L\" [.5 1 2] \"float scale\" 3";
    for light in [sky.as_str(), even] {
        let [open, portal] = ["", PORTAL].map(|portal| EYE.take(&format!("{light} {portal}"), ""));
        assert_near(&format!("{light}, by eye"), mean(&portal.image), mean(&open.image), 0.005);
        let carried = PHOTONS.take(&format!("{light} {PORTAL}"), "");
        assert_near(&format!("{light}, by photons"), mean(&carried.image), mean(&portal.image), 0.005);
        // Of light that has met one surface, only what is in the room meets another: outside the box is convex.
        let share = |portal: &str| {
            let look = Look { direct: DirectLight::Nee, depth: 2, iterations: 1, ..PHOTONS };
            let tally = look.take(&format!("{light} {portal}"), "").tally;
            tally.recorded as f64 / tally.emitted as f64
        };
        let [with, without] = [PORTAL, ""].map(share);
        println!("{with:.3} of the photons are in the room, {without:.3} without a portal");
        assert!(with > 0.5 && with > 4.0 * without, "{with} {without}");
    }
}

/// With light of several bounces.
#[test]
fn what_stands_before_a_portal_hides_the_sky() {
    let light = "LightSource \"infinite\" \"rgb L\" [1 1 1]";
    // In the open, a card that reflects would send light of the sky beside it into the room.
    let card = "Material \"diffuse\" \"rgb reflectance\" [0 0 0] Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
        \"point3 P\" [1.2 -.6 -.6  1.2 .1 -.6  1.2 .1 .6  1.2 -.6 .6]\n";
    let look = Look { depth: 6, photons: 60_000, eye_paths: 64, ..EYE };
    let [open, portal] = ["", PORTAL].map(|portal| look.take(&format!("{light} {portal}"), card));
    assert_near("by eye", mean(&portal.image), mean(&open.image), 0.01);
    let carried = Look { depth: 6, ..PHOTONS }.take(&format!("{light} {PORTAL}"), card);
    assert_near("by photons", mean(&carried.image), mean(&portal.image), 0.01);
}

/// As in pbrt, a portal is seen from one side, and what looks elsewhere is black.
#[test]
fn portals_have_a_side_and_the_rest_is_black() {
    let light = "LightSource \"infinite\" \"rgb L\" [1 1 1]";
    for look in [EYE, PHOTONS] {
        let dark = look.take(&format!("{light} {REVERSED}"), "");
        assert_eq!(mean(&dark.image), [0.0; 3]);
    }
    // From inside of the room through its window, and past a floor without a room.
    let seen = |look_at: &str| {
        let options = Options { resolution: Some([8; 2]), photons: Some(1), ..Options::default() };
        let text = scene_text(&camera(look_at, 5.0), &format!("{light} {PORTAL}\n{}", square(0.3, -0.9)));
        mean(&support::render(&text, &options, 1).image)
    };
    assert_near("through the portal", seen("0 0 0  1 0 0  0 0 1"), [1.0; 3], 1e-5);
    assert_eq!(seen("0 0 0  0 1 0  0 0 1"), [0.0; 3]);
    assert_eq!(seen("2 0 0  3 0 0  0 0 1"), [0.0; 3]);
}
