//! Errors of checkpoints.

use std::io;

use super::difference::Differences;

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
    #[error(
        "{} of the scene differ from what the checkpoint was made with; expected the scene file as it was, or another \
         checkpoint",
        parts_in_words(parts)
    )]
    Scene {
        /// The parts of the scene that differ, at least one.
        parts: Vec<String>,
    },
    /// Options have other values.
    #[error("{0}")]
    Options(Differences),
    /// The files to merge have other numbers of shards.
    #[error("it is one of {there} shards, and the files before it are of {here}; expected all shards of one render")]
    Shards {
        /// The number of shards in the files before.
        here: u32,
        /// The number of shards in the checkpoint.
        there: u32,
    },
    /// The files to merge begin with other radii.
    #[error("its radii are not those of the files before it; expected all shards of one render")]
    Radii,
    /// The checkpoint has iterations of other shards.
    #[error("the checkpoint is of {there}, and this render is {here}; expected {expected}")]
    Shard {
        /// The shard that is to be continued.
        here: String,
        /// The shards in the checkpoint.
        there: String,
        /// What would fit.
        expected: String,
    },
    /// Two of the files to merge have the same shard.
    #[error("shard {0} is there twice; expected each shard once")]
    Twice(u32),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] goblet_host::Error),
}

/// Returns the names of parts of a scene as words: `the materials and the camera`.
fn parts_in_words(parts: &[String]) -> String {
    let name = |part: &String| match part.as_str() {
        "the camera" => "the camera, its crop window or its pixel filter".to_owned(),
        other => other.to_owned(),
    };
    parts.iter().map(name).collect::<Vec<_>>().join(" and ")
}
