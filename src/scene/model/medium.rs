//! Participating media, which light crosses between surfaces.

use crate::scene::model::{ByWavelength, Rgb};

/// A homogeneous medium that absorbs light, and neither scatters nor emits it.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Absorption coefficient in 1/scene unit; finite, 0 or more, and not all 0. After a distance d the share
    /// exp(-absorption · d) of the light is left.
    pub absorption: Rgb,
    /// The coefficient by wavelength, 1/scene unit; `None` if it is known per channel only.
    pub by_wavelength: Option<ByWavelength>,
}

/// The media on both sides of a surface: indices into [`crate::scene::Scene::media`], or `None` for a vacuum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MediumInterface {
    /// Medium behind the surface.
    pub inside: Option<usize>,
    /// Medium in front of the surface, where its normal points.
    pub outside: Option<usize>,
}

impl MediumInterface {
    /// Returns true if the surface separates two media, or a medium and the vacuum.
    pub fn is_transition(&self) -> bool {
        self.inside != self.outside
    }
}
