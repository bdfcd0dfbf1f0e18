//! `Texture`, and parameters that may name one.

use super::error::SceneError;
use super::model::{Input, Rgb};
use super::params::Param;
use super::spectrum::Spectrum;

/// The named textures so far.
#[derive(Debug, Default)]
pub(super) struct Textures;

impl Textures {
    /// A colour with channels from 0 to 1, or the texture that the parameter names.
    pub fn color(&self, param: &Param) -> Result<Input<Rgb>, SceneError> {
        let rgb = Spectrum::from_param(param)?.reflectance();
        if rgb.min_element() < 0.0 || rgb.max_element() > 1.0 {
            return Err(param.bad_value("channels from 0 to 1"));
        }
        Ok(Input::Constant(rgb))
    }

    /// A number, or the texture that the parameter names.
    pub fn number(&self, param: &Param) -> Result<Input<f64>, SceneError> {
        let [value] = param.one()?;
        Ok(Input::Constant(value))
    }
}
