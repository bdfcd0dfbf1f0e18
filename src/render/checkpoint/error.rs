//! Why a checkpoint fails.

use std::io;

/// The version of the format.
pub(super) const FORMAT: u32 = 2;

/// Why a checkpoint cannot be read, written or used.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file cannot be read.
    #[error("cannot read the checkpoint: {0}")]
    Read(io::Error),
    /// The file cannot be written.
    #[error("cannot write the checkpoint: {0}")]
    Write(io::Error),
    /// The file is something else, or not whole.
    #[error("not a whole checkpoint of goblet: {0}")]
    Format(String),
    /// The file was written in another format.
    #[error("a checkpoint of format {0}: expected format {FORMAT}; render anew, or use the goblet that wrote it")]
    Version(u32),
    /// The scene is not the one that was rendered.
    #[error("{part} of the scene differ from what the checkpoint was made with")]
    Scene {
        /// Which part.
        part: String,
    },
    /// An option is not as it was.
    #[error("{name}: the checkpoint was made with {there}, and this is {here}")]
    Option {
        /// Which one.
        name: String,
        /// Its value now.
        here: String,
        /// Its value in the checkpoint.
        there: String,
    },
    /// It has the iterations of other shards.
    #[error("the checkpoint is of shard {there}, and this is shard {here}")]
    Shard {
        /// The one that is asked for.
        here: String,
        /// Those that it has.
        there: String,
    },
    /// Two of the files to merge have the same iterations.
    #[error("shard {0} is there twice")]
    Twice(u32),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] goblet_host::Error),
}
