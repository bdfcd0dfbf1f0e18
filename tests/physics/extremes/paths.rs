//! Paths that are longer than a driver's loops, which llvmpipe ends after 65,535 rounds: they go on,
//! or are cut and counted, and the render never stops for them.

use std::fmt::Write;
use std::sync::Arc;

use goblet::image::layers::Groups;
use goblet::scene::Scene;
use goblet::{ByPass, DirectLight, Guidance, Options, Renderer, Submission, Tally};
use goblet_host::Device;

use super::{SKY, block, camera, lamp, square};
use crate::support::command::Bench;
use crate::support::{assert_silent, device, mean, root, work};

/// A mirror of two triangles in each of `n` by `n` cells, in the plane z = 1 and with normals down.
fn tiled_mirror(n: usize) -> String {
    let (mut points, mut indices) = (String::new(), String::new());
    for i in 0..=n {
        for j in 0..=n {
            let at = |k| -1.0 + 2.0 * k as f64 / n as f64;
            write!(points, "{} {} 1 ", at(i), at(j)).unwrap();
            if i < n && j < n {
                let corner = i * (n + 1) + j;
                let [a, b, c, d] = [corner, corner + 1, corner + n + 2, corner + n + 1];
                write!(indices, "{a} {b} {c} {a} {c} {d} ").unwrap();
            }
        }
    }
    format!("Shape \"trianglemesh\" \"point3 P\" [{points}] \"integer indices\" [{indices}]\n")
}

/// A closed room of mirrors with glass and mirroring foliage in it, in which nothing but a black lamp
/// of this half width and radiance 1 ends a path: everything is as bright as the lamp.
fn furnace(half: f64) -> String {
    let mirror = "Material \"conductor\" \"rgb reflectance\" [1 1 1]";
    let turns = ["", "Rotate 90 1 0 0", "Rotate 180 1 0 0", "Rotate 270 1 0 0", "Rotate 90 0 1 0", "Rotate 270 0 1 0"];
    let walls: String = turns.iter().map(|turn| block(&format!("{turn}\n{mirror}\n{}", tiled_mirror(16)))).collect();
    let sides = ["", "Rotate 180 1 0 0"];
    let lamp: String = sides
        .iter()
        .map(|side| block(&format!("Translate .2 .1 -.7\nRotate 30 1 2 0\n{side}\n{}", lamp(1.0, &square(half, 5e-4)))))
        .collect();
    let glass = block(
        "Material \"dielectric\" \"float eta\" 1.5\nTranslate .35 -.3 .1\nShape \"sphere\" \"float radius\" .5\n\
         Material \"dielectric\" \"float eta\" .8\nShape \"sphere\" \"float radius\" .25",
    );
    let leaf = |i| {
        let height = -0.97 + 0.01 * f64::from(i);
        format!(
            "Shape \"bilinearmesh\" \"float alpha\" .05 \
             \"point3 P\" [-1 {height} -1 1 {height} -1 -1 {height} 1 1 {height} 1]\n"
        )
    };
    let foliage = block(&format!("{mirror}\n{}", (0..16).map(leaf).collect::<String>()));
    format!("{walls}{lamp}{glass}{foliage}")
}

fn scene(world: &str) -> Scene {
    let filter = "PixelFilter \"box\" \"float xradius\" .5 \"float yradius\" .5";
    let camera = camera("-.7 .6 .55  0 0 0  0 1 0", 70.0);
    Scene::parse(&format!("{filter}\n{camera}\nWorldBegin\n{world}"), "test.pbrt", root()).expect("a scene")
}

/// In which paths are too long for one dispatch of llvmpipe's.
pub fn furnace_scene() -> Scene {
    scene(&furnace(0.1))
}

fn options(depth: u32) -> Options {
    Options {
        resolution: Some([8, 6]),
        photons: Some(240),
        eye_paths: Some(2),
        radius: Some(0.1),
        max_depth: Some(depth),
        // A pilot would follow more photons than the test.
        guidance: Guidance::Off,
        ..Options::default()
    }
}

/// What some iterations come to: the image's bits, its mean, and what happened.
fn outcome(device: &Arc<Device>, scene: &Scene, options: &Options, iterations: u32) -> (Vec<[u32; 3]>, f64, Tally) {
    let mut renderer = Renderer::new(Arc::clone(device), scene, options).expect("a renderer");
    for _ in 0..iterations {
        renderer.step().expect("an iteration");
    }
    let image = renderer.resolve().expect("an image");
    let bits = image.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect();
    (bits, mean(&image)[1], *renderer.tally())
}

/// Renders the furnace; the shares of light that do not arrive at the eye, and of photons that do not
/// arrive at the lamp.
fn lost(device: &Arc<Device>, half: f64, depth: u32) -> [f64; 2] {
    let (_, brightness, tally) = outcome(device, &scene(&furnace(half)), &options(depth), 3);
    let arrived = tally.deposited as f64 / tally.emitted as f64;
    println!("lamp of {half}, depth {depth}: brightness {brightness:.5}, {arrived:.5} of photons, {tally:?}");
    assert_eq!(tally.deposited + tally.absorbed + tally.truncated, tally.emitted, "{tally:?}");
    assert_eq!([tally.cut, tally.non_finite], [ByPass::default(); 2], "{tally:?}");
    [1.0 - brightness, 1.0 - arrived]
}

/// What does not arrive is still on its way after the last segment, or was absorbed by mirrors, which
/// keep 0.9999 of the light each.
#[test]
fn long_paths_end_where_the_depth_says() {
    let device = device();
    let depths = work(&[65, 1000][..], &[65, 256, 1000]);
    let losses = depths.iter().map(|&depth| {
        let [of_light, of_photons] = lost(&device, 0.1, depth);
        // Four standard deviations of 288 eye paths and 720 photons.
        assert!((of_light - of_photons).abs() < 0.13, "depth {depth}: {of_light} of light, {of_photons} of photons");
        of_light
    });
    let losses: Vec<f64> = losses.collect();
    assert!(losses[0] > 0.7 && losses[losses.len() - 1] < 0.3, "{losses:?}");
    assert!(losses.len() == 2 || losses[1] < 0.7, "{losses:?}");
    let [of_light, of_photons] = lost(&device, 0.4, 1000);
    assert!(of_light > 0.0 && of_light < 0.01 && of_photons < 0.01, "{of_light} of light, {of_photons} of photons");
    assert_silent(&device);
}

/// The furnace with media in its glass, and a ball of a third one around that.
fn furnace_with_media() -> Scene {
    let medium = |name: &str, [r, g, b]: [f64; 3]| {
        format!(
            "MakeNamedMedium \"{name}\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [0 0 0] \
             \"rgb sigma_a\" [{r} {g} {b}]\n"
        )
    };
    let media =
        medium("outer", [0.1, 0.0, 0.02]) + &medium("inner", [0.0, 0.2, 0.1]) + &medium("haze", [0.02, 0.0, 0.05]);
    let haze = "MediumInterface \"haze\" \"\"\nMaterial \"interface\"\nTranslate .35 -.3 .1\nShape \"sphere\" \"float radius\" .6\n";
    let glass = ["\"float eta\" 1.5\n", "\"float eta\" .8\n"];
    let world = furnace(0.1)
        .replace(glass[0], &format!("{}MediumInterface \"outer\" \"haze\"\n", glass[0]))
        .replace(glass[1], &format!("{}MediumInterface \"inner\" \"outer\"\n", glass[1]));
    scene(&format!("{media}{world}{}", block(haze)))
}

/// Nor does it matter which invocations share a dispatch.
#[test]
fn dispatches_that_paths_go_on_in_change_no_bit() {
    same_bits_in_other_dispatches(&furnace_scene(), 0.1);
}

/// A path goes on in the medium that it was in.
#[test]
fn dispatches_that_paths_through_media_go_on_in_change_no_bit() {
    same_bits_in_other_dispatches(&furnace_with_media(), 0.01);
}

/// Renders in dispatches of several sizes; the image is brighter than `least`.
fn same_bits_in_other_dispatches(scene: &Scene, least: f64) {
    let device = device();
    let options = Options { direct: DirectLight::Photons, ..options(256) };
    let iterations = work(1, 2);
    let expected = outcome(&device, scene, &options, iterations);
    println!("{:?}", expected.2);
    assert!(expected.1 > least, "{}", expected.1);
    let cases = [(32, Some(77), true), (128, None, false), (32, Some(77), false), (64, Some(500), true)];
    for &(workgroup_size, batch_size, responsive) in work(&cases[..2], &cases[..]) {
        let options = Options { workgroup_size: Some(workgroup_size), batch_size, responsive, ..options.clone() };
        let found = outcome(&device, scene, &options, iterations);
        assert!(found == expected, "{workgroup_size}, {batch_size:?}: {:?}", found.2);
    }
    assert_silent(&device);
}

/// Needles along the diagonal of a box: a ray through the box meets the boxes of all of them, and
/// few of them. Around them is the sky.
fn needles(count: u32) -> String {
    let (mut points, mut indices) = (String::new(), String::new());
    for i in 0..count {
        let [x, y] = [i.wrapping_mul(2_654_435_769), i.wrapping_mul(2_246_822_519)]
            .map(|bits| 0.1 * f64::from(bits) / f64::from(u32::MAX));
        let (low, high) = (x - 1.1, x - 0.1);
        write!(points, "{low:.4} {:.4} 0 {high:.4} {:.4} 1 {:.4} {:.4} 0 ", y - 0.5, y + 0.5, low + 1e-3, y - 0.5)
            .unwrap();
        write!(indices, "{} {} {} ", 3 * i, 3 * i + 1, 3 * i + 2).unwrap();
    }
    let needles = format!("Shape \"trianglemesh\" \"point3 P\" [{points}] \"integer indices\" [{indices}]\n");
    format!("{SKY}Material \"conductor\" \"rgb reflectance\" [.5 .5 .5]\n{needles}")
}

const NEEDLES: &str = "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 4\n\
    PixelFilter \"box\" \"float xradius\" .5 \"float yradius\" .5\nIntegrator \"sppm\" \"integer maxdepth\" 65\n\
    LookAt 0 0 4  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 15\nWorldBegin\n";

/// A segment that alone needs more rounds than the driver has is left out, in any dispatch.
#[test]
fn paths_that_a_driver_cannot_follow_are_cut_and_said() {
    let bench = Bench::new();
    bench.write("scene.pbrt", format!("{NEEDLES}{}", needles(60_000)));
    let render = |name: &str, options: &[&str], threads: Option<&str>| {
        let outputs = ["render", "scene.pbrt", "-o", name, "--stats", "x.json"];
        let common = ["--eye-paths", "1", "--photons", "64"];
        let mut command = bench.command(&[&outputs[..], &common, options].concat());
        threads.map(|threads| command.env("LP_NUM_THREADS", threads));
        let run = crate::support::command::Run::of(command.output().unwrap());
        assert_eq!(run.code, 0, "{run:?}");
        (run.stderr, bench.json("x.json"))
    };
    let [first, next, eye_paths] = work(["1", "2", "32"], ["2", "3", "64"]);
    let (said, stats) = render("x.exr", &["--iterations", first, "--checkpoint", "x.checkpoint"], None);
    println!("{said}{}", stats["cut"]);
    // Another driver may have no such limit.
    let eye = stats["cut"]["eye"].as_u64().unwrap();
    assert_eq!(stats["eye_paths"].to_string(), eye_paths);
    assert_eq!(said.matches("were cut").count(), usize::from(eye > 0), "{said}");
    assert!(eye <= stats["eye_paths"].as_u64().unwrap() * 5 / 8, "{stats:#}");
    let image = bench.image("x.exr");
    for (i, pixel) in image.pixels.iter().enumerate().filter(|(i, _)| i % 8 < 3) {
        assert!(pixel.iter().all(|value| (value - 1.0).abs() < 1e-5), "pixel {i} sees the sky: {pixel:?}");
    }
    let one_thread = (&["--iterations", first, "--workgroup-size", "32", "--batch-size", "7"][..], Some("1"));
    let large_groups = (&["--iterations", first, "--workgroup-size", "128"][..], None);
    for (options, threads) in work(&[one_thread][..], &[one_thread, large_groups]).iter().copied() {
        let (_, other) = render("other.exr", options, threads);
        assert!(bench.bytes("other.exr") == bench.bytes("x.exr"), "{options:?}");
        assert_eq!([&other["cut"], &other["truncated"]], [&stats["cut"], &stats["truncated"]], "{options:?}");
    }
    let (_, resumed) = render("other.exr", &["--resume", "x.checkpoint", "--iterations", next], None);
    assert!(resumed["cut"]["eye"].as_u64().unwrap() >= eye, "{resumed:#}");
}

/// Segments that need most of the rounds, each: too many for those that share them in one dispatch.
#[test]
fn paths_that_a_driver_can_follow_alone_are_followed() {
    let device = device();
    let text = format!("{NEEDLES}{}", needles(6_000));
    let scene = Scene::parse(&text, "test.pbrt", root()).expect("a scene");
    let options = |workgroup_size| Options {
        photons: Some(64),
        eye_paths: Some(2),
        workgroup_size: Some(workgroup_size),
        ..Options::default()
    };
    let expected = outcome(&device, &scene, &options(64), 2);
    println!("brightness {}, {:?}", expected.1, expected.2);
    assert_eq!(expected.2.cut, ByPass::default());
    for workgroup_size in [32, 128] {
        assert!(outcome(&device, &scene, &options(workgroup_size), 2) == expected, "{workgroup_size}");
    }
    let whole = Options { submission: Submission::Whole, ..options(64) };
    assert!(outcome(&device, &scene, &whole, 2) == expected, "in one submission");
    assert_silent(&device);
}

/// The same for what eye paths meet first, which has a pass of its own.
#[test]
fn layers_do_not_depend_on_who_shares_the_rounds_of_a_dispatch() {
    let device = device();
    let text = format!("{NEEDLES}{}", needles(6_000));
    let scene = Scene::parse(&text, "test.pbrt", root()).expect("a scene");
    let layers = |workgroup_size, submission| {
        let options = Options {
            photons: Some(64),
            eye_paths: Some(2),
            workgroup_size: Some(workgroup_size),
            submission,
            layers: Groups::OF_GBUFFER,
            ..Options::default()
        };
        let mut renderer = Renderer::new(Arc::clone(&device), &scene, &options).expect("a renderer");
        (0..2).for_each(|_| renderer.step().expect("an iteration"));
        renderer.estimate().expect("an estimate")
    };
    let expected = layers(64, Submission::Pieces);
    let albedo = expected.albedo().expect("its sums");
    assert!(albedo[0].iter().any(|value| *value > 0.0));
    for (workgroup_size, submission) in [(32, Submission::Pieces), (128, Submission::Pieces), (64, Submission::Whole)] {
        assert!(layers(workgroup_size, submission) == expected, "{workgroup_size}, {submission:?}");
    }
    assert_silent(&device);
}
