//! Images: estimates of radiance from sums over iterations, image files, comparison.

pub mod compare;
pub mod difference;
pub mod estimate;
pub mod exposure;
pub mod false_color;
pub mod file;
pub mod film;
pub mod layers;
pub mod planes;
pub mod smooth;
mod sum;
