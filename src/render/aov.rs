//! Arbitrary output variables: the quantities of each pixel that can be shown besides its radiance.
//!
//! [`AOVS`] is the only list of them. The layers of `goblet render --aov` and `goblet merge --aov`, their
//! help, and the views of the window follow from it.

use crate::image::estimate::Estimate;
use crate::image::file::Channel;
use crate::render::error::RenderError;
use crate::render::renderer::Renderer;

/// A quantity that each pixel has.
#[derive(Clone, Copy, Debug)]
pub struct Aov {
    /// Its name on the command line: words with hyphens.
    pub name: &'static str,
    /// Names of its channels in an EXR, `layer.X`: one for a number, three for a direction.
    pub channels: &'static [&'static str],
    /// Unit of its values; empty for a direction.
    pub unit: &'static str,
    /// A description of the quantity in one line.
    pub meaning: &'static str,
    /// The value of pixels for which the quantity is unknown, and the condition for this.
    pub unknown: &'static str,
    values: Values,
}

/// The source of the values. Each function returns a plane for each channel, with a value for each pixel,
/// row by row.
#[derive(Clone, Copy, Debug)]
enum Values {
    /// The sums, which a checkpoint has too.
    Estimate(fn(&Estimate) -> Vec<Vec<f32>>),
    /// The last iteration, whose results only the renderer has.
    Renderer(fn(&Renderer) -> Result<Vec<Vec<f32>>, RenderError>),
}

const NO_POINT: &str = "0 without a visible point";

/// All quantities, in the order in which the window lists them.
pub static AOVS: [Aov; 5] = [
    Aov {
        name: "radius",
        channels: &["radius.Y"],
        unit: "scene units",
        meaning: "Radius of the disc on which the last iteration gathered photons",
        unknown: NO_POINT,
        values: Values::Renderer(|renderer| Ok(vec![renderer.radii()?])),
    },
    Aov {
        name: "photon-density",
        channels: &["density.Y"],
        unit: "photons per square scene unit",
        meaning: "Photons that the pixel has kept over the area of its disc",
        unknown: NO_POINT,
        values: Values::Renderer(|renderer| Ok(vec![renderer.photon_densities()?])),
    },
    Aov {
        name: "standard-error",
        channels: &["standardError.Y"],
        unit: "W/(m² sr)",
        meaning: "Standard error of the pixel's luminance",
        unknown: "infinite before both halves of the rounds have begun",
        values: Values::Estimate(|estimate| vec![estimate.standard_error_or_infinite()]),
    },
    Aov {
        name: "normal",
        channels: &["normal.X", "normal.Y", "normal.Z"],
        unit: "",
        meaning: "Normal in world space at the visible point of the last iteration, on the side of its eye path",
        unknown: NO_POINT,
        values: Values::Renderer(|renderer| {
            let normals = renderer.normals()?;
            Ok([0, 1, 2].map(|axis| normals.iter().map(|normal| normal[axis]).collect()).into())
        }),
    },
    Aov {
        name: "depth",
        channels: &["depth.Z"],
        unit: "scene units",
        meaning: "Length of the eye path to the visible point of the last iteration",
        unknown: NO_POINT,
        values: Values::Renderer(|renderer| Ok(vec![renderer.path_lengths()?])),
    },
];

impl PartialEq for Aov {
    /// Names are unique.
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Aov {}

impl Aov {
    /// Returns the quantity with this name on the command line; `None` if there is none.
    pub fn named(name: &str) -> Option<&'static Self> {
        AOVS.iter().find(|aov| aov.name == name)
    }

    /// Returns the name of the quantity in words.
    pub fn title(&self) -> String {
        self.name.replace('-', " ")
    }

    /// Returns a line of help: the meaning, the unit, the value of unknown pixels, and the channels.
    pub fn help(&self) -> String {
        let Self { channels, unit, meaning, unknown, .. } = self;
        let unit = if unit.is_empty() { String::new() } else { format!(", in {unit}") };
        format!("{meaning}{unit}; {unknown}: {}", channels.join(", "))
    }

    /// Returns whether the quantity follows from an [`Estimate`], and so from a checkpoint.
    pub fn is_of_estimate(&self) -> bool {
        matches!(self.values, Values::Estimate(_))
    }

    /// Returns a plane of values for each channel, row by row, the top row first. `estimate` is the estimate
    /// of `renderer`. `None` if the quantity does not follow from an estimate and there is no renderer.
    ///
    /// # Errors
    /// The device fails.
    pub fn planes(
        &self,
        estimate: &Estimate,
        renderer: Option<&Renderer>,
    ) -> Result<Option<Vec<Vec<f32>>>, RenderError> {
        match (self.values, renderer) {
            (Values::Estimate(planes), _) => Ok(Some(planes(estimate))),
            (Values::Renderer(planes), Some(renderer)) => planes(renderer).map(Some),
            (Values::Renderer(_), None) => Ok(None),
        }
    }
}

/// Returns the channels of some quantities for an EXR. `estimate` is the estimate of `renderer`. Without a
/// renderer, quantities that do not follow from an estimate are left out.
///
/// # Errors
/// The device fails.
pub fn channels(
    aovs: &[&'static Aov],
    estimate: &Estimate,
    renderer: Option<&Renderer>,
) -> Result<Vec<Channel>, RenderError> {
    let mut channels = Vec::new();
    for aov in aovs {
        for (name, values) in aov.channels.iter().zip(aov.planes(estimate, renderer)?.into_iter().flatten()) {
            channels.push(Channel { name: (*name).to_owned(), values });
        }
    }
    Ok(channels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::film::Window;

    #[test]
    fn names_and_channels_are_unique_and_follow_the_conventions_of_exr() {
        let mut names: Vec<&str> = AOVS.iter().map(|aov| aov.name).collect();
        let mut channels: Vec<&str> = AOVS.iter().flat_map(|aov| aov.channels).copied().collect();
        for name in &channels {
            let (layer, channel) = name.split_once('.').expect("a layer");
            assert!(!layer.is_empty() && ["X", "Y", "Z"].contains(&channel), "{name}");
        }
        for aov in &AOVS {
            assert!([1, 3].contains(&aov.channels.len()), "{aov:?}");
            assert_eq!(Aov::named(aov.name), Some(aov));
        }
        for list in [&mut names, &mut channels] {
            let count = list.len();
            list.sort_unstable();
            list.dedup();
            assert_eq!(list.len(), count, "{list:?}");
        }
        assert_eq!(Aov::named("image"), None);
    }

    #[test]
    fn an_estimate_has_a_plane_for_each_channel_and_an_unknown_error_is_infinite() {
        let zeros = || vec![[0; 4]; 6];
        let estimate = Estimate {
            resolution: [3, 2],
            window: Window::whole([3, 2]),
            unit: 1.0,
            white_balance: None,
            halves: [1, 0],
            radiance: [zeros(), zeros(), zeros()],
            second_half: zeros(),
        };
        for aov in &AOVS {
            let planes = aov.planes(&estimate, None).unwrap();
            assert_eq!(planes.is_some(), aov.is_of_estimate(), "{aov:?}");
            if let Some(planes) = planes {
                assert_eq!(planes.len(), aov.channels.len(), "{aov:?}");
                assert!(planes.iter().all(|plane| plane.len() == 6), "{aov:?}");
            }
        }
        let all: Vec<&Aov> = AOVS.iter().collect();
        let channels = channels(&all, &estimate, None).unwrap();
        let expected = Channel { name: "standardError.Y".to_owned(), values: vec![f32::INFINITY; 6] };
        assert_eq!(channels, [expected]);
    }
}
