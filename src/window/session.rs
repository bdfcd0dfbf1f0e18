//! What the user looks at and asks for.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::{DVec2, DVec3};

use super::camera_control::CameraControl;
use super::display::{Look, Placement};
use super::quantity::{Picture, Quantity};
use super::shared::{Loaded, Shared, Status};
use crate::options::Options;
use crate::scene::Scene;

/// The window's side of a render.
pub struct Session {
    /// The camera.
    pub control: CameraControl,
    /// How to render.
    pub options: Options,
    /// How to show it.
    pub look: Look,
    /// What to show.
    pub quantity: Quantity,
    /// Iterate no further.
    pub paused: bool,
    /// Whether the panel is open.
    pub has_panel: bool,
    /// The scene file as it is written in the panel.
    pub scene_text: String,
    /// The file to save to, as it is written in the panel.
    pub save_text: String,
    /// How the render is doing.
    pub status: Status,
    /// What went wrong or was done last.
    pub message: Option<Result<String, String>>,
    /// What is shown as white, where it is no light.
    pub white: Option<f32>,
    /// Which moves the picture has seen.
    pub seen: u64,
    /// How often the camera was moved.
    pub moves: u64,
    /// Where the image is in the window.
    pub placement: Placement,
    /// Width and height of the image that is shown.
    pub image: [u32; 2],
    /// How deep the point is that is being moved sideways.
    pub grabbed: Option<f64>,
    /// Whether this scene's camera was moved.
    has_moved: bool,
    /// Whether the size of the image is the window's.
    follows_window: bool,
    /// Lengths of eye paths, and the image that they are of.
    lengths: (Vec<f32>, [u32; 2]),
    /// A scene that is not here yet, or read again.
    opening: Option<Opening>,
    shared: Arc<Shared>,
}

#[derive(Clone, Copy, PartialEq)]
enum Opening {
    Another,
    Again,
}

impl Session {
    /// Of a scene that was read, with options that say its resolution.
    pub fn new(path: &Path, scene: &Scene, options: Options, save: Option<&Path>, shared: Arc<Shared>) -> Self {
        let exr = path.file_stem().map_or_else(|| PathBuf::from("image"), PathBuf::from).with_extension("exr");
        Self {
            control: CameraControl::new(scene.camera, scene.film.clone()),
            options,
            look: Look::default(),
            quantity: Quantity::Image,
            paused: false,
            has_panel: true,
            scene_text: path.display().to_string(),
            save_text: save.unwrap_or(&exr).display().to_string(),
            status: Status::default(),
            message: None,
            white: None,
            seen: 0,
            moves: 0,
            placement: Placement { origin: [0.0; 2], per_pixel: 1.0 },
            image: [1, 1],
            grabbed: None,
            has_moved: false,
            follows_window: follows_window(&scene.film),
            lengths: (Vec::new(), [0, 0]),
            opening: None,
            shared,
        }
    }

    /// Takes the news; a new picture, if there is one.
    pub fn take_news(&mut self) -> Option<Picture> {
        let shared = Arc::clone(&self.shared);
        let mut news = shared.news();
        if let Some(loaded) = news.loaded.take() {
            self.take_scene(loaded);
        }
        self.status = news.status.clone();
        if let Some(message) = news.message.take() {
            self.message = Some(message);
        }
        let view = news.view.take()?;
        self.seen = view.moves;
        self.white = view.picture.white;
        self.image = view.picture.size;
        if let Some(lengths) = view.lengths {
            self.lengths = (lengths, view.picture.size);
            if let Some(length) = self.length_at(DVec2::splat(0.5)) {
                self.control.set_distance_once(length);
            }
        }
        Some(view.picture)
    }

    fn take_scene(&mut self, loaded: Loaded) {
        let control = CameraControl::new(loaded.camera, loaded.film.clone());
        if self.opening.take() == Some(Opening::Again) && self.has_moved {
            self.control.set_home(control);
        } else {
            self.control = control;
            self.has_moved = false;
            self.moves += 1;
        }
        self.follows_window = follows_window(&loaded.film);
        self.look_again(false);
    }

    /// The camera was moved, or changed otherwise.
    pub fn moved(&mut self) {
        self.has_moved = true;
        self.moves += 1;
        self.look_again(true);
    }

    /// Back to the scene's own camera.
    pub fn reset(&mut self) {
        self.control.reset();
        self.has_moved = false;
        self.moves += 1;
        self.look_again(true);
    }

    fn look_again(&mut self, is_moving: bool) {
        let camera = self.has_moved.then_some(*self.control.camera());
        let (moves, options) = (self.moves, self.options.clone());
        self.shared.wish(true, |wish| {
            (wish.camera, wish.moves, wish.options) = (camera, moves, options);
            if is_moving {
                wish.moved = Some(Instant::now());
            }
        });
    }

    /// The options were changed.
    pub fn changed_options(&mut self) {
        self.look_again(false);
    }

    /// The window has this size now.
    pub fn resized(&mut self, size: [u32; 2]) {
        if self.follows_window && self.options.resolution != Some(size) {
            self.options.resolution = Some(size);
            self.look_again(true);
        }
    }

    /// Another quantity is to be shown, or the render to be stopped or to go on.
    pub fn changed_view(&self) {
        let (quantity, paused) = (self.quantity, self.paused);
        self.shared.wish(true, |wish| (wish.quantity, wish.paused) = (quantity, paused));
    }

    /// Opens another scene.
    pub fn open(&mut self, path: &Path) {
        self.scene_text = path.display().to_string();
        self.opening = Some(Opening::Another);
        self.shared.wish(true, |wish| {
            wish.scene = path.to_owned();
            wish.loads += 1;
        });
    }

    /// Reads the scene again: its files have changed.
    pub fn reload(&mut self) {
        self.opening.get_or_insert(Opening::Again);
        self.shared.wish(true, |wish| wish.loads += 1);
    }

    /// Writes the image or a checkpoint.
    pub fn save(&mut self, path: &Path) {
        self.message = Some(Ok(format!("writing {} after this iteration", path.display())));
        self.shared.wish(false, |wish| wish.saves.push(path.to_owned()));
    }

    /// The camera as pbrt reads it.
    pub fn camera_text(&self) -> String {
        self.control.camera().to_text(self.resolution())
    }

    fn resolution(&self) -> [u32; 2] {
        self.options.resolution.unwrap_or([1, 1])
    }

    /// A place on the image, whose corners are (0, 0) and (1, 1), of a pixel of the window.
    pub fn on_image(&self, pixel: [f32; 2]) -> DVec2 {
        let Placement { origin, per_pixel } = self.placement;
        let place = |axis: usize| f64::from((pixel[axis] - origin[axis]) * per_pixel) / f64::from(self.image[axis]);
        DVec2::new(place(0), place(1))
    }

    /// Length of an eye path, scene units.
    fn length_at(&self, at: DVec2) -> Option<f64> {
        let (lengths, [width, height]) = &self.lengths;
        let place =
            |fraction: f64, side: u32| (0.0..1.0).contains(&fraction).then(|| (fraction * f64::from(side)) as usize);
        let (x, y) = (place(at.x, *width)?, place(at.y, *height)?);
        lengths.get(y * *width as usize + x).copied().filter(|length| *length > 0.0).map(f64::from)
    }

    /// The point that is seen at a place on the image.
    pub fn point_at(&self, at: DVec2) -> Option<DVec3> {
        self.control.seen(at, self.length_at(at)?, self.resolution())
    }

    /// Moves the camera sideways, so that what was at one place is at another.
    pub fn pan(&mut self, from: DVec2, to: DVec2) {
        self.control.pan(from, to, self.grabbed, self.resolution());
    }
}

/// Whether an image is as large as its window: not where the film is a part of it.
fn follows_window(film: &crate::scene::Film) -> bool {
    film.window == [0.0, 1.0, 0.0, 1.0]
}
