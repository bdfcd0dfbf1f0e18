//! Colours of reflectances that are sampled at wavelengths.

use super::{daylight, response_of_daylight, rgb_from_xyz, wavelengths};
use crate::scene::model::Rgb;

/// Returns, for each of the wavelengths in nm, which ascend, the colour that a reflectance of 1 there adds to that
/// of a sampled reflectance. The reflectance is linear between samples, and constant before the first and after
/// the last. The colours sum to white.
pub(in crate::scene) fn colors_of_samples(samples: &[f32]) -> Vec<Rgb> {
    let white = response_of_daylight().rgb;
    let mut colors = vec![Rgb::ZERO; samples.len()];
    for (nm, xyz) in wavelengths() {
        let color = rgb_from_xyz(xyz * daylight(nm)) / white;
        let above = samples.partition_point(|sample| f64::from(*sample) < nm);
        match (above.checked_sub(1), samples.get(above)) {
            (Some(below), Some(high)) => {
                let [low, high] = [samples[below], *high].map(f64::from);
                let part = (nm - low) / (high - low);
                colors[below] += color * (1.0 - part);
                colors[above] += color * part;
            }
            (Some(last), None) => colors[last] += color,
            (None, Some(_)) => colors[0] += color,
            (None, None) => {}
        }
    }
    colors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::spectrum::Spectrum;

    /// A reflectance by its samples has the colour that it has as a table.
    #[test]
    fn sampled_reflectances_have_the_colours_of_their_tables() {
        let samples: Vec<f32> = (0..30).map(|i| 360.0 + 17.0 * i as f32).collect();
        let value = |nm: f64| 0.5 + 0.3 * (nm / 40.0).sin();
        let pairs = samples.iter().map(|nm| [f64::from(*nm), value(f64::from(*nm))]).collect();
        let expected = Spectrum::Table(pairs).reflectance();
        let colors = colors_of_samples(&samples);
        let found: Rgb = samples.iter().zip(&colors).map(|(nm, color)| *color * value(f64::from(*nm))).sum();
        assert!((found - expected).abs().max_element() < 1e-9, "{found} {expected}");
        assert!((colors.iter().sum::<Rgb>() - Rgb::ONE).abs().max_element() < 1e-12);
        assert!((colors_of_samples(&[500.0])[0] - Rgb::ONE).abs().max_element() < 1e-12);
    }
}
