//! The quantities of a render that the window can show: the image, two parts of its light, and every AOV.

use super::false_color;
use crate::image::estimate::Estimate;
use crate::image::layers::Groups;
use crate::render::aov::{AOVS, Aov, AovKind};
use crate::render::options::{Contribution, Options};

/// A quantity of each pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quantity {
    /// The image.
    #[default]
    Image,
    /// The light of eye paths.
    Direct,
    /// The light of photons.
    Photons,
    /// An AOV.
    Aov(&'static Aov),
}

/// An image for the screen.
pub struct Picture {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Row by row, the top row first; the fourth number is unused.
    pub pixels: Vec<[f32; 4]>,
    /// The values that are shown as black and white, or by the first and the last false colour, if the picture is of an
    /// AOV with one channel; the second is infinite if no value is known.
    pub ends: Option<[f32; 2]>,
    /// How it shows values.
    pub shade: Shade,
}

/// How a picture shows values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    /// Light, to which exposure and tone curves apply.
    Light,
    /// Numbers as grey, and others as red, green and blue, to which the exposure applies.
    Plain,
    /// Shares from 0 to 1 in [false colours](false_color::shares).
    Shares,
    /// Amounts in [false colours](false_color::amounts).
    Amounts,
}

impl Shade {
    /// Returns whether the exposure applies to the picture.
    pub fn has_exposure(self) -> bool {
        matches!(self, Self::Light | Self::Plain)
    }
}

/// The quantile of an AOV's values that is shown as white.
const BRIGHT: f64 = 0.99;

impl Quantity {
    /// All quantities, in the order of the window's list.
    pub const ALL: [Self; 3 + AOVS.len()] = {
        let mut all = [Self::Image; 3 + AOVS.len()];
        all[1] = Self::Direct;
        all[2] = Self::Photons;
        let mut index = 0;
        while index < AOVS.len() {
            all[3 + index] = Self::Aov(&AOVS[index]);
            index += 1;
        }
        all
    };

    /// Returns the name that the window shows.
    pub fn name(self) -> String {
        match self {
            Self::Image => "image".to_owned(),
            Self::Direct => "direct light".to_owned(),
            Self::Photons => "light of photons".to_owned(),
            Self::Aov(aov) => aov.title(),
        }
    }

    /// Returns the part of the light that has to be rendered.
    pub fn contribution(self) -> Contribution {
        match self {
            Self::Direct => Contribution::Direct,
            Self::Photons => Contribution::Photons,
            Self::Image | Self::Aov(_) => Contribution::All,
        }
    }

    /// Returns the layers that have to be summed.
    pub fn layers(self) -> Groups {
        match self {
            Self::Aov(aov) => aov.groups,
            Self::Image | Self::Direct | Self::Photons => Groups::default(),
        }
    }

    /// Returns whether a render with these options has the quantity.
    pub fn is_in(self, options: &Options) -> bool {
        options.contribution == self.contribution() && options.layers.has_all(self.layers())
    }

    /// Returns how a picture shows the quantity.
    pub fn shade(self) -> Shade {
        let Self::Aov(aov) = self else { return Shade::Light };
        match aov.kind {
            AovKind::Light => Shade::Light,
            AovKind::Share => Shade::Shares,
            AovKind::Amount => Shade::Amounts,
            AovKind::Number | AovKind::Direction | AovKind::Point | AovKind::Color => Shade::Plain,
        }
    }

    /// Returns what the quantity is in a line of help.
    pub fn help(self) -> String {
        match self {
            Self::Image => "All light".to_owned(),
            Self::Direct => "Emission that is seen, and direct light, rendered alone".to_owned(),
            Self::Photons => "All other light, rendered alone".to_owned(),
            Self::Aov(aov) => aov.help(),
        }
    }

    /// Returns the picture of the quantity after the iterations so far; black if the estimate does not have its
    /// layers.
    pub fn picture(self, estimate: &Estimate) -> Picture {
        let (size, shade) = (estimate.resolution, self.shade());
        let Self::Aov(aov) = self else {
            let pixels = estimate.image().pixels.into_iter().map(|[r, g, b]| [r, g, b, 0.0]).collect();
            return Picture { size, pixels, ends: None, shade };
        };
        let (pixels, ends) = match (aov.planes(estimate).as_deref(), aov.kind) {
            (Some([r, g, b]), AovKind::Color | AovKind::Light) => (colors([r, g, b]), None),
            (Some([x, y, z]), AovKind::Direction) => (directions([x, y, z]), None),
            (Some([x, y, z]), _) => {
                let far = bright([x, y, z].into_iter().flatten().map(|value| value.abs()).collect());
                let near = |values: &Vec<f32>| values.iter().map(|value| value / far).collect();
                (directions([&near(x), &near(y), &near(z)]), None)
            }
            (Some([values, ..]), AovKind::Share) => (false_color::shares(values), Some([0.0, 1.0])),
            (Some([values, ..]), AovKind::Amount) => {
                let ends = ends_of_amounts(values);
                (false_color::amounts(values, ends), Some(ends))
            }
            (Some([values, ..]), _) => {
                let white = bright(values.clone());
                (numbers(values, white), Some([0.0, white]))
            }
            (Some([]) | None, _) => (vec![[0.0; 4]; size.map(|side| side as usize).iter().product()], None),
        };
        Picture { size, pixels, ends, shade }
    }
}

/// Returns colours as they are.
fn colors([r, g, b]: [&Vec<f32>; 3]) -> Vec<[f32; 4]> {
    r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b, 0.0]).collect()
}

/// Returns directions as colours: coordinates from -1 to 1 become 0 to 1, and a zero vector is black.
fn directions([x, y, z]: [&Vec<f32>; 3]) -> Vec<[f32; 4]> {
    let shown = |direction: [f32; 3]| {
        let [x, y, z] = if direction == [0.0; 3] { direction } else { direction.map(|axis| 0.5 + 0.5 * axis) };
        [x, y, z, 0.0]
    };
    x.iter().zip(y).zip(z).map(|((x, y), z)| shown([*x, *y, *z])).collect()
}

/// Returns numbers divided by the value that is white; infinite numbers are white too.
fn numbers(values: &[f32], white: f32) -> Vec<[f32; 4]> {
    let shown = |value: f32| if value.is_finite() { value / white } else { 1.0 };
    values.iter().map(|value| [shown(*value), shown(*value), shown(*value), 0.0]).collect()
}

/// Returns the [`BRIGHT`] quantile of the values, which may be infinite; 1 if the quantile is 0 or if there
/// is no value.
fn bright(mut values: Vec<f32>) -> f32 {
    quantile(&mut values, BRIGHT).filter(|value| *value > 0.0).unwrap_or(1.0)
}

/// Returns the amounts that have the first and the last colour: quantiles of those above 0, a decade or more apart.
fn ends_of_amounts(values: &[f32]) -> [f32; 2] {
    let mut amounts: Vec<f32> = values.iter().copied().filter(|value| *value > 0.0).collect();
    let [least, most] = [1.0 - BRIGHT, BRIGHT].map(|part| quantile(&mut amounts, part).unwrap_or(1.0));
    [least.min(0.1 * most), most]
}

/// Returns a quantile of the values, which may be infinite; `None` if there is no value.
fn quantile(values: &mut [f32], part: f64) -> Option<f32> {
    let place = (values.len().checked_sub(1)? as f64 * part) as usize;
    Some(*values.select_nth_unstable_by(place, f32::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keys show them in this order.
    #[test]
    fn what_photons_do_is_in_false_colors() {
        let shades: Vec<_> = Quantity::ALL[..10].iter().map(|quantity| (quantity.name(), quantity.shade())).collect();
        for (name, shade) in
            [("density", Shade::Amounts), ("photon share", Shade::Shares), ("light per photon", Shade::Amounts)]
        {
            assert!(shades.contains(&(name.to_owned(), shade)), "{name}");
        }
        assert_eq!(shades.iter().filter(|(_, shade)| !shade.has_exposure()).count(), 3);
        assert_eq!(Quantity::Image.shade(), Shade::Light);
    }

    #[test]
    fn numbers_are_shown_up_to_white_and_the_unknown_is_white() {
        let of = |values: &[f32]| {
            let white = bright(values.to_vec());
            (white, numbers(values, white).into_iter().map(|[r, ..]| r).collect::<Vec<_>>())
        };
        assert_eq!(of(&[0.0, 1.0, 2.0, 4.0]), (2.0, vec![0.0, 0.5, 1.0, 2.0]));
        assert_eq!(of(&[f32::INFINITY; 2]), (f32::INFINITY, vec![1.0; 2]));
        assert_eq!(of(&[0.0; 2]), (1.0, vec![0.0; 2]));
        assert_eq!(ends_of_amounts(&[0.0; 3]), [0.1, 1.0]);
        assert_eq!(ends_of_amounts(&[0.0, 4.0, 5.0, 0.0]), [0.4, 4.0], "a decade at least");
        let wide: Vec<f32> = (0..=200).map(|step| 1.06_f32.powi(step)).collect();
        assert_eq!(ends_of_amounts(&wide), [wide[2], wide[198]]);
        let axis = |value: f32| vec![value];
        assert_eq!(directions([&axis(-1.0), &axis(0.0), &axis(1.0)]), [[0.0, 0.5, 1.0, 0.0]]);
        assert_eq!(directions([&axis(0.0), &axis(0.0), &axis(0.0)]), [[0.0; 4]]);
    }
}
