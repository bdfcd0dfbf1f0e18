//! What the window can show of a render.

use crate::image::estimate::Estimate;
use crate::render::error::RenderError;
use crate::render::options::Contribution;
use crate::render::renderer::Renderer;

/// Something that each pixel has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quantity {
    /// The image.
    #[default]
    Image,
    /// What eye paths bring of it.
    Direct,
    /// What photons bring of it.
    Photons,
    /// Radius of its disc.
    Radius,
    /// Photons per area.
    Density,
    /// Standard error of its luminance.
    StandardError,
    /// Normal of its visible point.
    Normal,
    /// Length of its eye path.
    Depth,
}

/// Numbers to be shown, and how.
pub struct Picture {
    /// Width and height.
    pub size: [u32; 2],
    /// Row by row; the fourth is unused.
    pub pixels: Vec<[f32; 4]>,
    /// Of what is no light: the value that is shown as white, and nothing where it is a direction.
    pub white: Option<f32>,
    /// Whether it is light, and tone curves apply.
    pub is_light: bool,
}

/// Values above those of so many pixels are shown as white.
const BRIGHT: f64 = 0.99;

impl Quantity {
    /// All, as they are listed.
    pub const ALL: [Self; 8] = [
        Self::Image,
        Self::Direct,
        Self::Photons,
        Self::Radius,
        Self::Density,
        Self::StandardError,
        Self::Normal,
        Self::Depth,
    ];

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Image => "image",
            Self::Direct => "direct light",
            Self::Photons => "light of photons",
            Self::Radius => "radius",
            Self::Density => "photon density",
            Self::StandardError => "standard error",
            Self::Normal => "normal",
            Self::Depth => "depth",
        }
    }

    /// What has to be rendered for it.
    pub fn contribution(self) -> Contribution {
        match self {
            Self::Direct => Contribution::Direct,
            Self::Photons => Contribution::Photons,
            _ => Contribution::All,
        }
    }

    /// What it is now.
    ///
    /// # Errors
    /// The device fails.
    pub fn picture(self, renderer: &Renderer, estimate: &Estimate) -> Result<Picture, RenderError> {
        let size = estimate.resolution;
        let values = match self {
            Self::Image | Self::Direct | Self::Photons => {
                let pixels = estimate.image().pixels.into_iter().map(|[r, g, b]| [r, g, b, 0.0]).collect();
                return Ok(Picture { size, pixels, white: None, is_light: true });
            }
            Self::Normal => {
                let shown = |normal: [f32; 3]| {
                    let [x, y, z] = if normal == [0.0; 3] { normal } else { normal.map(|axis| 0.5 + 0.5 * axis) };
                    [x, y, z, 0.0]
                };
                let pixels = renderer.normals()?.into_iter().map(shown).collect();
                return Ok(Picture { size, pixels, white: None, is_light: false });
            }
            Self::Radius => renderer.radii()?,
            Self::Density => renderer.photon_densities()?,
            Self::StandardError => match estimate.standard_error() {
                Some(errors) => errors,
                // Not known yet: as in an EXR, no error is too large for it.
                None => {
                    let pixels = vec![[1.0, 1.0, 1.0, 0.0]; estimate.second_half.len()];
                    return Ok(Picture { size, pixels, white: Some(f32::INFINITY), is_light: false });
                }
            },
            Self::Depth => renderer.path_lengths()?,
        };
        let white = bright(values.clone());
        let pixels = values.into_iter().map(|value| [value / white, value / white, value / white, 0.0]).collect();
        Ok(Picture { size, pixels, white: Some(white), is_light: false })
    }
}

/// A value that few are above.
fn bright(mut values: Vec<f32>) -> f32 {
    let place = ((values.len() - 1) as f64 * BRIGHT) as usize;
    let (_, value, _) = values.select_nth_unstable_by(place, f32::total_cmp);
    if *value > 0.0 && value.is_finite() { *value } else { 1.0 }
}
