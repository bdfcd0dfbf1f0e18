//! Fixed-point sums: to_fixed and from_fixed, and gather_grid's exact sums over photons.

use bytemuck::Zeroable;
use goblet::kernels::{
    Cell, GatherGrid, GatherGridPush, GridExtent, MaterialFeatures, PhotonRecord, Specialization, VisiblePoint,
};

use crate::discs::Flux;
use crate::fixture::{EPS, Fixture, Rng};
use crate::generated::RoundFixed;

/// Fixed-point units of weight 1.
const UNIT: f64 = 268_435_456.0;

/// The largest fp32 below 2^36, where a sum would overflow.
const LARGEST: f32 = 68_719_472_640.0;

fn round_fixed(weights: &[f32]) -> Vec<(u64, f32)> {
    let fixture = Fixture::new();
    let (weights, fixed, back) =
        (fixture.upload(weights), fixture.output(weights.len()), fixture.output(weights.len()));
    fixture.run(&RoundFixed { weights: &weights, fixed_points: &fixed, back: &back }, weights.len() as usize);
    let fixed = fixture.read(&fixed).into_iter().map(|[low, high]| u64::from(high) << 32 | u64::from(low));
    fixed.zip(fixture.read(&back)).collect()
}

/// Nearest integer; exact, since a weight has 24 bits and f64 holds 53.
fn to_fixed(weight: f32) -> u64 {
    (f64::from(weight) * UNIT).round_ties_even() as u64
}

/// From 0 to the largest, with every carry between the words.
fn weights() -> Vec<f32> {
    let mut rng = Rng(1);
    let mut weights: Vec<f32> = (0..500_000).map(|_| rng.log_range(1e-10, 6.8e10) as f32).collect();
    weights.extend((0..200_000).map(|_| rng.range(0.0, 40.0) as f32));
    for exponent in -40..=36 {
        let power = f32::exp2(exponent as f32);
        weights.extend([power.next_down(), power, power.next_up(), 1.5 * power, 3.0 * power]);
    }
    for sixteens in 0..4096 {
        let edge = 16.0 * sixteens as f32;
        weights.extend([edge.next_down().max(0.0), edge, edge.next_up()]);
    }
    weights.extend([0.0, f32::MIN_POSITIVE, LARGEST]);
    weights.retain(|weight| *weight <= LARGEST);
    weights.sort_by(f32::total_cmp);
    weights
}

#[test]
fn weights_round_to_the_nearest_fixed_point_number() {
    let weights = weights();
    for (weight, (fixed, _)) in weights.iter().zip(round_fixed(&weights)) {
        let error = (fixed as f64 - f64::from(*weight) * UNIT).abs();
        assert!(error <= 0.5, "{weight:e} becomes {fixed}, off by {error}");
    }
}

/// Two roundings of integers to 24 bits and one of their sum.
#[test]
fn fixed_point_numbers_come_back() {
    let weights = weights();
    for (weight, (fixed, back)) in weights.iter().zip(round_fixed(&weights)) {
        let exact = fixed as f64 / UNIT;
        assert!((f64::from(back) - exact).abs() <= 3.0 * EPS * exact, "{weight:e}: {exact:e} reads {back:e}");
    }
}

#[test]
fn more_weight_is_never_less_in_fixed_point() {
    let rounded = round_fixed(&weights());
    assert!(rounded.is_sorted_by(|a, b| a.0 <= b.0), "to_fixed is not monotone");
    assert!(rounded[0].0 == 0 && rounded[rounded.len() - 1].0 == to_fixed(LARGEST));
}

/// What one visible point has gathered.
#[derive(Debug, PartialEq)]
struct Sums {
    channels: [u64; 3],
    count: u32,
    saturated: u32,
}

/// Sends photons of these weights to one visible point, whose sums have the words `low` and
/// `high` before.
fn accumulate(weights: &[[f32; 3]], low: u32, high: u32) -> Sums {
    accumulate_in(&Specialization::DECLARED, weights, low, high)
}

/// The same in a scene with dispersion, where weights and sums have a sign.
fn accumulate_signed(weights: &[[f32; 3]], low: u32, high: u32) -> Sums {
    let declared = Specialization::DECLARED;
    let material = MaterialFeatures { has_dispersion: true, ..declared.material };
    accumulate_in(&Specialization { material, ..declared }, weights, low, high)
}

fn accumulate_in(specialization: &Specialization, weights: &[[f32; 3]], low: u32, high: u32) -> Sums {
    let fixture = Fixture::new();
    let device = fixture.device();
    let position = [0.3; 3];
    // Of the cell at (1, 1, 1), as cell_mark says.
    let cell = 1 | 1 << 10 | 1 << 20;
    let record = |weight: &[f32; 3]| PhotonRecord { position, normal: 0, weight: *weight, cell };
    let photons = fixture.upload_texels(&weights.iter().map(record).collect::<Vec<_>>());
    // A table of one cell, which every cell of the grid therefore shares.
    let cells = fixture.upload(&[Cell { first: 0, count: weights.len() as u32 }]);
    let flux = Flux::of(&fixture, [(); 3].map(|()| vec![[low, high]]));
    let kernel = GatherGrid {
        visible_points: &fixture.upload_texels(&[VisiblePoint { position, normal: 0 }]),
        visible_radii2: &fixture.upload_texels(&[0.01_f32]),
        max_radius2: &fixture.upload(&[0.01_f32.to_bits()]),
        grid_extent: &fixture.upload(&[GridExtent::zeroed()]),
        cells: &cells,
        grid_photons: &photons,
        flux_red: &flux.red,
        flux_green: &flux.green,
        flux_blue: &flux.blue,
        flux_counts: &flux.counts,
        counters: &flux.counters,
        places: &fixture.output(64),
    };
    let pass = device.pass(&kernel, specialization, 64).expect("a pass");
    let mut saturated = 0;
    for resumed in 0.. {
        let mut frame = device.frame().expect("a frame");
        frame.clear(&flux.counters);
        let push = GatherGridPush { width: 1, height: 1, resumed: u32::min(resumed, 1), offset: 0 };
        frame.dispatch(&pass, push, 32);
        frame.run().expect("a run");
        let counted = fixture.read(&flux.counters)[0];
        saturated += counted.saturated;
        if counted.unfinished == 0 {
            break;
        }
    }
    let channels = flux.sums(&fixture).map(|sums| sums[0]);
    Sums { channels, count: fixture.read(&flux.counts)[0], saturated }
}

/// Bright and faint photons, so that low words carry thousands of times.
#[test]
fn sums_of_deposits_are_exact() {
    let mut rng = Rng(2);
    let mut weight = || [1e-7, 1e-3, 1.0, 15.99, 1e4][rng.below(5)] as f32 * (0.5 + 0.5 * rng.unit_f32());
    let weights: Vec<[f32; 3]> = (0..200_000).map(|_| [weight(), weight(), weight()]).collect();
    let sums = accumulate(&weights, 0, 0);
    for channel in 0..3 {
        let exact: u64 = weights.iter().map(|weight| to_fixed(weight[channel])).sum();
        assert_eq!(sums.channels[channel], exact);
    }
    assert_eq!((sums.count, sums.saturated), (weights.len() as u32, 0));
}

#[test]
fn the_carry_happens_at_two_to_the_32() {
    let almost = u32::MAX;
    let one = 1.0 / UNIT as f32;
    let sums = accumulate(&[[one, 2.0 * one, 0.0]], almost, 7);
    let carried = 8 << 32;
    assert_eq!(sums, Sums { channels: [carried, carried + 1, carried - 1], count: 1, saturated: 0 });
}

#[test]
fn a_sum_that_overflows_is_counted_as_saturated() {
    assert_eq!(accumulate(&[[16.0, 0.0, 0.0]], 0, u32::MAX - 1).saturated, 0);
    assert_eq!(accumulate(&[[16.0, 0.0, 16.0]], 0, u32::MAX).saturated, 1);
}

/// Of numbers of both signs, around 0 too: the sums are two's complements.
#[test]
fn signed_sums_of_deposits_are_exact() {
    let mut rng = Rng(3);
    let mut weight =
        || [1e-7, 1e-3, 1.0, 15.99, 16.0, 1e4][rng.below(6)] as f32 * [-1.0, 1.0][rng.below(2)] * rng.unit_f32();
    let mut weights: Vec<[f32; 3]> = (0..200_000).map(|_| [weight(), weight(), -weight().abs()]).collect();
    weights.extend([[-0.0, -16.0, -1e-20], [16.0, -32.0, 0.0]]);
    let sums = accumulate_signed(&weights, 0, 0);
    for channel in 0..3 {
        let exact: i64 = weights
            .iter()
            .map(|weight| weight[channel])
            .map(|weight| to_fixed(weight.abs()) as i64 * if weight < 0.0 { -1 } else { 1 })
            .sum();
        assert_eq!(sums.channels[channel] as i64, exact);
    }
    assert_eq!((sums.count, sums.saturated), (weights.len() as u32, 0));
}

/// From 2^63 - 2^32 units up, and from -2^63 + 2^32 units down. 16 is 2^32 units.
#[test]
fn a_signed_sum_that_overflows_is_counted_as_saturated() {
    let high = i32::MAX as u32;
    let saturated = |weight: f32, high: u32| accumulate_signed(&[[0.0, weight, 0.0]], 0, high).saturated;
    assert_eq!([saturated(15.0, high), saturated(16.0, high)], [0, 1]);
    let low = i32::MIN as u32 + 1;
    assert_eq!([saturated(-16.0, low), saturated(-17.0, low)], [0, 1]);
    // Through 0, and far from either end.
    assert_eq!([saturated(16.0, u32::MAX), saturated(-16.0, 0)], [0, 0]);
}
