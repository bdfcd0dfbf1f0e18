//! The session of a user: the state of the window, and the wishes that follow from it.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::{DVec2, DVec3};

use super::camera_control::CameraControl;
use super::display::Look;
use super::keys::Command;
use super::layout::{Area, Placement};
use super::quantity::{Picture, Quantity, Shade};
use super::shared::{Loaded, Save, Shared, Status, Target};
use crate::render::options::{Options, photons_of};
use crate::scene::{Film, Integrator, Scene};

/// The state of the window.
pub struct Session {
    /// The camera.
    pub control: CameraControl,
    /// The options of the render. The quantity that is shown determines the contribution.
    pub options: Options,
    /// Exposure and tone curve.
    pub look: Look,
    /// The quantity that is shown.
    pub quantity: Quantity,
    /// Whether the render is paused.
    pub paused: bool,
    /// Whether the panel is open.
    pub has_panel: bool,
    /// The text of the panel's field for the scene file.
    pub scene_text: String,
    /// The text of the panel's field for the file to save to.
    pub save_text: String,
    /// The status of the render.
    pub status: Status,
    /// The last message about a finished action or an error.
    pub message: Option<Result<String, String>>,
    /// How the picture shows values.
    pub shade: Shade,
    /// [`Picture::ends`] of the picture.
    pub ends: Option<[f32; 2]>,
    /// The number of the last move of the camera in the picture.
    pub seen: u64,
    /// The number of moves of the camera.
    pub moves: u64,
    /// The area of the window for the image.
    pub area: Area,
    /// The depth of the point that the user pans, during a pan.
    pub grabbed: Option<f64>,
    /// The scene file that is shown.
    path: PathBuf,
    film: Film,
    integrator: Integrator,
    /// The number of times that the window has asked to read a scene.
    loads: u64,
    /// Whether the user has moved the camera of this scene.
    has_moved: bool,
    /// Lengths of eye paths in scene units, and the width and height of their picture.
    lengths: (Vec<f32>, [u32; 2]),
    /// Whether a scene that is not read yet is another one, or the same one read again.
    opening: Option<Opening>,
    shared: Arc<Shared>,
}

#[derive(Clone, Copy, PartialEq)]
enum Opening {
    Another,
    Again,
}

/// An effect of a command that the window itself carries out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Copy a text to the clipboard.
    Copy(String),
    /// Close the window.
    Quit,
}

impl Session {
    /// Returns the session of a scene that was read. `options` contain a resolution. `save` is the file to
    /// save to; by default it is an EXR named after the scene file.
    pub fn new(path: &Path, scene: &Scene, options: Options, save: Option<&Path>, shared: Arc<Shared>) -> Self {
        let exr = path.file_stem().map_or_else(|| PathBuf::from("image"), PathBuf::from).with_extension("exr");
        Self {
            control: CameraControl::new(scene.camera, scene.film.clone()),
            options: Options { responsive: true, ..options },
            look: Look::default(),
            quantity: Quantity::Image,
            paused: false,
            has_panel: true,
            scene_text: path.display().to_string(),
            save_text: save.unwrap_or(&exr).display().to_string(),
            status: Status::default(),
            message: None,
            shade: Shade::Light,
            ends: None,
            seen: 0,
            moves: 0,
            area: Area { origin: [0, 0], size: [1, 1] },
            grabbed: None,
            path: path.to_owned(),
            film: scene.film.clone(),
            integrator: scene.integrator,
            loads: 0,
            has_moved: false,
            lengths: (Vec::new(), [0, 0]),
            opening: None,
            shared,
        }
    }

    /// Carries out a command. Returns the part that the window has to carry out, if there is one.
    pub fn obey(&mut self, command: Command) -> Option<Effect> {
        match command {
            Command::Show(quantity) => self.show(quantity),
            Command::Reset => self.reset(),
            Command::Pause => self.pause(),
            Command::Copy => return Some(Effect::Copy(self.camera_text())),
            Command::Panel => self.has_panel = !self.has_panel,
            Command::Save => self.save(),
            Command::Quit => return Some(Effect::Quit),
        }
        None
    }

    /// Takes the news. Returns the new picture, if there is one.
    pub fn take_news(&mut self) -> Option<Picture> {
        let shared = Arc::clone(&self.shared);
        let mut news = shared.news();
        if let Some(loaded) = news.loaded.take() {
            self.take_scene(loaded);
        }
        if news.unread.take() == Some(self.loads) {
            self.keep_scene();
        }
        self.status = news.status.clone();
        if let Some(message) = news.message.take() {
            self.message = Some(message);
        }
        let view = news.view.take()?;
        self.seen = view.moves;
        (self.shade, self.ends) = (view.picture.shade, view.picture.ends);
        if let Some(lengths) = view.lengths {
            self.lengths = (lengths, view.picture.size);
            if let Some(length) = self.length_at(DVec2::splat(0.5)) {
                self.control.set_distance_once(length);
            }
        }
        Some(view.picture)
    }

    fn take_scene(&mut self, loaded: Loaded) {
        let Loaded { path, camera, film, loads, integrator } = loaded;
        let control = CameraControl::new(camera, film.clone());
        let opening = self.opening;
        if loads == self.loads {
            // If the numbers differ, another scene is still to come.
            self.opening = None;
        }
        if opening != Some(Opening::Another) && self.has_moved {
            self.control.set_home(control);
        } else {
            self.control = control;
            self.has_moved = false;
            self.moves += 1;
        }
        (self.path, self.film, self.integrator) = (path, film, integrator);
        self.look_again(false);
    }

    /// Keeps the scene that is shown, because another one could not be read. A later change of files reads
    /// the scene that is shown again.
    fn keep_scene(&mut self) {
        self.opening = None;
        self.shared.wish(false, |wish| wish.scene.clone_from(&self.path));
    }

    /// Follows a change of the camera.
    pub fn moved(&mut self) {
        self.has_moved = true;
        self.moves += 1;
        self.look_again(true);
    }

    /// Resets the camera to the one of the scene.
    pub fn reset(&mut self) {
        self.control.reset();
        self.has_moved = false;
        self.moves += 1;
        self.look_again(true);
    }

    /// Returns the target to render.
    fn target(&self) -> Target {
        let options = Options {
            contribution: self.quantity.contribution(),
            layers: self.options.layers.with(self.quantity.layers()),
            // A radius from the panel, in scene units, replaces one in pixels.
            radius_in_pixels: self.options.radius_in_pixels.filter(|_| self.options.radius.is_none()),
            ..self.options.clone()
        };
        Target { loads: self.loads, camera: self.has_moved.then_some(*self.control.camera()), options }
    }

    /// Sends the render thread the current target and quantity. The iteration in flight is given up.
    fn look_again(&mut self, is_moving: bool) {
        let (target, moves, quantity) = (self.target(), self.moves, self.quantity);
        self.shared.wish(true, |wish| {
            (wish.target, wish.moves, wish.quantity) = (target, moves, quantity);
            if is_moving {
                wish.moved = Some(Instant::now());
            }
        });
    }

    /// Follows a change of the options.
    pub fn changed_options(&mut self) {
        self.look_again(false);
    }

    /// Sets the size of the image when the window opens, unless the film is a part of a larger image.
    pub fn opens_with(&mut self, image: [u32; 2]) {
        if follows_window(&self.film) && self.options.resolution != Some(image) {
            self.options.resolution = Some(image);
            self.look_again(false);
        }
    }

    /// Follows a change of the window's size: the image fills its area, unless the film is a part of a larger
    /// image.
    pub fn resized(&mut self) {
        if follows_window(&self.film) && self.options.resolution != Some(self.area.size) {
            self.options.resolution = Some(self.area.size.map(|side| side.max(1)));
            self.look_again(true);
        }
    }

    /// Shows another quantity.
    pub fn show(&mut self, quantity: Quantity) {
        if self.quantity != quantity {
            self.quantity = quantity;
            self.look_again(false);
        }
    }

    /// Pauses or continues. The iteration in flight is finished first.
    pub fn pause(&mut self) {
        self.paused = !self.paused;
        let paused = self.paused;
        self.shared.wish(false, |wish| wish.paused = paused);
    }

    /// Opens another scene.
    pub fn open(&mut self, path: &Path) {
        self.scene_text = path.display().to_string();
        self.opening = Some(Opening::Another);
        self.shared.wish(false, |wish| wish.scene = path.to_owned());
        self.load();
    }

    /// Reads the scene again, because its files have changed.
    pub fn reload(&mut self) {
        self.opening.get_or_insert(Opening::Again);
        self.load();
    }

    fn load(&mut self) {
        self.loads += 1;
        self.look_again(false);
    }

    /// Writes the image or a checkpoint to the file that the panel names.
    pub fn save(&mut self) {
        let save = Save { path: PathBuf::from(&self.save_text), target: self.target(), quantity: self.quantity };
        self.message = Some(Ok(format!("writing {} after this iteration", save.path.display())));
        self.shared.wish(false, |wish| wish.saves.push(save));
    }

    /// Returns the camera as pbrt text.
    pub fn camera_text(&self) -> String {
        self.control.camera().to_text(self.resolution())
    }

    fn resolution(&self) -> [u32; 2] {
        self.options.resolution.unwrap_or(self.film.resolution)
    }

    /// Returns the width and height of the image at full resolution, after the film's crop window.
    pub fn image(&self) -> [u32; 2] {
        let [first, end] = self.film.bounds(self.resolution());
        [0, 1].map(|axis| end[axis] - first[axis])
    }

    /// Returns the number of photons per iteration that is used if the user gives none.
    pub fn own_photons(&self) -> u64 {
        photons_of(&self.integrator, self.image())
    }

    /// Returns the initial radius in scene units that is used if the user gives none in scene units. If it
    /// follows the pixels, it is the radius at the pivot.
    pub fn own_radius(&self) -> f64 {
        let in_pixels = self.options.radius_in_pixels;
        let of_scene = self.integrator.radius.filter(|_| in_pixels.is_none());
        let pixels = in_pixels.unwrap_or(Options::DEFAULT_RADIUS_IN_PIXELS);
        of_scene.unwrap_or_else(|| pixels * self.control.pixel_width(self.resolution()))
    }

    /// Returns the place of the image in the window.
    pub fn placement(&self) -> Placement {
        Placement::new(self.area, self.image())
    }

    /// Converts a pixel of the window to a place on the image, whose corners are (0, 0) and (1, 1).
    pub fn on_image(&self, pixel: [f32; 2]) -> DVec2 {
        let Placement { origin, size } = self.placement();
        let place = |axis: usize| f64::from((pixel[axis] - origin[axis]) / size[axis]);
        DVec2::new(place(0), place(1))
    }

    /// Returns the length of the eye path at a place on the image in scene units; `None` if there is no
    /// visible point.
    fn length_at(&self, at: DVec2) -> Option<f64> {
        let (lengths, [width, height]) = &self.lengths;
        let place =
            |fraction: f64, side: u32| (0.0..1.0).contains(&fraction).then(|| (fraction * f64::from(side)) as usize);
        let (x, y) = (place(at.x, *width)?, place(at.y, *height)?);
        lengths.get(y * *width as usize + x).copied().filter(|length| *length > 0.0).map(f64::from)
    }

    /// Returns the visible point at a place on the image; `None` if there is none.
    pub fn point_at(&self, at: DVec2) -> Option<DVec3> {
        self.control.seen(at, self.length_at(at)?, self.resolution())
    }

    /// Moves the camera sideways, so that a point moves on the image from one place to another.
    pub fn pan(&mut self, from: DVec2, to: DVec2) {
        self.control.pan(from, to, self.grabbed, self.resolution());
    }
}

/// Returns whether the image follows the size of the window: not if the film is a part of a larger image.
fn follows_window(film: &Film) -> bool {
    film.window == [0.0, 1.0, 0.0, 1.0]
}
