//! The session of a user: the state of the window, and the wishes that follow from it.

mod compare;
mod files;
mod image;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::{DVec2, DVec3};

pub use self::image::{EXPOSURES, Probe};
use super::bindings::Command;
use super::camera_control::CameraControl;
use super::compared::Compared;
use super::dialog::Question;
use super::display::Look;
use super::histogram::Histogram;
use super::history::History;
use super::layout::{Area, Zoom};
use super::paint::{Colors, Scale};
use super::quantity::{Picture, Quantity};
use super::shared::{Loaded, Shared, Status, Target, View};
use crate::render::options::{Options, photons_of};
use crate::scene::{Film, Integrator, Scene};

/// The factor by which a key makes the width of what is seen larger.
const WIDER: f64 = 1.1;

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
    /// The text of the panel's field for the image to compare with.
    pub reference_text: String,
    /// The text of the panel's field for the file to save to.
    pub save_text: String,
    /// The status of the render.
    pub status: Status,
    /// The last message about a finished action or an error.
    pub message: Option<Result<String, String>>,
    /// The picture that was last rendered.
    pub picture: Option<Arc<Picture>>,
    /// How values become colours.
    pub colors: Colors,
    /// Whether the exposure follows from the image.
    pub has_auto_exposure: bool,
    /// The scale of false colours that are shown.
    pub scale: Option<Scale>,
    /// How large the image is shown.
    pub zoom: Zoom,
    /// Whether the last turn of the wheel was with Alt, and enlarges the image.
    pub enlarges: bool,
    /// The pixel of the window under the cursor, while it is on the image.
    pub cursor: Option<[f32; 2]>,
    /// The picture to compare with, and how both are shown.
    pub compared: Compared,
    /// Whether the list of keys is open.
    pub has_keys: bool,
    /// Whether a file dialog is open.
    pub is_asking: bool,
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
    history: History,
    /// Whether what the window shows of the picture has changed.
    is_changed: bool,
    /// The number of pictures so far.
    pictures: u64,
    /// The number of measurements of the error so far.
    measurements: u64,
    /// The histogram of the picture with this number.
    histogram: Option<(u64, Histogram)>,
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
    /// Open a file dialog. The path is the file that it names first.
    Ask(Question, PathBuf),
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
            reference_text: String::new(),
            save_text: save.unwrap_or(&exr).display().to_string(),
            status: Status::default(),
            message: None,
            picture: None,
            colors: Colors::default(),
            has_auto_exposure: false,
            scale: None,
            zoom: Zoom::default(),
            enlarges: false,
            cursor: None,
            compared: Compared::default(),
            has_keys: false,
            is_asking: false,
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
            history: History::default(),
            is_changed: false,
            pictures: 0,
            measurements: 0,
            histogram: None,
            shared,
        }
    }

    /// Returns the state that all threads share.
    pub fn shared(&self) -> Arc<Shared> {
        Arc::clone(&self.shared)
    }

    /// Carries out a command. Returns the part that the window has to carry out, if there is one.
    pub fn obey(&mut self, command: Command) -> Option<Effect> {
        match command {
            Command::Show(quantity) => self.show(quantity),
            Command::Colors => self.color(self.colors.next(self.quantity)),
            Command::Expose(steps) => self.expose(steps),
            Command::AutoExpose => self.auto_expose(!self.has_auto_exposure),
            Command::Zoom(is_in) => self.zoom = self.zoom.step(is_in, self.hand(), self.area, self.image()),
            Command::Fit => self.zoom = Zoom::Fit,
            Command::Pixels => self.zoom = Zoom::Own { scale: 1.0, middle: [0.5; 2] },
            Command::Shift(eighths) => self.shift(eighths),
            Command::Widen(is_wider) => self.widen(if is_wider { WIDER } else { 1.0 / WIDER }),
            Command::Undo | Command::Redo => self.travel(command == Command::Redo),
            Command::Reset => self.reset(),
            Command::Copy => {
                self.message = Some(Ok("copied the camera as pbrt text".to_owned()));
                return Some(Effect::Copy(self.camera_text()));
            }
            Command::Keep => self.keep(),
            Command::Flip => self.flip(),
            Command::Split => self.split(),
            Command::MoveSplit(is_right) => self.move_split(is_right),
            Command::Pause => self.pause(),
            Command::Save => self.save(),
            Command::Ask(question) => return self.ask(question),
            Command::Panel => self.has_panel = !self.has_panel,
            Command::Keys => self.has_keys = !self.has_keys,
            Command::Quit if self.has_keys => self.has_keys = false,
            Command::Quit => return Some(Effect::Quit),
        }
        None
    }

    /// Takes the news. Returns the new picture, if there is one.
    pub fn take_news(&mut self) -> Option<Arc<Picture>> {
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
        self.take_answers(&mut news);
        let view = news.view.take();
        drop(news);
        let taken = view.map(|view| self.take_view(view));
        self.measure();
        taken
    }

    fn take_view(&mut self, view: View) -> Arc<Picture> {
        self.seen = view.moves;
        if let Some(lengths) = view.lengths {
            self.lengths = (lengths, view.picture.size);
            if let Some(length) = self.length_at(DVec2::splat(0.5)) {
                self.control.set_distance_once(length);
            }
        }
        let picture = Arc::new(view.picture);
        self.picture = Some(Arc::clone(&picture));
        self.pictures += 1;
        self.follow_exposure();
        self.is_changed = true;
        picture
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
            self.history = History::default();
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

    /// Changes the camera, and notes the place before the change so that the user can return to it.
    pub fn moves(&mut self, change: impl FnOnce(&mut CameraControl)) {
        self.moves_if(|control| {
            change(control);
            true
        });
    }

    /// As [`Self::moves`], if the change says that the image changes.
    pub fn moves_if(&mut self, change: impl FnOnce(&mut CameraControl) -> bool) {
        let before = self.control.place();
        if change(&mut self.control) {
            self.history.moves(before, Instant::now());
            self.moved();
        }
    }

    fn moved(&mut self) {
        self.has_moved = true;
        self.moves += 1;
        self.look_again(true);
    }

    /// Resets the camera to the one of the scene.
    pub fn reset(&mut self) {
        if !self.control.is_home() {
            self.history.ends_step();
            self.history.moves(self.control.place(), Instant::now());
            self.history.ends_step();
        }
        self.control.reset();
        self.has_moved = false;
        self.moves += 1;
        self.look_again(true);
    }

    /// Undoes the last move of the camera, or does it again.
    pub fn travel(&mut self, is_forward: bool) {
        let here = self.control.place();
        let place = if is_forward { self.history.redo(here) } else { self.history.undo(here) };
        let Some(place) = place else {
            let what = if is_forward { "no move was undone" } else { "the camera has not moved" };
            self.message = Some(Ok(what.to_owned()));
            return;
        };
        self.control.go_to(place);
        self.moved();
        // The scene's own camera is the same target as at first, even if the scene is read again.
        if self.control.is_home() {
            self.has_moved = false;
            self.look_again(true);
        }
    }

    /// Returns the numbers of moves that can be undone and done again.
    pub fn steps(&self) -> [usize; 2] {
        self.history.steps()
    }

    /// Multiplies the width of what the camera sees by a factor.
    pub fn widen(&mut self, factor: f64) {
        self.moves_if(|control| {
            let before = *control.camera();
            control.widen(factor);
            *control.camera() != before
        });
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
            self.color(Colors::first(quantity));
            self.look_again(false);
        }
    }

    /// Pauses or continues. The iteration in flight is finished first.
    pub fn pause(&mut self) {
        self.paused = !self.paused;
        let paused = self.paused;
        self.shared.wish(false, |wish| wish.paused = paused);
    }

    /// Reads the scene again, because its files have changed.
    pub fn reload(&mut self) {
        self.opening.get_or_insert(Opening::Again);
        self.load();
    }

    /// Opens another scene.
    pub fn open(&mut self, path: &Path) {
        self.scene_text = path.display().to_string();
        self.opening = Some(Opening::Another);
        self.shared.wish(false, |wish| wish.scene = path.to_owned());
        self.load();
    }

    fn load(&mut self) {
        self.loads += 1;
        self.look_again(false);
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
        let (grabbed, resolution) = (self.grabbed, self.resolution());
        self.moves(|control| control.pan(from, to, grabbed, resolution));
    }

    /// Returns the state of the render in words.
    pub fn state(&self) -> String {
        self.status.doing.words(self.paused, self.status.since)
    }

    /// Returns the title of the window: the scene's name, and the state.
    pub fn title(&self) -> String {
        let name = self.path.file_name().unwrap_or_else(|| self.path.as_os_str());
        format!("{} - {} - goblet", name.to_string_lossy(), self.status.doing.words(self.paused, None))
    }
}

/// Returns whether the image follows the size of the window: not if the film is a part of a larger image.
fn follows_window(film: &Film) -> bool {
    film.window == [0.0, 1.0, 0.0, 1.0]
}
