//! The failures of commands, and their exit codes.

use std::io;
use std::path::{Path, PathBuf};

use crate::image::compare::SizeMismatch;
use crate::image::file::ImageError;
use crate::image::film::Apart;
use crate::render::aov::NoSums;
use crate::render::checkpoint::CheckpointError;
use crate::render::error::RenderError;
use crate::scene::SceneError;
use crate::scene::mesh::tessellate::TooFine;
#[cfg(feature = "study")]
use crate::study::measure::KnobError;

/// The failure of a command. `main` prints it once.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The scene file is invalid, or needs a feature that goblet lacks.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene file has several faults, which are already printed.
    #[error("{0} cannot be rendered as it is")]
    Unrenderable(String),
    /// The render could not start or continue.
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
    /// Some settings cannot be measured.
    #[cfg(feature = "study")]
    #[error(transparent)]
    Knob(#[from] KnobError),
    /// A report could not be written.
    #[error("{path}: cannot write the report: {reason}")]
    Report {
        /// The file or folder.
        path: String,
        /// The reason.
        reason: String,
    },
    /// Bodies of revolution could not be replaced by meshes.
    #[error(transparent)]
    Tessellate(#[from] TessellateError),
    /// A checkpoint could not be read, written or used.
    #[error("{path}: {reason}")]
    Checkpoint {
        /// The file.
        path: String,
        /// The reason.
        reason: CheckpointError,
    },
    /// Two of the files to merge have the same shard.
    #[error("{}: shard {shard} is in {} as well; expected each shard once", .path.display(), .other.display())]
    ShardTwice {
        /// The file.
        path: PathBuf,
        /// The file before it that has the shard too.
        other: PathBuf,
        /// The shard, as in `--shard`.
        shard: String,
    },
    /// A layer that was asked for does not follow from the sums of a checkpoint.
    #[error(transparent)]
    Layer(#[from] NoSums),
    /// The operating system does not let the process listen for signals.
    #[error("cannot listen for signals: {0}")]
    Signals(std::io::Error),
    /// The statistics could not be written.
    #[error("{path}: cannot write the statistics: {reason}")]
    Stats {
        /// The file.
        path: String,
        /// The error of the operating system.
        reason: std::io::Error,
    },
    /// Standard output cannot be written to.
    #[error("cannot write to standard output: {0}")]
    Print(std::io::Error),
    /// Writing a file would replace another file of the command.
    #[error("{}: {fact}{}; expected another name for {what}", .path.display(), as_named(.path, .other))]
    SameFile {
        /// The file.
        path: PathBuf,
        /// The other use of the file, as in "the scene reads this file".
        fact: String,
        /// The name of the file in the other use.
        other: PathBuf,
        /// The output that was to be written, as in "the image".
        what: &'static str,
    },
    /// No command has this name.
    #[error("no command is called \"{name}\"; expected one of: {known}")]
    NoCommand {
        /// The wrong name.
        name: String,
        /// The names of all commands.
        known: String,
    },
    /// The description of a scene could not be written.
    #[error("cannot describe the scene: {0}")]
    Info(String),
    /// A window could not be opened.
    #[error("cannot open a window: {0}; goblet render needs none")]
    Window(String),
    /// A file was not written, because there is no image.
    #[error("{0}")]
    Unwritten(String),
    /// All photon paths or all eye paths were dropped. The image is written nevertheless.
    #[error("every {0} was dropped because it had values that are not finite: the image is wrong")]
    NotFinite(&'static str),
    /// The validation layers have messages.
    #[error("{} validation message(s), the first: {}", .0.len(), .0[0])]
    Validation(Vec<String>),
}

/// The reason why two images could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// An image could not be read, or the difference could not be written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The images have different sizes.
    #[error(
        "{0}; `goblet render --resolution {width}x{height}` renders in that of the reference",
        width = .0.reference[0], height = .0.reference[1]
    )]
    Size(#[from] SizeMismatch),
    /// The scene's images do not have the size of the reference.
    #[error(
        "{0}; `--vary resolution={width}x{height}` renders in that of the reference",
        width = .0.reference[0], height = .0.reference[1]
    )]
    FilmSize(SizeMismatch),
    /// The images are parts of a larger image that have no pixel in common.
    #[error(transparent)]
    Apart(#[from] Apart),
    /// An EXR was asked to have what only a picture has.
    #[error("{0}: expected a --diff that ends in .png; an .exr has the values of the map alone")]
    NoPicture(&'static str),
    /// This goblet cannot measure FLIP.
    #[error("--diff-kind flip: this goblet was built without the feature `study`, which measures FLIP")]
    NoFlip,
}

/// The reason why the bodies of a scene could not be replaced by meshes.
#[derive(Debug, thiserror::Error)]
pub enum TessellateError {
    /// The new scene must contain a path that is not Unicode.
    #[error("{}: expected a path in Unicode, which a scene can name", .0.display())]
    Name(PathBuf),
    /// A mesh would be too large.
    #[error("{location}: {reason}")]
    TooFine {
        /// `file:line:column` of the shape.
        location: String,
        /// The size of the mesh, and the tolerance that would fit.
        reason: TooFine,
    },
    /// A body emits light with a given power.
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
        /// The error of the operating system.
        reason: io::Error,
    },
}

/// Returns the other name of a file for a message; empty if both names are equal.
fn as_named(path: &Path, other: &Path) -> String {
    if path == other { String::new() } else { format!(" (as {})", other.display()) }
}

/// Returns the reason in a message of a library that may begin with a place in its own source, as winit's do: `os error at
/// PATH:LINE: reason`. The place tells users nothing.
fn reason_of(message: &str) -> &str {
    let place = message.strip_prefix("os error at ").and_then(|rest| rest.split_once(": "));
    place.map_or(message, |(_, reason)| reason).trim_end_matches('.')
}

impl Failure {
    /// Returns the failure of a window for an error of the library that opens it.
    pub fn window(error: impl std::fmt::Display) -> Self {
        Self::Window(reason_of(&error.to_string()).to_owned())
    }

    /// Returns the exit code: 2 if the user can correct the command or its inputs, else 1.
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
            | Self::ShardTwice { .. }
            | Self::NoCommand { .. }
            | Self::Layer(_)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_message_has_a_place_in_the_source_of_a_library() {
        for (message, expected) in [
            (
                "os error at /home/x/.cargo/registry/src/winit-0.30/src/linux/mod.rs:765: no DISPLAY is set.",
                "no DISPLAY is set",
            ),
            ("os error at C:\\x\\mod.rs:7: denied: really", "denied: really"),
            ("nothing of the kind: here", "nothing of the kind: here"),
        ] {
            let failure = Failure::window(message);
            assert_eq!(failure.to_string(), format!("cannot open a window: {expected}; goblet render needs none"));
        }
    }
}
