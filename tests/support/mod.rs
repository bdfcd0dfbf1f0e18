//! Helpers of all suites: a validated device, renders of scene text, the command, random numbers.
#![allow(dead_code, reason = "each suite uses a part of this")]

pub mod command;
pub mod layered;
pub mod measured;
pub mod noise;
pub mod place;
pub mod random;
pub mod schema;
pub mod spectral;
pub mod variants;

use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

use goblet::image::film::Image;
use goblet::scene::Scene;
use goblet::{Options, Renderer, Tally};
use goblet_host::Device;
pub use place::root;

/// A device with validation layers on. The tests of a suite share as many as there are cores: each compiles
/// a kernel once, and only tests on the same device wait for each other. Without a device, a test fails and
/// says why.
pub fn device() -> Arc<Device> {
    static DEVICES: LazyLock<Result<Vec<Arc<Device>>, String>> = LazyLock::new(|| {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let open = |_| goblet::open_device(&device_options()).map(Arc::new).map_err(|error| error.to_string());
        (0..cores).map(open).collect()
    });
    match &*DEVICES {
        Ok(devices) => devices.iter().min_by_key(|device| Arc::strong_count(device)).map(Arc::clone).unwrap(),
        Err(error) => panic!("{error}"),
    }
}

/// How tests open devices: with validation layers, unless `GOBLET_TEST_LAYERS=off`, and the one that
/// `GOBLET_TEST_DEVICE` names as `--device` does.
pub fn device_options() -> goblet::DeviceOptions<'static> {
    static DEVICE: LazyLock<String> = LazyLock::new(|| std::env::var("GOBLET_TEST_DEVICE").unwrap_or_default());
    let validation = !std::env::var("GOBLET_TEST_LAYERS").is_ok_and(|layers| layers == "off");
    let selector = Some(DEVICE.as_str()).filter(|name| !name.is_empty());
    goblet::DeviceOptions { selector, validation, ..Default::default() }
}

/// Fails if the validation layers have said anything, be it about another test of the suite.
pub fn assert_silent(device: &Device) {
    let messages = device.validation_messages();
    assert!(messages.is_empty(), "validation messages: {messages:#?}");
}

/// A finished render.
pub struct Rendered {
    /// Linear RGB.
    pub image: Image,
    /// What happened to the photons.
    pub tally: Tally,
    /// Smallest and largest radius, scene units.
    pub radius: [f64; 2],
}

/// Renders `iterations` of a scene, and checks that validation stays silent.
pub fn render_scene(device: &Arc<Device>, scene: &Scene, options: &Options, iterations: u32) -> Rendered {
    let mut renderer = Renderer::new(Arc::clone(device), scene, options).expect("a renderer");
    for _ in 0..iterations {
        renderer.step().expect("an iteration");
    }
    let image = renderer.resolve().expect("an image");
    let radius = renderer.radius_range().expect("radii");
    assert_silent(device);
    Rendered { image, tally: *renderer.tally(), radius }
}

/// Renders scene text.
pub fn render(text: &str, options: &Options, iterations: u32) -> Rendered {
    let scene = Scene::parse(text, "test.pbrt", root()).expect("a scene");
    render_scene(&device(), &scene, options, iterations)
}

/// Whether tests are to run in their long form: `GOBLET_TESTS=full`, as tests/full.sh sets it.
pub fn is_full() -> bool {
    std::env::var("GOBLET_TESTS").is_ok_and(|form| form == "full")
}

/// One of two amounts of work for the same check, by [`is_full`].
pub fn work<T>(quick: T, full: T) -> T {
    if is_full() { full } else { quick }
}

/// An image in a file that a scene can name.
pub struct ImageFile {
    folder: tempfile::TempDir,
}

impl ImageFile {
    pub fn new(image: &Image) -> Self {
        let file = Self { folder: tempfile::tempdir().expect("a folder") };
        goblet::image::file::write(&file.path(), image, &[]).expect("a file");
        file
    }

    /// As scenes name it.
    pub fn path(&self) -> PathBuf {
        self.folder.path().join("image.exr")
    }
}

/// The mean over all pixels, per channel.
pub fn mean(image: &Image) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for pixel in &image.pixels {
        for (sum, value) in sum.iter_mut().zip(pixel) {
            *sum += f64::from(*value);
        }
    }
    sum.map(|sum| sum / image.pixels.len() as f64)
}
