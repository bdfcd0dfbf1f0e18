//! Tests of the render thread without a window.

use std::fs;
use std::path::PathBuf;
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use clap::Parser;
use goblet_host::Device;

use super::guiding::Guiding;
use super::quantity::Quantity;
use super::shared::{News, Save, Shared, View, Wish};
use super::{first_wish, render_thread};
use crate::cli::{Cli, Command, RenderArgs};
use crate::render::aov::AovKind;
use crate::render::device::{DeviceOptions, open_device};
use crate::render::guide::guidance::Guidance;
use crate::render::options::{Contribution, Options};
use crate::scene::Scene;

pub const SCENE: &str = r#"Film "rgb" "integer xresolution" 24 "integer yresolution" 16
LookAt 0 0 -3  0 0 0  0 1 0
Camera "perspective" "float fov" 60
Integrator "sppm" "integer maxdepth" 4 "integer photonsperiteration" 500 "float radius" 0.5
WorldBegin
LightSource "point" "point3 from" [ 0 1.5 -1 ] "rgb I" [ 5 5 5 ]
Shape "trianglemesh" "integer indices" [ 0 2 1 0 3 2 3 5 4 3 4 2 ]
  "point3 P" [ -2 -1 -2  2 -1 -2  2 -1 2  -2 -1 2  2 2 2  -2 2 2 ]
"#;

/// A scene that is being rendered, until it is dropped.
pub struct Rendering {
    folder: tempfile::TempDir,
    /// The state that the thread of the window would use.
    pub shared: Arc<Shared>,
    /// The arguments of the command line.
    pub args: RenderArgs,
    /// The device of the render thread; `None` if the thread opens its own.
    pub device: Option<Arc<Device>>,
    thread: Option<std::thread::JoinHandle<()>>,
}

/// Returns one of two devices with validation layers that tests share. A device compiles each kernel once.
pub fn shared_device() -> Arc<Device> {
    static DEVICES: LazyLock<[Arc<Device>; 2]> = LazyLock::new(|| {
        let options = DeviceOptions { validation: true, ..DeviceOptions::default() };
        [(); 2].map(|()| Arc::new(open_device(&options).unwrap()))
    });
    DEVICES.iter().min_by_key(|device| Arc::strong_count(device)).map(Arc::clone).unwrap()
}

fn args(path: &str, others: &[&str]) -> RenderArgs {
    let all = [&["goblet", "render", path, "--validate"], others].concat();
    let Command::Render(args) = Cli::parse_from(all).command else { panic!("another command") };
    *args
}

impl Rendering {
    fn new() -> Self {
        let mut rendering = Self::waiting(&[]);
        rendering.start();
        rendering
    }

    /// Returns a scene with further arguments, without a render thread.
    pub fn waiting(others: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.pbrt");
        fs::write(&path, SCENE).unwrap();
        let args = args(path.to_str().unwrap(), others);
        let shared = Arc::new(Shared::new(first_wish(&path, &args.options()), || {}));
        Self { folder, shared, args, device: None, thread: None }
    }

    /// Starts the render thread.
    pub fn start(&mut self) {
        let (theirs, args) = (Arc::clone(&self.shared), self.args.clone());
        let scene = Scene::load(&args.scene).unwrap();
        let device = self.device.clone();
        self.thread = Some(std::thread::spawn(move || match device {
            Some(device) => render_thread::run_on(&device, &theirs, &args, scene),
            None => render_thread::run(&theirs, &args, scene),
        }));
    }

    /// Returns the path of a file in the folder of the scene.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Returns the wish to save the first image.
    fn save(&self, name: &str) -> Save {
        let Wish { target, quantity, .. } = first_wish(&self.args.scene, &self.args.options());
        Save { path: self.path(name), may_replace: false, exposure: self.args.exposure, target, quantity }
    }

    /// Waits for news of a kind.
    pub fn wait<T>(&self, what: &str, mut take: impl FnMut(&mut News) -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(answer) = take(&mut self.shared.news()) {
                return answer;
            }
            assert!(start.elapsed() < Duration::from_secs(60), "waited in vain for {what}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits for a picture.
    pub fn view(&self) -> View {
        self.wait("a picture", |news| news.view.take())
    }

    /// Waits for a message.
    pub fn message(&self) -> Result<String, String> {
        self.wait("a message", |news| news.message.take())
    }
}

impl Drop for Rendering {
    fn drop(&mut self) {
        self.shared.close();
        let ended = self.thread.take().map(std::thread::JoinHandle::join);
        if let Some(ended) = ended.filter(|_| !std::thread::panicking()) {
            ended.unwrap();
            assert_eq!(self.shared.news().validation, [""; 0]);
        }
    }
}

fn largest(view: &View) -> f32 {
    view.picture.values.iter().flatten().copied().fold(0.0, f32::max)
}

#[test]
fn every_quantity_has_a_picture() {
    let rendering = Rendering::new();
    for quantity in Quantity::ALL.into_iter().chain([Quantity::Image]) {
        // Errors are known from the second iteration on.
        rendering.wait("iterations", |news| (news.status.iterations > 2).then_some(()));
        rendering.shared.wish(true, |wish| {
            (wish.quantity, wish.target.options.contribution) = (quantity, quantity.contribution());
            wish.target.options.layers = quantity.layers();
        });
        rendering.shared.news().view = None;
        let has_ends = !matches!(quantity.kind(), AovKind::Light | AovKind::Color);
        let is_wanted = |view: &View| view.picture.size == [24, 16] && view.picture.quantity == quantity;
        let view = rendering.wait(&quantity.name(), |news| news.view.take_if(|view| is_wanted(view)));
        assert_eq!((view.picture.ends.is_some(), view.picture.values.len()), (has_ends, 24 * 16), "{quantity:?}");
        assert!(view.picture.values.iter().flatten().all(|value| value.is_finite()), "{quantity:?}");
        // Nothing in the scene is specular.
        assert_eq!(largest(&view) > 0.0, quantity.name() != "caustic", "{quantity:?}");
    }
}

/// What the panel says is of the render that is shown: with the options of the window, and with what its pilot has found.
#[test]
fn the_status_says_where_photons_begin() {
    let rendering = Rendering::new();
    let expect = |contribution, guidance, is_expected: fn(&Guiding) -> bool| {
        rendering.shared.wish(true, |wish| {
            wish.target.options = Options { contribution, guidance, ..wish.target.options.clone() };
        });
        let what = format!("the state of {guidance} with {contribution:?}");
        rendering.wait(&what, |news| is_expected(&news.status.guiding).then(|| news.status.guiding.sentences()))
    };
    expect(Contribution::All, Guidance::Auto, |guiding| *guiding == Guiding::NotInWindows);
    let said = expect(Contribution::All, Guidance::On, |guiding| matches!(guiding, Guiding::Found(_)));
    assert!(said.contains("with it.") && said.contains("The pilot took"), "{said}");
    expect(Contribution::All, Guidance::Off, |guiding| *guiding == Guiding::Off);
    expect(Contribution::Direct, Guidance::On, |guiding| *guiding == Guiding::NoPhotons);
}

#[test]
fn a_moving_camera_sees_coarse_pictures_and_then_fine_ones() {
    let rendering = Rendering::new();
    let home = Scene::load(rendering.path("scene.pbrt")).unwrap().camera;
    assert!(rendering.view().lengths.is_some(), "of the first picture");
    let mut moved = home;
    moved.world_from_camera.translation.x += 0.1;
    for moves in 1..4 {
        rendering.shared.wish(true, |wish| {
            (wish.target.camera, wish.moves, wish.moved) = (Some(moved), moves, Some(Instant::now()));
        });
        let seen = rendering.wait("a move", |news| news.view.take_if(|view| view.moves == moves));
        assert!(seen.picture.size[0] < 24, "{:?}", seen.picture.size);
        moved.world_from_camera.translation.x += 0.1;
    }
    let fine = rendering.wait("a fine picture", |news| news.view.take_if(|view| view.picture.size == [24, 16]));
    assert_eq!(fine.moves, 3);
}

#[test]
fn a_scene_that_breaks_leaves_the_old_one() {
    let rendering = Rendering::new();
    let before = largest(&rendering.view());
    let rewrite = |text: &str| {
        fs::write(rendering.path("scene.pbrt"), text).unwrap();
        rendering.shared.wish(true, |wish| wish.target.loads += 1);
    };
    rewrite(&SCENE.replace("LookAt 0", "LookAt oops"));
    let error = rendering.message().unwrap_err();
    assert!(error.contains("scene.pbrt:2:8"), "{error}");
    rendering.shared.news().view = None;
    assert!((largest(&rendering.view()) / before - 1.0).abs() < 0.5, "it goes on");

    rewrite(&SCENE.replace("[ 5 5 5 ]", "[ 500 500 500 ]"));
    assert_eq!(rendering.message(), Ok("read the scene".to_owned()));
    assert!(rendering.shared.news().loaded.take().is_some());
    rendering.wait("more light", |news| news.view.take_if(|view| largest(view) > 20.0 * before));
    assert_eq!(rendering.wait("files", |news| news.files.take()), [rendering.path("scene.pbrt")]);
}

#[test]
fn options_that_cannot_be_are_said_and_can_be_mended() {
    let rendering = Rendering::new();
    rendering.view();
    rendering.shared.wish(true, |wish| wish.target.options.radius = Some(1e9));
    let error = rendering.message().unwrap_err();
    assert!(error.contains("a radius of"), "{error}");
    rendering.shared.wish(true, |wish| wish.target.options.radius = Some(0.25));
    rendering.shared.news().view = None;
    rendering.view();
}

#[test]
fn what_is_saved_is_whole_and_what_cannot_be_is_said() {
    let rendering = Rendering::new();
    for name in ["saved.png", "saved.exr", "saved.checkpoint"] {
        let save = rendering.save(name);
        rendering.shared.wish(false, |wish| wish.saves.push(save.clone()));
        let said = rendering.message().unwrap();
        assert!(said.starts_with(&format!("wrote {}: the image after ", save.path.display())), "{said}");
        assert!(fs::metadata(&save.path).unwrap().len() > 100);
    }
    let save = rendering.save("saved.tiff");
    rendering.shared.wish(false, |wish| wish.saves.push(save));
    assert!(rendering.message().unwrap_err().contains(".exr and .png"));
}

/// The window has announced that it will write the file, so it must, even if it is closed at once.
#[test]
fn what_is_to_be_saved_is_written_though_the_window_closes() {
    let mut rendering = Rendering::waiting(&[]);
    let (save, other) = (rendering.save("saved.exr"), rendering.save("saved.tiff"));
    let path = save.path.clone();
    rendering.shared.wish(true, |wish| {
        wish.saves.extend([save, other]);
        wish.close = true;
    });
    rendering.start();
    rendering.thread.take().unwrap().join().unwrap();
    assert!(crate::image::file::read(&path).unwrap().pixels.iter().flatten().any(|value| *value > 0.0));
    let unwritten: Vec<String> = rendering.shared.news().unwritten.iter().map(ToString::to_string).collect();
    assert!(unwritten.len() == 1 && unwritten[0].contains("saved.tiff"), "{unwritten:?}");
}

/// Without a device nothing is rendered, and the wishes are answered.
#[test]
fn without_a_device_nothing_is_saved_and_that_is_said() {
    let mut rendering = Rendering::waiting(&["--device", "no such device"]);
    rendering.start();
    assert!(rendering.message().unwrap_err().contains("no such device"));
    let save = rendering.save("saved.exr");
    rendering.shared.wish(false, |wish| wish.saves.push(save));
    assert!(rendering.message().unwrap_err().contains("not written"));
    assert!(!rendering.path("saved.exr").exists());
}
