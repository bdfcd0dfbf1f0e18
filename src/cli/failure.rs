//! What a command can fail with, and the exit code of each.

use std::io;
use std::path::{Path, PathBuf};

use crate::image::compare::SizeMismatch;
use crate::image::file::ImageError;
use crate::image::film::Apart;
use crate::render::checkpoint::CheckpointError;
use crate::render::error::RenderError;
use crate::scene::SceneError;
use crate::scene::mesh::tessellate::TooFine;
#[cfg(feature = "study")]
use crate::study::measure::KnobError;

/// A failed command; printed once, by `main`.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The scene file is wrong or needs what goblet does not have.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene file has more than one fault, which are printed already.
    #[error("{0} cannot be rendered as it is")]
    Unrenderable(String),
    /// The render could not start or go on.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] goblet_host::Error),
    /// An image could not be written.
    #[error(transparent)]
    Output(#[from] ImageError),
    /// Images could not be compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// Settings that cannot be measured.
    #[cfg(feature = "study")]
    #[error(transparent)]
    Knob(#[from] KnobError),
    /// A report could not be written.
    #[error("{path}: cannot write the report: {reason}")]
    Report {
        /// The file or folder.
        path: String,
        /// What is in the way.
        reason: String,
    },
    /// Bodies could not be replaced by meshes.
    #[error(transparent)]
    Tessellate(#[from] TessellateError),
    /// A checkpoint could not be read, written or used.
    #[error("{path}: {reason}")]
    Checkpoint {
        /// The file.
        path: String,
        /// What is wrong with it.
        reason: CheckpointError,
    },
    /// The operating system does not let us listen for signals.
    #[error("cannot listen for signals: {0}")]
    Signals(std::io::Error),
    /// The statistics could not be written.
    #[error("{path}: cannot write the statistics: {reason}")]
    Stats {
        /// The file.
        path: String,
        /// What the operating system says.
        reason: std::io::Error,
    },
    /// Standard output takes no more.
    #[error("cannot write to standard output: {0}")]
    Print(std::io::Error),
    /// Writing a file would destroy another.
    #[error("{}: {fact}{}; expected another name for {what}", .path.display(), as_named(.path, .other))]
    SameFile {
        /// The file.
        path: PathBuf,
        /// What it is already, as in "the scene reads this file".
        fact: String,
        /// Its name as that.
        other: PathBuf,
        /// What it was to be.
        what: &'static str,
    },
    /// There is no manual of a command of this name.
    #[error("no command is called \"{name}\"; expected one of: {known}")]
    NoCommand {
        /// What was asked for.
        name: String,
        /// The commands that there are.
        known: String,
    },
    /// What is known of a scene could not be put into words.
    #[error("cannot describe the scene: {0}")]
    Info(String),
    /// There is no window to show anything in.
    #[error("cannot open a window: {0}; goblet render needs none")]
    Window(String),
    /// There is no image that could be written to a file.
    #[error("{0}")]
    Unwritten(String),
    /// No path of a kind has brought any light; the image is written.
    #[error("every {0} was dropped for values that are not finite: the image is not right")]
    NotFinite(&'static str),
    /// The validation layer had something to say.
    #[error("{} validation message(s), the first: {}", .0.len(), .0[0])]
    Validation(Vec<String>),
}

/// Why two images could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// An image could not be read, or the difference not written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The images have different sizes.
    #[error(transparent)]
    Size(#[from] SizeMismatch),
    /// The images are of different places.
    #[error(transparent)]
    Apart(#[from] Apart),
}

/// Why the bodies of a scene could not be replaced.
#[derive(Debug, thiserror::Error)]
pub enum TessellateError {
    /// A path that the new scene must name is not Unicode.
    #[error("{}: expected a path in Unicode, which a scene can name", .0.display())]
    Name(PathBuf),
    /// A mesh would be too large.
    #[error("{location}: {reason}")]
    TooFine {
        /// `file:line:column` of the shape.
        location: String,
        /// How large, and what would fit.
        reason: TooFine,
    },
    /// A body emits a given power.
    #[error(
        "{location}: this body's light has a \"float power\", which every triangle of a mesh would emit; \
         expected its radiance by \"L\" and \"scale\""
    )]
    Power {
        /// `file:line:column` of the shape.
        location: String,
    },
    /// A file could not be created or written.
    #[error("{}: cannot write: {reason}", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        reason: io::Error,
    },
}

/// The other name of a file, if it has one.
fn as_named(path: &Path, other: &Path) -> String {
    if path == other { String::new() } else { format!(" (as {})", other.display()) }
}

impl Failure {
    /// 2 for what the user can mend in the command or the scene, else 1.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Tessellate(TessellateError::Write { .. }) => 1,
            #[cfg(feature = "study")]
            Self::Knob(_) => 2,
            Self::Scene(_)
            | Self::Unrenderable(_)
            | Self::Compare(_)
            | Self::Tessellate(_)
            | Self::SameFile { .. }
            | Self::NoCommand { .. }
            | Self::Render(RenderError::Scene(_) | RenderError::Option(_))
            | Self::Device(goblet_host::Error::NoSuchDevice { .. }) => 2,
            Self::Checkpoint { reason: CheckpointError::Write(_) | CheckpointError::Device(_), .. } => 1,
            Self::Checkpoint { .. } => 2,
            Self::Render(
                RenderError::Device(_)
                | RenderError::Memory { .. }
                | RenderError::Interrupted { .. }
                | RenderError::GivenUp
                | RenderError::Host(_),
            )
            | Self::Device(_)
            | Self::Output(_)
            | Self::Signals(_)
            | Self::Window(_)
            | Self::Unwritten(_)
            | Self::Stats { .. }
            | Self::Print(_)
            | Self::Info(_)
            | Self::Report { .. }
            | Self::NotFinite(_)
            | Self::Validation(_) => 1,
        }
    }
}
