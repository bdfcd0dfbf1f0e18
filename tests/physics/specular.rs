//! Glass and metal.

use std::f64::consts::PI;

use super::{EYE_ONLY, Shot, assert_closed, assert_near, assert_uniform, camera, solid, square};
use crate::support::mean;

#[test]
fn glass_of_any_shape_vanishes_in_a_furnace() {
    let place = |at: &str, shape: &str| format!("AttributeBegin\nTranslate {at}\n{shape}\nAttributeEnd\n");
    let mut world = "LightSource \"infinite\" \"rgb L\" [1 1 1]\n".to_owned();
    for (x, eta) in [(-2.0, 1.5), (0.0, 1.33), (2.0, 1.8)] {
        let prism = "Shape \"trianglemesh\" \"point3 P\" [0 .8 -.6  .7 -.4 -.6  -.7 -.4 -.6  0 .8 .6  .7 -.4 .6  -.7 -.4 .6] \
                     \"integer indices\" [0 1 2  3 5 4  0 4 1  0 3 4  1 5 2  1 4 5  2 3 0  2 5 3]";
        world += &format!("Material \"dielectric\" \"float eta\" {eta}\n");
        world += &place(&format!("{x} 3 0"), "Shape \"sphere\" \"float radius\" .8");
        world += &place(&format!("{x} 1 0"), "Rotate 40 1 2 3\nScale -.6 .9 .3\nReverseOrientation\nShape \"sphere\"");
        world += &place(&format!("{x} -1 0"), &format!("Rotate 30 1 2 0\n{}", solid([-0.6; 3], [0.6, 0.5, 0.4])));
        world += &place(&format!("{x} -3 0"), &format!("Rotate 20 1 -2 0\n{prism}"));
    }
    let rendered = Shot { resolution: [64; 2], iterations: 1, depth: 1000, ..EYE_ONLY }
        .take(&camera("0 0 12  0 0 0  0 1 0", 36.0), &world);
    assert_uniform("glass", &rendered.image, [1.0; 3], 0.005);
    assert_eq!(rendered.tally.lost_in_glass, 0);
}

/// Reflectance of glass of index 1.5 for unpolarised light.
fn glass_reflectance(cos_i: f64) -> f64 {
    let cos_t = (1.0 - (1.0 - cos_i * cos_i) / 2.25).sqrt();
    let parallel = (1.5 * cos_i - cos_t) / (1.5 * cos_i + cos_t);
    let perpendicular = (cos_i - 1.5 * cos_t) / (cos_i + 1.5 * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

const TINT: [f64; 3] = [0.9, 0.6, 0.3];
const TINTED: &str = "Material \"dielectric\" \"float eta\" 1.5 \"rgb transmittance\" [.9 .6 .3]\n";

/// Two crossings, and any number of reflections inside between them: t² (1-R)² Σ R^2k.
#[test]
fn a_tinted_pane_darkens_what_is_behind_it() {
    let world = format!(
        "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [2 2 2]\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
         {}\nAttributeEnd\n{TINTED}{}",
        square(50.0, -1.0),
        solid([-10.0, -10.0, 0.0], [10.0, 10.0, 0.1])
    );
    for degrees in [0.0, 40.0, 65.0_f64] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let look = camera(&format!("{} 0 {}  0 0 0.1  0 1 0", 4.0 * sin, 4.0 * cos + 0.1), 2.0);
        let rendered = Shot { iterations: 8, ..EYE_ONLY }.take(&look, &world);
        let reflected = glass_reflectance(cos);
        let expected = TINT.map(|tint| 2.0 * tint * tint * (1.0 - reflected) / (1.0 + reflected));
        assert_near(&format!("pane at {degrees}°"), mean(&rendered.image), expected, 0.005);
    }
}

/// A floor of two by two units from above, lit by photons.
const FLOOR: Shot =
    Shot { resolution: [24; 2], photons: 32768, iterations: 32, radius: 0.15, alpha: 0.667, depth: 3, eye_paths: 4 };

/// The eye path and the photons cross the pane, once each way: both tints count, and the
/// photons that meet the glass within the floor's radius do not. Three segments leave out
/// reflections inside the pane, and between pane and floor.
#[test]
fn a_floor_lit_and_seen_through_a_tinted_pane_is_darkened_twice() {
    let world = format!(
        "LightSource \"distant\" \"point3 from\" [0 0 1] \"point3 to\" [0 0 0] \"rgb L\" [3 3 3]\n\
         Material \"diffuse\" \"rgb reflectance\" [.8 .8 .8]\n{}\n{TINTED}{}",
        square(1.0, 0.0),
        solid([-1.1, -1.1, 0.02], [1.1, 1.1, 0.04])
    );
    let shot = FLOOR;
    let rendered = shot.take(&camera("0 0 5  0 0 0  0 1 0", 12.0), &world);
    let crossing = 1.0 - glass_reflectance(1.0);
    let expected = TINT.map(|tint| 0.8 / PI * 3.0 * (tint * crossing).powi(4));
    assert_near("floor under a pane", mean(&rendered.image), expected, 0.01);
    assert_closed(&rendered.tally, 32768 * 32);
}

/// Reflectance of a metal of index eta + ik for unpolarised light, by complex arithmetic.
fn metal_reflectance(cos_i: f64, eta: f64, k: f64) -> f64 {
    let divide = |a: [f64; 2], b: [f64; 2]| {
        let size = b[0] * b[0] + b[1] * b[1];
        [(a[0] * b[0] + a[1] * b[1]) / size, (a[1] * b[0] - a[0] * b[1]) / size]
    };
    let square = |a: [f64; 2]| [a[0] * a[0] - a[1] * a[1], 2.0 * a[0] * a[1]];
    let sin2_t = divide([1.0 - cos_i * cos_i, 0.0], square([eta, k]));
    let root = |a: [f64; 2]| {
        let size = a[0].hypot(a[1]);
        [((size + a[0]) / 2.0).sqrt(), ((size - a[0]) / 2.0).sqrt().copysign(a[1])]
    };
    let cos_t = root([1.0 - sin2_t[0], -sin2_t[1]]);
    let times = |a: [f64; 2], b: [f64; 2]| [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
    let amplitude = |a: [f64; 2], b: [f64; 2]| {
        let ratio = divide([a[0] - b[0], a[1] - b[1]], [a[0] + b[0], a[1] + b[1]]);
        ratio[0] * ratio[0] + ratio[1] * ratio[1]
    };
    let index = [eta, k];
    let parallel = amplitude([eta * cos_i, k * cos_i], cos_t);
    let perpendicular = amplitude([cos_i, 0.0], times(index, cos_t));
    0.5 * (parallel + perpendicular)
}

const METAL: &str = "Material \"conductor\" \"rgb eta\" [.2 .9 1.5] \"rgb k\" [3.9 2.4 1.9] \"float roughness\" 0\n";
const ETA_K: [[f64; 2]; 3] = [[0.2, 3.9], [0.9, 2.4], [1.5, 1.9]];

#[test]
fn a_mirror_corner_reflects_three_times() {
    let corner = "Shape \"trianglemesh\" \"integer indices\" [0 1 2  0 2 3  0 3 1] \
                  \"point3 P\" [0 0 0  9 0 0  0 9 0  0 0 9]";
    let world = format!("LightSource \"infinite\" \"rgb L\" [1 1 1]\n{METAL}{corner}");
    let eye = [1.2, 1.0, 0.7_f64];
    let rendered = EYE_ONLY.take(&camera("1.2 1 .7  0 0 0  0 1 0", 1.0), &world);
    let length = eye.iter().map(|x| x * x).sum::<f64>().sqrt();
    let expected = ETA_K.map(|[eta, k]| eye.iter().map(|x| metal_reflectance(x / length, eta, k)).product());
    assert_uniform("mirror corner", &rendered.image, expected, 0.05);
}

/// A mirror at 45° sends level light down, as wide as it came. Two segments leave out what
/// goes back up.
#[test]
fn photons_carry_what_a_mirror_reflects() {
    let world = format!(
        "LightSource \"distant\" \"point3 from\" [-1 0 0] \"point3 to\" [0 0 0] \"rgb L\" [3 3 3]\n\
         Material \"diffuse\" \"rgb reflectance\" [.8 .8 .8]\n{}\n{METAL}\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-1 -1 2.2  1 -1 .2  1 1 .2  -1 1 2.2]",
        square(1.0, 0.0)
    );
    let shot = Shot { depth: 2, ..FLOOR };
    let rendered = shot.take(&camera("0 -1 .6  0 0 0  0 0 1", 20.0), &world);
    let expected = ETA_K.map(|[eta, k]| 0.8 / PI * 3.0 * metal_reflectance(0.5_f64.sqrt(), eta, k));
    assert_near("mirrored floor", mean(&rendered.image), expected, 0.01);
    assert_closed(&rendered.tally, 32768 * 32);
    assert!(rendered.tally.absorbed > 0);
}
