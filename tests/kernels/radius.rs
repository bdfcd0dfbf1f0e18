//! radius and update with radii from the data: the sums of discs, and the radius that follows.

use bytemuck::Zeroable;
use goblet::kernels::{PixelState, Radius, RadiusPush, Update, UpdatePush};

use crate::discs::{Flux, with_data_radii};
use crate::fixture::{EPS, Fixture, Rng};

const WIDTH: usize = 37;
const HEIGHT: usize = 11;

/// What a pixel keeps: the sums of `shaders/include/lookup/data_radius.glsl`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sums {
    found: f32,
    excess: f32,
    reach: f32,
    area: f32,
}

impl Sums {
    fn state(self) -> PixelState {
        let Self { found, excess, reach, area } = self;
        PixelState { found_low: found.to_bits(), found_high: excess.to_bits(), shrink: reach, rest: area }
    }

    fn of(state: &PixelState) -> Self {
        let [found, excess] = [state.found_low, state.found_high].map(f32::from_bits);
        Self { found, excess, reach: state.shrink, area: state.rest }
    }
}

/// The squared radius of each pixel in iteration `iterations`, from 1. All paths have the length 1.
fn radii2(sums: &[Sums], width: usize, shrink: f32, iterations: f32, first: bool) -> Vec<f32> {
    let fixture = Fixture::new();
    let states: Vec<PixelState> = sums.iter().map(|sums| sums.state()).collect();
    let visible_radii2 = fixture.output_texels(sums.len());
    let kernel = Radius {
        visible_radii2: &visible_radii2,
        visible_throughputs: &fixture.upload_texels(&vec![[1.0_f32; 4]; sums.len()]),
        pixel_states: &fixture.upload_texels(&states),
        max_radius2: &fixture.upload(&[0_u32]),
    };
    let pass = fixture.device().pass(&kernel, &with_data_radii(), 64).expect("a pass");
    let push = RadiusPush {
        pixel_count: sums.len() as u32,
        per_length: 0.5,
        least: 0.25,
        most: 1.0,
        shrink,
        first: first.into(),
        width: width as u32,
        iterations,
    };
    let mut frame = fixture.device().frame().expect("a frame");
    frame.dispatch(&pass, push, sums.len() as u64);
    frame.run().expect("a run");
    fixture.read_texels(&visible_radii2)
}

/// The same of one pixel in f64, without the shortcut by units.
fn radius2(sums: &[Sums], pixel: usize, shrink: f64, iterations: f64) -> f64 {
    let [mut found, mut excess2, mut reach2, mut area] = [0.0; 4];
    for y in [-2, 0, 2] {
        for x in [-2, 0, 2] {
            let column = ((pixel % WIDTH) as i32 + x).clamp(0, WIDTH as i32 - 1) as usize;
            let row = ((pixel / WIDTH) as i32 + y).clamp(0, HEIGHT as i32 - 1) as usize;
            let at = sums[row * WIDTH + column];
            found += f64::from(at.found);
            excess2 += f64::from(at.excess).powi(2);
            reach2 += f64::from(at.reach).powi(2);
            area += f64::from(at.area);
        }
    }
    let global = 0.25 * shrink;
    let bias2 = 4.0 * (excess2 - found).max(0.1 * found) / reach2;
    (1.0 / (2.0 * bias2 * found / area * iterations)).cbrt().clamp(global / 8.0, global * 8.0)
}

/// Photons of a pixel over some iterations, with more on the outer halves of discs by a share of at most `slope`.
fn random(rng: &mut Rng, iterations: f64, slope: f64) -> Sums {
    let found = if rng.chance(0.1) { 0.0 } else { rng.log_range(1.0, 1e9).round() };
    let radius2 = rng.log_range(0.01, 1.0);
    let excess = (found * rng.range(-slope, slope)).round();
    let [found, excess, reach, area] = [found, excess, found * radius2, iterations * radius2].map(|sum| sum as f32);
    Sums { found, excess, reach, area }
}

/// A logarithm and a power of 2 are off by 3 units in the last place and by one more for each 2 of the exponent
/// (Vulkan, Precision and Operation of SPIR-V Instructions): arguments are within 2^±120, so that powers of -1/3 are
/// off by 40 units and some. The difference of an excess and its noise loses 10 parts of 11 at most, of 12 roundings.
#[test]
fn radii_balance_noise_and_blur() {
    let mut rng = Rng(31);
    let (mut bounded, mut free) = (0, 0);
    for slope in [0.0, 1e-3, 0.1, 1.0] {
        for (iterations, shrink) in [(2.0, 0.7), (64.0, 0.2), (1e6, 0.01)] {
            let sums: Vec<Sums> = (0..WIDTH * HEIGHT).map(|_| random(&mut rng, iterations, slope)).collect();
            let found = radii2(&sums, WIDTH, shrink, iterations as f32, false);
            for (pixel, found) in found.into_iter().enumerate() {
                let expected = radius2(&sums, pixel, shrink.into(), iterations);
                let off = f64::from(found) / expected - 1.0;
                assert!(off.abs() < 300.0 * EPS, "pixel {pixel}, {slope}, {iterations}: {found} is off by {off:e}");
                let factor = expected / (0.25 * f64::from(shrink));
                if (0.126..7.9).contains(&factor) { free += 1 } else { bounded += 1 }
            }
        }
    }
    assert!(bounded > 300 && free > 300, "{bounded} {free}");
}

#[test]
fn radii_stay_in_their_range() {
    let nothing = Sums { found: 0.0, excess: 0.0, reach: 0.0, area: 0.0 };
    let seen = Sums { area: 1e6, ..nothing };
    // All photons outside, and photons that have been halved to almost nothing.
    let edge = Sums { found: 1e15, excess: 1e15, reach: 1e14, area: 1e6 };
    let faint = Sums { found: 1e-38, excess: 1e-38, reach: 1e-39, area: 1e-38 };
    // A single photon in one iteration says little.
    let one = Sums { found: 1.0, excess: -1.0, reach: 0.25, area: 0.25 };
    for (sums, factor) in [(nothing, 8.0), (seen, 8.0), (edge, 0.125), (faint, 8.0)] {
        for iterations in [1.0, 4e9] {
            assert_eq!(radii2(&[sums], 1, 0.5, iterations, false), [0.125 * factor], "{sums:?}, {iterations}");
        }
    }
    // Nine times the pixel itself: k^2 = 4 * 0.1 * 9 / (9 * 2^2), p = 9 / (9 * 2), in 2 iterations.
    let best = (2.0 * 0.1 * 0.5 * 2.0_f64).powf(-1.0 / 3.0);
    assert!((f64::from(radii2(&[one], 1, 0.5, 2.0, false)[0]) / (0.125 * best) - 1.0).abs() < 1e-5);
    // The first iteration of a round forgets what was before.
    assert_eq!(radii2(&[edge], 1, 0.5, 1.0, true), [0.125]);
}

/// A pixel's sums after an iteration with a disc of squared radius 1/4.
fn updated(before: Sums, [count, inner]: [u32; 2], kept: f32) -> Sums {
    let fixture = Fixture::new();
    let flux = Flux::with_inner(&fixture, 1);
    fixture.device().write(&flux.counts, &[count, inner]).expect("an upload");
    let sums = fixture.upload_group::<_, 4>(&[[0_u32; 4]]);
    let pixel_states = fixture.upload_texels(&[before.state()]);
    let kernel = Update {
        visible_radii2: &fixture.upload_texels(&[0.25_f32]),
        visible_throughputs: &fixture.upload_texels(&[[1.0_f32; 4]]),
        visible_radiances: &fixture.upload_texels(&[[0.0_f32; 4]]),
        pixel_states: &pixel_states,
        sum_red: &sums[0],
        sum_green: &sums[1],
        sum_blue: &sums[2],
        sum_second: &sums[3],
        counters: &flux.counters,
        flux_red: &flux.red,
        flux_green: &flux.green,
        flux_blue: &flux.blue,
        flux_counts: &flux.counts,
    };
    let pass = fixture.device().pass(&kernel, &with_data_radii(), 64).expect("a pass");
    let push = UpdatePush { pixel_count: 1, alpha: 1.0, per_unit: 1.0, flux_scale: 1.0, kept, ..Zeroable::zeroed() };
    let mut frame = fixture.device().frame().expect("a frame");
    frame.dispatch(&pass, push, 1);
    frame.run().expect("a run");
    assert_eq!(fixture.read(&flux.counts), [0, 0], "counts are cleared");
    Sums::of(&fixture.read_texels(&pixel_states)[0])
}

#[test]
fn an_iteration_is_added_to_the_sums_of_discs() {
    let sums = |found, excess, reach, area| Sums { found, excess, reach, area };
    let before = sums(40.0, -6.0, 8.0, 2.0);
    assert_eq!(updated(before, [7, 2], 1.0), sums(47.0, -3.0, 9.75, 2.25));
    assert_eq!(updated(before, [7, 6], 0.5), sums(27.0, -8.0, 5.75, 1.25));
    assert_eq!(updated(before, [0, 0], 1.0), sums(40.0, -6.0, 8.0, 2.25));
    // More than half of 2^32, on either half.
    let many = 3 << 30;
    let all = f64::from(many) as f32;
    assert_eq!(updated(sums(0.0, 0.0, 0.0, 0.0), [many, 0], 1.0), sums(all, all, 0.25 * all, 0.25));
    assert_eq!(updated(sums(0.0, 0.0, 0.0, 0.0), [many, many], 1.0), sums(all, -all, 0.25 * all, 0.25));
}
