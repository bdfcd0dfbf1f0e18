//! Absorption by media: absorb.

use crate::fixture::{EPS, Fixture, Rng, UNBOUNDED};
use crate::generated::{CrossMedia, WayThrough};

/// The largest optical depth that lets light pass.
const OPAQUE_DEPTH: f64 = 87.0;

/// Coefficients and ways of any size, so that many of their products are about 1.
fn ways() -> Vec<WayThrough> {
    let mut rng = Rng(1);
    let mut ways: Vec<WayThrough> = (0..200_000)
        .map(|_| {
            let way = rng.log_range(1e-30, 1e30);
            let absorption = [(); 3].map(|()| (rng.log_range(1e-8, 1e3) / way) as f32);
            WayThrough { absorption, way: way as f32 }
        })
        .collect();
    for way in [0.0, -1e-6, 1e-30, 1.0, UNBOUNDED, f32::MAX, f32::INFINITY] {
        ways.push(WayThrough { absorption: [0.0, 1e-30, 1e20], way });
        ways.push(WayThrough { absorption: [f32::MAX, 1.0, f32::MIN_POSITIVE], way });
    }
    ways
}

/// GLSL's exp of -x is right to 3 + 2 x units in the last place, of 2 EPS each; x is rounded twice.
#[test]
fn media_leave_what_the_law_of_beer_and_lambert_says() {
    let ways = ways();
    let fixture = Fixture::new();
    let (inputs, shares) = (fixture.upload(&ways), fixture.output::<[f32; 4]>(ways.len()));
    fixture.run(&CrossMedia { ways: &inputs, shares: &shares }, ways.len());
    let mut partly = 0;
    for (WayThrough { absorption, way }, share) in ways.iter().zip(fixture.read(&shares)) {
        for (absorption, share) in absorption.iter().zip(share) {
            let depth = f64::from(*absorption) * f64::from(way.clamp(0.0, UNBOUNDED));
            let expected = if depth > OPAQUE_DEPTH * (1.0 + 2.0 * EPS) { 0.0 } else { (-depth).exp() };
            let bound = (6.0 + 8.0 * depth) * EPS * expected;
            let is_edge = (depth / OPAQUE_DEPTH - 1.0).abs() < 2.0 * EPS && share == 0.0;
            let error = (f64::from(share) - expected).abs();
            assert!(error <= bound || is_edge, "{absorption:e} over {way:e} leaves {share:e}, not {expected:e}");
            partly += u32::from(share > 0.0 && share < 1.0);
        }
    }
    assert!(partly > 100_000, "{partly}");
}
