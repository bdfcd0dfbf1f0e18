//! What must not change an image: bit for bit where it is a matter of scheduling or of
//! units, in the mean where it is a matter of chance.

use std::cell::Cell;
use std::process::Command;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use goblet::image::compare::compare;
use goblet::image::film::Image;
use goblet::scene::Scene;
use goblet::{Contribution, DirectLight, Guidance, Integrator, LookupKind, Options, RadiusSchedule, Renderer};
use goblet_host::Device;

use crate::support::{self, work};

/// Every kind of surface. A `+` before an x becomes a minus in the mirrored world, and a `~` the reverse.
const WORLD: &str = r#"
Material "diffuse" "rgb reflectance" [.6 .58 .5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 -3  -3 0 3  3 0 3  3 0 -3]
Material "diffuse" "rgb reflectance" [.7 .2 .2]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 -2  3 0 -2  3 3 -2  -3 3 -2]
Material "dielectric" "float eta" 1.5
AttributeBegin
  Translate +.7 .6 .4
  Shape "sphere" "float radius" .5
AttributeEnd
Material "conductor" "rgb reflectance" [.9 .8 .7] "float roughness" 0
AttributeBegin
  Translate ~.8 .5 .2
  Rotate +25 0 1 0
  Shape "disk" "float radius" .5
AttributeEnd
"#;

const LIGHTS: [&str; 3] = [
    "LightSource \"point\" \"point3 from\" [+1.2 2.6 .8] \"rgb I\" [8 7 6]\n",
    "LightSource \"spot\" \"point3 from\" [~1.5 2.5 1.5] \"point3 to\" [~.5 .3 0] \"rgb I\" [9 9 12]\n",
    "AttributeBegin\nTranslate ~.3 2.2 -.6\nAreaLightSource \"diffuse\" \"rgb L\" [9 9 9]\n\
     Shape \"sphere\" \"float radius\" .3\nAttributeEnd\n",
];

const VIEW: &str = "LookAt +.3 1.6 4.5  0 .7 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\n";

fn parse(view: &str, world: &[&str]) -> Scene {
    let text = format!("{view}WorldBegin\n{}", world.concat()).replace('+', "").replace('~', "-");
    Scene::parse(&text, "test.pbrt", support::root()).expect("a scene")
}

fn plain() -> Scene {
    parse(VIEW, &[&LIGHTS.concat(), WORLD])
}

const ITERATIONS: u32 = 32;
/// Where images are to be the same bits, so that noise is of no matter.
const FEW_ITERATIONS: u32 = 6;
/// A third more than what two seeds differ by.
const MAX_RELMSE: f64 = 0.06;
const MAX_ENERGY: f64 = 0.015;

fn options() -> Options {
    Options {
        resolution: Some([32, 24]),
        photons: Some(5003),
        radius: Some(0.1),
        max_depth: Some(8),
        seed: Some(7),
        // A guide that is learned from rounded numbers is another guide.
        guidance: Guidance::Off,
        ..Options::default()
    }
}

/// The same with a guide, whether it pays or not.
fn guided() -> Options {
    Options { guidance: Guidance::On, ..options() }
}

fn shoot(device: &Arc<Device>, scene: &Scene, options: &Options) -> Image {
    support::render_scene(device, scene, options, ITERATIONS).image
}

fn shoot_few(device: &Arc<Device>, scene: &Scene, options: &Options) -> Image {
    support::render_scene(device, scene, options, FEW_ITERATIONS).image
}

fn bits(image: &Image) -> Vec<[u32; 3]> {
    image.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

fn assert_same(what: &str, image: &Image, expected: &Image) {
    let differing = bits(image).iter().zip(bits(expected)).filter(|(a, b)| **a != *b).count();
    assert_eq!(differing, 0, "{what}: pixels that differ of {}", expected.pixels.len());
}

// ---- Scheduling

#[test]
fn a_render_repeats_bit_for_bit() {
    let device = support::device();
    let first = shoot_few(&device, &plain(), &options());
    assert!(support::mean(&first)[0] > 0.1);
    assert_same("again", &shoot_few(&device, &plain(), &options()), &first);
    assert_same("on a new device", &shoot_few(&support::device(), &plain(), &options()), &first);
    let other = shoot_few(&device, &plain(), &Options { seed: Some(8), ..options() });
    assert_ne!(bits(&other), bits(&first), "another seed");
}

#[test]
fn batches_of_photons_do_not_change_a_bit() {
    let device = support::device();
    let expected = shoot_few(&device, &plain(), &options());
    for size in [1000, 4096, 5002, 65_536] {
        let image = shoot_few(&device, &plain(), &Options { batch_size: Some(size), ..options() });
        assert_same(&format!("batches of {size}"), &image, &expected);
    }
}

#[test]
fn the_size_of_workgroups_does_not_change_a_bit() {
    let device = support::device();
    let expected = shoot_few(&device, &plain(), &options());
    for size in [32, 64, 128] {
        let image = shoot_few(&device, &plain(), &Options { workgroup_size: Some(size), ..options() });
        assert_same(&format!("workgroups of {size}"), &image, &expected);
    }
}

/// Renders, gives up some dispatches into each iteration, and goes on.
fn shoot_with_interruptions(renderer: &mut Renderer, iterations: u32) -> Image {
    let mut patience = 1;
    while renderer.iterations() < iterations {
        let asked = Cell::new(0);
        let gives_up = || asked.replace(asked.get() + 1) >= patience;
        let done = renderer.step_unless(&gives_up).expect("an iteration");
        assert_eq!(done, asked.get() <= patience);
        patience = if done { 1 } else { patience + 2 };
    }
    renderer.resolve().expect("an image")
}

#[test]
fn iterations_that_were_given_up_leave_no_trace() {
    let device = support::device();
    for lookup in [LookupKind::HashGrid, LookupKind::KdTree] {
        for integrator in [Integrator::Sppm, Integrator::Ppm] {
            let options = Options { lookup, integrator, resolution: Some([72, 50]), ..guided() };
            let expected = support::render_scene(&device, &plain(), &options, 3).image;
            let responsive = Options { responsive: true, ..options };
            let mut renderer = Renderer::new(Arc::clone(&device), &plain(), &responsive).expect("a renderer");
            let image = shoot_with_interruptions(&mut renderer, 3);
            assert_same(&format!("{lookup:?}, {integrator:?}"), &image, &expected);
        }
    }
    support::assert_silent(&device);
}

#[test]
fn a_renderer_that_was_elsewhere_is_as_good_as_new() {
    let device = support::device();
    let elsewhere = parse(&VIEW.replace("4.5", "3.5"), &[&LIGHTS.concat(), WORLD]);
    let wanted = Options { radius: None, ..guided() };
    let coarse = Options { resolution: Some([13, 9]), photons: Some(700), eye_paths: Some(1), ..guided() };
    let others = Options {
        resolution: Some([24, 32]),
        radius_schedule: RadiusSchedule::Global,
        alpha: Some(0.5),
        contribution: Contribution::Direct,
        responsive: true,
        ..guided()
    };
    for lookup in [LookupKind::HashGrid, LookupKind::KdTree] {
        let with = |options: &Options| Options { lookup, ..options.clone() };
        let mut renderer = Renderer::new(Arc::clone(&device), &plain(), &with(&wanted)).expect("a renderer");
        let mut see = |scene: &Scene, options: &Options| {
            assert!(renderer.restart(scene, &with(options)).expect("a restart"));
            let image = shoot_with_interruptions(&mut renderer, 3);
            let mut fresh = Renderer::new(Arc::clone(&device), scene, &with(options)).expect("a renderer");
            (0..3).for_each(|_| fresh.step().expect("an iteration"));
            assert_same(&format!("{lookup:?}, {options:?}"), &image, &fresh.resolve().expect("an image"));
            assert_eq!(renderer.tally(), fresh.tally());
            assert_eq!(renderer.photons(), fresh.tally().emitted);
            assert_eq!(renderer.radius_range().expect("radii"), fresh.radius_range().expect("radii"));
            fresh.resume(&renderer.checkpoint("").expect("a checkpoint")).expect("the same render");
        };
        see(&elsewhere, &coarse);
        see(&plain(), &wanted);
        see(&plain(), &others);
    }
}

#[test]
fn what_was_not_compiled_or_does_not_fit_needs_a_new_renderer() {
    let device = support::device();
    let mut renderer = Renderer::new(device, &plain(), &options()).expect("a renderer");
    for other in [
        Options { resolution: Some([33, 24]), ..options() },
        Options { lookup: LookupKind::KdTree, ..options() },
        Options { max_depth: Some(7), ..options() },
        Options { seed: Some(8), ..options() },
        Options { direct: DirectLight::Photons, ..options() },
    ] {
        assert!(!renderer.restart(&plain(), &other).expect("an answer"), "{other:?}");
    }
    assert!(renderer.restart(&plain(), &Options { photons: Some(0), ..options() }).is_err());
}

#[test]
fn direct_light_and_that_of_photons_make_the_image() {
    let device = support::device();
    let options = Options { radius_schedule: RadiusSchedule::Global, ..options() };
    let part = |contribution| shoot(&device, &plain(), &Options { contribution, ..options.clone() });
    let [all, direct, photons] = [Contribution::All, Contribution::Direct, Contribution::Photons].map(part);
    for ((all, direct), photons) in all.pixels.iter().zip(&direct.pixels).zip(&photons.pixels) {
        for channel in 0..3 {
            let sum = direct[channel] + photons[channel];
            assert!((all[channel] - sum).abs() <= 1e-5 * sum, "{all:?} {direct:?} {photons:?}");
        }
    }
    assert!(support::mean(&direct)[0] > 0.1 && support::mean(&photons)[0] > 0.01);
}

/// Sums of integers do not depend on the order in which points are found.
fn assert_lookups_agree(device: &Arc<Device>, what: &str, scene: &Scene, options: &Options) {
    // In the last of three iterations, radii have shrunk twice, and rounds of two iterations have ended once.
    let shoot = |options: &Options| support::render_scene(device, scene, options, work(3, 8)).image;
    let expected = shoot(options);
    let tree = Options { lookup: LookupKind::KdTree, ..options.clone() };
    assert_same(&format!("{what}, kd-tree"), &shoot(&tree), &expected);
    for scale in work(&[0.25, 8.0][..], &[0.25, 0.5, 2.0, 8.0]).iter().copied() {
        let image = shoot(&Options { cell_scale: Some(scale), ..options.clone() });
        assert_same(&format!("{what}, cells of {scale}"), &image, &expected);
    }
}

#[test]
fn the_lookup_does_not_change_a_bit() {
    let device = support::device();
    let rounds = Options { integrator: Integrator::Ppm, photons_per_round: Some(2 * 5003), ..options() };
    let cases = [
        ("adaptive radii", options()),
        ("global radii", Options { radius_schedule: RadiusSchedule::Global, ..options() }),
        ("radii from the data", Options { radius_schedule: RadiusSchedule::Data, ..options() }),
        ("rounds", rounds),
        ("automatic radius", Options { radius: None, ..options() }),
        ("small radius", Options { radius: Some(1e-6), ..options() }),
        ("large radius", Options { radius: Some(1.5), photons: Some(700), ..options() }),
    ];
    for (what, options) in cases {
        assert_lookups_agree(&device, what, &plain(), &options);
    }
    let room = Scene::load(support::root().join("tests/reference/cornell-caustic.pbrt")).expect("a scene");
    assert_lookups_agree(&device, "a room", &room, &options());
    let away = VIEW.replace("0 .7 0", "0 1.6 99");
    assert_lookups_agree(&device, "nothing in view", &parse(&away, &[&LIGHTS.concat(), WORLD]), &options());
}

#[test]
fn how_a_tree_is_walked_does_not_change_a_bit() {
    let device = support::device();
    let expected = shoot_few(&device, &plain(), &options());
    let options = Options { lookup: LookupKind::KdTree, ..options() };
    for size in [100, 1000, 65_536] {
        let image = shoot_few(&device, &plain(), &Options { batch_size: Some(size), ..options.clone() });
        assert_same(&format!("batches of {size}"), &image, &expected);
    }
    for size in [32, 64, 128] {
        let image = shoot_few(&device, &plain(), &Options { workgroup_size: Some(size), ..options.clone() });
        assert_same(&format!("workgroups of {size}"), &image, &expected);
    }
}

/// The number of threads of a device that is a CPU is set for a process.
#[test]
fn the_number_of_threads_does_not_change_a_byte_of_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let render = |threads: &str| {
        let output = folder.path().join(format!("{threads}.exr"));
        let status = Command::new(support::command::goblet())
            .arg("render")
            .arg(support::root().join("tests/reference/cornell-caustic.pbrt"))
            .args(["--resolution", "24x24", "--photons", "5000", "--iterations", "4", "--quiet", "-o"])
            .arg(&output)
            .env("LP_NUM_THREADS", threads)
            .env(support::command::CACHE, "")
            .status()
            .expect("a process");
        assert!(status.success());
        std::fs::read(output).expect("a file")
    };
    let one = render("1");
    for threads in ["2", "3"] {
        assert!(render(threads) == one, "{threads} threads");
    }
}

// ---- Units and places

/// Lengths times `factor`, and light so that radiance stays.
fn scaled(factor: f64) -> (Scene, Options) {
    let scale = format!("Scale {factor:?} {factor:?} {factor:?}\n");
    // What a point light casts falls with the square of its distance.
    let lights = LIGHTS.concat().replace("\"rgb I\"", &format!("\"float scale\" {:?} \"rgb I\"", factor * factor));
    let mut scene = parse(VIEW, &[&scale, &lights, WORLD]);
    scene.camera.world_from_camera.translation *= factor;
    (scene, Options { radius: Some(0.1 * factor), ..options() })
}

#[test]
fn a_scale_by_a_power_of_two_does_not_change_a_bit() {
    let device = support::device();
    let expected = shoot_few(&device, &plain(), &options());
    // Radii of scenes end at 1e30, which is 2^99.7; squares of small ones where f64 does.
    for exponent in [-330, -2, 10, 97] {
        let (scene, options) = scaled(f64::from(exponent).exp2());
        assert_same(&format!("scaled by 2^{exponent}"), &shoot_few(&device, &scene, &options), &expected);
    }
}

#[test]
fn any_scale_changes_roundings_only() {
    let device = support::device();
    let expected = shoot(&device, &plain(), &options());
    for factor in [1e-4, 0.3, 1e4] {
        let (scene, options) = scaled(factor);
        assert_rounded(&format!("scaled by {factor}"), &shoot(&device, &scene, &options), &expected);
    }
}

#[test]
fn a_move_far_from_the_origin_changes_roundings_only() {
    let device = support::device();
    let expected = shoot(&device, &plain(), &options());
    let image = shoot(
        &device,
        &moved("Translate 1e5 -2e5 3e5\n", DAffine3::from_translation(DVec3::new(1e5, -2e5, 3e5))),
        &options(),
    );
    assert_rounded("moved", &image, &expected);
}

/// The plain scene with all of it moved, the camera too.
fn moved(directive: &str, place: DAffine3) -> Scene {
    let mut scene = parse(VIEW, &[directive, &LIGHTS.concat(), WORLD]);
    scene.camera.world_from_camera = place * scene.camera.world_from_camera;
    scene
}

/// Equal but for a few paths that a rounding sent another way.
fn assert_rounded(what: &str, image: &Image, expected: &Image) {
    let comparison = compare(image, expected).expect("images of one size");
    println!("{what}: relMSE {:.3e}, energy {:.6}", comparison.relmse, comparison.energy_ratio);
    assert!(comparison.relmse < 1e-4, "{what}: {comparison:#?}");
}

// ---- Chance

/// Equal but for noise: not much farther apart than two seeds are, and of one mean.
fn assert_alike(what: &str, image: &Image, expected: &Image) {
    let comparison = compare(image, expected).expect("images of one size");
    println!("{}: relMSE {:.5}, energy {:.5}", what, comparison.relmse, comparison.energy_ratio);
    assert!(comparison.relmse < MAX_RELMSE, "{what}: {comparison:#?}");
    assert!((comparison.energy_ratio - 1.0).abs() < MAX_ENERGY, "{what}: {comparison:#?}");
}

#[test]
fn two_seeds_differ_by_noise_only() {
    let device = support::device();
    let [a, b] = [1, 2].map(|seed| shoot(&device, &plain(), &Options { seed: Some(seed), ..options() }));
    assert_alike("two seeds", &a, &b);
}

#[test]
fn a_turn_of_everything_changes_noise_only() {
    let device = support::device();
    let expected = shoot(&device, &plain(), &options());
    let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, -2.0) / 3.0, 77_f64.to_radians());
    assert_alike("turned", &shoot(&device, &moved("Rotate 77 1 2 -2\n", turn), &options()), &expected);
}

#[test]
fn the_order_of_lights_and_shapes_changes_noise_only() {
    let device = support::device();
    let expected = shoot(&device, &plain(), &options());
    let [point, spot, ball] = LIGHTS;
    let scene = parse(VIEW, &[WORLD, ball, point, spot]);
    assert_alike("reordered", &shoot(&device, &scene, &options()), &expected);
}

#[test]
fn a_light_in_two_halves_changes_noise_only() {
    let device = support::device();
    let expected = shoot(&device, &plain(), &options());
    let [point, spot, ball] = LIGHTS;
    let halves = [point, point, spot, spot].map(|light| light.replace("\"rgb I\"", "\"float scale\" .5 \"rgb I\""));
    let scene = parse(VIEW, &[&halves.concat(), ball, WORLD]);
    assert_alike("halved lights", &shoot(&device, &scene, &options()), &expected);
}

#[test]
fn a_mirrored_world_makes_a_mirrored_image() {
    let device = support::device();
    let mut expected = shoot(&device, &plain(), &options());
    for row in expected.pixels.chunks_exact_mut(expected.width as usize) {
        row.reverse();
    }
    let mirror = |text: &str| text.replace('+', "-").replace('~', "");
    let scene = parse(&mirror(VIEW), &[&mirror(&LIGHTS.concat()), &mirror(WORLD)]);
    assert_alike("mirrored", &shoot(&device, &scene, &options()), &expected);
}

#[test]
fn photons_may_come_in_many_iterations_or_few() {
    let device = support::device();
    let expected = shoot(&device, &plain(), &options());
    let options = Options { photons: Some(1251), ..options() };
    let image = support::render_scene(&device, &plain(), &options, 4 * ITERATIONS).image;
    assert_alike("four times the iterations", &image, &expected);
}
