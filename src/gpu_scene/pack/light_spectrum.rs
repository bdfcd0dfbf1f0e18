//! Colors of lights by wavelength, for paths that have taken one.

use super::Packer;
use super::material::has_dispersion;
use crate::gpu_scene::pack::texture::PackedTextures;
use crate::kernels::{BANDS, INFINITE, NONE};
use crate::scene::{Band, ByWavelength, Rgb, Wavelengths};

/// Where the colors of lights are in the packed elements of textures.
#[derive(Clone, Copy, Debug)]
pub struct LightSpectra {
    /// The first element that says where the colors of each light are, four lights to an element.
    pub first: u32,
    /// The first element of the colors of all constant infinite light; `NONE` if they are those of its RGB.
    pub infinite: u32,
}

impl LightSpectra {
    /// No light has a color by wavelength.
    pub const NONE: Self = Self { first: NONE, infinite: NONE };

    /// Returns true if some light has a color by wavelength.
    pub fn exist(&self) -> bool {
        self.first != NONE
    }
}

impl Packer {
    /// Packs the colors of the lights by wavelength, if some material splits light.
    pub(super) fn pack_light_spectra(&mut self) -> LightSpectra {
        if !has_dispersion(&self.materials) || self.light_curves.iter().all(Option::is_none) {
            return LightSpectra::NONE;
        }
        let wavelengths = Wavelengths::new(BANDS);
        let infinite = self.infinite_colors(&wavelengths);
        let textures = &mut self.textures;
        let infinite = infinite.map_or(NONE, |colors| add(textures, &colors));
        let lights: Vec<u32> = self
            .light_curves
            .iter()
            .map(|curve| curve.as_ref().map_or(NONE, |curve| add(textures, &colors(curve, &wavelengths))))
            .collect();
        let first = textures.texels.len() as u32;
        let four = |lights: &[u32]| std::array::from_fn(|i| lights.get(i).copied().unwrap_or(NONE));
        textures.texels.extend(lights.chunks(4).map(four));
        LightSpectra { first, infinite }
    }

    /// Returns the colors of all constant infinite light; `None` if they are those of its RGB.
    fn infinite_colors(&self, wavelengths: &Wavelengths) -> Option<Vec<Rgb>> {
        let lights = self.lights.iter().zip(&self.light_curves).filter(|(light, _)| light.kind == INFINITE);
        lights.clone().any(|(_, curve)| curve.is_some()).then(|| {
            let mut sum = vec![Rgb::ZERO; wavelengths.bands.len()];
            for (light, curve) in lights {
                let rgb = Rgb::from(light.emission.map(f64::from));
                let own = curve.as_ref().map(|curve| colors(curve, wavelengths));
                for (band, sum) in sum.iter_mut().enumerate() {
                    *sum += rgb * own.as_ref().map_or(Rgb::ONE, |own| own[band]);
                }
            }
            sum.iter().map(|sum| over(*sum, self.infinite)).collect()
        })
    }
}

/// Returns what a light shows in each band, over its RGB: the mean over all bands of this, times the color of the band,
/// is 1 in each channel that the light has.
fn colors(curve: &ByWavelength, wavelengths: &Wavelengths) -> Vec<Rgb> {
    let values: Vec<f64> = wavelengths.ranges().map(|[first, last]| curve.mean(first, last)).collect();
    let shown: Rgb = wavelengths.bands.iter().zip(&values).map(|(Band { color, .. }, value)| *color * *value).sum();
    let rgb = shown / f64::from(BANDS);
    values.iter().map(|value| over(Rgb::splat(*value), rgb)).collect()
}

/// Divides colors; channels that the divisor does not have become 0.
fn over(color: Rgb, by: Rgb) -> Rgb {
    Rgb::from([0, 1, 2].map(|channel| if by[channel] > 0.0 { color[channel] / by[channel] } else { 0.0 }))
}

fn add(textures: &mut PackedTextures, colors: &[Rgb]) -> u32 {
    let table: Vec<[u32; 4]> =
        colors.iter().map(|color| color.as_vec3().extend(0.0).to_array().map(f32::to_bits)).collect();
    let key = table.iter().flatten().map(|word| u64::from(*word)).collect();
    textures.table(key, || table)
}
