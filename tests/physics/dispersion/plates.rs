//! Where colours overlap again, white light stays white, but for what boundaries reflect: that depends on the index.
//!
//! Noise: the channels of single wavelengths have a variance of 2.2 to 3.8, so that N paths whose wavelengths are drawn by
//! chance have an error of up to 1.9 / sqrt(N) in the mean. Tests take 400,000 and more, which gives 0.3 %. Paths are spread
//! evenly over the wavelengths, and boundaries take some of them by chance: the error is about a half of that, and 0.5 % is
//! three times as much. Negative channels are 37 % of red and 13 % of the others: what clamps them is seen at once.

use std::f64::consts::PI;

use goblet::Options;
use goblet::render::options::Dispersion;

use super::super::{EYE_ONLY, Shot, assert_closed, assert_near, assert_pixels, camera, scene_text, solid, square};
use crate::support::spectral::{self, CROWN, FLINT, daylight, reflectance, seen};
use crate::support::{self, Rendered, mean};

const WHITE: [f64; 3] = [1.0; 3];

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

/// Bodies of every kind of boundary before light that comes evenly from everywhere. Rays that enter take a wavelength,
/// and are reflected in total at some angles.
#[test]
fn glass_that_splits_light_vanishes_in_a_furnace() {
    let place = |at: &str, shape: &str| format!("AttributeBegin\nTranslate {at}\n{shape}\nAttributeEnd\n");
    let prism = "Shape \"trianglemesh\" \"point3 P\" [0 .8 -.6  .7 -.4 -.6  -.7 -.4 -.6  0 .8 .6  .7 -.4 .6  -.7 -.4 .6] \
                 \"integer indices\" [0 1 2  3 5 4  0 4 1  0 3 4  1 5 2  1 4 5  2 3 0  2 5 3]";
    let mut world = "LightSource \"infinite\" \"rgb L\" [1 1 1]\n".to_owned();
    // The last is a medium thinner than air for some wavelengths, and denser for others.
    let indices = ["\"glass-F11\"", "[400 1.9 550 1.3 700 1.2]", "[400 1.05 700 .95]"];
    for (x, eta) in [-2.0, 0.0, 2.0].into_iter().zip(indices) {
        world += &format!("Material \"dielectric\" \"spectrum eta\" {eta}\n");
        world += &place(&format!("{x} 3 0"), "Shape \"sphere\" \"float radius\" .8");
        world += &place(&format!("{x} 1 0"), "Rotate 40 1 2 3\nScale -.6 .9 .3\nReverseOrientation\nShape \"sphere\"");
        world += &place(&format!("{x} -1 0"), &format!("Rotate 30 1 2 0\n{}", solid([-0.6; 3], [0.6, 0.5, 0.4])));
        world += &place(&format!("{x} -3 0"), &format!("Rotate 20 1 -2 0\n{prism}"));
    }
    let shot = Shot { resolution: [96; 2], iterations: 1, depth: 1000, ..EYE_ONLY };
    let rendered = shot.take(&camera("0 0 12  0 0 0  0 1 0", 36.0), &world);
    // Colours are means over windows of wavelengths, as wide as the gather radius of three pixels does not show. Where glass is
    // curved, the windows differ by wavelength: half a percent at these pixels, and twice that for the steep list. It is
    // less at smaller pixels and after more iterations.
    assert_near("glass", mean(&rendered.image), WHITE, 0.005);
    for (third, (eta, tolerance)) in indices.iter().zip([0.005, 0.01, 0.005]).enumerate() {
        let mut part = rendered.image.clone();
        part.pixels = part.pixels.chunks(32).skip(third).step_by(3).flatten().copied().collect();
        assert_near(eta, mean(&part), WHITE, tolerance);
    }
    // 64 paths of a pixel: 0.25 by chance.
    assert_pixels("glass", &rendered.image, WHITE, 1.2);
    assert_eq!(rendered.tally.lost_in_glass, 0);
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

/// How much a rough plate lets through depends on the index, since light that it scatters is reflected in total inside. It
/// is rendered for three indices; a parabola through them says what each channel sees.
#[test]
fn white_light_through_a_rough_plate_is_as_white_as_the_mean_over_indices() {
    let rough = "\"float roughness\" .1";
    let floor = |material: &str| {
        let world = floor_under(&(material.to_owned() + &solid(PLATE[0], PLATE[1])), 0.0);
        mean(&FLOOR.take(BENEATH, &world).image)
    };
    let etas = [1.75, 1.79, 1.85];
    let lit = etas.map(|eta| floor(&format!("Material \"dielectric\" \"float eta\" {eta} {rough}\n"))[0]);
    let parabola = |eta: f64| {
        let term = |i: usize| {
            let others = [(i + 1) % 3, (i + 2) % 3].map(|other| (eta - etas[other]) / (etas[i] - etas[other]));
            lit[i] * others[0] * others[1]
        };
        term(0) + term(1) + term(2)
    };
    assert_near("rough plate", floor(&dielectric("glass-F11", rough)), FLINT.seen(parabola), 0.005);
}

/// Coats take no wavelength, and have the mean index for paths that have none: light that goes to the floor at once is the
/// same with dispersion and without. A photon that has crossed a plate enters the coat by the index of its wavelength; what
/// the base sends up and what the eye sees have the mean index, with a plate of one index too.
#[test]
fn a_coat_under_a_plate_meets_each_wavelength_by_its_index() {
    let coat = "Material \"coateddiffuse\" \"spectrum eta\" [400 2.4 700 1.3] \"rgb reflectance\" [.8 .8 .8] \
                \"float roughness\" 0 \"float thickness\" 0\n";
    let eta_of_coat = |nm: f64| 2.4 - 1.1 * ((nm - 400.0) / 300.0).clamp(0.0, 1.0);
    let coated =
        |glass: &str| floor_under(glass, 30.0).replace("Material \"diffuse\" \"rgb reflectance\" [.8 .8 .8]\n", coat);
    let [open, unsplit] = [Shot::take, Shot::take_unsplit].map(|take| mean(&take(&FLOOR, BENEATH, &coated("")).image));
    assert_near("coat", open, unsplit, 1e-5);

    let plate = dielectric("glass-F11", "") + &solid(PLATE[0], PLATE[1]);
    let [under, unsplit] =
        [Shot::take, Shot::take_unsplit].map(|take| mean(&take(&FLOOR, BENEATH, &coated(&plate)).image));
    let cos = 30_f64.to_radians().cos();
    let through = |plate: f64, coat: f64| (1.0 - reflectance(cos, plate)).powi(2) * (1.0 - reflectance(cos, coat));
    let change = seen(|nm| through(FLINT.eta(nm), eta_of_coat(nm)));
    let unchanged = through(FLINT.mean(), spectral::mean(eta_of_coat));
    let expected = [0, 1, 2].map(|channel| unsplit[channel] * change[channel] / unchanged);
    assert_near("coat under a plate", under, expected, 0.01);
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

/// A lamp that is a black body keeps its color behind a plate: red light of its own spectrum, and not of daylight.
#[test]
fn a_black_body_behind_a_plate_keeps_its_color() {
    let lamp = "AttributeBegin\nAreaLightSource \"diffuse\" \"blackbody L\" 2500\n\
                Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n"
        .to_owned()
        + &square(50.0, -1.0)
        + "\nAttributeEnd\n";
    let world = lamp + &dielectric("glass-F11", "") + &solid([-10.0, -10.0, -0.3], [10.0, 10.0, 0.1]);
    let shot = Shot { iterations: 8, ..EYE_ONLY };
    let look = camera("0 0 4  0 0 0  0 1 0", 2.0);
    let [split, unsplit] =
        [shot.take(&look, &world), shot.take_unsplit(&look, &world)].map(|rendered| mean(&rendered.image));
    let through = |eta: f64| {
        let reflected = reflectance(1.0, eta);
        (1.0 - reflected) / (1.0 + reflected)
    };
    // Planck's law.
    let lamp = |nm: f64| nm.powi(-5) / (1.438777e7 / (nm * 2500.0)).exp_m1() / daylight(nm);
    let [shown, kept] = [seen(lamp), seen(|nm| lamp(nm) * through(FLINT.eta(nm)))];
    let tint = [0, 1, 2].map(|channel| kept[channel] / shown[channel] / through(FLINT.mean()));
    assert_near("black body", split, [0, 1, 2].map(|channel| unsplit[channel] * tint[channel]), 0.005);
}
