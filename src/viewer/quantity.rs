//! The quantities of a render that the window can show: the image, two parts of its light, and every AOV.

use crate::image::estimate::Estimate;
use crate::image::film::Image;
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

/// The values of a quantity in each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Row by row, the top row first: red, green and blue, the axes of a vector, or a number three times. The fourth
    /// number is unused.
    pub values: Vec<[f32; 4]>,
    /// What the values are of.
    pub quantity: Quantity,
    /// The ends of the scale of numbers and vectors, in their unit; `None` for light and colours. The second is
    /// infinite if no value is known.
    pub ends: Option<[f32; 2]>,
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

    /// Returns the kind of the values.
    pub fn kind(self) -> AovKind {
        if let Self::Aov(aov) = self { aov.kind } else { AovKind::Light }
    }

    /// Returns the unit of the values; empty for numbers without a unit.
    pub fn unit(self) -> &'static str {
        if let Self::Aov(aov) = self { aov.unit } else { "W/(m² sr)" }
    }

    /// Returns whether the values are radiance in W/(m² sr) in linear RGB, which can be compared with an image file.
    pub fn is_radiance(self) -> bool {
        match self {
            Self::Image | Self::Direct | Self::Photons => true,
            Self::Aov(aov) => ["direct", "photons", "caustic"].contains(&aov.name),
        }
    }

    /// Returns the names of the values of a pixel.
    pub fn axes(self) -> &'static [&'static str] {
        match self.kind() {
            AovKind::Light | AovKind::Color => &["R", "G", "B"],
            AovKind::Direction | AovKind::Point => &["X", "Y", "Z"],
            AovKind::Number | AovKind::Share | AovKind::Amount => &[""],
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
        let size = estimate.resolution;
        let Self::Aov(aov) = self else {
            let values = estimate.image().pixels.into_iter().map(|[r, g, b]| [r, g, b, 0.0]).collect();
            return Picture { size, values, quantity: self, ends: None };
        };
        let (values, ends) = match aov.planes(estimate).as_deref() {
            Some([x, y, z]) => {
                let values: Vec<_> = x.iter().zip(y).zip(z).map(|((x, y), z)| [*x, *y, *z, 0.0]).collect();
                (values, self.ends([x, y, z].into_iter().flatten().map(|value| value.abs())))
            }
            Some([numbers, ..]) => (
                numbers.iter().map(|value| [*value, *value, *value, 0.0]).collect(),
                self.ends(numbers.iter().copied()),
            ),
            Some([]) | None => {
                (vec![[0.0; 4]; size.map(|side| side as usize).iter().product()], self.ends([].into_iter()))
            }
        };
        Picture { size, values, quantity: self, ends }
    }

    /// Returns the ends of the scale for some values, without the signs of vectors.
    fn ends(self, values: impl Iterator<Item = f32>) -> Option<[f32; 2]> {
        match self.kind() {
            AovKind::Light | AovKind::Color => None,
            AovKind::Share => Some([0.0, 1.0]),
            AovKind::Direction => Some([-1.0, 1.0]),
            AovKind::Amount => Some(ends_of_amounts(values)),
            AovKind::Number => Some([0.0, bright(values.collect())]),
            AovKind::Point => {
                let far = bright(values.collect());
                Some([-far, far])
            }
        }
    }
}

impl Picture {
    /// Returns the values as red, green and blue.
    pub fn to_image(&self) -> Image {
        let [width, height] = self.size;
        Image { width, height, pixels: self.values.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect() }
    }

    /// Returns the values of a place on the image, whose corners are (0, 0) and (1, 1); `None` outside.
    pub fn at(&self, [x, y]: [f64; 2]) -> Option<[f32; 3]> {
        let [width, height] = self.size;
        let place = |at: f64, side: u32| (0.0..1.0).contains(&at).then(|| (at * f64::from(side)) as usize);
        let (column, row) = (place(x, width)?, place(y, height)?);
        self.values.get(row * width as usize + column).map(|[x, y, z, _]| [*x, *y, *z])
    }
}

/// Returns the [`BRIGHT`] quantile of the values, which may be infinite; 1 if the quantile is 0 or if there
/// is no value.
fn bright(mut values: Vec<f32>) -> f32 {
    quantile(&mut values, BRIGHT).filter(|value| *value > 0.0).unwrap_or(1.0)
}

/// Returns the amounts that have the first and the last colour: quantiles of those above 0, a decade or more apart.
pub fn ends_of_amounts(values: impl Iterator<Item = f32>) -> [f32; 2] {
    let mut amounts: Vec<f32> = values.filter(|value| *value > 0.0).collect();
    let [least, most] = [1.0 - BRIGHT, BRIGHT].map(|part| quantile(&mut amounts, part).unwrap_or(1.0));
    [least.min(0.1 * most), most]
}

/// Returns a quantile of the values, which may be infinite; `None` if there is no value.
pub fn quantile(values: &mut [f32], part: f64) -> Option<f32> {
    let place = (values.len().checked_sub(1)? as f64 * part) as usize;
    Some(*values.select_nth_unstable_by(place, f32::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_follow_the_kind_of_the_values() {
        let named = |name| Quantity::Aov(Aov::named(name).unwrap());
        let of = |name, values: &[f32]| named(name).ends(values.iter().copied());
        assert_eq!(of("radius", &[0.0, 1.0, 2.0, 4.0]), Some([0.0, 2.0]));
        assert_eq!(of("standard-error", &[f32::INFINITY; 2]), Some([0.0, f32::INFINITY]));
        assert_eq!(of("radius", &[0.0; 2]), Some([0.0, 1.0]));
        assert_eq!(of("P", &[3.0; 2]), Some([-3.0, 3.0]));
        assert_eq!(of("N", &[0.5]), Some([-1.0, 1.0]));
        assert_eq!(of("photon-share", &[0.5]), Some([0.0, 1.0]));
        assert_eq!((of("Albedo", &[0.5]), of("caustic", &[0.5])), (None, None));
        assert_eq!(of("density", &[0.0; 3]), Some([0.1, 1.0]));
        assert_eq!(of("density", &[0.0, 4.0, 5.0, 0.0]), Some([0.4, 4.0]), "a decade at least");
        let wide: Vec<f32> = (0..=200).map(|step| 1.06_f32.powi(step)).collect();
        assert_eq!(of("density", &wide), Some([wide[2], wide[198]]));
    }

    #[test]
    fn a_place_on_the_image_has_the_values_of_its_pixel() {
        let values = (0..6).map(|number| [number as f32; 4]).collect();
        let picture = Picture { size: [3, 2], values, quantity: Quantity::Image, ends: None };
        assert_eq!(picture.at([0.0, 0.0]), Some([0.0; 3]));
        assert_eq!(picture.at([0.99, 0.49]), Some([2.0; 3]));
        assert_eq!(picture.at([0.34, 0.5]), Some([4.0; 3]));
        assert_eq!([picture.at([1.0, 0.5]), picture.at([0.5, -0.1])], [None; 2]);
    }

    #[test]
    fn only_radiance_can_be_compared_with_files() {
        let names: Vec<_> = Quantity::ALL.into_iter().filter(|quantity| quantity.is_radiance()).collect();
        let names: Vec<_> = names.into_iter().map(Quantity::name).collect();
        let expected = ["image", "direct light", "light of photons", "direct", "photons", "caustic"];
        assert_eq!(names, expected);
    }
}
