//! Reads pbrt-v4 scene files.
//!
//! [`Scene::load`] turns a file into a [`Scene`] that needs nothing more: every
//! file it names is read, every name is looked up, every number is checked. What
//! goblet cannot render is an error that says so; what cannot change the image is
//! passed over.
//!
//! One parameter is goblet's own: `"rgb transmittance"` of
//! `Material "dielectric"` says what part of the light each crossing of the
//! surface lets through (default `[1 1 1]`), so that glass can be tinted.

use std::path::Path;

mod camera;
mod color;
mod error;
mod extent;
mod files;
mod film;
#[cfg(test)]
mod format_tests;
mod lexer;
mod light;
mod light_image;
mod material;
#[cfg(test)]
mod material_tests;
mod missing_light;
mod model;
mod object;
mod option;
mod params;
mod parser;
mod plane;
mod ply;
#[cfg(test)]
mod reading_tests;
mod registry;
mod rewrite;
mod shape;
mod spectrum;
mod spectrum_data;
mod state;
#[cfg(test)]
mod tests;
mod texture;
mod texture_model;
#[cfg(test)]
mod texture_tests;
mod transform;
mod version3;

pub(crate) use camera::default_window;
pub use error::{Location, SceneError};
pub(crate) use extent::{PACKED_LIGHT, PACKED_TRIANGLE};
pub(crate) use files::directory;
pub(crate) use lexer::shorten;
pub(crate) use light_image::window_cosine;
pub use model::*;
pub use parser::Survey;
pub(crate) use parser::load_with_text;
pub use registry::{Family, Kind, ParamSpec, Support, TypeSpec};
pub(crate) use rewrite::Rewrite;
pub use texture_model::*;

use crate::input::Budget;

/// What goblet knows of the pbrt-v4 format: directives that have types, their
/// types, and the parameters of each.
pub const FAMILIES: [&Family; 11] = [
    &film::FILM_FAMILY,
    &film::FILTER_FAMILY,
    &film::SAMPLER_FAMILY,
    &film::INTEGRATOR_FAMILY,
    &camera::FAMILY,
    &material::FAMILY,
    &light::FAMILY,
    &light::AREA_FAMILY,
    &shape::FAMILY,
    &texture::FLOAT_FAMILY,
    &texture::SPECTRUM_FAMILY,
];

impl Scene {
    /// Reads the scene file at `path`, and the files that it names, within the default budget of
    /// memory.
    pub fn load(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
        Self::load_within(path, Budget::default())
    }

    /// Reads the scene file at `path`, and the files that it names, within a budget of memory.
    pub fn load_within(path: impl AsRef<Path>, budget: Budget) -> Result<Scene, SceneError> {
        parser::load(path.as_ref(), budget)
    }

    /// Reads the scene file at `path` within a budget of memory, and finds all of it that is not
    /// supported.
    pub fn survey(path: impl AsRef<Path>, budget: Budget) -> Survey {
        parser::survey(path.as_ref(), budget)
    }

    /// Reads a scene from `text`. Messages call it `file_name`; files that it
    /// names are looked for in `base_dir`.
    pub fn parse(text: &str, file_name: &str, base_dir: impl AsRef<Path>) -> Result<Scene, SceneError> {
        parser::parse(text, file_name, base_dir.as_ref())
    }
}
