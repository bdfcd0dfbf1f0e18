//! The state that the thread of the window and the render thread share.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::compared::Other;
use super::dialog::{Answer, Question};
use super::doing::Doing;
use super::guiding::Guiding;
use super::quantity::{Picture, Quantity};
use crate::cli::Failure;
use crate::image::compare::Comparison;
use crate::image::exposure::Exposure;
use crate::render::options::Options;
use crate::scene::{Camera, Film, Integrator};

/// The target of a render: a version of the scene, a camera and options.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// The number of times that the window has asked to read a scene. Each reading may give another scene.
    pub loads: u64,
    /// The camera; `None` for the scene's own camera if the user has not moved it.
    pub camera: Option<Camera>,
    /// The options, including the resolution, the contribution and the layers.
    pub options: Options,
}

impl Target {
    /// Returns whether another target is the same except for the part of the light and the layers.
    pub fn is_alike(&self, other: &Self) -> bool {
        let Options { contribution, layers, .. } = self.options;
        *self == Self { options: Options { contribution, layers, ..other.options.clone() }, ..other.clone() }
    }
}

/// A file to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct Save {
    /// The name of the file; its extension decides about the format.
    pub path: PathBuf,
    /// Whether a file with this name is replaced, because the user was asked. Else the file gets the next free name.
    pub may_replace: bool,
    /// The exposure of a PNG.
    pub exposure: Exposure,
    /// The target of the image. A later target replaces it if it does not get an iteration.
    pub target: Target,
    /// The quantity that was shown when the user saved.
    pub quantity: Quantity,
}

impl Save {
    /// Returns the file with a name that no other file has: `image.exr`, else `image-2.exr` and so on, unless the file may
    /// be replaced.
    pub fn with_free_name(&self) -> Self {
        let Self { path, may_replace, .. } = self;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let extension = path.extension().map_or_else(String::new, |end| format!(".{}", end.to_string_lossy()));
        let numbered = |number: u32| path.with_file_name(format!("{stem}-{number}{extension}"));
        let mut names = [path.clone()].into_iter().chain((2..).map(numbered));
        let is_free = |path: &PathBuf| *may_replace || path.symlink_metadata().is_err();
        Self { path: names.find(is_free).unwrap_or_else(|| path.clone()), ..self.clone() }
    }
}

/// The wishes of the window. Only the newest state counts.
#[derive(Clone, Debug)]
pub struct Wish {
    /// The scene file.
    pub scene: PathBuf,
    /// The target to render.
    pub target: Target,
    /// The number of moves of the camera.
    pub moves: u64,
    /// The time when the camera or the size last changed. Shortly after it, coarse images are enough.
    pub moved: Option<Instant>,
    /// The quantity to show.
    pub quantity: Quantity,
    /// Whether the render is paused. A target without an iteration gets one nevertheless.
    pub paused: bool,
    /// Files to write.
    pub saves: Vec<Save>,
    /// Whether the window is closed.
    pub close: bool,
}

/// A picture of a render.
pub struct View {
    /// The picture.
    pub picture: Picture,
    /// The number of the last move of the camera in the picture.
    pub moves: u64,
    /// Lengths of eye paths in scene units, if they are new.
    pub lengths: Option<Vec<f32>>,
}

/// A scene that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// The scene file.
    pub path: PathBuf,
    /// The camera of the scene.
    pub camera: Camera,
    /// The film of the scene.
    pub film: Film,
    /// The value of [`Target::loads`] for which the scene was read.
    pub loads: u64,
    /// The integrator of the scene, with its numbers of photons and its radius.
    pub integrator: Integrator,
}

/// The status of a render.
#[derive(Clone, Debug, Default)]
pub struct Status {
    /// The activity of the render thread.
    pub doing: Doing,
    /// The time when it began.
    pub since: Option<Instant>,
    /// The number of finished iterations.
    pub iterations: u32,
    /// The number of emitted photons.
    pub photons: u64,
    /// The total time of the iterations.
    pub time: Duration,
    /// Device time of the last iteration by pass.
    pub passes: Vec<(&'static str, Duration)>,
    /// Estimated relative error.
    pub error: Option<f64>,
    /// Where photons begin.
    pub guiding: Guiding,
    /// Device memory in bytes.
    pub memory: u64,
    /// Width and height of the rendered image in pixels.
    pub resolution: [u32; 2],
    /// The name of the device.
    pub device: String,
}

/// The news for the window.
#[derive(Default)]
pub struct News {
    /// The newest picture, until the window takes it.
    pub view: Option<View>,
    /// A scene that was just read, until the window takes it.
    pub loaded: Option<Loaded>,
    /// The value of [`Target::loads`] for which reading a scene failed, until the window takes it.
    pub unread: Option<u64>,
    /// The files of a scene that was just read, until the watching thread takes them.
    pub files: Option<Vec<PathBuf>>,
    /// The status of the render.
    pub status: Status,
    /// A message about a finished action or an error, until the window takes it.
    pub message: Option<Result<String, String>>,
    /// The answer to a file dialog, until the window takes it.
    pub answer: Option<(Question, Answer)>,
    /// An image file that was read for a comparison, or the reason why it was not, until the window takes it.
    pub other: Option<Result<Other, String>>,
    /// The error that the measurement with this number has found, until the window takes it.
    pub comparison: Option<(u64, Comparison)>,
    /// The errors of files that could not be written after the window was closed.
    pub unwritten: Vec<Failure>,
    /// Messages of the validation layers, once the render thread has ended.
    pub validation: Vec<String>,
}

/// The state that the thread of the window writes and the render thread reads.
struct Desk {
    wish: Wish,
    /// Whether the wish has changed since the render thread last took it.
    is_new: bool,
}

/// The state of both threads.
pub struct Shared {
    desk: Mutex<Desk>,
    wished: Condvar,
    closed: Condvar,
    /// Whether the iteration in flight should be given up.
    hurry: AtomicBool,
    news: Mutex<News>,
    /// Wakes the thread of the window.
    wake: Box<dyn Fn() + Send + Sync>,
}

impl Status {
    /// Notes an activity. Its time begins now, unless it goes on.
    pub fn does(&mut self, doing: Doing) {
        if !self.doing.is_same(doing) || self.since.is_none() {
            self.since = Some(Instant::now());
        }
        self.doing = doing;
    }
}

impl Shared {
    /// Returns the state with a first wish. `wake` wakes the thread of the window.
    pub fn new(wish: Wish, wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            desk: Mutex::new(Desk { wish, is_new: true }),
            wished: Condvar::new(),
            closed: Condvar::new(),
            hurry: AtomicBool::new(false),
            news: Mutex::default(),
            wake: Box::new(wake),
        }
    }

    /// Changes the wish. With `hurry`, the iteration in flight is given up.
    pub fn wish(&self, hurry: bool, change: impl FnOnce(&mut Wish)) {
        {
            let mut desk = lock(&self.desk);
            change(&mut desk.wish);
            desk.is_new = true;
            if hurry {
                self.hurry.store(true, Ordering::Relaxed);
            }
        }
        self.wished.notify_one();
    }

    /// Returns the current wish, and removes the files to write from it, since each is written only once.
    pub fn take_wish(&self) -> Wish {
        let mut desk = lock(&self.desk);
        self.hurry.store(false, Ordering::Relaxed);
        desk.is_new = false;
        let saves = std::mem::take(&mut desk.wish.saves);
        Wish { saves, ..desk.wish.clone() }
    }

    /// Waits until the wish changes, for at most the given time.
    pub fn wait(&self, most: Duration) {
        drop(self.wished.wait_timeout_while(lock(&self.desk), most, |desk| !desk.is_new));
    }

    /// Returns whether the iteration in flight should be given up.
    pub fn in_hurry(&self) -> bool {
        self.hurry.load(Ordering::Relaxed)
    }

    /// Returns whether the render thread has taken the newest wish.
    #[cfg(test)]
    pub fn is_taken(&self) -> bool {
        !lock(&self.desk).is_new
    }

    /// Returns whether the newest wish has this target. If `may_close`, a wish to close the window has none.
    pub fn still_wants(&self, target: &Target, may_close: bool) -> bool {
        let wish = &lock(&self.desk).wish;
        wish.target == *target && !(may_close && wish.close)
    }

    /// Tells all threads that the window is closed.
    pub fn close(&self) {
        self.wish(true, |wish| wish.close = true);
        self.closed.notify_all();
    }

    /// Waits until the window is closed, for at most the given time. Returns whether it is closed.
    pub fn waits_for_close(&self, most: Duration) -> bool {
        let waited = self.closed.wait_timeout_while(lock(&self.desk), most, |desk| !desk.wish.close);
        waited.unwrap_or_else(PoisonError::into_inner).0.wish.close
    }

    /// Returns the files of a scene that are not watched yet, once.
    pub fn files_of_new_scene(&self) -> Option<Vec<PathBuf>> {
        lock(&self.news).files.take()
    }

    /// Changes the news and wakes the thread of the window.
    pub fn tell(&self, change: impl FnOnce(&mut News)) {
        change(&mut lock(&self.news));
        (self.wake)();
    }

    /// Locks the news.
    pub fn news(&self) -> MutexGuard<'_, News> {
        lock(&self.news)
    }
}

/// Locks a mutex, even if a thread panicked with it: its numbers and lists can still be shown.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_is_taken_gets_a_number() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.v2.exr");
        let target = Target { loads: 0, camera: None, options: Options::default() };
        let save = Save {
            path: path.clone(),
            may_replace: false,
            exposure: Exposure::default(),
            target,
            quantity: Quantity::Image,
        };
        for expected in ["image.v2.exr", "image.v2-2.exr", "image.v2-3.exr"] {
            let free = save.with_free_name().path;
            assert_eq!(free, folder.path().join(expected));
            std::fs::write(free, "").unwrap();
        }
        let may = Save { may_replace: true, ..save };
        assert_eq!(may.with_free_name().path, path);
    }
}
