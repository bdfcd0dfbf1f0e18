//! What a render does at a moment, in words for people. The command line and the window show the same words.

use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What a render does at a moment. Its text is in lower case and without a full stop: `compiling kernels 3/8`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// The scene file and the files that it names are read.
    ReadingScene,
    /// The device is opened, and its driver loaded.
    OpeningDevice,
    /// The shapes are prepared for rays: space, materials, and the hierarchies that rays walk through.
    BuildingHierarchy,
    /// The scene is copied to the device.
    Uploading,
    /// The driver compiles the kernels.
    CompilingKernels {
        /// The number of kernels that are compiled.
        done: u32,
        /// The number of all kernels that the render needs.
        all: u32,
    },
    /// The trial that chooses the numbers of photons and of eye paths: [`crate::render::counts`].
    Trial,
    /// The pilot that finds where photons begin that bring light to what is seen: [`crate::render::guide`].
    Pilot,
    /// Short renders with several settings: `goblet advise`.
    Probing {
        /// The number of the render, from 1.
        number: u32,
        /// The number of all of them.
        all: u32,
    },
    /// Iterations are rendered.
    Rendering,
    /// Images and other outputs are written.
    Writing,
}

impl fmt::Display for Activity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ReadingScene => f.write_str("reading the scene"),
            Self::OpeningDevice => f.write_str("opening the device"),
            Self::BuildingHierarchy => f.write_str("building the hierarchy"),
            Self::Uploading => f.write_str("copying the scene to the device"),
            Self::CompilingKernels { done, all } => write!(f, "compiling kernels {done}/{all}"),
            Self::Trial => f.write_str("trial of photons and eye paths"),
            Self::Pilot => f.write_str("pilot of the guide"),
            Self::Probing { number, all } => write!(f, "probe {number}/{all}"),
            Self::Rendering => f.write_str("rendering"),
            Self::Writing => f.write_str("writing the files"),
        }
    }
}

impl Activity {
    /// Returns whether both are the same activity, however far it has come.
    pub fn is_same(self, other: Self) -> bool {
        std::mem::discriminant(&self) == std::mem::discriminant(&other)
    }
}

/// An activity and the time since which it goes on.
#[derive(Clone, Copy, Debug)]
pub struct Since {
    /// The activity.
    pub activity: Activity,
    /// When it began.
    pub begin: Instant,
}

impl Since {
    /// Returns an activity that begins now.
    pub fn now(activity: Activity) -> Self {
        Self { activity, begin: Instant::now() }
    }

    /// Notes what is done now. The time goes on if it is the same activity, such as the next kernel.
    pub fn note(&mut self, activity: Activity) {
        if self.activity.is_same(activity) {
            self.activity = activity;
        } else {
            *self = Self::now(activity);
        }
    }

    /// Returns for how long the activity has gone on.
    pub fn elapsed(&self) -> Duration {
        self.begin.elapsed()
    }
}

impl fmt::Display for Since {
    /// Writes the activity and its seconds: `building the hierarchy, 2.1 s`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {:.1} s", self.activity, self.elapsed().as_secs_f64())
    }
}

/// A function that is told of each activity when it begins, on the thread that does it. It should return soon.
#[derive(Clone, Default)]
pub struct Observer(Option<Arc<dyn Fn(Activity) + Send + Sync>>);

impl Observer {
    /// Returns an observer that calls a function.
    pub fn new(tell: impl Fn(Activity) + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(tell)))
    }

    /// Tells what is done now.
    pub fn tell(&self, activity: Activity) {
        if let Some(tell) = &self.0 {
            tell(activity);
        }
    }
}

impl fmt::Debug for Observer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Observer(..)" } else { "Observer" })
    }
}

/// Counts kernels while they are compiled, and tells an observer.
pub struct Kernels<'a> {
    observer: &'a Observer,
    done: u32,
    all: u32,
}

impl<'a> Kernels<'a> {
    /// Tells that none of `all` kernels is compiled yet.
    pub fn new(observer: &'a Observer, all: u32) -> Self {
        observer.tell(Activity::CompilingKernels { done: 0, all });
        Self { observer, done: 0, all }
    }

    /// Notes that another `count` kernels are compiled.
    pub fn compiled(&mut self, count: u32) {
        self.done += count;
        if count > 0 {
            self.observer.tell(Activity::CompilingKernels { done: self.done, all: self.all });
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn kernels_are_counted_while_their_time_goes_on() {
        let told = Arc::new(Mutex::new(Vec::new()));
        let tell = Arc::clone(&told);
        let observer = Observer::new(move |activity| tell.lock().unwrap().push(activity.to_string()));
        let mut kernels = Kernels::new(&observer, 3);
        kernels.compiled(1);
        kernels.compiled(0);
        kernels.compiled(2);
        observer.tell(Activity::Pilot);
        let words = ["compiling kernels 0/3", "compiling kernels 1/3", "compiling kernels 3/3", "pilot of the guide"];
        assert_eq!(*told.lock().unwrap(), words);

        let mut since = Since::now(Activity::CompilingKernels { done: 1, all: 3 });
        let begin = since.begin;
        since.note(Activity::CompilingKernels { done: 2, all: 3 });
        assert!(since.begin == begin && since.activity == Activity::CompilingKernels { done: 2, all: 3 });
        since.note(Activity::Rendering);
        assert!(since.begin >= begin && since.activity == Activity::Rendering);
        assert!(since.to_string().starts_with("rendering, ") && since.to_string().ends_with(" s"));
    }
}
