//! Meshes that are awkward: needles, duplicates, coplanar faces, rays at edges and corners.

use goblet::image::film::Image;

use super::{EYE_ONLY, Shot, assert_exact, assert_same, block, camera, diffuse, lamp, render, solid, square};
use crate::support::{device, mean};

fn mesh(points: &[[f64; 3]], triangles: &[[usize; 3]]) -> String {
    let join = |values: Vec<String>| values.join(" ");
    let points = join(points.iter().flatten().map(f64::to_string).collect());
    let triangles = join(triangles.iter().flatten().map(usize::to_string).collect());
    format!("Shape \"trianglemesh\" \"integer indices\" [{triangles}] \"point3 P\" [{points}]\n")
}

/// The square of half width 2 at z = 0, in strips that end at these x.
fn strips(ends: &[f64]) -> String {
    let points: Vec<[f64; 3]> = ends.iter().flat_map(|x| [[*x, -2.0, 0.0], [*x, 2.0, 0.0]]).collect();
    let strip = |i: usize| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]];
    mesh(&points, &(0..ends.len() - 1).flat_map(strip).collect::<Vec<_>>())
}

/// A glass ball and a white one over a floor.
fn over(device: &std::sync::Arc<goblet_host::Device>, floor: &str) -> Image {
    let shot =
        Shot { resolution: [24, 24], photons: 5000, iterations: 3, radius: 0.25, alpha: 1.0, depth: 6, eye_paths: 4 };
    let world = format!(
        "LightSource \"point\" \"point3 from\" [1 0 3] \"rgb I\" [9 9 9]\n{}{floor}{}{}",
        diffuse(0.5),
        block("Translate 1.1 0 .5 Shape \"sphere\" \"float radius\" .5"),
        block("Material \"dielectric\"\nTranslate 0 0 .7\nShape \"sphere\" \"float radius\" .5")
    );
    shot.take_checked(device, &camera("0 -4 3  0 0 .3  0 0 1", 40.0), &world).image
}

/// However a floor is cut, it is the same floor.
#[test]
fn a_floor_of_needles_and_slivers_is_a_floor() {
    let device = device();
    let expected = over(&device, &square(2.0, 0.0));
    assert!(mean(&expected)[0] > 0.02);
    let needles: Vec<f64> = (0..=2000).map(|i| -2.0 + 0.002 * f64::from(i)).collect();
    assert_same("needles", &over(&device, &strips(&needles)), &expected, 1e-4);
    // Every second strip is 1e-6 wide, and some are narrower than fp32 tells apart.
    let slivers: Vec<f64> = (0..40)
        .flat_map(|i| [0.1, 0.1 + 1e-6, 0.1 + 1e-6 + 1e-9].map(|x| -2.1 + x + 0.1 * f64::from(i)))
        .chain([2.0])
        .collect();
    assert_same("slivers", &over(&device, &strips(&slivers)), &expected, 1e-4);
    // A fan of needles that all meet in a corner outside.
    let fan: Vec<[f64; 3]> = [[-2.0, -2.0, 0.0]]
        .into_iter()
        .chain((0..=500).map(|i| [2.0, -2.0 + 0.008 * f64::from(i), 0.0]))
        .chain((1..=500).map(|i| [2.0 - 0.008 * f64::from(i), 2.0, 0.0]))
        .collect();
    let triangles: Vec<[usize; 3]> = (1..fan.len() - 1).map(|i| [0, i, i + 1]).collect();
    assert_same("a fan", &over(&device, &mesh(&fan, &triangles)), &expected, 1e-4);
}

#[test]
fn degenerate_and_duplicate_triangles_change_nothing() {
    let device = device();
    let floor = square(2.0, 0.0);
    let expected = over(&device, &floor);
    let broken = mesh(
        &[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.5, 0.5, 0.5], [-2.0, 0.0, 0.3]],
        &[[0, 0, 0], [0, 1, 1], [0, 1, 2], [3, 3, 2], [2, 1, 0]],
    );
    assert_same("degenerate", &over(&device, &format!("{floor}{broken}")), &expected, 1e-4);
    assert_same("duplicates", &over(&device, &floor.repeat(3)), &expected, 1e-4);
    // Cut along the other diagonal.
    let other =
        mesh(&[[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]], &[[1, 2, 3], [1, 3, 0]]);
    assert_same("coplanar", &over(&device, &format!("{floor}{other}")), &expected, 1e-4);
}

/// A box that stands on the floor has a face in the floor's plane: neither changes what is
/// seen of the other.
#[test]
fn a_box_may_stand_on_the_floor() {
    let device = device();
    let shot =
        Shot { resolution: [24, 24], photons: 5000, iterations: 3, radius: 0.2, alpha: 1.0, depth: 6, eye_paths: 4 };
    let shoot = |bottom: f64| {
        let world = format!(
            "LightSource \"point\" \"point3 from\" [1 -1 3] \"rgb I\" [9 9 9]\n{}{}{}",
            diffuse(0.5),
            square(2.0, 0.0),
            solid([-0.5, -0.5, bottom], [0.5, 0.5, 1.0])
        );
        shot.take_checked(&device, &camera("2 -4 3  0 0 .3  0 0 1", 40.0), &world).image
    };
    // With the face well below the floor.
    assert_same("on the floor", &shoot(0.0), &shoot(-0.1), 1e-3);
}

/// Rays through the corners and along the edges of a mesh: a lamp in front of nothing.
#[test]
fn rays_at_corners_and_edges_hit() {
    const SIDE: usize = 32;
    let device = device();
    let index = |x: usize, y: usize| y * (SIDE + 3) + x;
    let triangles: Vec<[usize; 3]> = (0..SIDE + 2)
        .flat_map(|y| (0..SIDE + 2).map(move |x| (x, y)))
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [index(x, y), index(x + 1, y), index(x + 1, y + 1), index(x, y + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    // Pixels are of width 1/16; their centres are corners, or in the middle of edges.
    for (what, shift, tilt) in [
        ("corners", [0.5, 0.5], 0.0),
        ("corners", [0.5, 0.5], 0.37),
        ("edges", [0.0, 0.5], 0.37),
        ("diagonals", [0.0, 0.0], 0.0),
    ] {
        let at = |i: usize, shift: f64| (i as f64 - 1.0 + shift - SIDE as f64 / 2.0) / 16.0;
        let points: Vec<[f64; 3]> = (0..SIDE + 3)
            .flat_map(|y| (0..SIDE + 3).map(move |x| (x, y)))
            .map(|(x, y)| [at(x, shift[0]), at(y, shift[1]), tilt * at(x, shift[0])])
            .collect();
        let view = "Option \"bool disablepixeljitter\" true\nLookAt 0 0 5  0 0 0  0 1 0\nCamera \"orthographic\"";
        let shot = Shot { resolution: [SIDE as u32; 2], iterations: 1, ..EYE_ONLY };
        let image = render(&device, view, &lamp(1.0, &mesh(&points, &triangles)), &shot.options(), 1).image;
        assert_exact(&format!("{what}, tilt {tilt}"), &image, 1.0, 0.0);
    }
}

/// In a closed room of needles, no ray finds a way out.
#[test]
fn no_light_escapes_between_needles() {
    const SECTORS: usize = 700;
    let ring = |z: f64| {
        (0..SECTORS).map(move |i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / SECTORS as f64).sin_cos();
            [cos, sin, z]
        })
    };
    let points: Vec<[f64; 3]> = ring(-9.0).chain(ring(9.0)).chain([[0.0, 0.0, -9.0], [0.0, 0.0, 9.0]]).collect();
    let triangles: Vec<[usize; 3]> = (0..SECTORS)
        .flat_map(|i| {
            let (j, n) = ((i + 1) % SECTORS, SECTORS);
            [[i, i + n, j], [j, i + n, j + n], [i, j, 2 * n], [i + n, 2 * n + 1, j + n]]
        })
        .collect();
    let shot =
        Shot { resolution: [32, 32], photons: 50_000, iterations: 1, radius: 0.1, alpha: 1.0, depth: 20, eye_paths: 4 };
    let world = format!(
        "LightSource \"point\" \"point3 from\" [0 0 0] \"rgb I\" [1 1 1]\n{}{}",
        diffuse(0.8),
        mesh(&points, &triangles)
    );
    let rendered = shot.take_checked(&device(), &camera("0 0 0  1 .2 .1  0 0 1", 100.0), &world);
    assert_eq!(rendered.tally.escaped, 0);
    assert!(rendered.image.pixels.iter().all(|pixel| pixel[0] > 0.0));
}
