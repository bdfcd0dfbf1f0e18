//! Colors of wavelengths in each light, for paths that have taken a wavelength.

use super::Packer;
use super::material::has_dispersion;
use crate::gpu_scene::pack::texture::PackedTextures;
use crate::kernels::{BANDS, INFINITE, NONE};
use crate::scene::{ByWavelength, Rgb, Wavelengths};

/// Where the colors of wavelengths are in the packed elements of textures: tables of integrals of the color from the
/// first wavelength to the ends of bands.
#[derive(Clone, Copy, Debug)]
pub struct LightSpectra {
    /// The first element of the colors in daylight; `NONE` if no material splits light.
    pub white: u32,
    /// The first element of the colors in all constant infinite light.
    pub infinite: u32,
    /// The first element that says where the colors of each light are, four lights to an element; `NONE` if those of all
    /// are the colors in daylight.
    pub lights: u32,
}

impl Packer {
    /// Packs the colors of wavelengths, if some material splits light.
    pub(super) fn pack_light_spectra(&mut self) -> LightSpectra {
        if !has_dispersion(&self.materials) {
            return LightSpectra { white: NONE, infinite: NONE, lights: NONE };
        }
        let wavelengths = Wavelengths::new(BANDS);
        let infinite = self.infinite_colors(&wavelengths);
        let white = add(&mut self.textures, &shown(None, &wavelengths), &wavelengths);
        let infinite = add(&mut self.textures, &infinite, &wavelengths);
        if self.light_curves.iter().all(Option::is_none) {
            return LightSpectra { white, infinite, lights: NONE };
        }
        let textures = &mut self.textures;
        let mut lights = Vec::with_capacity(self.light_curves.len());
        // Of a lamp that is a mesh, each triangle is a light.
        let mut before = (None, white);
        for curve in &self.light_curves {
            if *curve != before.0 {
                before = (curve.clone(), add(textures, &shown(curve.as_ref(), &wavelengths), &wavelengths));
            }
            lights.push(before.1);
        }
        let first = textures.texels.len() as u32;
        let four = |lights: &[u32]| std::array::from_fn(|i| lights.get(i).copied().unwrap_or(NONE));
        textures.texels.extend(lights.chunks(4).map(four));
        LightSpectra { white, infinite, lights: first }
    }

    /// Returns what all constant infinite light shows in each band, over its RGB.
    fn infinite_colors(&self, wavelengths: &Wavelengths) -> Vec<Rgb> {
        let lights = self.lights.iter().zip(&self.light_curves).filter(|(light, _)| light.kind == INFINITE);
        let mut sum = vec![Rgb::ZERO; wavelengths.bands.len()];
        for (light, curve) in lights {
            let rgb = Rgb::from(light.emission.map(f64::from));
            let shown = shown(curve.as_ref(), wavelengths);
            sum.iter_mut().zip(shown).for_each(|(sum, color)| *sum += rgb * color);
        }
        sum.iter().map(|sum| over(*sum, self.infinite)).collect()
    }
}

/// Returns what a light shows in each band, over its RGB: the mean over all bands is 1 in each channel that the light
/// has. Without a curve it is daylight.
fn shown(curve: Option<&ByWavelength>, wavelengths: &Wavelengths) -> Vec<Rgb> {
    let value = |[first, last]: [f64; 2]| curve.map_or(1.0, |curve| curve.mean(first, last));
    let colors = wavelengths.bands.iter().zip(wavelengths.ranges()).map(|(band, range)| band.color * value(range));
    let colors: Vec<Rgb> = colors.collect();
    let rgb = colors.iter().sum::<Rgb>() / colors.len() as f64;
    colors.iter().map(|color| over(*color, rgb)).collect()
}

/// Divides colors; channels that the divisor does not have become 0.
fn over(color: Rgb, by: Rgb) -> Rgb {
    Rgb::from([0, 1, 2].map(|channel| if by[channel] > 0.0 { color[channel] / by[channel] } else { 0.0 }))
}

/// Returns the places of the ends of bands in a curve like those of glasses, whose indices fall as 1 / nm² does (Cauchy).
/// They are 0.1 and 0.9 where a tenth and nine tenths of the bands end.
fn places(wavelengths: &Wavelengths) -> Vec<f64> {
    let ends = wavelengths.bands.iter().map(|band| band.first).chain([wavelengths.last]);
    let curve: Vec<f64> = ends.map(|nm| nm.powi(-2)).collect();
    let tenth = wavelengths.bands.len() / 10;
    let [first, last] = [curve[tenth], curve[wavelengths.bands.len() - tenth]];
    let share = tenth as f64 / wavelengths.bands.len() as f64;
    curve.iter().map(|value| share + (1.0 - 2.0 * share) * (value - first) / (last - first)).collect()
}

/// Adds the integrals of colors with the places in the curve, then the integrals of colors times these places, and returns
/// the first element.
fn add(textures: &mut PackedTextures, colors: &[Rgb], wavelengths: &Wavelengths) -> u32 {
    let places = places(wavelengths);
    let width = 1.0 / colors.len() as f64;
    let middles = places.windows(2).map(|ends| 0.5 * (ends[0] + ends[1]));
    let moments: Vec<Rgb> = colors.iter().zip(middles).map(|(color, place)| color * place).collect();
    let integrals = |values: &[Rgb]| {
        let mut integral = Rgb::ZERO;
        let sum = values.iter().map(|value| {
            integral += value * width;
            integral
        });
        [Rgb::ZERO].into_iter().chain(sum).collect::<Vec<Rgb>>()
    };
    let element = |value: Rgb, place: f64| value.as_vec3().extend(place as f32).to_array().map(f32::to_bits);
    let each = integrals(colors).into_iter().zip(places).map(|(color, place)| element(color, place));
    let table: Vec<[u32; 4]> = each.chain(integrals(&moments).into_iter().map(|moment| element(moment, 0.0))).collect();
    let key = table.iter().flatten().map(|word| u64::from(*word)).collect();
    textures.table(key, || table)
}
