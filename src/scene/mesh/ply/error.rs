//! Why a PLY file is refused.

use std::io;

/// The reason why a mesh could not be read.
#[derive(Debug)]
pub(in crate::scene) enum PlyError {
    /// The file could not be opened or read.
    Unreadable(io::Error),
    /// The file is not a mesh that can be rendered. The message contains the place in the file and the
    /// reason.
    Invalid(String),
}
