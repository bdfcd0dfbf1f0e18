//! Reads pbrt-v4 scene files.
//!
//! [`Scene::load`] turns a file into a complete [`Scene`]: every file that it names is read, every name is
//! looked up, every number is checked. A feature that goblet cannot render is an error that says so; a
//! parameter that cannot change the image is ignored.
//!
//! One parameter is an extension of the format: `"rgb transmittance"` of `Material "dielectric"` is the
//! fraction of the light that passes at each crossing of the surface (default `[1 1 1]`), so that glass can
//! be tinted.

use std::path::Path;

mod directives;
mod format;
mod measured;
pub mod mesh;
mod model;
mod parser;
mod rewrite;
mod spectrum;
mod survey;
#[cfg(test)]
mod tests;

pub(crate) use directives::camera::default_window;
pub(crate) use directives::light_image::window_cosine;
pub use format::error::{Location, SceneError};
pub(crate) use format::files::directory;
pub use format::kind::Kind;
pub(crate) use format::lexer::shorten;
pub use format::registry::{Family, ParamSpec, Support, TypeSpec};
pub(crate) use model::extent::{PACKED_LIGHT, PACKED_TRIANGLE};
pub use model::texture::*;
pub use model::*;
pub(crate) use parser::load_with_text;
pub(crate) use rewrite::Rewrite;
pub(crate) use spectrum::wavelength::{Band, Wavelengths};
pub use survey::Survey;

use crate::base::input::Budget;

/// The part of the pbrt-v4 format that goblet knows: directives that have types, their types, and the
/// parameters of each type.
pub const FAMILIES: [&Family; 12] = [
    &directives::film::FILM_FAMILY,
    &directives::film::FILTER_FAMILY,
    &directives::film::SAMPLER_FAMILY,
    &directives::film::INTEGRATOR_FAMILY,
    &directives::camera::FAMILY,
    &directives::material::FAMILY,
    &directives::medium::FAMILY,
    &directives::light::FAMILY,
    &directives::light::AREA_FAMILY,
    &directives::shape::FAMILY,
    &directives::texture::FLOAT_FAMILY,
    &directives::texture::SPECTRUM_FAMILY,
];

impl Scene {
    /// Reads the scene file at `path`, and the files that it names, within the default budget of memory.
    pub fn load(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
        Self::load_within(path, Budget::default())
    }

    /// Reads the scene file at `path`, and the files that it names, within a budget of memory.
    pub fn load_within(path: impl AsRef<Path>, budget: Budget) -> Result<Scene, SceneError> {
        parser::load(path.as_ref(), budget)
    }

    /// Reads the scene file at `path` within a budget of memory, and collects every error and every
    /// unsupported feature.
    pub fn survey(path: impl AsRef<Path>, budget: Budget) -> Survey {
        parser::survey(path.as_ref(), budget)
    }

    /// Reads a scene from `text`. Messages call the text `file_name`; file names in the text are relative
    /// to `base_dir`.
    pub fn parse(text: &str, file_name: &str, base_dir: impl AsRef<Path>) -> Result<Scene, SceneError> {
        parser::parse(text, file_name, base_dir.as_ref())
    }
}
