//! File dialogs of the desktop. A dialog runs on a thread of its own, so that the window goes on.

use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};

use log::{LevelFilter, Log, Metadata, Record};
use rfd::AsyncFileDialog;
use winit::window::Window;

/// What the user is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// A scene to open.
    Scene,
    /// An image to compare with.
    Reference,
    /// A file to save to.
    Save,
}

/// The user's answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// A file.
    Chosen(PathBuf),
    /// None.
    Cancelled,
    /// The desktop shows no dialog, for this reason.
    Failed(String),
}

/// Opens a dialog, whose answer another thread hands to `tell`. `start` is the file that is named first.
pub fn ask(question: Question, start: &Path, window: &Window, tell: impl FnOnce(Answer) + Send + 'static) {
    Errors::listen();
    let mut dialog = AsyncFileDialog::new().set_parent(window);
    if let Some(folder) = start.parent().and_then(|folder| std::path::absolute(folder).ok()) {
        dialog = dialog.set_directory(folder);
    }
    // Some desktops want the dialog to be made on the thread of the window. It is waited for on another one.
    let answer: std::pin::Pin<Box<dyn Future<Output = Option<rfd::FileHandle>> + Send>> = match question {
        Question::Scene => Box::pin(dialog.set_title("Open a scene").add_filter("pbrt scenes", &["pbrt"]).pick_file()),
        Question::Reference => {
            let images = ["exr", "png", "pfm", "hdr", "jpg", "tga"];
            Box::pin(dialog.set_title("Compare with an image").add_filter("images", &images).pick_file())
        }
        Question::Save => {
            let name = start.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            let kinds = ["exr", "png", "checkpoint"];
            Box::pin(dialog.set_title("Save the image").set_file_name(name).add_filter("images", &kinds).save_file())
        }
    };
    std::thread::spawn(move || {
        let chosen = pollster::block_on(answer);
        let answer = match (chosen, Errors::take()) {
            (Some(file), _) => Answer::Chosen(file.path().to_owned()),
            (None, Some(error)) => Answer::Failed(error),
            (None, None) => Answer::Cancelled,
        };
        tell(answer);
    });
}

/// The first error of the crate `rfd`, which reports errors to the log alone, and returns the same as when the user
/// chooses nothing. The first one is that of the portal; the next ones are of programs that it tries instead.
struct Errors(Mutex<Option<String>>);

static ERRORS: LazyLock<Errors> = LazyLock::new(|| Errors(Mutex::new(None)));

impl Errors {
    /// Starts to keep errors. A program with another log has none here: a dialog that fails then looks as if the user had
    /// chosen nothing.
    fn listen() {
        if log::set_logger(&*ERRORS).is_ok() {
            log::set_max_level(LevelFilter::Error);
        }
        Self::take();
    }

    fn take() -> Option<String> {
        ERRORS.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Log for Errors {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target().starts_with("rfd")
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            let mut first = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert_with(|| record.args().to_string());
        }
    }

    fn flush(&self) {}
}
