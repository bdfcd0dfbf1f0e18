//! layer_sums: signed values of any size, added to exact sums.

use bytemuck::Zeroable;
use goblet::kernels::{Counters, LayerSums, LayerSumsPush, Specialization};

use crate::fixture::{Fixture, Rng};
use crate::sum::{Sum, number, to_term};

/// The largest float that a sum takes as a term.
const LARGEST: f32 = 549_755_781_120.0;

/// Adds each row of values to the sums of as many pixels, after passes that have counted something.
fn added(rows: &[Vec<[f32; 4]>], before: Counters) -> Vec<[Sum; 4]> {
    let fixture = Fixture::new();
    let pixels = rows[0].len();
    let sums = fixture.upload_group::<_, 4>(&vec![[0_u32; 4]; pixels]);
    let counters = fixture.upload(&[before]);
    let values = fixture.upload_texels(&rows.concat());
    let kernel = LayerSums {
        layer_values: &values,
        layer_x: &sums[0],
        layer_y: &sums[1],
        layer_z: &sums[2],
        layer_w: &sums[3],
        counters: &counters,
    };
    let pass = fixture.device().pass(&kernel, &Specialization::DECLARED, 64).expect("a pass");
    let mut frame = fixture.device().frame().expect("a frame");
    for group in 0..rows.len() as u32 {
        frame.dispatch(&pass, LayerSumsPush { pixel_count: pixels as u32, group, capacity: 7, pad0: 0 }, pixels as u64);
    }
    frame.run().expect("a run");
    let sums = [0, 1, 2, 3].map(|sum| fixture.read_texels(&sums[sum]));
    (0..pixels).map(|pixel| [0, 1, 2, 3].map(|sum| sums[sum][pixel])).collect()
}

/// The term of a value in 2^-56: what is no number is 0, and what is too large is the largest.
fn term(value: f32) -> i128 {
    let magnitude = to_term(value.abs().min(LARGEST)) as i128;
    if value.is_nan() {
        0
    } else if value < 0.0 {
        -magnitude
    } else {
        magnitude
    }
}

#[test]
fn sums_of_signed_values_are_exact() {
    let mut rng = Rng(5);
    let mut rows: Vec<Vec<[f32; 4]>> = Vec::new();
    for _ in 0..40 {
        let mut value = || {
            let scale = [1e-18, 1e-9, 1.0, 1e6, 1e11, 1e13][rng.below(6)];
            rng.range(-scale, scale) as f32
        };
        rows.push((0..100).map(|_| [value(), value(), value(), value()]).collect());
    }
    rows[7][0] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0];
    let sums = added(&rows, Counters::zeroed());
    for (pixel, sums) in sums.into_iter().enumerate() {
        for (channel, sum) in sums.into_iter().enumerate() {
            let expected: i128 = rows.iter().map(|row| term(row[pixel][channel])).sum();
            assert_eq!(number(sum).cast_signed(), expected, "pixel {pixel}, channel {channel}");
        }
    }
}

#[test]
fn an_iteration_that_is_not_complete_has_no_layers() {
    let none = Counters::zeroed();
    let rows = [vec![[1.0, -2.0, 3.0, -4.0]]];
    let full = added(&rows, Counters { recorded: 7, ..none });
    assert_eq!(full[0].map(|sum| number(sum).cast_signed() >> 56), [1, -2, 3, -4]);
    for before in
        [Counters { recorded: 8, ..none }, Counters { interrupted: 1, ..none }, Counters { unfinished: 1, ..none }]
    {
        assert_eq!(added(&rows, before), [[[0; 4]; 4]]);
    }
}
