//! All light on one pixel.

use std::f64::consts::PI;

use goblet::{ByPass, DirectLight, Options};

use super::{assert_near, camera, square};
use crate::support::{mean, render};

/// Ten million photons in one iteration, all on one visible point's disc: their sum passes
/// 32 bits, and is right to the last photon.
#[test]
fn ten_million_photons_on_one_pixel_are_all_counted() {
    const PHOTONS: u64 = 10_000_000;
    let (angle, falloff) = (1.0_f64, 0.5_f64);
    let world = format!(
        "LightSource \"spot\" \"point3 from\" [0 0 1] \"point3 to\" [0 0 0] \"rgb I\" [7 5 3] \
         \"float coneangle\" {angle} \"float conedeltaangle\" {falloff}\n\
         Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n{}",
        square(0.5, 0.0)
    );
    let radius = 0.1;
    let options = Options {
        resolution: Some([1, 1]),
        photons: Some(PHOTONS),
        radius: Some(radius),
        max_depth: Some(1),
        direct: DirectLight::Photons,
        ..Options::default()
    };
    let text = format!("{}\nWorldBegin\n{world}", camera("0 0 2  0 0 0  0 1 0", 0.1));
    let rendered = render(&text, &options, 1);
    assert_eq!((rendered.tally.recorded, rendered.tally.saturated), (PHOTONS, ByPass::default()));
    // The falloff is symmetric in the cosine between the two angles.
    let [inner, outer] = [angle - falloff, angle].map(|angle| 1.0 - angle.to_radians().cos());
    let solid_angle = 2.0 * PI * 0.5 * (inner + outer);
    let expected = [7.0, 5.0, 3.0].map(|intensity| 0.5 / PI * intensity * solid_angle / (PI * radius * radius));
    assert_near("radiance", mean(&rendered.image), expected, 2e-4);
}

/// A lamp far smaller and brighter than anything that the sums have room for.
#[test]
fn light_that_is_too_bright_is_counted_as_saturated() {
    let world = |radius: f64| {
        format!(
            "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\nMaterial \"diffuse\"\n\
             Shape \"sphere\" \"float radius\" {radius}\nAttributeEnd\n{}",
            square(1.0, 1.0)
        )
    };
    let saturated = |radius: f64| {
        let options = Options { resolution: Some([1, 1]), photons: Some(1000), ..Options::default() };
        let camera = camera(&format!("0 0 {}  0 0 0  0 1 0", -100.0 * radius), 0.1);
        let rendered = render(&format!("{camera}\nWorldBegin\n{}", world(radius)), &options, 3);
        assert_eq!(rendered.tally.saturated, ByPass { update: rendered.tally.saturated.update, ..ByPass::default() });
        (rendered.tally.saturated.update, mean(&rendered.image)[0])
    };
    let (within, radiance) = saturated(1e-5);
    assert_eq!((within, radiance), (0, 1.0));
    let (beyond, radiance) = saturated(1e-7);
    assert_eq!(beyond, 3);
    assert!(radiance > 0.05 && radiance < 1.0, "{radiance}");
}
