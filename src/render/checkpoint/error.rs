//! Errors of checkpoints.

use std::io;

/// The version of the file format.
pub(super) const FORMAT: u32 = 2;

/// The reason why a checkpoint cannot be read, written or used.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file cannot be read.
    #[error("cannot read the checkpoint: {0}")]
    Read(io::Error),
    /// The file cannot be written.
    #[error("cannot write the checkpoint: {0}")]
    Write(io::Error),
    /// The file is not a checkpoint, or not a whole one.
    #[error("not a whole checkpoint of goblet: {0}")]
    Format(String),
    /// The file has another version of the format.
    #[error("a checkpoint of format {0}: expected format {FORMAT}; render anew, or use the goblet that wrote it")]
    Version(u32),
    /// The scene differs from the scene that was rendered.
    #[error("{part} of the scene differ from what the checkpoint was made with")]
    Scene {
        /// The part of the scene that differs.
        part: String,
    },
    /// An option has another value.
    #[error("{name}: the checkpoint was made with {there}, and this is {here}")]
    Option {
        /// The name of the option.
        name: String,
        /// Its value now.
        here: String,
        /// Its value in the checkpoint.
        there: String,
    },
    /// The checkpoint has iterations of other shards.
    #[error("the checkpoint is of shard {there}, and this is shard {here}")]
    Shard {
        /// The shard that is to be continued.
        here: String,
        /// The shards in the checkpoint.
        there: String,
    },
    /// Two of the files to merge have the same shard.
    #[error("shard {0} is there twice")]
    Twice(u32),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] goblet_host::Error),
}
