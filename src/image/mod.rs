//! Images: estimates that become linear radiance, files, comparison.

pub mod compare;
pub mod estimate;
pub mod file;
pub mod film;
