//! Tables of indices of refraction by wavelength, and of the wavelengths that paths take.

use crate::gpu_scene::pack::texture::PackedTextures;
use crate::kernels::{self, BANDS, DISPERSIVE, FIRST_WAVELENGTH, INDEX_STEPS, WAVELENGTH_STEP};
use crate::scene::{ByWavelength, Index, Rgb, Wavelengths};

/// Adds the tables of an index that depends on the wavelength, unless dispersion is off.
pub(super) fn with_dispersion(
    material: kernels::Material,
    index: &Index,
    textures: &mut PackedTextures,
) -> kernels::Material {
    let Some(curve) = index.curve.as_ref().filter(|_| textures.has_dispersion) else {
        return material;
    };
    let wavelengths = textures.table(vec![Table::Bands as u64], || bands(&Wavelengths::new(BANDS)));
    let key = [Table::Index as u64].into_iter().chain(curve.values().iter().map(|eta| eta.to_bits())).collect();
    let indices = textures.table(key, || indices(curve));
    kernels::Material { flags: material.flags | DISPERSIVE, indices, wavelengths, ..material }
}

/// The first words of the keys of tables, which tell them from those of coats: no index has these bits.
enum Table {
    Bands = 1,
    Index = 2,
}

fn element(values: [f64; 4]) -> [u32; 4] {
    values.map(|value| (value as f32).to_bits())
}

/// The color and the first wavelength of each band, and the last wavelength.
fn bands(wavelengths: &Wavelengths) -> Vec<[u32; 4]> {
    let band = |color: Rgb, first| element([color.x, color.y, color.z, first]);
    let last = band(Rgb::ZERO, wavelengths.last);
    wavelengths.bands.iter().map(|at| band(at.color, at.first)).chain([last]).collect()
}

/// The mean index that each channel sees, then the indices in pairs of neighbours.
fn indices(curve: &ByWavelength) -> Vec<[u32; 4]> {
    let Wavelengths { bands, last } = Wavelengths::new(BANDS);
    let ends = bands.iter().skip(1).map(|band| band.first).chain([last]);
    let seen: Rgb = bands.iter().zip(ends).map(|(band, end)| band.color * curve.at(0.5 * (band.first + end))).sum();
    let mean = seen / f64::from(BANDS);
    let at = |step: u32| curve.at(f64::from(FIRST_WAVELENGTH + WAVELENGTH_STEP * step));
    let pairs = (0..INDEX_STEPS).map(|step| element([at(step), at(step + 1), 0.0, 0.0]));
    [element([mean.x, mean.y, mean.z, 0.0])].into_iter().chain(pairs).collect()
}
