//! The thread that renders, without a window.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Parser;

use super::quantity::Quantity;
use super::shared::{News, Shared, View};
use super::{first_wish, render_thread};
use crate::cli::{Cli, Command, RenderArgs};
use crate::scene::Scene;

const SCENE: &str = r#"Film "rgb" "integer xresolution" 24 "integer yresolution" 16
LookAt 0 0 -3  0 0 0  0 1 0
Camera "perspective" "float fov" 60
Integrator "sppm" "integer maxdepth" 4 "integer photonsperiteration" 500 "float radius" 0.5
WorldBegin
LightSource "point" "point3 from" [ 0 1.5 -1 ] "rgb I" [ 5 5 5 ]
Shape "trianglemesh" "integer indices" [ 0 2 1 0 3 2 3 5 4 3 4 2 ]
  "point3 P" [ -2 -1 -2  2 -1 -2  2 -1 2  -2 -1 2  2 2 2  -2 2 2 ]
"#;

/// A scene that is being rendered, until it is dropped.
struct Rendering {
    folder: tempfile::TempDir,
    shared: Arc<Shared>,
    thread: Option<std::thread::JoinHandle<()>>,
}

fn args(path: &str) -> RenderArgs {
    let Command::Render(args) = Cli::parse_from(["goblet", "render", path, "--validate"]).command else {
        panic!("another command")
    };
    *args
}

impl Rendering {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.pbrt");
        fs::write(&path, SCENE).unwrap();
        let args = args(path.to_str().unwrap());
        let scene = Scene::load(&path).unwrap();
        let shared = Arc::new(Shared::new(first_wish(&path, &args.options()), || {}));
        let theirs = Arc::clone(&shared);
        let thread = Some(std::thread::spawn(move || render_thread::run(&theirs, &args, scene)));
        Self { folder, shared, thread }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Waits for news of a kind.
    fn wait<T>(&self, what: &str, mut take: impl FnMut(&mut News) -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(answer) = take(&mut self.shared.news()) {
                return answer;
            }
            assert!(start.elapsed() < Duration::from_secs(60), "waited in vain for {what}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn view(&self) -> View {
        self.wait("a picture", |news| news.view.take())
    }

    fn message(&self) -> Result<String, String> {
        self.wait("a message", |news| news.message.take())
    }
}

impl Drop for Rendering {
    fn drop(&mut self) {
        self.shared.close();
        let ended = self.thread.take().map(std::thread::JoinHandle::join);
        if !std::thread::panicking() {
            ended.unwrap().unwrap();
            assert_eq!(self.shared.news().validation, [""; 0]);
        }
    }
}

fn largest(view: &View) -> f32 {
    view.picture.pixels.iter().flatten().copied().fold(0.0, f32::max)
}

#[test]
fn every_quantity_has_a_picture() {
    let rendering = Rendering::new();
    for quantity in Quantity::ALL.into_iter().chain([Quantity::Image]) {
        // Errors are known from the second iteration on.
        rendering.wait("iterations", |news| (news.status.iterations > 2).then_some(()));
        rendering.shared.wish(true, |wish| wish.quantity = quantity);
        rendering.shared.news().view = None;
        let is_light = quantity.contribution() != Default::default() || quantity == Quantity::Image;
        let is_wanted = |view: &View| {
            let has_white = view.picture.white.is_some();
            view.picture.size == [24, 16]
                && view.picture.is_light == is_light
                && has_white == (!is_light && quantity != Quantity::Normal)
        };
        let view = rendering.wait(quantity.name(), |news| news.view.take_if(|view| is_wanted(view)));
        assert_eq!(view.picture.pixels.len(), 24 * 16);
        assert!(view.picture.pixels.iter().flatten().all(|value| value.is_finite()), "{quantity:?}");
        assert!(largest(&view) > 0.0, "{quantity:?}");
    }
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
            (wish.camera, wish.moves, wish.moved) = (Some(moved), moves, Some(Instant::now()));
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
        rendering.shared.wish(true, |wish| wish.loads += 1);
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
    rendering.shared.wish(true, |wish| wish.options.radius = Some(1e9));
    let error = rendering.message().unwrap_err();
    assert!(error.contains("a radius of"), "{error}");
    rendering.shared.wish(true, |wish| wish.options.radius = Some(0.25));
    rendering.shared.news().view = None;
    rendering.view();
}

#[test]
fn what_is_saved_is_whole_and_what_cannot_be_is_said() {
    let rendering = Rendering::new();
    for name in ["saved.png", "saved.exr", "saved.checkpoint"] {
        let path = rendering.path(name);
        rendering.shared.wish(false, |wish| wish.saves.push(path.clone()));
        assert_eq!(rendering.message(), Ok(format!("wrote {}", path.display())));
        assert!(fs::metadata(&path).unwrap().len() > 100);
    }
    let path = rendering.path("saved.tiff");
    rendering.shared.wish(false, |wish| wish.saves.push(path));
    assert!(rendering.message().unwrap_err().contains(".exr and .png"));
}
