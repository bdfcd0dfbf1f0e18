//! Wavelengths that paths take, their colours, and the indices of glass, against Sellmeier's formula and the observer.

use bytemuck::Zeroable;

use crate::fixture::{EPS, Fixture};
use crate::generated::{DrawWavelengths, DrawnWavelength};
use crate::support::spectral::{CROWN, FLINT, Glass, LINES};
use crate::world::World;

/// Wavelengths that are spread evenly, a whole number of them in each band.
const COUNT: usize = 1 << 16;

/// What paths are whose colours are means over a window, and whose weights have slopes.
fn draw_with(glass: &str, window: f32, slope: impl Fn(usize) -> f64) -> Vec<DrawnWavelength> {
    let material = format!("Material \"dielectric\" \"spectrum eta\" \"{glass}\"");
    let (world, _) = World::parse(&format!("WorldBegin LightSource \"infinite\" {material} Shape \"sphere\""));
    let fixture = Fixture::new();
    let gpu = world.upload(&fixture);
    let given = |i: usize| DrawnWavelength {
        wavelength: (i as f32 + 0.5) / COUNT as f32,
        window,
        slope: slope(i) as f32,
        ..DrawnWavelength::zeroed()
    };
    let drawn = fixture.upload(&(0..COUNT).map(given).collect::<Vec<_>>());
    fixture.run(&DrawWavelengths { scene: gpu.bindings(), drawn: &drawn }, COUNT);
    fixture.read(&drawn)
}

fn draw(glass: &str, window: f32) -> Vec<DrawnWavelength> {
    draw_with(glass, window, |_| 0.0)
}

fn mean(drawn: &[DrawnWavelength], value: impl Fn(&DrawnWavelength, usize) -> f64) -> [f64; 3] {
    [0, 1, 2].map(|channel| drawn.iter().map(|one| value(one, channel)).sum::<f64>() / drawn.len() as f64)
}

fn color(one: &DrawnWavelength, channel: usize) -> f64 {
    f64::from(one.color[channel])
}

/// However wide the windows are. A color is a difference of integrals up to 2, each with a few roundings, over twice the
/// window; the narrowest is a band, 1/512, so that an error is below 3000 EPS. Errors of 65,536 colors are not all alike.
#[test]
fn the_mean_color_of_wavelengths_is_white() {
    for window in [0.0, 0.01, 0.1, 0.4, 0.7, 1.0] {
        for mean in mean(&draw("glass-F11", window), color) {
            println!("{window}: {:e}", mean - 1.0);
            assert!((mean - 1.0).abs() <= 300.0 * EPS, "{window}: {mean}");
        }
    }
    for one in draw("glass-F11", 1.0) {
        assert!((0..3).all(|channel| (color(&one, channel) - 1.0).abs() < 8.0 * EPS), "{one:?}");
    }
}

/// A weight that falls as the index does, times colours that know its slope, has the same mean in all windows: that of single
/// wavelengths. The index of a glass is within a hundredth of its range of a line over 1 / nm², from a tenth of the
/// wavelengths to nine tenths; and a weight of it is a stronger one than boundaries make.
#[test]
fn windows_keep_what_a_slope_takes() {
    for glass in ["glass-F11", "glass-BK7"] {
        let exact = draw(glass, 0.0);
        let eta: Vec<f64> = exact.iter().map(|one| f64::from(one.eta)).collect();
        let [first, last] = [eta[COUNT / 10], eta[COUNT - COUNT / 10]];
        let fall = |i: usize| 1.0 + 0.2 * (eta[i] - last) / (first - last);
        let weighted = |drawn: &[DrawnWavelength]| {
            [0, 1, 2].map(|channel| {
                let each = drawn.iter().enumerate().map(|(i, one)| color(one, channel) * fall(i));
                each.sum::<f64>() / COUNT as f64
            })
        };
        let expected = weighted(&exact);
        for window in [0.05, 0.3, 1.0] {
            let found = weighted(&draw_with(glass, window, |i| -0.25 / fall(i)));
            println!("{glass}, {window}: {found:?}, expected {expected:?}");
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 0.004, "{glass}, {window}: {found}, expected {expected}");
            }
        }
    }
}

/// The wavelength of an index, nm.
fn wavelength_of(glass: &Glass, eta: f64) -> f64 {
    let [mut low, mut high] = [370.0, 790.0];
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        // Long waves are refracted less.
        if glass.eta(middle) > eta {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// In each 20 nm, as the index tells them, wavelengths have the colours of daylight there. The twin's observer is within
/// 1 % of its largest value; a color is a mean over neighbours that are a band away, which are about 1 nm.
#[test]
fn wavelengths_have_their_colors_and_indices() {
    for (name, glass) in [("glass-F11", FLINT), ("glass-BK7", CROWN)] {
        let drawn = draw(name, 0.0);
        // But for a rounding.
        assert!(drawn.is_sorted_by(|a, b| a.eta >= b.eta - 2.0 * f32::EPSILON), "indices fall");
        let nm: Vec<f64> = drawn.iter().map(|one| wavelength_of(&glass, one.eta.into())).collect();
        assert!(nm[0] > 379.9 && nm[COUNT - 1] < 780.1, "{} {}", nm[0], nm[COUNT - 1]);
        for first in (380..780).step_by(20).map(f64::from) {
            let is_here = |nm: f64| nm >= first && nm < first + 20.0;
            let here: Vec<_> = drawn.iter().zip(&nm).filter(|(_, nm)| is_here(**nm)).map(|(one, _)| *one).collect();
            let share = here.len() as f64 / COUNT as f64;
            let found = if here.is_empty() { [0.0; 3] } else { mean(&here, color).map(|mean| mean * share) };
            let expected = LINES.with(|lines| {
                let here = lines.iter().filter(|line| is_here(line.nm));
                here.fold([0.0; 3], |sum, line| [0, 1, 2].map(|channel| sum[channel] + line.rgb[channel]))
            });
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 0.02, "{name} from {first} nm: {found}, expected {expected}");
            }
        }
        assert_channels(&drawn, &glass);
    }
}

/// What each channel sees is the mean of what it is drawn for. Against the twin, the observer's error counts: 1 % of the
/// range of indices.
fn assert_channels(drawn: &[DrawnWavelength], glass: &Glass) {
    let means = mean(drawn, |one, channel| color(one, channel) * f64::from(one.eta));
    let seen = glass.seen(|eta| eta);
    let range = glass.eta(400.0) - glass.eta(700.0);
    for channel in 0..3 {
        let found = f64::from(drawn[0].channels[channel]);
        println!("{found} {} {}", means[channel], seen[channel]);
        assert!((found - means[channel]).abs() < 0.002 * range, "{found}, and a mean of {}", means[channel]);
        assert!((found - seen[channel]).abs() < 0.01 * range, "{found}, expected {}", seen[channel]);
    }
}
