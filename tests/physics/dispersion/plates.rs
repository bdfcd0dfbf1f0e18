//! Where colours overlap again, white light stays white, but for what boundaries reflect: that depends on the index.
//!
//! Noise: the channels of single wavelengths have a variance of 2.2 to 3.8, so that N paths whose wavelengths are drawn by
//! chance have an error of up to 1.9 / sqrt(N) in the mean. Tests take 400,000 and more, which gives 0.3 %. Paths are spread
//! evenly over the wavelengths, and boundaries take some of them by chance: the error is about a half of that, and 0.5 % is
//! three times as much. Negative channels are 37 % of red and 13 % of the others: what clamps them is seen at once.

use std::f64::consts::PI;

use goblet::Options;
use goblet::render::options::Dispersion;

use super::super::{EYE_ONLY, Shot, assert_closed, assert_near, camera, scene_text, solid, square};
use crate::support::spectral::{CROWN, FLINT, reflectance};
use crate::support::{self, Rendered, mean};

fn dielectric(glass: &str, more: &str) -> String {
    format!("Material \"dielectric\" \"spectrum eta\" \"{glass}\" {more}\n")
}

impl Shot {
    /// The same with the mean index.
    fn take_unsplit(&self, camera: &str, world: &str) -> Rendered {
        let options = Options { dispersion: Dispersion::Off, ..self.options() };
        support::render(&scene_text(camera, world), &options, self.iterations)
    }
}

/// Seen at an angle, the lamp behind a plate is where it was, whatever the wavelength. Two crossings, and any number of
/// reflections inside between them: (1-R)² Σ R^2k.
#[test]
fn a_lamp_behind_a_plate_is_as_white_as_what_the_plate_lets_through() {
    let lamp = format!(
        "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [2 2 2]\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
         {}\nAttributeEnd\n",
        square(50.0, -1.0)
    );
    // Colours are means over windows of wavelengths, which a thin plate makes the widest and a thick one narrow.
    let plate = |thick: f64| dielectric("glass-F11", "") + &solid([-10.0, -10.0, 0.1 - thick], [10.0, 10.0, 0.1]);
    let pane = "Material \"thindielectric\" \"spectrum eta\" \"glass-F11\"\n".to_owned() + &square(10.0, 0.05);
    let shot = Shot { iterations: 8, ..EYE_ONLY };
    for (name, glass) in [("thin plate", plate(0.1)), ("plate", plate(0.4)), ("pane", pane)] {
        let world = format!("{lamp}{glass}");
        for degrees in [0.0, 65.0_f64] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let look = camera(&format!("{} 0 {}  0 0 0.1  0 1 0", 4.0 * sin, 4.0 * cos + 0.1), 2.0);
            let through = |eta: f64| {
                let reflected = reflectance(cos, eta);
                2.0 * (1.0 - reflected) / (1.0 + reflected)
            };
            let split = mean(&shot.take(&look, &world).image);
            assert_near(&format!("{name} at {degrees}°"), split, FLINT.seen(through), 0.005);
            let unsplit = mean(&shot.take_unsplit(&look, &world).image);
            assert_near(&format!("{name} at {degrees}° of one index"), unsplit, [through(FLINT.mean()); 3], 0.005);
        }
    }
}

/// A floor of two by two units close under a plate, seen from between the two, so that photons alone meet the plate. Light
/// from the side, and the plate's shadow, end outside of what is seen.
const FLOOR: Shot =
    Shot { resolution: [48; 2], photons: 65536, iterations: 16, radius: 0.1, alpha: 1.0, depth: 3, eye_paths: 4 };
const BENEATH: &str = "LookAt 0 0 .01  0 0 0  0 1 0\nCamera \"orthographic\" \"float screenwindow\" [-.8 .8 -.8 .8]";
const PLATE: [[f64; 3]; 2] = [[-1.0, -1.0, 0.02], [1.0, 1.0, 0.04]];

fn floor_under(glass: &str, degrees: f64) -> String {
    let (sin, cos) = degrees.to_radians().sin_cos();
    format!(
        "LightSource \"distant\" \"point3 from\" [{sin} 0 {cos}] \"point3 to\" [0 0 0] \"rgb L\" [3 3 3]\n\
         Material \"diffuse\" \"rgb reflectance\" [.8 .8 .8]\n{}\n{glass}",
        square(1.0, 0.0)
    )
}

/// Three segments leave out reflections inside the plate, and between plate and floor.
#[test]
fn white_light_through_a_plate_is_as_white_as_what_the_plate_lets_through() {
    for (name, sellmeier, degrees) in
        [("glass-F11", FLINT, 0.0), ("glass-F11", FLINT, 60.0_f64), ("glass-BK7", CROWN, 0.0)]
    {
        let cos = degrees.to_radians().cos();
        let lit = |eta: f64| 0.8 / PI * 3.0 * cos * (1.0 - reflectance(cos, eta)).powi(2);
        let world = floor_under(&(dielectric(name, "") + &solid(PLATE[0], PLATE[1])), degrees);
        let rendered = FLOOR.take(BENEATH, &world);
        assert_near(&format!("{name} at {degrees}°"), mean(&rendered.image), sellmeier.seen(lit), 0.005);
        assert_closed(&rendered.tally, 65536 * 16);
        let unsplit = FLOOR.take_unsplit(BENEATH, &world);
        let expected = [lit(sellmeier.mean()); 3];
        assert_near(&format!("{name} at {degrees}° of one index"), mean(&unsplit.image), expected, 0.005);
    }
}

/// Eye paths and photons take a wavelength each. A pixel has one visible point in an iteration: 260,000 in all. Errors of both
/// add up: 1 %.
#[test]
fn a_floor_lit_and_seen_through_a_plate_is_as_white_as_both_ways() {
    let world = floor_under(&(dielectric("glass-F11", "") + &solid(PLATE[0], PLATE[1])), 0.0);
    let shot = Shot { resolution: [64; 2], photons: 8192, iterations: 64, eye_paths: 1, ..FLOOR };
    let rendered = shot.take(&camera("0 0 5  0 0 0  0 1 0", 18.0), &world);
    let through = FLINT.seen(|eta| (1.0 - reflectance(1.0, eta)).powi(2));
    let expected = through.map(|through| 0.8 / PI * 3.0 * through * through);
    assert_near("both ways", mean(&rendered.image), expected, 0.01);
}
