//! Resampling of skies with longitude and latitude to the equal-area square of
//! [`crate::geometry::equal_area`].
//!
//! In each quarter of the square, the upper half of the sphere is the triangle u + v <= 1, and the lower
//! half is the other triangle. There a circle of latitude is a line u + v = r with r = sqrt(1 - |z|), and a
//! meridian is a line through the corner. So a texel of the image is a quadrilateral with straight sides,
//! which is clipped exactly against the square's texels: its power is kept to the last bits.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, SQRT_2};

use glam::DVec2;

use crate::image::film::Image;
use crate::scene::model::Rgb;

/// Maximum factor of the side of a square, for small images: with smaller texels, resampling changes
/// directions little.
const MOST_FINE: u32 = 4;
/// Maximum number of texels of a square whose side is multiplied by such a factor.
const FINE_TEXELS: u32 = 1 << 19;

/// Returns the equal-area square of an image over longitude and latitude; each texel has one colour. The
/// square's texels are about as large as the texels on the image's equator, or smaller.
pub(in crate::scene) fn equal_area(image: &Image) -> Image {
    let equal = f64::from(image.width) * FRAC_1_PI.sqrt();
    // The side is even, so that quarters have whole texels.
    let half_of = |fine: u32| (0.5 * equal * f64::from(fine)).ceil() as u32;
    let fine = (1..=MOST_FINE).rev().find(|fine| 4 * half_of(*fine).pow(2) <= FINE_TEXELS).unwrap_or(1);
    let half = half_of(fine);
    let mut square = Image::new(2 * half, 2 * half);
    for quarter in 0..4 {
        let texels = Quarter::new(image, quarter, half).texels();
        // Quarters are in order of azimuth, from +x to +y.
        let (is_left, is_upper) = (quarter == 1 || quarter == 2, quarter >= 2);
        let place = |at: u32, mirrored: bool| if mirrored { half - 1 - at } else { half + at };
        for (i, texel) in (0..).zip(texels) {
            let (x, y) = (place(i % half, is_left), place(i / half, is_upper));
            square.pixels[(y * 2 * half + x) as usize] = texel.as_vec3().to_array();
        }
    }
    square
}

/// A row or column of the image: its index, and its range on the quarter, in [0, 1].
type Part = (u32, [f64; 2]);

/// A quarter of the square, and the part of the image that lies in it.
struct Quarter<'a> {
    image: &'a Image,
    /// Number of texels along a side.
    half: u32,
    /// Columns, with azimuths in quarter turns from the x axis.
    columns: Vec<Part>,
    /// Rows of the upper half of the sphere, with ranges of r; rows of the lower half mirror them.
    rows: Vec<Part>,
}

impl<'a> Quarter<'a> {
    fn new(image: &'a Image, quarter: u32, half: u32) -> Self {
        let Image { width, height, .. } = *image;
        let turn = |column: u32| (4.0 * f64::from(column) / f64::from(width) - f64::from(quarter)).clamp(0.0, 1.0);
        let column = |i: u32| {
            let [start, end] = [turn(i), turn(i + 1)];
            (i, if quarter.is_multiple_of(2) { [start, end] } else { [1.0 - end, 1.0 - start] })
        };
        let radius = |row: u32| SQRT_2 * (0.5 * (PI * f64::from(row) / f64::from(height)).min(FRAC_PI_2)).sin();
        let row = |j: u32| (j, [radius(j), radius(j + 1)]);
        let first = quarter * width / 4;
        let columns = (first..((quarter + 1) * width).div_ceil(4)).map(column).collect();
        Self { image, half, columns, rows: (0..height.div_ceil(2)).map(row).collect() }
    }

    /// Returns the quarter's texels, row by row from the middle of the square.
    fn texels(&self) -> Vec<Rgb> {
        let mut texels = vec![Rgb::ZERO; (self.half * self.half) as usize];
        let scale = f64::from(self.half);
        for (row, radii) in &self.rows {
            for (column, turns) in &self.columns {
                let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(r, t)| (radii[r], turns[t]));
                let upper = corners.map(|(r, t)| scale * DVec2::new(r * (1.0 - t), r * t));
                let lower = corners.map(|(r, t)| scale * DVec2::new(1.0 - r * t, 1.0 - r * (1.0 - t)));
                let [inner, outer] = *radii;
                let area = 0.5 * (outer - inner) * (outer + inner) * (turns[1] - turns[0]) * scale * scale;
                for (row, corners) in [(*row, upper), (self.image.height - 1 - row, lower)] {
                    let pixel = self.image.pixels[(row * self.image.width + column) as usize];
                    if pixel != [0.0; 3] {
                        self.spread(&mut texels, &Polygon::new(&corners), area, Rgb::from(pixel.map(f64::from)));
                    }
                }
            }
        }
        texels
    }

    /// Adds the light of an image's texel, or part of one, to the square's texels in proportion to the area
    /// covered. `area` is the area of `part` without rounding.
    fn spread(&self, texels: &mut [Rgb], part: &Polygon, area: f64, color: Rgb) {
        let rounded = part.area();
        if rounded <= 0.0 {
            return;
        }
        let color = color * (area / rounded);
        let cells = |[low, high]: [f64; 2]| (low.max(0.0) as u32)..(high.ceil() as u32).min(self.half);
        for y in cells(part.range(1)) {
            let band = part.between(1, f64::from(y));
            for x in cells(band.range(0)) {
                texels[(y * self.half + x) as usize] += color * band.between(0, f64::from(x)).area();
            }
        }
    }
}

/// Maximum number of corners: those of a quadrilateral, and one more for each of the four lines that clip
/// it.
const MOST_CORNERS: usize = 8;

/// A convex polygon.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [DVec2; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    const EMPTY: Self = Self { corners: [DVec2::ZERO; MOST_CORNERS], count: 0 };

    fn new(corners: &[DVec2]) -> Self {
        let mut polygon = Self::EMPTY;
        corners.iter().for_each(|corner| polygon.push(*corner));
        polygon
    }

    fn push(&mut self, corner: DVec2) {
        // Rounding may make a side cross a line twice; the extra corner adds no area.
        if self.count < MOST_CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    fn corners(&self) -> &[DVec2] {
        &self.corners[..self.count]
    }

    /// Returns the polygon's range along an axis.
    fn range(&self, axis: usize) -> [f64; 2] {
        let along = self.corners().iter().map(|corner| corner[axis]);
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
    }

    fn area(&self) -> f64 {
        let Some((first, others)) = self.corners().split_first() else { return 0.0 };
        let doubled: f64 = others.windows(2).map(|two| (two[0] - *first).perp_dot(two[1] - *first)).sum();
        0.5 * doubled.abs()
    }

    /// Returns the part of the polygon between the lines at `from` and `from + 1` across an axis.
    fn between(&self, axis: usize, from: f64) -> Self {
        let [low, high] = self.range(axis);
        if low >= from && high <= from + 1.0 {
            return *self;
        }
        self.beyond(axis, from, 1.0).beyond(axis, from + 1.0, -1.0)
    }

    /// Returns the part of the polygon on one side of a line (Sutherland and Hodgman 1974).
    fn beyond(&self, axis: usize, line: f64, side: f64) -> Self {
        let mut part = Self::EMPTY;
        let Some(mut before) = self.corners().last().copied() else { return part };
        for corner in self.corners() {
            let [from, to] = [before, *corner].map(|point| side * (point[axis] - line));
            if (from < 0.0) != (to < 0.0) {
                let mut crossing = before.lerp(*corner, from / (from - to));
                crossing[axis] = line;
                part.push(crossing);
            }
            if to >= 0.0 {
                part.push(*corner);
            }
            before = *corner;
        }
        part
    }
}
