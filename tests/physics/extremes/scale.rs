//! Scenes of any size, anywhere.

use goblet::scene::Scene;

use super::{EYE_ONLY, Shot, assert_mean, assert_same, camera, diffuse, lamp, square};
use crate::support::{device, mean, render_scene, root};

/// A glass ball, a mirror, a mesh and a lamp in a box, of this size and at this place.
fn room(size: f64, place: f64) -> Scene {
    let at = |[x, y, z]: [f64; 3]| format!("{:?} {:?} {:?} ", place + size * x, place + size * y, place - size * z);
    let quad = |corners: [[f64; 3]; 4]| {
        format!(
            "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [{}]\n",
            corners.map(at).concat()
        )
    };
    let quads = |corners: &[[[f64; 3]; 4]]| corners.iter().copied().map(quad).collect::<String>();
    let floor_and_back = quads(&[
        [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]],
        [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 2.0, -1.0], [-1.0, 2.0, -1.0]],
    ]);
    let side = quad([[-1.0, 0.0, -1.0], [-1.0, 2.0, -1.0], [-1.0, 2.0, 1.0], [-1.0, 0.0, 1.0]]);
    let light = quad([[-0.3, 1.9, -0.3], [-0.3, 1.9, 0.3], [0.3, 1.9, 0.3], [0.3, 1.9, -0.3]]);
    let text = format!(
        "LookAt {}{}0 1 0\nCamera \"perspective\" \"float fov\" 45\nWorldBegin\n{}{floor_and_back}\
         Material \"conductor\" \"float roughness\" 0\n{side}\
         AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [10 10 10] \"bool twosided\" true\n{}{light}AttributeEnd\n\
         Material \"dielectric\"\nTranslate {}\nShape \"sphere\" \"float radius\" {:?}\n",
        at([0.1, 1.0, 3.5]),
        at([0.0, 1.0, 0.0]),
        diffuse(0.7),
        diffuse(0.0),
        at([0.2, 0.5, 0.2]),
        0.4 * size,
    );
    Scene::parse(&text, "room.pbrt", root()).expect("a scene")
}

#[test]
fn sizes_and_places_change_roundings_only() {
    let device = device();
    let shot =
        Shot { resolution: [24, 24], photons: 4000, iterations: 4, radius: 0.15, alpha: 1.0, depth: 8, eye_paths: 4 };
    let shoot = |size: f64, place: f64| {
        let options = goblet::Options { radius: Some(shot.radius * size), ..shot.options() };
        render_scene(&device, &room(size, place), &options, shot.iterations).image
    };
    let expected = shoot(1.0, 0.0);
    assert!(mean(&expected)[0] > 0.1);
    for (size, place) in [(1e-4, 100.0), (1.0, 1e6), (1e6, -1e12), (1e-15, 0.0), (1e15, 0.0)] {
        assert_same(&format!("size {size:e} at {place:e}"), &shoot(size, place), &expected, 1e-5);
    }
}

/// A lamp that fills the image, however far away the camera stands.
#[test]
fn a_camera_sees_far() {
    let device = device();
    for distance in [10.0, 1e3, 1e5_f64] {
        let fov = 2.0 * (0.5 / distance).atan().to_degrees();
        let world = lamp(3.0, &square(1.0, 0.0));
        let image =
            EYE_ONLY.take_checked(&device, &camera(&format!("0 0 {distance}  0 0 0  0 1 0"), fov), &world).image;
        assert_mean(&format!("from {distance} away"), &image, 3.0, 1e-6);
    }
}
