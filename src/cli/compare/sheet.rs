//! A map of differences as a picture for people: false colours, their scale with its values, and, if asked for, the
//! image and the reference at the left of the map.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use crate::image::difference::{DifferenceMap, Scale};
use crate::image::film::{Image, picture, srgb_decode};

/// Smaller images are enlarged by a whole number, so that the longer side is at least as long, in pixels.
const LEAST_SIDE: u32 = 192;
/// Around the panes and between them, pixels.
const MARGIN: u32 = 10;
/// Width of the scale, pixels.
const BAR: u32 = 16;
/// Length of the line from the scale to a value, pixels.
const TICK: u32 = 5;
/// Height of a line of text, pixels.
const LINE: u32 = 16;

/// Where the map is on a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Column and row of its first pixel.
    pub first: [u32; 2],
    /// How many pixels of the sheet a pixel of the map has on each side.
    pub zoom: u32,
}

/// Draws a map with its scale, and returns where the map is. `sides` are the image and the reference, of the map's
/// size.
pub fn draw(map: &DifferenceMap, scale: &Scale, sides: Option<[&Image; 2]>) -> (Image, Place) {
    let zoom = LEAST_SIDE.div_ceil(map.width.max(map.height)).max(1);
    let pane = [map.width, map.height].map(|side| side * zoom);
    let mut panes: Vec<(&str, Vec<u8>)> =
        sides.into_iter().flat_map(|sides| ["image", "reference"].into_iter().zip(sides.map(picture))).collect();
    panes.push((map.kind.title(), map.picture(scale)));

    let ticks = scale.ticks();
    let values = ticks.iter().map(|(_, text)| width_of(text)).max().unwrap_or(0);
    // A title may be wider than its pane.
    let widths: Vec<u32> = panes.iter().map(|(title, _)| pane[0].max(width_of(title))).collect();
    let (map_width, sides_width) = widths
        .split_last()
        .map_or((0, 0), |(last, others)| (*last, others.iter().map(|width| width + MARGIN).sum::<u32>()));
    // The scale is beside the map, and its values may pass below the end of the title.
    let map_width = map_width.max(pane[0] + MARGIN + BAR + TICK + 2 + values);
    let top = MARGIN + LINE + 4;
    let height = top + pane[1].max(2 * LINE) + LINE / 2 + MARGIN;
    let mut sheet = Sheet::new(MARGIN + sides_width + map_width + MARGIN, height);
    let mut x = MARGIN;
    let mut place = Place { first: [x, top], zoom };
    for ((title, colors), width) in panes.iter().zip(&widths) {
        place.first[0] = x;
        sheet.text([x, MARGIN], title);
        sheet.frame([x, top], pane);
        sheet.image([x, top], map.width, zoom, colors);
        x += width + MARGIN;
    }
    sheet.scale([place.first[0] + pane[0] + MARGIN, top], pane[1], scale, &ticks);
    (sheet.into_image(), place)
}

fn width_of(text: &str) -> u32 {
    (text.chars().count() * get_raster_width(FontWeight::Regular, RasterHeight::Size16)) as u32
}

/// White paper with 8 bits a channel, sRGB.
struct Sheet {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 3]>,
}

impl Sheet {
    fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![[255; 3]; width as usize * height as usize] }
    }

    /// What is outside is left out.
    fn set(&mut self, [x, y]: [u32; 2], color: [u8; 3]) {
        if x < self.width && y < self.height {
            self.pixels[y as usize * self.width as usize + x as usize] = color;
        }
    }

    fn fill(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2], color: [u8; 3]) {
        for y in y..y + height {
            for x in x..x + width {
                self.set([x, y], color);
            }
        }
    }

    /// A grey line around a part: a map around white would not show where it ends.
    fn frame(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2]) {
        self.fill([x - 1, y - 1], [width + 2, height + 2], [160; 3]);
    }

    fn image(&mut self, [x, y]: [u32; 2], columns: u32, zoom: u32, colors: &[u8]) {
        for (index, color) in colors.as_chunks().0.iter().enumerate() {
            let [column, row] = [index as u32 % columns, index as u32 / columns];
            self.fill([x + column * zoom, y + row * zoom], [zoom; 2], *color);
        }
    }

    /// Draws the colours of a scale, the largest value at the top, with ticks and their texts at its right.
    fn scale(&mut self, [x, y]: [u32; 2], height: u32, scale: &Scale, ticks: &[(f64, String)]) {
        let [least, most] = scale.ends();
        self.frame([x, y], [BAR, height]);
        for row in 0..height {
            let value = most - (most - least) * (f64::from(row) + 0.5) / f64::from(height);
            self.fill([x, y + row], [BAR, 1], scale.color(value as f32));
        }
        for (value, text) in ticks {
            let row = ((1.0 - scale.place(*value)) * f64::from(height - 1)).round() as u32;
            self.fill([x + BAR + 1, y + row], [TICK, 1], [0; 3]);
            self.text([x + BAR + 1 + TICK + 1, (y + row).saturating_sub(LINE / 2)], text);
        }
    }

    /// Draws black text, whose upper left corner is given.
    fn text(&mut self, [x, y]: [u32; 2], text: &str) {
        for (i, character) in text.chars().enumerate() {
            let raster = get_raster(character, FontWeight::Regular, RasterHeight::Size16);
            let Some(raster) = raster.or_else(|| get_raster('?', FontWeight::Regular, RasterHeight::Size16)) else {
                continue;
            };
            for (row, line) in raster.rows().enumerate() {
                for (column, ink) in line.iter().enumerate().filter(|(_, ink)| **ink > 0) {
                    self.set([x + (i * raster.width() + column) as u32, y + row as u32], [255 - ink; 3]);
                }
            }
        }
    }

    /// Returns linear values that are encoded as the same bytes again.
    fn into_image(self) -> Image {
        let linear: Vec<f32> = (0..=u8::MAX).map(|byte| srgb_decode(f32::from(byte) / 255.0)).collect();
        let pixels = self.pixels.iter().map(|pixel| pixel.map(|byte| linear[usize::from(byte)])).collect();
        Image { width: self.width, height: self.height, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::difference::Difference;

    fn map(width: u32, values: Vec<f32>) -> DifferenceMap {
        let height = values.len() as u32 / width;
        DifferenceMap { kind: Difference::Signed, width, height, values }
    }

    fn color(image: &Image, [x, y]: [u32; 2]) -> [u8; 3] {
        let at = 3 * (y * image.width + x) as usize;
        picture(image)[at..at + 3].try_into().unwrap()
    }

    #[test]
    fn every_byte_is_written_as_it_is() {
        let mut sheet = Sheet::new(256, 1);
        for byte in 0..=u8::MAX {
            sheet.set([u32::from(byte), 0], [byte; 3]);
        }
        assert_eq!(picture(&sheet.into_image()), (0..=u8::MAX).flat_map(|byte| [byte; 3]).collect::<Vec<_>>());
    }

    /// A value has the colour that the scale has beside the tick of that value.
    #[test]
    fn pixels_have_the_colors_of_the_scale() {
        let values: Vec<f32> = [-1.0, -0.5, 0.0, 0.5, 1.0].into_iter().flat_map(|value| [value; 41]).collect();
        let map = map(41, values);
        let scale = Scale::new(Difference::Signed, 1.0);
        let (image, Place { first: [x, y], zoom }) = draw(&map, &scale, None);
        assert_eq!(zoom, 5);
        let height = 5 * zoom;
        let bar = [x + 41 * zoom + MARGIN + BAR / 2, y];
        for (row, value) in [-1.0, -0.5, 0.0, 0.5, 1.0].into_iter().enumerate() {
            let on_map = color(&image, [x + 7, y + row as u32 * zoom + 1]);
            assert_eq!(on_map, scale.color(value), "{value}");
            let place = (1.0 - scale.place(f64::from(value))) * f64::from(height - 1);
            let on_bar = color(&image, [bar[0], bar[1] + place.round() as u32]);
            // A row of the scale is 1/25 of it, and shows its middle.
            let step = scale.color(value * (1.0 - 1.0 / f64::from(height) as f32));
            assert!(on_bar == step || on_bar == on_map, "{value}: {on_bar:?}, {on_map:?}, {step:?}");
        }
        assert_eq!(color(&image, [x + 7, y + 2 * zoom]), [255; 3], "equal is white");
    }

    #[test]
    fn sides_stand_at_the_left_and_nothing_is_cut_off() {
        let grey = |value: f32| Image::from_pixels(300, 2, vec![[value; 3]; 600]).unwrap();
        let [image, reference] = [grey(1.0), grey(0.0)];
        let map = map(300, vec![0.0; 600]);
        let (sheet, place) = draw(&map, &map.scale(), Some([&image, &reference]));
        assert_eq!((place.first[0], place.zoom), (MARGIN + 2 * (300 + MARGIN), 1));
        let [white, black] = [0, 1].map(|i| color(&sheet, [MARGIN + i * (300 + MARGIN) + 5, place.first[1]]));
        assert_eq!((white, black), ([255; 3], [0; 3]));
        let (sheet, _) = draw(&self::map(1, vec![0.0]), &Scale::new(Difference::Absolute, 2e-7), None);
        let edge = (0..sheet.height).all(|y| color(&sheet, [sheet.width - 1, y]) == [255; 3]);
        assert!(edge && sheet.width > 192 + BAR + MARGIN);
    }
}
