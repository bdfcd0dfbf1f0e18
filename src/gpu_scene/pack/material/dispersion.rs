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
    let colors = textures.table(vec![Table::Colors as u64], colors);
    let indices = textures.table(key(Table::Index, curve), || indices(curve));
    kernels::Material { flags: material.flags | DISPERSIVE, indices, colors, ..material }
}

impl PackedTextures {
    /// Adds a table of a curve, the same for all channels, and returns its first element.
    pub fn curve(&mut self, curve: &ByWavelength) -> u32 {
        let value = |[first, last]: [f64; 2]| element(Rgb::splat(curve.mean(first, last)));
        self.table(key(Table::Curve, curve), || Wavelengths::new(BANDS).ranges().map(value).collect())
    }
}

/// The first words of the keys of tables, which tell them from those of coats: no index has these bits.
enum Table {
    Colors = 1,
    Index = 2,
    Curve = 3,
}

fn key(table: Table, curve: &ByWavelength) -> Vec<u64> {
    [table as u64].into_iter().chain(curve.values().iter().map(|value| value.to_bits())).collect()
}

fn element(value: Rgb) -> [u32; 4] {
    value.as_vec3().extend(0.0).to_array().map(f32::to_bits)
}

/// The color of each band.
fn colors() -> Vec<[u32; 4]> {
    Wavelengths::new(BANDS).bands.iter().map(|band| element(band.color)).collect()
}

/// The mean index that each channel sees, then the indices at both ends of each band.
fn indices(curve: &ByWavelength) -> Vec<[u32; 4]> {
    let wavelengths = Wavelengths::new(BANDS);
    let each = wavelengths.bands.iter().zip(wavelengths.ranges());
    let seen: Rgb = each.map(|(Band { color, .. }, [first, last])| *color * curve.mean(first, last)).sum();
    let ends = wavelengths.ranges().map(|[first, last]| element(Rgb::new(curve.at(first), curve.at(last), 0.0)));
    [element(seen / f64::from(BANDS))].into_iter().chain(ends).collect()
}
