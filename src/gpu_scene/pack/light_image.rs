//! Packing of images of lights, with tables that choose texels by power.

pub mod portal;

use glam::DVec2;

use super::mean;
use crate::gpu_scene::alias;
use crate::kernels::{self, LightTexel};
use crate::scene::{LightImage, Rgb, window_cosine};

/// Appends an image's rows and texels to `texels`, and returns the packed image and the weighted mean of
/// the texels' colours. A projector has a window, whose texels are weighted by solid angle.
pub fn pack(
    image: &LightImage,
    window: Option<DVec2>,
    tables: Tables,
    texels: &mut Vec<LightTexel>,
) -> (kernels::LightImage, Rgb) {
    let weight = |place| window.map_or(1.0, |half_extent| window_cosine(half_extent, place).powi(3));
    let (packed, average) = pack_weighed(image, weight, tables, texels);
    let half_extent = window.unwrap_or_default().as_vec2().to_array();
    (kernels::LightImage { half_extent, ..packed }, average)
}

/// Appends an image whose texels are chosen by their colour times a weight at their centre, in [0, 1]².
pub fn pack_weighed(
    image: &LightImage,
    weight: impl Fn(DVec2) -> f64,
    tables: Tables,
    texels: &mut Vec<LightTexel>,
) -> (kernels::LightImage, Rgb) {
    let (width, height) = (image.pixels.width, image.pixels.height);
    let size = DVec2::new(width.into(), height.into());
    let first = texels.len();
    texels.reserve(height as usize + image.pixels.pixels.len());
    texels.resize(first + height as usize, bytemuck::Zeroable::zeroed());
    let mut rows = Vec::with_capacity(height as usize);
    let mut sum = Rgb::ZERO;
    for (y, row) in image.pixels.pixels.chunks_exact(width as usize).enumerate() {
        let weighed = |(x, pixel): (usize, &[f32; 3])| {
            let place = (DVec2::new(x as f64, y as f64) + 0.5) / size;
            weight(place) * Rgb::from(pixel.map(f64::from))
        };
        let colours: Vec<Rgb> = row.iter().enumerate().map(weighed).collect();
        let weights: Vec<f64> = colours.iter().copied().map(mean).collect();
        sum += colours.iter().sum::<Rgb>();
        rows.push(weights.iter().sum());
        let texel = |(color, choice): (&[f32; 3], u32)| LightTexel { color: *color, choice };
        texels.extend(row.iter().zip(tables.choices(&weights)).map(texel));
    }
    for (texel, choice) in texels[first..].iter_mut().zip(tables.choices(&rows)) {
        texel.choice = choice;
    }
    let average = sum / size.element_product();
    let axes = image.world_from_image.as_mat3();
    let packed = kernels::LightImage {
        x_axis: axes.x_axis.to_array(),
        first: first as u32,
        y_axis: axes.y_axis.to_array(),
        width,
        z_axis: axes.z_axis.to_array(),
        height,
        half_extent: [0.0; 2],
        average: mean(average) as f32,
        pad: 0.0,
    };
    (packed, average)
}

/// The tables that texels are chosen by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tables {
    /// Alias tables, in constant time.
    Alias,
    /// Cumulative tables, with which neighbouring numbers choose neighbouring texels: guided emission learns from that.
    Cumulative,
}

impl Tables {
    /// Returns a table with 32 bits per entry. For long sides this rounding is smaller than that of random numbers of 24
    /// bits.
    fn choices(self, weights: &[f64]) -> Vec<u32> {
        match self {
            Self::Alias => alias_choices(weights),
            Self::Cumulative => cumulative_choices(weights),
        }
    }
}

/// Returns an alias table: the alias in the upper 16 bits, the threshold times 2^16 in the lower ones.
fn alias_choices(weights: &[f64]) -> Vec<u32> {
    let indices: Vec<u32> = (0..weights.len() as u32).collect();
    let table = alias::table(weights, &indices);
    if table.is_empty() {
        return vec![0; weights.len()];
    }
    table.iter().map(|entry| entry.alias << 16 | ((entry.threshold * 65536.0).round() as u32).min(65535)).collect()
}

/// Returns for each entry the chance of all entries up to it, times 2^32. That of the last entry with a weight, and of
/// those after it, is the largest u32.
fn cumulative_choices(weights: &[f64]) -> Vec<u32> {
    let total: f64 = weights.iter().sum();
    let mut sum = 0.0;
    let mut choices: Vec<u32> = weights
        .iter()
        .map(|weight| {
            sum += weight;
            // The conversion saturates.
            if total > 0.0 { (sum / total * 4_294_967_296.0).round() as u32 } else { 0 }
        })
        .collect();
    if let Some(last) = weights.iter().rposition(|weight| *weight > 0.0) {
        choices[last..].fill(u32::MAX);
    }
    choices
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cumulative_tables_rise_to_one() {
        assert_eq!(cumulative_choices(&[1.0, 0.0, 3.0, 0.0]), [1 << 30, 1 << 30, u32::MAX, u32::MAX]);
        assert_eq!(cumulative_choices(&[0.0, 0.0]), [0, 0]);
    }
}
