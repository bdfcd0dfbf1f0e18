//! Shading normals: eye paths weight light by them, and so must photons (Veach 1997, section 5.3).

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write;

use goblet::{DirectLight, Options};

use super::{EYE_ONLY, camera};
use crate::support::{self, Rendered, mean, work};

/// A ball of few triangles about the origin, with the normals of a sphere.
fn smooth_ball(radius: f64, stacks: usize, slices: usize) -> String {
    let (mut normals, mut triangles) = (Vec::new(), String::new());
    for i in 0..=stacks {
        let (sin, cos) = (PI * i as f64 / stacks as f64 - FRAC_PI_2).sin_cos();
        for j in 0..slices {
            let (y, x) = (TAU * j as f64 / slices as f64).sin_cos();
            normals.push([cos * x, cos * y, sin]);
            if i < stacks {
                let at = |i: usize, j: usize| i * slices + j % slices;
                let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                write!(triangles, "{a} {b} {c} {a} {c} {d} ").expect("text");
            }
        }
    }
    let text = |scale: f64| normals.iter().flatten().map(|x| format!("{:.9}", scale * x)).collect::<Vec<_>>().join(" ");
    format!(
        "Shape \"trianglemesh\" \"integer indices\" [{triangles}] \"point3 P\" [{}] \"normal N\" [{}]\n",
        text(radius),
        text(1.0)
    )
}

const GREY: &str = "Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n";
const FILTER: &str = "PixelFilter \"box\" \"float xradius\" .5 \"float yradius\" .5";

fn render(look: &str, world: &str, options: Options, iterations: u32) -> Rendered {
    support::render(&format!("{FILTER}\n{look}\nWorldBegin\n{world}"), &options, iterations)
}

/// A ball that is lit from a point and from all around: straight from the light by eye paths, and
/// by photons. The point shines into a cone about the ball, so that nine photons in ten meet it: half
/// of more than a million are in sight, and discs of a hundredth cover that side once, so that the
/// mean over the image has a noise of about 0.2 %. Wider discs lose light at the ball's edges.
#[test]
fn a_smooth_ball_is_lit_alike_by_eye_paths_and_photons() {
    let look = camera("0 -4 1  0 0 0  0 0 1", 30.0);
    for light in [
        "LightSource \"spot\" \"point3 from\" [2 -3 3] \"point3 to\" [0 0 0] \"float coneangle\" 12 \"rgb I\" [30 30 30]\n",
        "LightSource \"infinite\" \"rgb L\" [1 1 1]\n",
    ] {
        let world = format!("{light}{GREY}{}", smooth_ball(0.9, 6, 10));
        let by = |direct: DirectLight| {
            let options = Options {
                resolution: Some([64, 64]),
                photons: Some(200_000),
                radius: Some(0.01),
                alpha: Some(1.0),
                max_depth: Some(1),
                direct,
                ..Options::default()
            };
            mean(&render(&look, &world, options, work(8, 24)).image)[0]
        };
        let [eye, photons] = [DirectLight::Nee, DirectLight::Photons].map(by);
        println!("{light}: {eye:.5} by eye paths, {photons:.5} by photons, ratio {:.4}", photons / eye);
        assert!((photons / eye - 1.0).abs() < 0.01, "{light}: {eye} {photons}");
    }
}

/// Albedo of a floor that sends next to nothing back to the glass above it.
const DARK: f64 = 0.01;

/// A part of a floor at z = 0, of albedo [`DARK`], under something that refracts light.
#[derive(Clone, Copy)]
pub(super) struct Floor {
    /// Radius of the disc over which its radiance is averaged.
    pub radius: f64,
    /// Largest angle in degrees at which light comes to it, from the axes of the image.
    pub angle: f64,
}

/// Radiance of a floor by eye paths that look up from there: the integral of what they see.
pub(super) fn floor_by_eye_paths(floor: Floor, world: &str, iterations: u32) -> f64 {
    let pixels = 96;
    // The lens is as large as the disc on which photons are gathered.
    let up = format!(
        "LookAt .05 .02 1e-4  .05 .02 1  0 1 0\nCamera \"perspective\" \"float fov\" {} \
         \"float lensradius\" {} \"float focaldistance\" 1e4",
        2.0 * floor.angle,
        floor.radius
    );
    let options = Options {
        resolution: Some([pixels; 2]),
        photons: Some(1),
        eye_paths: Some(64),
        max_depth: Some(EYE_ONLY.depth),
        ..Options::default()
    };
    let image = render(&up, world, options, iterations).image;
    // The sum of L cos over solid angle: a pixel on the plane z = 1 shows cos³ of its area.
    let half = floor.angle.to_radians().tan();
    let at = |i: usize| half * ((2 * i + 1) as f64 / f64::from(pixels) - 1.0);
    let weight = |index: usize| {
        let (x, y) = (at(index % pixels as usize), at(index / pixels as usize));
        (1.0 + x * x + y * y).powi(-2)
    };
    let sum: f64 = image.pixels.iter().enumerate().map(|(i, pixel)| f64::from(pixel[0]) * weight(i)).sum();
    DARK / PI * sum * (2.0 * half / f64::from(pixels)).powi(2)
}

/// The same by photons.
pub(super) fn floor_by_photons(Floor { radius, .. }: Floor, world: &str, iterations: u32) -> f64 {
    let down = "LookAt .05 .02 .2  .05 .02 0  0 1 0\n\
                Camera \"orthographic\" \"float screenwindow\" [-1e-4 1e-4 -1e-4 1e-4]";
    let floor = format!(
        "Material \"diffuse\" \"rgb reflectance\" [{DARK} {DARK} {DARK}]\nShape \"disk\" \"float radius\" {}\n",
        2.5 * radius
    );
    let options = Options {
        resolution: Some([8, 8]),
        photons: Some(3_000_000),
        radius: Some(radius),
        alpha: Some(1.0),
        max_depth: Some(EYE_ONLY.depth),
        direct: DirectLight::Photons,
        ..Options::default()
    };
    mean(&render(down, &format!("{world}{floor}"), options, iterations).image)[0]
}

/// The light of a lamp through a smooth ball of glass, on a floor: by photons, and by eye paths that
/// look up from there.
#[test]
fn smooth_glass_passes_as_much_light_either_way() {
    let lamp = "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [5 5 5]\n\
                Material \"diffuse\" \"rgb reflectance\" [0 0 0]\nTranslate 0 0 3\nRotate 180 1 0 0\n\
                Shape \"disk\" \"float radius\" 1.5\nAttributeEnd\n";
    for [stacks, slices] in work(&[[3, 4]][..], &[[3, 4], [6, 9]]).iter().copied() {
        let glass = format!(
            "AttributeBegin\nMaterial \"dielectric\"\nTranslate .1 0 1.3\nRotate 20 1 2 3\n{}AttributeEnd\n",
            smooth_ball(0.6, stacks, slices)
        );
        let world = format!("{lamp}{glass}");
        let floor = Floor { radius: 0.4, angle: 60.0 };
        let expected = floor_by_eye_paths(floor, &world, 3);
        let measured = floor_by_photons(floor, &world, work(2, 8));
        println!("{stacks}x{slices}: {expected:.6} by eye paths, {measured:.6} by photons, {:.4}", measured / expected);
        assert!((measured / expected - 1.0).abs() < 0.01, "{stacks}x{slices}: {expected} {measured}");
    }
}

/// Normals count: the same triangles without them cast another caustic.
#[test]
fn normals_change_what_photons_do() {
    let ball = smooth_ball(0.6, 6, 9);
    let flat = format!("{}\n", ball.split(" \"normal N\"").next().expect("text"));
    let images = [&ball, &flat].map(|ball| {
        let world = format!(
            "LightSource \"point\" \"point3 from\" [0 0 4] \"rgb I\" [30 30 30]\n{GREY}Shape \"disk\" \"float radius\" 3\n\
             Material \"dielectric\"\nTranslate 0 0 1\n{ball}"
        );
        let options = Options {
            resolution: Some([24, 24]),
            photons: Some(100_000),
            radius: Some(0.1),
            max_depth: Some(12),
            ..Options::default()
        };
        render(&camera("0 -3 3  0 0 0  0 0 1", 40.0), &world, options, 4).image
    });
    let difference = goblet::image::compare::compare(&images[0], &images[1]).expect("images of one size");
    assert!(difference.relmse > 0.05, "{difference:?}");
}
