//! Arbitrary output variables: the quantities of a pixel, besides its radiance, that can be written or shown.
//!
//! [`AOVS`] is the only list of these quantities. The layers and the help of `--aov`, the layers of a `gbuffer`
//! film, and the views of the window follow from the list.

use crate::image::estimate::Estimate;
use crate::image::file::Channel;
use crate::image::layers::{Group, Groups};
use crate::image::planes::Planes;

/// A quantity that each pixel has: a layer of an EXR.
#[derive(Clone, Copy, Debug)]
pub struct Aov {
    /// Its name on the command line, in which upper and lower case are alike.
    pub name: &'static str,
    /// Another name on the command line; empty if there is none.
    pub alias: &'static str,
    /// Names of its channels in an EXR: those of pbrt-v4's `gbuffer` film, where that has the quantity.
    pub channels: &'static [&'static str],
    /// Unit of its values; empty for a number without a unit.
    pub unit: &'static str,
    /// A description of the quantity in one line.
    pub meaning: &'static str,
    /// The value of pixels for which the quantity is unknown, and the condition for this.
    pub unknown: &'static str,
    /// Kind of its values.
    pub kind: AovKind,
    /// Whether a `gbuffer` film of pbrt-v4 has it.
    pub is_of_gbuffer: bool,
    /// The groups of sums from which it is computed, besides the sums of the image.
    pub groups: Groups,
    planes: fn(&Estimate) -> Option<Planes>,
}

/// What the values of a quantity are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AovKind {
    /// A number of any size.
    Number,
    /// A share from 0 to 1.
    Share,
    /// A number of 0 or more, which may differ by orders of magnitude between pixels.
    Amount,
    /// A unit vector.
    Direction,
    /// A point in space.
    Point,
    /// A color from 0 to 1.
    Color,
    /// Linear RGB of any brightness.
    Light,
}

impl AovKind {
    /// Returns whether a value is a single number.
    pub fn is_number(self) -> bool {
        matches!(self, Self::Number | Self::Share | Self::Amount)
    }
}

const NOTHING: &str = "0 where no surface is visible";
const NO_POINT: &str = "iterations without a visible point count as 0";
const RADIANCE: &str = "W/(m² sr)";
const NO_IMAGE: &str = "0 before the first iteration";

/// An entry of the list; the other fields have the values of most quantities.
const BLANK: Aov = Aov {
    name: "",
    alias: "",
    channels: &[],
    unit: "",
    meaning: "",
    unknown: NOTHING,
    kind: AovKind::Number,
    is_of_gbuffer: true,
    groups: Groups::of(&[]),
    planes: |_| None,
};

/// All quantities, in the order in which the window lists them.
pub static AOVS: [Aov; 19] = [
    Aov {
        name: "radius",
        channels: &["radius.Y"],
        unit: "scene units",
        meaning: "Gather radius, as the mean over the iterations",
        unknown: NO_POINT,
        is_of_gbuffer: false,
        groups: Groups::of(&[Group::Square]),
        planes: Estimate::radius,
        ..BLANK
    },
    Aov {
        name: "density",
        alias: "photon-density",
        channels: &["density.Y"],
        unit: "photons per square scene unit",
        meaning: "Photons of one iteration on the gather disc, divided by its area, as the mean over the iterations",
        unknown: NO_POINT,
        kind: AovKind::Amount,
        is_of_gbuffer: false,
        groups: Groups::of(&[Group::Light]),
        planes: Estimate::density,
    },
    Aov {
        name: "standard-error",
        channels: &["standardError.Y"],
        unit: RADIANCE,
        meaning: "Standard error of the pixel's luminance",
        unknown: "infinite until the error can be estimated, after two rounds or more",
        is_of_gbuffer: false,
        planes: |estimate| Some(vec![estimate.standard_error_or_infinite()]),
        ..BLANK
    },
    Aov {
        name: "N",
        alias: "normal",
        channels: &["N.X", "N.Y", "N.Z"],
        meaning: "Geometric normal of the first surface, on the camera's side",
        kind: AovKind::Direction,
        groups: Groups::of(&[Group::Normal]),
        planes: Estimate::normal,
        ..BLANK
    },
    Aov {
        name: "Z",
        alias: "depth",
        channels: &["Z"],
        unit: "camera units",
        meaning: "Depth of the first surface: its z in camera space",
        is_of_gbuffer: false,
        groups: Groups::of(&[Group::Albedo, Group::Position]),
        planes: Estimate::depth,
        ..BLANK
    },
    Aov {
        name: "photon-share",
        channels: &["photonShare.Y"],
        meaning: "Share of the pixel's luminance that photons carry, from 0 to 1",
        unknown: "0 where the pixel is black",
        kind: AovKind::Share,
        is_of_gbuffer: false,
        groups: Groups::of(&[Group::Light]),
        planes: Estimate::photon_share,
        ..BLANK
    },
    Aov {
        name: "light-per-photon",
        channels: &["lightPerPhoton.Y"],
        unit: "W/(m² sr) per photon per square scene unit",
        meaning: "Luminance of the layer photons, divided by the layer density",
        unknown: "0 where no photon was gathered",
        kind: AovKind::Amount,
        is_of_gbuffer: false,
        groups: Groups::of(&[Group::Light]),
        planes: Estimate::light_per_photon,
        ..BLANK
    },
    Aov {
        name: "Albedo",
        channels: &["Albedo.R", "Albedo.G", "Albedo.B"],
        meaning: "Albedo of the first surface: share of the light that it reflects or transmits along the eye path",
        kind: AovKind::Color,
        groups: Groups::of(&[Group::Albedo]),
        planes: Estimate::albedo,
        ..BLANK
    },
    Aov {
        name: "Ns",
        channels: &["Ns.X", "Ns.Y", "Ns.Z"],
        meaning: "Shading normal of the first surface, on the camera's side",
        kind: AovKind::Direction,
        groups: Groups::of(&[Group::ShadingNormal]),
        planes: Estimate::shading_normal,
        ..BLANK
    },
    Aov {
        name: "P",
        channels: &["P.X", "P.Y", "P.Z"],
        unit: "camera units (scene units if the film is in world space)",
        meaning: "Point where the eye path meets the first surface",
        kind: AovKind::Point,
        groups: Groups::of(&[Group::Albedo, Group::Position]),
        planes: Estimate::position,
        ..BLANK
    },
    Aov {
        name: "u",
        channels: &["u"],
        meaning: "Texture coordinate u of the first surface",
        groups: Groups::of(&[Group::Albedo, Group::Slope]),
        planes: Estimate::u,
        ..BLANK
    },
    Aov {
        name: "v",
        channels: &["v"],
        meaning: "Texture coordinate v of the first surface",
        groups: Groups::of(&[Group::Albedo, Group::Slope]),
        planes: Estimate::v,
        ..BLANK
    },
    Aov {
        name: "dzdx",
        channels: &["dzdx"],
        unit: "units of P per pixel",
        meaning: "Absolute change of P.Z from a pixel to its neighbour in the row, on the tangent plane",
        groups: Groups::of(&[Group::Albedo, Group::Slope]),
        planes: |estimate| estimate.slope(0),
        ..BLANK
    },
    Aov {
        name: "dzdy",
        channels: &["dzdy"],
        unit: "units of P per pixel",
        meaning: "Absolute change of P.Z from a pixel to its neighbour in the column, on the tangent plane",
        groups: Groups::of(&[Group::Albedo, Group::Slope]),
        planes: |estimate| estimate.slope(1),
        ..BLANK
    },
    Aov {
        name: "Variance",
        channels: &["Variance.R", "Variance.G", "Variance.B"],
        unit: "(W/(m² sr))²",
        meaning: "Variance between the iterations of the pixel's value in one iteration",
        unknown: "0 before the second iteration",
        kind: AovKind::Light,
        groups: Groups::of(&[Group::Square]),
        planes: Estimate::variance,
        ..BLANK
    },
    Aov {
        name: "RelativeVariance",
        channels: &["RelativeVariance.R", "RelativeVariance.G", "RelativeVariance.B"],
        unit: RADIANCE,
        meaning: "Layer Variance divided by the pixel's value",
        unknown: "0 before the second iteration, and where the pixel is black",
        kind: AovKind::Light,
        groups: Groups::of(&[Group::Square]),
        planes: Estimate::relative_variance,
        ..BLANK
    },
    Aov {
        name: "direct",
        channels: &["direct.R", "direct.G", "direct.B"],
        unit: RADIANCE,
        meaning: "Visible light sources and direct light: the image without the light of photons",
        unknown: NO_IMAGE,
        kind: AovKind::Light,
        is_of_gbuffer: false,
        groups: Groups::of(&[Group::Light]),
        planes: Estimate::direct,
        ..BLANK
    },
    Aov {
        name: "photons",
        channels: &["photons.R", "photons.G", "photons.B"],
        unit: RADIANCE,
        meaning: "Light of photons: the image without the layer direct",
        unknown: NO_IMAGE,
        kind: AovKind::Light,
        is_of_gbuffer: false,
        groups: Groups::of(&[Group::Light]),
        planes: Estimate::photons,
        ..BLANK
    },
    Aov {
        name: "caustic",
        channels: &["caustic.R", "caustic.G", "caustic.B"],
        unit: RADIANCE,
        meaning: "Part of the layer photons that met only specular or glossy surfaces on the way from the light source",
        unknown: NO_IMAGE,
        kind: AovKind::Light,
        is_of_gbuffer: false,
        groups: Groups::of(&[Group::Caustic]),
        planes: Estimate::caustic,
        ..BLANK
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
        let is_named = |aov: &&Self| {
            aov.name.eq_ignore_ascii_case(name) || !aov.alias.is_empty() && aov.alias.eq_ignore_ascii_case(name)
        };
        AOVS.iter().find(is_named)
    }

    /// Returns the name of the quantity in words.
    pub fn title(&self) -> String {
        self.name.replace('-', " ")
    }

    /// Returns a line of help: the meaning, the unit, the value of unknown pixels, and the channels.
    pub fn help(&self) -> String {
        let Self { channels, unit, meaning, unknown, .. } = self;
        let unit = if unit.is_empty() { String::new() } else { format!(", in {unit}") };
        let plural = if channels.len() > 1 { "s" } else { "" };
        format!("{meaning}{unit}; {unknown}. Channel{plural} {}", channels.join(", "))
    }

    /// Returns a plane of values for each channel, row by row, the top row first. `None` if the estimate does not
    /// have the groups of sums.
    pub fn planes(&self, estimate: &Estimate) -> Option<Planes> {
        (self.planes)(estimate)
    }
}

/// Returns the groups of sums from which some quantities are computed.
pub fn groups(aovs: &[&'static Aov]) -> Groups {
    aovs.iter().fold(Groups::default(), |groups, aov| groups.with(aov.groups))
}

/// The sums from which a quantity is computed are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the layer {0} was not summed: expected a render with --aov {0}")]
pub struct NoSums(pub &'static str);

/// Returns the channels of an EXR for some quantities and for the quantities that the film asks for, each once.
///
/// # Errors
/// The estimate does not have the sums of one of `aovs`.
pub fn channels(aovs: &[&'static Aov], estimate: &Estimate) -> Result<Vec<Channel>, NoSums> {
    let of_film = estimate.layers.form.of_film;
    let mut channels = Vec::new();
    for aov in AOVS.iter().filter(|aov| aovs.contains(aov) || of_film && aov.is_of_gbuffer) {
        let planes = aov.planes(estimate).ok_or(NoSums(aov.name))?;
        channels.extend(aov.channels.iter().zip(planes).map(|(name, values)| Channel { name: (*name).into(), values }));
    }
    Ok(channels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::estimate::Sum;
    use crate::image::film::Window;
    use crate::image::layers::{LayerForm, Layers};

    #[test]
    fn names_and_channels_are_unique_and_follow_the_conventions_of_exr() {
        let names = AOVS.iter().flat_map(|aov| [aov.name, aov.alias]).filter(|name| !name.is_empty());
        let mut names: Vec<String> = names.map(str::to_lowercase).collect();
        let mut channels: Vec<String> = AOVS.iter().flat_map(|aov| aov.channels).map(ToString::to_string).collect();
        for aov in &AOVS {
            for (index, name) in aov.channels.iter().enumerate() {
                let expected = match (name.split_once('.'), aov.kind) {
                    (None, kind) if kind.is_number() => *name,
                    (Some((_, "Y")), kind) if kind.is_number() => name,
                    (Some((layer, _)), AovKind::Direction | AovKind::Point) => {
                        &format!("{layer}.{}", ["X", "Y", "Z"][index])
                    }
                    (Some((layer, _)), AovKind::Color | AovKind::Light) => {
                        &format!("{layer}.{}", ["R", "G", "B"][index])
                    }
                    other => panic!("{name}: {other:?}"),
                };
                assert_eq!(*name, expected);
            }
            assert_eq!(aov.channels.len(), if aov.kind.is_number() { 1 } else { 3 }, "{aov:?}");
            assert_eq!(Aov::named(&aov.name.to_uppercase()), Some(aov));
            assert!(aov.alias.is_empty() || Aov::named(aov.alias) == Some(aov), "{aov:?}");
        }
        for list in [&mut names, &mut channels] {
            let count = list.len();
            list.sort_unstable();
            list.dedup();
            assert_eq!(list.len(), count, "{list:?}");
        }
        assert_eq!((Aov::named("image"), Aov::named("")), (None, None));
    }

    fn estimate(groups: Groups, of_film: bool) -> Estimate {
        let zeros = || vec![[0; 4]; 6];
        let group = |_| [(); 4].map(|()| zeros());
        let sums: Vec<[Vec<Sum>; 4]> = groups.iter().map(group).collect();
        Estimate {
            resolution: [3, 2],
            window: Window::whole([3, 2]),
            unit: 1.0,
            white_balance: None,
            halves: [1, 0],
            radiance: [zeros(), zeros(), zeros()],
            second_half: zeros(),
            layers: Layers { form: LayerForm { groups, of_film, ..LayerForm::default() }, sums },
        }
    }

    #[test]
    fn an_estimate_has_a_plane_for_each_channel_if_it_has_the_groups() {
        for aov in &AOVS {
            let planes = aov.planes(&estimate(aov.groups, false)).expect("the groups");
            assert_eq!(planes.len(), aov.channels.len(), "{aov:?}");
            assert!(planes.iter().all(|plane| plane.len() == 6 && plane.iter().all(|v| !v.is_nan())), "{aov:?}");
            assert_eq!(aov.planes(&estimate(Groups::default(), false)).is_some(), aov.groups.is_empty(), "{aov:?}");
        }
        let error = Aov::named("standard-error").unwrap();
        let expected = Channel { name: "standardError.Y".to_owned(), values: vec![f32::INFINITY; 6] };
        assert_eq!(channels(&[error, error], &estimate(Groups::default(), false)), Ok(vec![expected]));
        let direct = Aov::named("direct").unwrap();
        assert_eq!(channels(&[direct], &estimate(Groups::OF_GBUFFER, true)), Err(NoSums("direct")));
    }

    /// The names, in the order of pbrt-v4's file.
    #[test]
    fn a_gbuffer_film_has_the_channels_of_pbrt() {
        let of_film: Vec<&Aov> = AOVS.iter().filter(|aov| aov.is_of_gbuffer).collect();
        assert_eq!(groups(&of_film), Groups::OF_GBUFFER);
        let mut names: Vec<String> =
            channels(&[], &estimate(Groups::OF_GBUFFER, true)).unwrap().into_iter().map(|it| it.name).collect();
        names.sort_unstable();
        let mut expected = vec!["dzdx", "dzdy", "u", "v"];
        expected.extend(["P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "Ns.X", "Ns.Y", "Ns.Z"]);
        expected.extend(["Albedo.R", "Albedo.G", "Albedo.B", "Variance.R", "Variance.G", "Variance.B"]);
        expected.extend(["RelativeVariance.R", "RelativeVariance.G", "RelativeVariance.B"]);
        expected.sort_unstable();
        assert_eq!(names, expected);
    }
}
