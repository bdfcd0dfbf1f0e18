//! Tables by wavelength: of indices of refraction, of colors, of coefficients of absorption.

use crate::gpu_scene::pack::texture::PackedTextures;
use crate::kernels::{self, BANDS, DISPERSIVE};
use crate::scene::{Band, ByWavelength, Index, Rgb, Wavelengths};

/// Adds the tables of an index that depends on the wavelength, unless dispersion is off.
pub(super) fn with_dispersion(
    material: kernels::Material,
    index: &Index,
    textures: &mut PackedTextures,
) -> kernels::Material {
    let Some(curve) = index.curve.as_ref().filter(|_| textures.has_dispersion) else {
        return material;
    };
    let indices = textures.table(key(Table::Index, curve), || indices(curve));
    kernels::Material { flags: material.flags | DISPERSIVE, indices, ..material }
}

impl PackedTextures {
    /// Adds a table of a curve, the same for all channels, and returns its first element.
    pub fn curve(&mut self, curve: &ByWavelength) -> u32 {
        let most = f64::from(f32::MAX);
        let value = |[first, last]: [f64; 2]| element(Rgb::splat(curve.mean(first, last).min(most)));
        self.table(key(Table::Curve, curve), || Wavelengths::new(BANDS).ranges().map(value).collect())
    }
}

/// The first words of the keys of tables, which tell them from those of coats: no index has these bits.
enum Table {
    Index = 1,
    Curve = 2,
}

fn key(table: Table, curve: &ByWavelength) -> Vec<u64> {
    [table as u64].into_iter().chain(curve.values().iter().map(|value| value.to_bits())).collect()
}

fn element(value: Rgb) -> [u32; 4] {
    value.as_vec3().extend(0.0).to_array().map(f32::to_bits)
}

/// The mean index that each channel sees and the slope, then the indices at both ends of each band.
fn indices(curve: &ByWavelength) -> Vec<[u32; 4]> {
    let wavelengths = Wavelengths::new(BANDS);
    let each = wavelengths.bands.iter().zip(wavelengths.ranges());
    let seen: Rgb = each.map(|(Band { color, .. }, [first, last])| *color * curve.mean(first, last)).sum();
    let ends = wavelengths.ranges().map(|[first, last]| element(Rgb::new(curve.at(first), curve.at(last), 0.0)));
    let mean = (seen / f64::from(BANDS)).as_vec3();
    let first = mean.extend(slope(curve, &wavelengths) as f32).to_array().map(f32::to_bits);
    [first].into_iter().chain(ends).collect()
}

/// The change of the index over all bands, by the bands that are not at the ends, where few wavelengths are seen.
fn slope(curve: &ByWavelength, wavelengths: &Wavelengths) -> f64 {
    let tenth = wavelengths.bands.len() / 10;
    let ends = [tenth, wavelengths.bands.len() - tenth].map(|band| curve.at(wavelengths.bands[band].first));
    let share = (wavelengths.bands.len() - 2 * tenth) as f64 / wavelengths.bands.len() as f64;
    (ends[1] - ends[0]) / share
}
