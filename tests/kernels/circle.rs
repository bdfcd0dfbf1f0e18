//! Cosine and sine: circle_point.

use std::f64::consts::FRAC_PI_4;

use crate::fixture::{Fixture, Rng};
use crate::generated::GoRound;

/// The polynomials leave out terms below 2.5e-8; the reduction to a quarter turn and the last sums round by
/// less than 2^-24 each.
const BOUND: f64 = 1.0 / (1 << 23) as f64;

#[test]
fn cosines_and_sines_are_right_to_the_last_digits() {
    let mut rng = Rng(1);
    let mut angles: Vec<f32> = (0..500_000).map(|_| rng.range(-8.0, 8.0) as f32).collect();
    angles.extend((0..1000).map(|_| rng.log_range(1e-38, 1.0) as f32));
    // Where the quarter turns change, and where one of both vanishes.
    for eighth in -10..=10 {
        let edge = (f64::from(eighth) * FRAC_PI_4) as f32;
        angles.extend([edge.next_down(), edge, edge.next_up()]);
    }
    let fixture = Fixture::new();
    let (inputs, points) = (fixture.upload(&angles), fixture.output::<[f32; 2]>(angles.len()));
    fixture.run(&GoRound { angles: &inputs, points: &points }, angles.len());
    for (angle, [x, y]) in angles.iter().zip(fixture.read(&points)) {
        let (sine, cosine) = f64::from(*angle).sin_cos();
        assert!((f64::from(x) - cosine).abs() <= BOUND, "the cosine of {angle:e} is {cosine:e}, not {x:e}");
        assert!((f64::from(y) - sine).abs() <= BOUND, "the sine of {angle:e} is {sine:e}, not {y:e}");
    }
}
