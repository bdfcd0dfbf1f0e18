//! The colours of a picture: its values as colours of the screen, in their own colours or in false ones.

use std::borrow::Cow;

use super::quantity::{Picture, Quantity, ends_of_amounts, quantile};
use crate::image::false_color::Palette;
use crate::image::film::luminance;
use crate::render::aov::AovKind;

/// How values become colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colors {
    /// Light and colours as they are, vectors as colours, numbers as grey.
    #[default]
    Own,
    /// In false colours: the luminance of light and colours, a number, or the axis of a vector with this index.
    False(usize),
}

/// How the screen shows colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    /// Light, to which exposure and tone curves apply.
    Light,
    /// Colours to which the exposure applies.
    Plain,
    /// False colours.
    Fixed,
}

/// The scale of false colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The values at its ends, in the unit of the quantity.
    pub ends: [f32; 2],
    /// Whether it is logarithmic. Then 0 is black.
    pub is_log: bool,
    channel: usize,
}

/// The part of the values that may lie beyond either end of a scale.
const BEYOND: f64 = 0.01;

impl Colors {
    /// Returns how a quantity is shown at first.
    pub fn first(quantity: Quantity) -> Self {
        match quantity.kind() {
            AovKind::Share | AovKind::Amount => Self::False(0),
            _ => Self::Own,
        }
    }

    /// Returns all ways to show a quantity.
    pub fn all(quantity: Quantity) -> Vec<Self> {
        let scales = match quantity.kind() {
            AovKind::Direction | AovKind::Point => 3,
            _ => 1,
        };
        [Self::Own].into_iter().chain((0..scales).map(Self::False)).collect()
    }

    /// Returns the next way to show a quantity; after the last one, the first.
    pub fn next(self, quantity: Quantity) -> Self {
        let all = Self::all(quantity);
        let place = all.iter().position(|colors| *colors == self).map_or(0, |place| place + 1);
        all[place % all.len()]
    }

    /// Returns the name that the panel shows.
    pub fn name(self, quantity: Quantity) -> String {
        match (self, quantity.kind()) {
            (Self::Own, AovKind::Light | AovKind::Color) => "as it is".to_owned(),
            (Self::Own, AovKind::Direction | AovKind::Point) => "X, Y, Z as red, green, blue".to_owned(),
            (Self::Own, _) => "grey".to_owned(),
            (Self::False(_), AovKind::Light | AovKind::Color) => "false colours of luminance".to_owned(),
            (Self::False(axis), AovKind::Direction | AovKind::Point) => {
                format!("false colours of {}", quantity.axes()[axis])
            }
            (Self::False(_), _) => "false colours".to_owned(),
        }
    }

    /// Returns how the screen shows the colours.
    pub fn shade(self, quantity: Quantity) -> Shade {
        match (self, quantity.kind()) {
            (Self::False(_), _) => Shade::Fixed,
            (Self::Own, AovKind::Light) => Shade::Light,
            (Self::Own, _) => Shade::Plain,
        }
    }
}

/// Returns the number that false colours show.
fn number(quantity: Quantity, channel: usize, [x, y, z, _]: [f32; 4]) -> f32 {
    match quantity.kind() {
        AovKind::Light | AovKind::Color => luminance([x, y, z]),
        _ => [x, y, z][channel],
    }
}

impl Scale {
    /// Returns the scale of a picture in false colours; `None` if it is shown in its own.
    pub fn of(picture: &Picture, colors: Colors) -> Option<Self> {
        let Colors::False(channel) = colors else { return None };
        let numbers = picture.values.iter().map(|values| number(picture.quantity, channel, *values));
        let (ends, is_log) = match (picture.quantity.kind(), picture.ends) {
            (AovKind::Light, _) => (ends_of_amounts(numbers), true),
            (AovKind::Amount, Some(ends)) => (ends, true),
            (AovKind::Share | AovKind::Direction, Some(ends)) => (ends, false),
            (AovKind::Color, _) => ([0.0, 1.0], false),
            _ => (ends_of_numbers(numbers), false),
        };
        Some(Self { ends, is_log, channel })
    }

    /// Returns the place of a number on the scale: 0 is its beginning, 1 its end. `None` if the number has no colour.
    pub fn place(&self, number: f32) -> Option<f32> {
        let [least, most] = self.ends;
        if self.is_log {
            (number > 0.0).then(|| (number / least).ln() / (most / least).ln())
        } else if least == 0.0 {
            // Of shares, 0 is black too.
            (number > 0.0).then(|| number / most)
        } else {
            (!number.is_nan()).then(|| (number - least) / (most - least))
        }
    }
}

/// Returns the ends of a linear scale: quantiles of the finite numbers.
fn ends_of_numbers(numbers: impl Iterator<Item = f32>) -> [f32; 2] {
    let mut finite: Vec<f32> = numbers.filter(|number| number.is_finite()).collect();
    let [least, most] = [BEYOND, 1.0 - BEYOND].map(|part| quantile(&mut finite, part).unwrap_or(0.0));
    let apart = (1e-3 * least.abs()).max(1e-6);
    [least, most.max(least + apart)]
}

/// Returns the colours of a picture. `scale` is that of false colours, which may be that of another picture of the same
/// quantity.
pub fn paint<'a>(picture: &'a Picture, scale: Option<&Scale>) -> Cow<'a, [[f32; 4]]> {
    let values = &picture.values;
    if let Some(scale) = scale {
        let color = |values: &[f32; 4]| match scale.place(number(picture.quantity, scale.channel, *values)) {
            Some(place) => with_blank(Palette::Viridis.color(place)),
            None => [0.0; 4],
        };
        return values.iter().map(color).collect();
    }
    let most = picture.ends.map_or(1.0, |[_, most]| most);
    match picture.quantity.kind() {
        AovKind::Light | AovKind::Color => Cow::Borrowed(values),
        AovKind::Direction | AovKind::Point => values.iter().map(|values| direction(*values, most)).collect(),
        AovKind::Number | AovKind::Share | AovKind::Amount => {
            // Of a number, as of an axis, what is below the scale is 0: only colours have a gamut.
            let grey = |value: f32| if value.is_finite() { (value / most).max(0.0) } else { 1.0 };
            values.iter().map(|[value, ..]| with_blank([grey(*value); 3])).collect()
        }
    }
}

fn with_blank([r, g, b]: [f32; 3]) -> [f32; 4] {
    [r, g, b, 0.0]
}

/// Returns a vector as a colour: coordinates from -`most` to `most` become 0 to 1, and a zero vector is black.
fn direction([x, y, z, _]: [f32; 4], most: f32) -> [f32; 4] {
    let vector = [x, y, z];
    with_blank(if vector == [0.0; 3] { vector } else { vector.map(|axis| (0.5 + 0.5 * axis / most).max(0.0)) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::aov::Aov;

    fn named(name: &str) -> Quantity {
        Quantity::Aov(Aov::named(name).unwrap())
    }

    fn picture(quantity: Quantity, values: &[[f32; 3]], ends: Option<[f32; 2]>) -> Picture {
        let values: Vec<_> = values.iter().map(|values| with_blank(*values)).collect();
        Picture { size: [values.len() as u32, 1], values, quantity, ends }
    }

    fn painted(picture: &Picture, colors: Colors) -> Vec<[f32; 3]> {
        let scale = Scale::of(picture, colors);
        paint(picture, scale.as_ref()).iter().map(|[r, g, b, _]| [*r, *g, *b]).collect()
    }

    fn near(found: [f32; 3], expected: [f32; 3]) -> bool {
        found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5)
    }

    #[test]
    fn light_is_as_it_is_and_numbers_are_grey_up_to_white() {
        let light = picture(Quantity::Image, &[[0.5, 2.0, -9.0]], None);
        assert!(matches!(paint(&light, None), Cow::Borrowed(_)));
        let numbers = [1.0, 4.0, -1.0, f32::INFINITY].map(|number| [number; 3]);
        let numbers = picture(named("radius"), &numbers, Some([0.0, 2.0]));
        assert_eq!(painted(&numbers, Colors::Own), [[0.5; 3], [2.0; 3], [0.0; 3], [1.0; 3]]);
        let unknown = picture(named("radius"), &[[f32::INFINITY; 3]; 2], Some([0.0, f32::INFINITY]));
        assert_eq!(painted(&unknown, Colors::Own), [[1.0; 3]; 2]);
    }

    #[test]
    fn vectors_are_colors_and_nothing_is_black() {
        let normals = picture(named("N"), &[[-1.0, 0.0, 1.0], [0.0; 3]], Some([-1.0, 1.0]));
        assert_eq!(painted(&normals, Colors::Own), [[0.0, 0.5, 1.0], [0.0; 3]]);
        let points = picture(named("P"), &[[-4.0, 0.0, 2.0], [-9.0, 0.0, 6.0]], Some([-4.0, 4.0]));
        assert_eq!(painted(&points, Colors::Own), [[0.0, 0.5, 0.75], [0.0, 0.5, 1.25]]);
    }

    #[test]
    fn false_colors_go_from_end_to_end() {
        let [first, middle, last] = [0.0, 0.5, 1.0].map(|at| Palette::Viridis.color(at));
        let shares = picture(named("photon-share"), &[[0.0; 3], [1e-12; 3], [0.5; 3], [1.0; 3]], Some([0.0, 1.0]));
        let found = painted(&shares, Colors::False(0));
        assert!(found.iter().zip([[0.0; 3], first, middle, last]).all(|(a, b)| near(*a, b)), "{found:?}");
        let values = [0.0, 7e-9, 7e-4, 7e-2, 7.0, 700.0, f32::INFINITY].map(|value| [value; 3]);
        let amounts = picture(named("density"), &values, Some([7e-4, 7.0]));
        let found = painted(&amounts, Colors::False(0));
        let expected = [[0.0; 3], first, first, middle, last, last, last];
        assert!(found.iter().zip(expected).all(|(a, b)| near(*a, b)), "{found:?}");
        // A channel may be negative where the luminance is not.
        let light = picture(Quantity::Image, &[[2.0, 1.0, -1.0], [1.0, -1.0, 1.0]], None);
        let found = painted(&light, Colors::False(0));
        assert!(near(found[0], last) && near(found[1], [0.0; 3]), "{found:?}");
        let normals = picture(named("N"), &[[-1.0, 0.0, 1.0]], Some([-1.0, 1.0]));
        for (axis, color) in [first, middle, last].into_iter().enumerate() {
            assert!(near(painted(&normals, Colors::False(axis))[0], color), "{axis}");
        }
    }

    #[test]
    fn every_quantity_has_false_colors_with_a_scale() {
        let values: Vec<_> = (1..=1000).map(|step| [step as f32 * 1e-3; 3]).collect();
        for quantity in Quantity::ALL {
            let ends = (!matches!(quantity.kind(), AovKind::Light | AovKind::Color)).then_some([0.1, 1.0]);
            let picture = picture(quantity, &values, ends);
            let all = Colors::all(quantity);
            assert_eq!(all[0], Colors::Own);
            for colors in &all[1..] {
                let scale = Scale::of(&picture, *colors).unwrap();
                assert!(scale.ends[0] < scale.ends[1] && scale.place(scale.ends[1]) == Some(1.0), "{quantity:?}");
                assert_eq!(colors.shade(quantity), Shade::Fixed);
                assert_eq!(paint(&picture, Some(&scale)).len(), values.len());
            }
            let mut colors = Colors::first(quantity);
            for _ in 0..all.len() {
                colors = colors.next(quantity);
            }
            assert_eq!(colors, Colors::first(quantity), "a circle");
        }
    }

    #[test]
    fn what_photons_do_is_in_false_colors_at_first() {
        let first: Vec<_> = Quantity::ALL[..10].iter().filter(|all| Colors::first(**all) != Colors::Own).collect();
        let names: Vec<_> = first.into_iter().map(|quantity| quantity.name()).collect();
        assert_eq!(names, ["density", "photon share", "light per photon"]);
    }

    #[test]
    fn a_scale_of_equal_numbers_has_a_length() {
        let flat = picture(named("Z"), &[[5.0; 3]; 4], Some([0.0, 5.0]));
        let scale = Scale::of(&flat, Colors::False(0)).unwrap();
        assert!(scale.ends[0] == 5.0 && scale.ends[1] > 5.0);
        let none = picture(named("Z"), &[[f32::NAN; 3]; 4], Some([0.0, 5.0]));
        assert_eq!(painted(&none, Colors::False(0)), [[0.0; 3]; 4]);
    }
}
