//! Comparison of the picture with another one: a picture that was kept, or an image file.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use super::paint::{Colors, Scale, Shade, paint};
use super::quantity::{Picture, Quantity};
use crate::image::compare::{Comparison, compare};
use crate::image::file;

/// A picture to compare with.
#[derive(Clone, Debug, PartialEq)]
pub struct Other {
    /// What it is, in a few words.
    pub name: String,
    /// Its values.
    pub picture: Arc<Picture>,
}

/// Which of two pictures the window shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Beside {
    /// The current picture.
    #[default]
    Current,
    /// The other picture.
    Other,
    /// The current picture to the left of a line, and the other one to the right. The line is at this share of the
    /// width.
    Split(f32),
}

/// The picture to compare with, and how both are shown.
#[derive(Default)]
pub struct Compared {
    /// The other picture.
    pub other: Option<Other>,
    /// Which one is shown.
    pub beside: Beside,
    /// The error of the current picture against the other one.
    pub error: Option<Comparison>,
    /// The last measurement of the error.
    pub measured: Option<Measurement>,
}

/// A measurement of the error, which another thread makes.
pub struct Measurement {
    /// Its number.
    pub number: u64,
    /// The number of the picture.
    pub picture: u64,
    /// The time when it began.
    pub start: Instant,
    /// Whether its result is there.
    pub is_done: bool,
}

/// The colours that the window shows.
pub struct Shown<'a> {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Row by row, the top row first; the fourth number is unused.
    pub pixels: Cow<'a, [[f32; 4]]>,
    /// How the screen shows them.
    pub shade: Shade,
    /// The scale of false colours, of the current picture.
    pub scale: Option<Scale>,
}

impl Other {
    /// Reads an image file.
    ///
    /// # Errors
    /// The file cannot be read as an image.
    pub fn read(path: &Path) -> Result<Self, String> {
        let image = file::read(path).map_err(|error| error.to_string())?;
        let values = image.pixels.into_iter().map(|[r, g, b]| [r, g, b, 0.0]).collect();
        let picture = Picture { size: [image.width, image.height], values, quantity: Quantity::Image, ends: None };
        let name = path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into());
        Ok(Self { name, picture: Arc::new(picture) })
    }

    /// Returns why an image of this size that shows this quantity cannot be compared; `None` if it can.
    pub fn refusal(&self, size: [u32; 2], quantity: Quantity) -> Option<String> {
        let Picture { size: other, quantity: of, .. } = *self.picture;
        if other != size {
            let [[width, height], [own_width, own_height]] = [other, size];
            return Some(format!(
                "{} is {width}x{height} and this image {own_width}x{own_height}: expected the same size",
                self.name
            ));
        }
        let is_alike = of == quantity || of.is_radiance() && quantity.is_radiance();
        (!is_alike).then(|| format!("{} shows {}: show it here too", self.name, of.name()))
    }
}

/// Returns the colours of a picture, or of both if there is another one. A coarse picture is enlarged to the size of the
/// other.
pub fn show<'a>(current: &'a Picture, other: Option<&'a Picture>, colors: Colors, beside: Beside) -> Shown<'a> {
    let scale = Scale::of(current, colors);
    let shade = colors.shade(current.quantity);
    let of = |picture: &'a Picture| Shown { size: picture.size, pixels: paint(picture, scale.as_ref()), shade, scale };
    match (other, beside) {
        (Some(other), Beside::Other) => of(other),
        (Some(other), Beside::Split(line)) => split(&of(current), of(other), line),
        _ => of(current),
    }
}

fn split<'a>(left: &Shown<'_>, right: Shown<'a>, line: f32) -> Shown<'a> {
    let [width, height] = right.size.map(|side| side as usize);
    let [left_width, left_height] = left.size.map(|side| side as usize);
    let until = (line.clamp(0.0, 1.0) * width as f32).round() as usize;
    let mut pixels = right.pixels.into_owned();
    for (y, row) in pixels.chunks_exact_mut(width.max(1)).enumerate() {
        let from = &left.pixels[y * left_height / height * left_width..][..left_width];
        if left_width == width {
            row[..until].copy_from_slice(&from[..until]);
        } else {
            row[..until].iter_mut().enumerate().for_each(|(x, pixel)| *pixel = from[x * left_width / width]);
        }
    }
    Shown { pixels: Cow::Owned(pixels), ..right }
}

/// Returns the error of a picture against another one, whose size is the same.
///
/// # Errors
/// The sizes differ.
pub fn error(current: &Picture, other: &Picture) -> Result<Comparison, String> {
    compare(&current.to_image(), &other.to_image()).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::aov::Aov;

    fn picture(size: [u32; 2], value: f32, quantity: Quantity) -> Picture {
        Picture { size, values: vec![[value, value, value, 0.0]; (size[0] * size[1]) as usize], quantity, ends: None }
    }

    fn reds(shown: &Shown) -> Vec<f32> {
        shown.pixels.iter().map(|[red, ..]| *red).collect()
    }

    #[test]
    fn a_line_divides_the_picture_from_the_other() {
        let [mine, other] = [1.0, 2.0].map(|value| picture([4, 2], value, Quantity::Image));
        let at = |line| reds(&show(&mine, Some(&other), Colors::Own, Beside::Split(line)));
        assert_eq!(at(0.25), [1.0, 2.0, 2.0, 2.0, 1.0, 2.0, 2.0, 2.0]);
        assert_eq!((at(0.0), at(1.0)), (vec![2.0; 8], vec![1.0; 8]));
        assert_eq!(reds(&show(&mine, Some(&other), Colors::Own, Beside::Other)), [2.0; 8]);
        assert_eq!(reds(&show(&mine, Some(&other), Colors::Own, Beside::Current)), [1.0; 8]);
        assert_eq!(reds(&show(&mine, None, Colors::Own, Beside::Other)), [1.0; 8]);
    }

    #[test]
    fn a_coarse_picture_is_enlarged_beside_the_other() {
        let mut coarse = picture([2, 1], 1.0, Quantity::Image);
        coarse.values[1] = [5.0; 4];
        let other = picture([5, 3], 2.0, Quantity::Image);
        let shown = show(&coarse, Some(&other), Colors::Own, Beside::Split(0.8));
        assert_eq!((shown.size, reds(&shown)), ([5, 3], [1.0, 1.0, 1.0, 5.0, 2.0].repeat(3)));
    }

    /// Else differences of the scale would look like differences of the images.
    #[test]
    fn both_have_the_scale_of_the_current_picture() {
        let mut mine = picture([10, 10], 1.0, Quantity::Image);
        mine.values[0] = [0.1; 4];
        let other = picture([10, 10], 100.0, Quantity::Image);
        let colors = Colors::False(0);
        let scale = Scale::of(&mine, colors).unwrap();
        let shown = show(&mine, Some(&other), colors, Beside::Other);
        assert_eq!(shown.pixels[0], paint(&other, Some(&scale))[0]);
        assert_eq!(shown.scale, Some(scale));
    }

    #[test]
    fn what_cannot_be_compared_is_said() {
        let other = |size, quantity| Other { name: "kept".to_owned(), picture: Arc::new(picture(size, 1.0, quantity)) };
        let density = Quantity::Aov(Aov::named("density").unwrap());
        assert_eq!(other([4, 2], Quantity::Image).refusal([4, 2], Quantity::Direct), None);
        let said = other([4, 2], Quantity::Image).refusal([4, 3], Quantity::Image).unwrap();
        assert!(said.contains("4x2") && said.contains("4x3"), "{said}");
        let said = other([4, 2], density).refusal([4, 2], Quantity::Image).unwrap();
        assert!(said.contains("density"), "{said}");
        assert_eq!(other([4, 2], density).refusal([4, 2], density), None);
    }

    #[test]
    fn the_error_is_that_of_goblet_compare() {
        let [mine, other] = [1.1, 1.0].map(|value| picture([4, 2], value, Quantity::Image));
        let error = error(&mine, &other).unwrap();
        assert!((error.energy_ratio - 1.1).abs() < 1e-6 && (error.relmse - 0.01 / 1.01).abs() < 1e-6, "{error:?}");
    }

    #[test]
    fn what_is_no_image_is_refused() {
        let error = Other::read("no-such-file.exr".as_ref()).unwrap_err();
        assert!(error.contains("no-such-file.exr"), "{error}");
        assert!(Other::read("scene.txt".as_ref()).unwrap_err().contains(".exr"));
    }
}
