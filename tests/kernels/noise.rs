//! noise.glsl against f64, at points that fp32 represents exactly.

use glam::{DVec3, Vec3};
use goblet::scene::Rgb;

use crate::fixture::{EPS, Fixture, Rng, double, single};
use crate::generated::{
    MakeNoise, NoisePoint, TEXTURE_DOTS, TEXTURE_FBM, TEXTURE_MARBLE, TEXTURE_WIND, TEXTURE_WRINKLED,
};
use crate::support::noise::{
    OF_PERLIN, fbm, frequencies, is_in_dot, marble, noise, noise_by, place_on_marble, wrinkled,
};
use crate::world::World;

const COUNT: usize = 20_000;

/// Octaves of a point, as the twin sees them: the kernel's products are rounded once.
fn rounded_octaves(point: &NoisePoint) -> Vec<f64> {
    let p = Vec3::from(point.position);
    frequencies(point.octaves).map(|frequency| noise((frequency * p).as_dvec3())).collect()
}

/// The values of nodes of a scene that has a table of noise.
fn make(points: &[NoisePoint]) -> Vec<[f32; 4]> {
    let scene = "WorldBegin LightSource \"infinite\" Texture \"t\" \"spectrum\" \"marble\"
        Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\"";
    let (world, _) = World::parse(scene);
    let fixture = Fixture::new();
    let gpu = world.upload(&fixture);
    let (points, values) = (fixture.upload(points), fixture.output::<[f32; 4]>(points.len()));
    fixture.run(&MakeNoise { scene: gpu.bindings(), points: &points, values: &values }, points.len() as usize);
    fixture.read(&values)
}

/// Points of a kind in cubes of several sizes.
fn random_points(kind: u32, sizes: &[f64]) -> Vec<NoisePoint> {
    let mut rng = Rng(17);
    (0..COUNT)
        .map(|i| NoisePoint {
            position: single(rng.cube(sizes[i % sizes.len()])),
            kind,
            roughness: rng.range(-0.9, 1.2) as f32,
            variation: rng.range(-3.0, 3.0) as f32,
            octaves: rng.below(17) as u32,
            pad: 0,
        })
        .collect()
}

fn at(position: [f32; 3]) -> NoisePoint {
    NoisePoint { position, kind: TEXTURE_FBM, roughness: 0.5, variation: 0.0, octaves: 1, pad: 0 }
}

/// The value that is published for the reference implementation: at (3.14, 42, 7).
#[test]
fn the_table_is_that_of_perlin() {
    assert!((noise_by(&OF_PERLIN, DVec3::new(314.0 / 100.0, 42.0, 7.0)) - 0.136_919_958_784_000_12).abs() < 1e-15);
}

#[test]
fn noise_agrees_with_f64() {
    let points = random_points(TEXTURE_FBM, &[1.0, 40.0, 3e3, 1e6, 1e8]);
    let mut extremes = [0.0_f64; 2];
    for (point, found) in points.iter().zip(make(&points)) {
        let (expected, found) = (noise(double(point.position)), f64::from(found[3]));
        // Eight products of three weights of at most 1 and a slope of at most 2, each with some ten roundings.
        assert!((found - expected).abs() <= 64.0 * EPS, "{point:?}: {found} is not {expected}");
        extremes = [extremes[0].min(found), extremes[1].max(found)];
    }
    assert!(extremes[0] < -0.7 && extremes[1] > 0.7 && extremes[0] > -1.0 && extremes[1] < 1.0, "{extremes:?}");
}

#[test]
fn noise_is_0_on_its_lattice_and_far_away() {
    let mut rng = Rng(4);
    let mut points: Vec<NoisePoint> = (0..COUNT).map(|_| at(single(rng.cube(1e4).round()))).collect();
    points.extend([0.0, -0.0, 256.0, -256.0, 1e9, -1e9, 3e38, -3e38, f32::MIN_POSITIVE].map(|x| at([x; 3])));
    points.extend([[3e38, -3e38, 7.0], [-1e-30, 0.0, 5.0]].map(at));
    for (point, found) in points.iter().zip(make(&points)) {
        assert!(found[3].abs() < 1e-30, "{point:?}: {found:?}");
    }
    // What lies outside of fp32 has any value, from any place of the table.
    make(&[f32::INFINITY, f32::NEG_INFINITY, f32::NAN].map(|x| at([x; 3])));
}

#[test]
fn noise_repeats_after_256() {
    let mut rng = Rng(6);
    let mut points = Vec::new();
    for _ in 0..COUNT / 2 {
        // Multiples of 1/64, so that the sum is exact.
        let p = (64.0 * rng.cube(100.0)).round() / 64.0;
        let period = 256.0 * rng.cube(3.0).round();
        points.extend([at(single(p)), at(single(p + period))]);
    }
    let found = make(&points);
    for (pair, found) in points.chunks(2).zip(found.chunks(2)) {
        assert_eq!(found[0][3].to_bits(), found[1][3].to_bits(), "{pair:?}");
    }
}

#[test]
fn sums_of_octaves_agree_with_f64() {
    for kind in [TEXTURE_FBM, TEXTURE_WRINKLED, TEXTURE_WIND] {
        let points = random_points(kind, &[0.01, 3.0, 50.0, 1e4]);
        for (point, found) in points.iter().zip(make(&points)) {
            let (terms, roughness) = (rounded_octaves(point), f64::from(point.roughness));
            let expected = match kind {
                TEXTURE_WRINKLED => wrinkled(&terms, roughness),
                TEXTURE_WIND => fbm(&terms, roughness).abs(),
                _ => fbm(&terms, roughness),
            };
            // The weights have up to 16 roundings, and the sum as many.
            let weights: f64 = (0..=point.octaves as i32).map(|i| roughness.abs().powi(i)).sum();
            let off = (f64::from(found[0]) - expected).abs();
            assert!(off <= 100.0 * EPS * weights, "{point:?}: {found:?} is not {expected}");
        }
    }
}

#[test]
fn marble_has_the_colours_of_pbrt() {
    let mut points = random_points(TEXTURE_MARBLE, &[0.5, 4.0, 30.0]);
    points.iter_mut().for_each(|point| point.roughness *= 0.5);
    let mut compared = 0;
    for (point, found) in points.iter().zip(make(&points)) {
        let sum = fbm(&rounded_octaves(point), point.roughness.into());
        let place = place_on_marble(f64::from(point.position[1]) + f64::from(point.variation) * sum);
        // The colours jump where a curve begins.
        if (place - place.round()).abs() < 5e-3 && place.round() % 6.0 != 0.0 {
            continue;
        }
        compared += 1;
        let found = Rgb::new(found[0].into(), found[1].into(), found[2].into());
        let off = (found - marble(place)).abs().max_element();
        // The phase is up to 40 with roundings of 1e-5, the sine is off by 5e-7 at most, and the colours change by
        // less than 6 per unit of either.
        assert!(off < 1e-4, "{point:?}: {found} is not {}", marble(place));
    }
    assert!(compared > COUNT * 9 / 10, "{compared}");
}

#[test]
fn dots_are_where_pbrt_has_them() {
    let points = random_points(TEXTURE_DOTS, &[2.0, 40.0, 2e3]);
    let mut counts = [0; 2];
    for (point, found) in points.iter().zip(make(&points)) {
        let Some(expected) = is_in_dot(double(point.position).truncate()) else { continue };
        counts[usize::from(expected)] += 1;
        assert_eq!(found[0], f32::from(u8::from(expected)), "{point:?}");
    }
    assert!(counts[0] > COUNT / 2 && counts[1] > COUNT / 10, "{counts:?}");
}
