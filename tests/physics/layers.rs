//! Rough, coated, thin and translucent surfaces.

use std::f64::consts::PI;

use goblet::{DirectLight, Options};

use super::{EYE_ONLY, Shot, assert_near, assert_uniform, camera, scene_text, square};
use crate::support::{self, mean, work};

/// What absorbs nothing, and meets light once, is as bright as the sky.
#[test]
fn white_layers_vanish_in_a_furnace() {
    let pale = "\"string type\" \"diffuse\" \"rgb reflectance\" [1 1 1]";
    let named =
        format!("MakeNamedMaterial \"pale\" {pale}\nMakeNamedMaterial \"pane\" \"string type\" \"thindielectric\"\n");
    let sheets = [
        "\"diffusetransmission\" \"rgb reflectance\" [.2 .5 .9] \"rgb transmittance\" [.8 .5 .1]",
        "\"coateddiffuse\" \"rgb reflectance\" [1 1 1] \"float thickness\" 0",
        "\"thindielectric\" \"float eta\" 1.8",
        "\"mix\" \"string materials\" [\"pale\" \"pane\"] \"float amount\" .3",
    ];
    for sheet in sheets {
        let sky = "LightSource \"infinite\" \"rgb L\" [1 1 1]";
        let world = format!("{sky}\n{named}Material {sheet}\nRotate 40 1 2 0\n{}", square(5.0, 0.0));
        let rendered = EYE_ONLY.take(&camera("0 0 4  0 0 0  0 1 0", 30.0), &world);
        assert_uniform(sheet, &rendered.image, [1.0; 3], 0.3);
    }
}

const LIGHT: &str = "LightSource \"point\" \"rgb I\" [9 9 9] \"point3 from\" [3 0 4]\n";

/// Cosine at the light of what lies at the origin, and the irradiance there.
const COS_I: f64 = 0.8;
const IRRADIANCE: f64 = 9.0 * COS_I / 25.0;

/// GGX as Walter and others have it (2007, eq. 33 and 34) with Smith's joint masking, for
/// light that leaves straight up.
fn facets(alpha: f64) -> f64 {
    let half_cos2 = (1.0 + COS_I) / 2.0;
    let tan2 = 1.0 / half_cos2 - 1.0;
    let d = alpha * alpha / (PI * half_cos2 * half_cos2 * (alpha * alpha + tan2).powi(2));
    let tan2_i = 1.0 / (COS_I * COS_I) - 1.0;
    let lambda_i = 0.5 * ((1.0 + alpha * alpha * tan2_i).sqrt() - 1.0);
    d / (4.0 * COS_I * (1.0 + lambda_i))
}

#[test]
fn rough_metal_shines_under_a_point_light() {
    for (roughness, alpha) in
        [("\"float roughness\" .16", 0.4), ("\"float roughness\" .7 \"bool remaproughness\" false", 0.7)]
    {
        let metal = format!("Material \"conductor\" \"rgb eta\" [.001 .001 .001] \"rgb k\" [99 99 99] {roughness}\n");
        let world = format!("{LIGHT}{metal}{}", square(5.0, 0.0));
        let rendered = Shot { iterations: 1, ..EYE_ONLY }.take(&camera("0 0 6  0 0 0  0 1 0", 0.2), &world);
        assert_near(&metal, mean(&rendered.image), [facets(alpha) * IRRADIANCE; 3], 0.01);
    }
}

fn fresnel(cos_i: f64, eta: f64) -> f64 {
    let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (eta * eta)).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// In the closed form, and the same by photons that enter the coat as by next-event
/// estimation. What the coat's underside reflects of diffuse light is 0.5964 at 1.5.
#[test]
fn a_coated_surface_has_the_radiance_of_the_closed_form() {
    let albedo = [0.9, 0.5, 0.1];
    let world = format!(
        "{LIGHT}Material \"coateddiffuse\" \"rgb reflectance\" [.9 .5 .1] \"float thickness\" 0\n{}",
        square(0.5, 0.0)
    );
    let through = (1.0 - fresnel(1.0, 1.5)) * (1.0 - fresnel(COS_I, 1.5)) / 2.25;
    let expected = albedo.map(|albedo| IRRADIANCE / PI * through * albedo / (1.0 - 0.5964 * albedo));
    for direct in [DirectLight::Nee, DirectLight::Photons] {
        let options = Options {
            resolution: Some([16; 2]),
            photons: Some(work(400_000, 1_600_000)),
            radius: Some(0.05),
            alpha: Some(1.0),
            direct,
            ..Options::default()
        };
        let look = camera("0 0 6  0 0 0  0 1 0", 2.0);
        let rendered = support::render(&format!("{look}\nWorldBegin\n{world}"), &options, 16);
        assert_near(&format!("{direct:?}"), mean(&rendered.image), expected, 0.02);
    }
}

/// A checkerboard of two thicknesses shows what coats of each of them do, to eye paths and to photons.
#[test]
fn a_textured_thickness_is_that_of_each_point() {
    let board = "Texture \"t\" \"float\" \"checkerboard\" \"float uscale\" 1 \"float vscale\" 2 \
        \"float tex1\" 0.05 \"float tex2\" 1.5\n";
    let metal = "\"rgb conductor.eta\" [.2 .9 1.5] \"rgb conductor.k\" [3 2 6] \"float conductor.roughness\" .1";
    let sky = "LightSource \"infinite\" \"rgb L\" [1 1 1]\n";
    for (coated, lights, direct) in [
        ("\"coateddiffuse\" \"rgb reflectance\" [.9 .5 .1]".to_string(), sky, DirectLight::Nee),
        ("\"coateddiffuse\" \"rgb reflectance\" [.9 .5 .1]".to_string(), LIGHT, DirectLight::Photons),
        (format!("\"coatedconductor\" {metal}"), sky, DirectLight::Nee),
    ] {
        let halves = |thickness: &str| {
            let surface = "\"point2 uv\" [0 0 1 0 1 1 0 1]";
            let world = format!("{lights}{board}Material {coated} {thickness}\n{} {surface}", square(1.0, 0.0));
            let options = Options {
                resolution: Some([16; 2]),
                photons: Some(if direct == DirectLight::Photons { 200_000 } else { 1 }),
                eye_paths: Some(64),
                radius: Some(0.02),
                alpha: Some(1.0),
                direct,
                ..Options::default()
            };
            // Light that photons carry is blurred at the edge: half of the rows are far from it.
            let look = camera("0 0 1  0 0 0  0 1 0", 60.0);
            let rendered = support::render(&scene_text(&look, &world), &options, 8);
            let half = |rows: std::ops::Range<usize>| {
                let pixels = &rendered.image.pixels[16 * rows.start..16 * rows.end];
                let sum = |c: usize| pixels.iter().map(|pixel| f64::from(pixel[c])).sum::<f64>();
                [0, 1, 2].map(|c| sum(c) / pixels.len() as f64)
            };
            [half(1..7), half(9..15)]
        };
        let textured = halves("\"texture thickness\" \"t\"");
        let (thin, thick) = (halves("\"float thickness\" 0.05"), halves("\"float thickness\" 1.5"));
        let tolerance = if direct == DirectLight::Photons { 0.01 } else { 0.005 };
        let [upper, lower] = textured;
        assert_near(&format!("{coated} above, {direct:?}"), upper, thick[0], tolerance);
        assert_near(&format!("{coated} below, {direct:?}"), lower, thin[1], tolerance);
    }
}
