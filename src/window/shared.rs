//! What the window's thread and the one that renders tell each other.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::quantity::{Picture, Quantity};
use crate::options::Options;
use crate::scene::{Camera, Film};

/// What the window wants. Only the newest wish counts.
#[derive(Clone, Debug)]
pub struct Wish {
    /// The scene file ..
    pub scene: PathBuf,
    /// .. and how often it was asked for: it may have changed.
    pub loads: u64,
    /// Where it is seen from; the scene's own camera if nobody has moved.
    pub camera: Option<Camera>,
    /// How often the camera was moved.
    pub moves: u64,
    /// When camera or size changed last, if they did: soon after, coarse images are enough.
    pub moved: Option<Instant>,
    /// How to render; the resolution included.
    pub options: Options,
    /// What to show.
    pub quantity: Quantity,
    /// Iterate no further.
    pub paused: bool,
    /// Files to write.
    pub saves: Vec<PathBuf>,
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
    /// Its camera.
    pub camera: Camera,
    /// Its film.
    pub film: Film,
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
    /// The files of a scene that was just read, until they are taken.
    pub files: Option<Vec<PathBuf>>,
    /// How the render is doing.
    pub status: Status,
    /// What went wrong or was done, until it is taken.
    pub message: Option<Result<String, String>>,
    /// Messages of the validation layer, once the thread has ended.
    pub validation: Vec<String>,
}

/// Where the two threads meet.
pub struct Shared {
    wish: Mutex<Wish>,
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
            wish: Mutex::new(wish),
            wished: Condvar::new(),
            closed: Condvar::new(),
            hurry: AtomicBool::new(false),
            news: Mutex::default(),
            wake: Box::new(wake),
        }
    }

    /// Changes the wish. With `hurry`, the iteration in flight is given up for it.
    pub fn wish(&self, hurry: bool, change: impl FnOnce(&mut Wish)) {
        change(&mut lock(&self.wish));
        if hurry {
            self.hurry.store(true, Ordering::Relaxed);
        }
        self.wished.notify_one();
    }

    /// The wish as it is; what is to be done once is taken out of it.
    pub fn take_wish(&self) -> Wish {
        let mut wish = lock(&self.wish);
        self.hurry.store(false, Ordering::Relaxed);
        let saves = std::mem::take(&mut wish.saves);
        Wish { saves, ..wish.clone() }
    }

    /// Waits for another wish, or some time.
    pub fn wait(&self, most: Duration) {
        let wish = lock(&self.wish);
        if wish.saves.is_empty() && !wish.close && !self.in_hurry() {
            drop(self.wished.wait_timeout(wish, most));
        }
    }

    /// Whether what is being done is of no use any more.
    pub fn in_hurry(&self) -> bool {
        self.hurry.load(Ordering::Relaxed)
    }

    /// The window is closed.
    pub fn close(&self) {
        self.wish(true, |wish| wish.close = true);
        self.closed.notify_all();
    }

    /// Waits for the end, or some time; whether it has come.
    pub fn waits_for_close(&self, most: Duration) -> bool {
        let wish = lock(&self.wish);
        let waited = self.closed.wait_timeout_while(wish, most, |wish| !wish.close);
        waited.unwrap_or_else(PoisonError::into_inner).0.close
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
