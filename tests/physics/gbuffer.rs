//! What eye paths meet first, against formulas: positions, normals, slopes, texture coordinates and albedos.

use glam::{DAffine3, DVec3};
use goblet::image::estimate::Estimate;
use goblet::image::layers::Groups;
use goblet::render::aov::Aov;
use goblet::scene::Scene;
use goblet::{Options, Renderer};

use crate::support;

const SIDE: usize = 16;

/// Renders what an orthographic camera sees of the square from -1 to 1.
fn look(film: &str, camera: &str, world: &str) -> (Scene, Estimate) {
    let text = format!("{film}\n{camera}\nCamera \"orthographic\"\nWorldBegin\nCoordSysTransform \"camera\"\n{world}");
    let scene = Scene::parse(&text, "test.pbrt", support::root()).expect("a scene");
    let options = Options {
        resolution: Some([SIDE as u32; 2]),
        photons: Some(1),
        eye_paths: Some(16),
        layers: Groups::OF_GBUFFER,
        ..Options::default()
    };
    let device = support::device();
    let mut renderer = Renderer::new(device.clone(), &scene, &options).expect("a renderer");
    (0..8).for_each(|_| renderer.step().expect("an iteration"));
    let estimate = renderer.estimate().expect("an estimate");
    support::assert_silent(&device);
    (scene, estimate)
}

/// The values of each pixel in a layer.
fn layer(estimate: &Estimate, name: &str) -> Vec<Vec<f64>> {
    let planes = Aov::named(name).expect("a layer").planes(estimate).expect("its sums");
    (0..planes[0].len()).map(|pixel| planes.iter().map(|plane| f64::from(plane[pixel])).collect()).collect()
}

/// The middle of a pixel.
fn middle(pixel: usize) -> [f64; 2] {
    let at = |place: usize| (2.0 * place as f64 + 1.0) / SIDE as f64 - 1.0;
    [at(pixel % SIDE), -at(pixel / SIDE)]
}

/// Each value is near what a formula gives for the middle of its pixel.
fn assert_layer(estimate: &Estimate, name: &str, tolerance: f64, expected: impl Fn([f64; 2]) -> Option<Vec<f64>>) {
    let mut checked = 0;
    for (pixel, values) in layer(estimate, name).into_iter().enumerate() {
        let Some(expected) = expected(middle(pixel)) else { continue };
        let is_near = values.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= tolerance);
        assert!(is_near && values.len() == expected.len(), "{name} of pixel {pixel}: {values:?}, not {expected:?}");
        checked += 1;
    }
    assert!(checked > SIDE, "{name}: {checked} pixels");
}

/// z of a plane.
fn height([x, y]: [f64; 2]) -> f64 {
    3.0 + 0.5 * x - 0.25 * y
}

/// A square from -2 to 2 on that plane, with texture coordinates from 0 to 1.
fn tilted() -> String {
    let corner = |x: f64, y: f64| format!("{x} {y} {} ", height([x, y]));
    let corners = [corner(-2.0, -2.0), corner(2.0, -2.0), corner(2.0, 2.0), corner(-2.0, 2.0)].concat();
    format!(
        "LightSource \"distant\" \"point3 from\" [0 0 -1] \"point3 to\" [0 0 0]\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [{corners}] \
         \"point2 uv\" [0 0 1 0 1 1 0 1]"
    )
}

/// Checks all layers of the tilted square, of which `out` maps camera space to the space of the layers.
fn assert_tilted(estimate: &Estimate, out: DAffine3, size: f64, noise: f64) {
    let place = |[x, y]: [f64; 2]| out.transform_point3(DVec3::new(x, y, height([x, y])));
    let normal = (out.matrix3.inverse().transpose() * DVec3::new(0.5, -0.25, -1.0)).normalize();
    let farthest = out.transform_point3(DVec3::ZERO).abs().max_element() + 5.0 * size;
    let tolerance = noise * size + 2e-7 * farthest;
    assert_layer(estimate, "P", tolerance, |at| Some(place(at).to_array().to_vec()));
    for name in ["N", "Ns"] {
        assert_layer(estimate, name, 1e-5, |_| Some(normal.to_array().to_vec()));
    }
    let pixel = 2.0 / SIDE as f64;
    let [right, below] = [DVec3::new(pixel, 0.0, 0.5 * pixel), DVec3::new(0.0, -pixel, 0.25 * pixel)];
    for (name, step) in [("dzdx", right), ("dzdy", below)] {
        let slope = (out.matrix3 * step).z.abs();
        assert_layer(estimate, name, 1e-3 * size * pixel, |_| Some(vec![slope]));
    }
    assert_layer(estimate, "u", noise, |[x, _]| Some(vec![(x + 2.0) / 4.0]));
    assert_layer(estimate, "v", noise, |[_, y]| Some(vec![(y + 2.0) / 4.0]));
}

#[test]
fn a_tilted_plane_is_where_it_is_in_camera_space() {
    for (filter, noise) in [("box", 0.01), ("gaussian", 0.02), ("mitchell", 0.1)] {
        let (_, estimate) = look(&format!("PixelFilter \"{filter}\""), "", &tilted());
        assert_tilted(&estimate, DAffine3::IDENTITY, 1.0, noise);
        assert_layer(&estimate, "Z", noise, |at| Some(vec![height(at)]));
    }
}

/// Also in scenes that are large, small, or far from the origin.
#[test]
fn a_tilted_plane_is_where_it_is_in_world_space() {
    for (camera, size) in [
        ("Translate 1 2 3 Rotate 30 1 2 3", 1.0),
        ("Scale 1e-6 1e-6 1e-6 Rotate 100 1 0 0", 1e6),
        ("Scale 1e5 1e5 1e5 Rotate 100 1 -1 0", 1e-5),
        ("Rotate 77 0 1 1 Translate 4e3 -5e3 2e3", 1.0),
        ("Scale 1e-3 1e-3 1e-3 Translate 4e6 -5e6 2e6", 1e3),
    ] {
        let film = "PixelFilter \"box\" Film \"gbuffer\" \"string coordinatesystem\" \"world\"";
        let (scene, estimate) = look(film, camera, &tilted());
        assert_tilted(&estimate, scene.camera.world_from_camera, size, 0.01);
        // Depths are along the line of sight, whatever the coordinate system is.
        assert_layer(&estimate, "Z", 0.01, |at| Some(vec![height(at)]));
    }
}

/// pbrt's normals of a curved surface, and nothing beside it; the sky is no surface.
#[test]
fn a_sphere_has_its_normals_and_nothing_is_beside_it() {
    let world = "LightSource \"infinite\"\nTranslate 0 0 3 Shape \"sphere\" \"float radius\" 0.75";
    let (_, estimate) = look("PixelFilter \"box\"", "", world);
    for name in ["N", "Ns"] {
        assert_layer(&estimate, name, 0.02, |[x, y]| {
            let depth = 0.36 - x * x - y * y;
            (depth > 0.0).then(|| vec![x / 0.75, y / 0.75, -(0.5625 - x * x - y * y).sqrt() / 0.75])
        });
    }
    for name in ["N", "Ns", "P", "Albedo", "u", "v", "dzdx", "dzdy", "Z"] {
        let zeros = vec![0.0; Aov::named(name).expect("a layer").channels.len()];
        assert_layer(&estimate, name, 0.0, |[x, y]| (x.hypot(y) > 0.9).then(|| zeros.clone()));
    }
}

#[test]
fn shading_normals_are_those_of_the_mesh() {
    let world = "LightSource \"infinite\"\nShape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
                 \"point3 P\" [-2 -2 3 2 -2 3 2 2 3 -2 2 3] \"normal N\" [3 0 -4 3 0 -4 3 0 -4 3 0 -4]";
    let (_, estimate) = look("", "", world);
    assert_layer(&estimate, "N", 1e-6, |_| Some(vec![0.0, 0.0, -1.0]));
    assert_layer(&estimate, "Ns", 1e-6, |_| Some(vec![0.6, 0.0, -0.8]));
}

/// Materials that are seen along their normal.
#[test]
fn albedos_are_the_light_that_materials_send_on() {
    let glass = 0.04; // ((1.5 - 1) / (1.5 + 1))^2
    for (material, expected) in [
        ("\"diffuse\" \"rgb reflectance\" [.8 .4 .1]", [0.8, 0.4, 0.1]),
        ("\"conductor\" \"rgb reflectance\" [.8 .4 .1] \"float roughness\" 0", [0.8, 0.4, 0.1]),
        ("\"conductor\" \"rgb reflectance\" [.8 .4 .1] \"float roughness\" 0.3", [0.8, 0.4, 0.1]),
        ("\"dielectric\"", [1.0; 3]),
        ("\"thindielectric\"", [1.0; 3]),
        ("\"diffusetransmission\" \"rgb reflectance\" [.3 .2 .1] \"rgb transmittance\" [.1 .2 .6]", [0.4, 0.4, 0.7]),
        ("\"coateddiffuse\" \"rgb reflectance\" [0 0 0] \"float roughness\" 0 \"float thickness\" 0", [glass; 3]),
        // Nothing is lost.
        ("\"coateddiffuse\" \"rgb reflectance\" [1 1 1] \"float roughness\" 0 \"float thickness\" 0", [1.0; 3]),
    ] {
        let (_, estimate) = look("", "", &format!("Material {material}\n{}", facing("")));
        assert_layer(&estimate, "Albedo", 0.003, |_| Some(expected.to_vec()));
    }
}

/// A square that faces the camera, with texture coordinates from 0 to 1 in the image.
fn facing(parameters: &str) -> String {
    format!(
        "LightSource \"infinite\"\nShape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
         \"point3 P\" [-3 -3 3 3 -3 3 3 3 3 -3 3 3] \"point2 uv\" [-1 -1 2 -1 2 2 -1 2] {parameters}"
    )
}

#[test]
fn a_texture_of_two_halves_is_an_albedo_of_two_halves() {
    let texture = "Texture \"halves\" \"spectrum\" \"checkerboard\" \"float uscale\" 2 \"float vscale\" 0.25 \
                   \"rgb tex1\" [.8 .2 .1] \"rgb tex2\" [.1 .5 .9]\n\
                   Material \"diffuse\" \"texture reflectance\" \"halves\"\n";
    let world = format!("{texture}Translate 0 0.5 0\n{}", facing(""));
    let (_, estimate) = look("PixelFilter \"box\"", "", &world);
    let halves = |[x, y]: [f64; 2]| (y > -0.4).then(|| if x < 0.0 { vec![0.8, 0.2, 0.1] } else { vec![0.1, 0.5, 0.9] });
    assert_layer(&estimate, "Albedo", 1e-5, halves);
}

/// The variance of what is seen without noise is 0; that of a pixel on an edge is that of its share.
#[test]
fn the_variance_is_that_of_iterations() {
    let lamp = "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\nAreaLightSource \"diffuse\" \"rgb L\" [2 4 0]\n\
                Shape \"trianglemesh\" \"integer indices\" [0 2 1 0 3 2] \"point3 P\" [0.0625 -9 3 9 -9 3 9 9 3 0.0625 9 3]";
    let text = format!("PixelFilter \"box\"\nCamera \"orthographic\"\nWorldBegin\n{lamp}");
    let options = Options {
        resolution: Some([SIDE as u32; 2]),
        photons: Some(1),
        eye_paths: Some(1),
        layers: Groups::OF_GBUFFER,
        sampler: goblet::Sampler::Pcg,
        ..Options::default()
    };
    let scene = Scene::parse(&text, "test.pbrt", support::root()).expect("a scene");
    let mut renderer = Renderer::new(support::device(), &scene, &options).expect("a renderer");
    (0..400).for_each(|_| renderer.step().expect("an iteration"));
    let estimate = renderer.estimate().expect("an estimate");
    // Half of the pixels of this column are lit in each iteration.
    let mut mean = [0.0; 3];
    let mut ratio = [0.0; 3];
    let (variances, ratios) = (layer(&estimate, "Variance"), layer(&estimate, "RelativeVariance"));
    for pixel in 0..SIDE * SIDE {
        let on_edge = pixel % SIDE == SIDE / 2;
        for channel in 0..3 {
            if on_edge {
                mean[channel] += variances[pixel][channel] / SIDE as f64;
                ratio[channel] += ratios[pixel][channel] / SIDE as f64;
            } else {
                assert!(variances[pixel][channel].abs() < 1e-6, "pixel {pixel}: {:?}", variances[pixel]);
            }
        }
    }
    for (found, expected) in mean.into_iter().chain(ratio).zip([1.0, 4.0, 0.0, 1.0, 2.0, 0.0]) {
        assert!((found - expected).abs() <= 0.05 * expected, "{mean:?} {ratio:?}");
    }
}
