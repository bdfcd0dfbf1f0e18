//! What the window's thread and the one that renders tell each other.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::quantity::{Picture, Quantity};
use crate::cli::Failure;
use crate::render::options::Options;
use crate::scene::{Camera, Film, Integrator};

/// What a render is of.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Which reading of the scene; it may have changed.
    pub loads: u64,
    /// Where it is seen from; the scene's own camera if nobody has moved.
    pub camera: Option<Camera>,
    /// How to render; resolution and contribution included.
    pub options: Options,
}

impl Target {
    /// Whether another one is of the same, but for the part of the light that it has.
    pub fn is_alike(&self, other: &Self) -> bool {
        let contribution = self.options.contribution;
        *self == Self { options: Options { contribution, ..other.options.clone() }, ..other.clone() }
    }
}

/// A file to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct Save {
    /// Its name; the ending says what is written.
    pub path: PathBuf,
    /// Of what; of something else that is wished later, if this does not get an iteration.
    pub target: Target,
    /// What was shown.
    pub quantity: Quantity,
}

/// What the window wants. Only the newest wish counts.
#[derive(Clone, Debug)]
pub struct Wish {
    /// The scene file.
    pub scene: PathBuf,
    /// What to render.
    pub target: Target,
    /// How often the camera was moved.
    pub moves: u64,
    /// When camera or size changed last, if they did: soon after, coarse images are enough.
    pub moved: Option<Instant>,
    /// What to show.
    pub quantity: Quantity,
    /// Iterate no further, once there is an iteration.
    pub paused: bool,
    /// Files to write.
    pub saves: Vec<Save>,
    /// End.
    pub close: bool,
}

/// A picture of a render.
pub struct View {
    /// What is shown.
    pub picture: Picture,
    /// Which move of the camera it has seen.
    pub moves: u64,
    /// Lengths of eye paths in scene units, if they are new.
    pub lengths: Option<Vec<f32>>,
}

/// A scene that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// Its file.
    pub path: PathBuf,
    /// Its camera.
    pub camera: Camera,
    /// Its film.
    pub film: Film,
    /// Which reading it was.
    pub loads: u64,
    /// What it says of photons and radii.
    pub integrator: Integrator,
}

/// How a render is doing.
#[derive(Clone, Debug, Default)]
pub struct Status {
    /// What the thread is at.
    pub doing: &'static str,
    /// Iterations finished.
    pub iterations: u32,
    /// Photons emitted.
    pub photons: u64,
    /// Time that they took.
    pub time: Duration,
    /// Device time of the last iteration by pass.
    pub passes: Vec<(&'static str, Duration)>,
    /// Estimated relative error.
    pub error: Option<f64>,
    /// Device memory, bytes.
    pub memory: u64,
    /// Width and height.
    pub resolution: [u32; 2],
    /// The device.
    pub device: String,
}

/// What there is to tell the window.
#[derive(Default)]
pub struct News {
    /// The newest picture, until it is taken.
    pub view: Option<View>,
    /// A scene that was just read, until it is taken.
    pub loaded: Option<Loaded>,
    /// Which reading of a scene has failed, until it is taken.
    pub unread: Option<u64>,
    /// The files of a scene that was just read, until they are taken.
    pub files: Option<Vec<PathBuf>>,
    /// How the render is doing.
    pub status: Status,
    /// What went wrong or was done, until it is taken.
    pub message: Option<Result<String, String>>,
    /// What could not be written after the window was closed.
    pub unwritten: Vec<Failure>,
    /// Messages of the validation layer, once the thread has ended.
    pub validation: Vec<String>,
}

/// What the window's thread writes and the other one reads.
struct Desk {
    wish: Wish,
    /// Whether it is another one than was taken last.
    is_new: bool,
}

/// Where the two threads meet.
pub struct Shared {
    desk: Mutex<Desk>,
    wished: Condvar,
    closed: Condvar,
    /// Whether the iteration in flight is of no use any more.
    hurry: AtomicBool,
    news: Mutex<News>,
    /// Wakes the window.
    wake: Box<dyn Fn() + Send + Sync>,
}

impl Shared {
    /// With a first wish.
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

    /// Changes the wish. With `hurry`, the iteration in flight is given up for it.
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

    /// The wish as it is; what is to be done once is taken out of it.
    pub fn take_wish(&self) -> Wish {
        let mut desk = lock(&self.desk);
        self.hurry.store(false, Ordering::Relaxed);
        desk.is_new = false;
        let saves = std::mem::take(&mut desk.wish.saves);
        Wish { saves, ..desk.wish.clone() }
    }

    /// Waits for another wish, or some time.
    pub fn wait(&self, most: Duration) {
        drop(self.wished.wait_timeout_while(lock(&self.desk), most, |desk| !desk.is_new));
    }

    /// Whether what is being done is of no use any more.
    pub fn in_hurry(&self) -> bool {
        self.hurry.load(Ordering::Relaxed)
    }

    /// Whether the newest wish has been taken.
    #[cfg(test)]
    pub fn is_taken(&self) -> bool {
        !lock(&self.desk).is_new
    }

    /// Whether the newest wish is of the same.
    pub fn still_wants(&self, target: &Target) -> bool {
        lock(&self.desk).wish.target == *target
    }

    /// The window is closed.
    pub fn close(&self) {
        self.wish(true, |wish| wish.close = true);
        self.closed.notify_all();
    }

    /// Waits for the end, or some time; whether it has come.
    pub fn waits_for_close(&self, most: Duration) -> bool {
        let waited = self.closed.wait_timeout_while(lock(&self.desk), most, |desk| !desk.wish.close);
        waited.unwrap_or_else(PoisonError::into_inner).0.wish.close
    }

    /// The files of a scene that nobody watches yet.
    pub fn files_of_new_scene(&self) -> Option<Vec<PathBuf>> {
        lock(&self.news).files.take()
    }

    /// Tells the window something.
    pub fn tell(&self, change: impl FnOnce(&mut News)) {
        change(&mut lock(&self.news));
        (self.wake)();
    }

    /// What there is to tell.
    pub fn news(&self) -> MutexGuard<'_, News> {
        lock(&self.news)
    }
}

/// A thread that panicked has left numbers and lists that are good enough to be shown.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
