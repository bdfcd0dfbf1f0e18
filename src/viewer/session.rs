//! What the user looks at and asks for.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::{DVec2, DVec3};

use super::camera_control::CameraControl;
use super::display::Look;
use super::keys::Command;
use super::layout::{Area, Placement};
use super::quantity::{Picture, Quantity};
use super::shared::{Loaded, Save, Shared, Status, Target};
use crate::render::options::{Options, photons_of};
use crate::scene::{Film, Integrator, Scene};

/// The window's side of a render.
pub struct Session {
    /// The camera.
    pub control: CameraControl,
    /// How to render. What is shown decides about the contribution.
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
    /// Where the window has room for the image.
    pub area: Area,
    /// How deep the point is that is being moved sideways.
    pub grabbed: Option<f64>,
    /// The scene file that is shown.
    path: PathBuf,
    film: Film,
    integrator: Integrator,
    /// How often a scene was asked for.
    loads: u64,
    /// Whether this scene's camera was moved.
    has_moved: bool,
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

/// What a command asks of the window itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Put a text on the clipboard.
    Copy(String),
    /// Close.
    Quit,
}

impl Session {
    /// Of a scene that was read, with options that say its resolution.
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
            white: None,
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

    /// Does what a key asks for; what is left for the window to do.
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

    /// Takes the news; a new picture, if there is one.
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
        self.white = view.picture.white;
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
            // Else there is another one to come.
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

    /// A scene could not be read: the one that is shown is what a change of files is about.
    fn keep_scene(&mut self) {
        self.opening = None;
        self.shared.wish(false, |wish| wish.scene.clone_from(&self.path));
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

    /// What is to be rendered.
    fn target(&self) -> Target {
        let options = Options {
            contribution: self.quantity.contribution(),
            // The radius that was asked for last counts, in whichever unit it is.
            radius_in_pixels: self.options.radius_in_pixels.filter(|_| self.options.radius.is_none()),
            ..self.options.clone()
        };
        Target { loads: self.loads, camera: self.has_moved.then_some(*self.control.camera()), options }
    }

    /// Asks for what is wanted by now.
    fn look_again(&mut self, is_moving: bool) {
        let (target, moves, quantity) = (self.target(), self.moves, self.quantity);
        self.shared.wish(true, |wish| {
            (wish.target, wish.moves, wish.quantity) = (target, moves, quantity);
            if is_moving {
                wish.moved = Some(Instant::now());
            }
        });
    }

    /// The options were changed.
    pub fn changed_options(&mut self) {
        self.look_again(false);
    }

    /// Opens with an image of this size, where it is free to have another one than the film's.
    pub fn opens_with(&mut self, image: [u32; 2]) {
        if follows_window(&self.film) && self.options.resolution != Some(image) {
            self.options.resolution = Some(image);
            self.look_again(false);
        }
    }

    /// The user has given the window another size: the image fills the room that it has now.
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

    /// Pauses, or goes on. What the iteration in flight has done so far is not lost.
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

    /// Reads the scene again: its files have changed.
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

    /// The camera as pbrt reads it.
    pub fn camera_text(&self) -> String {
        self.control.camera().to_text(self.resolution())
    }

    fn resolution(&self) -> [u32; 2] {
        self.options.resolution.unwrap_or(self.film.resolution)
    }

    /// Width and height of the image, a finished one: a film may be a part of what the camera sees.
    pub fn image(&self) -> [u32; 2] {
        let [first, end] = self.film.bounds(self.resolution());
        [0, 1].map(|axis| end[axis] - first[axis])
    }

    /// Photons of an iteration where nobody asks for a number.
    pub fn own_photons(&self) -> u64 {
        photons_of(&self.integrator, self.image())
    }

    /// The initial radius where nobody asks for one in scene units, of what the camera turns about.
    pub fn own_radius(&self) -> f64 {
        let in_pixels = self.options.radius_in_pixels;
        let of_scene = self.integrator.radius.filter(|_| in_pixels.is_none());
        let pixels = in_pixels.unwrap_or(Options::DEFAULT_RADIUS_IN_PIXELS);
        of_scene.unwrap_or_else(|| pixels * self.control.pixel_width(self.resolution()))
    }

    /// Where the image is in the window.
    pub fn placement(&self) -> Placement {
        Placement::new(self.area, self.image())
    }

    /// A place on the image, whose corners are (0, 0) and (1, 1), of a pixel of the window.
    pub fn on_image(&self, pixel: [f32; 2]) -> DVec2 {
        let Placement { origin, size } = self.placement();
        let place = |axis: usize| f64::from((pixel[axis] - origin[axis]) / size[axis]);
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
fn follows_window(film: &Film) -> bool {
    film.window == [0.0, 1.0, 0.0, 1.0]
}
