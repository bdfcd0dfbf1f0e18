//! The f64 twins of noise, and of pbrt's textures that are made of it.

use glam::{DVec2, DVec3};
use goblet::gpu_scene::pack::PERMUTATION;
use goblet::scene::Rgb;

/// pbrt-v4's gradients, by the four low bits of the hash.
pub const OF_PBRT: [[f64; 3]; 16] = with_last([[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 1.0, -1.0], [0.0, -1.0, -1.0]]);
/// Those of Perlin's reference implementation (2002).
pub const OF_PERLIN: [[f64; 3]; 16] =
    with_last([[1.0, 1.0, 0.0], [0.0, -1.0, 1.0], [-1.0, 1.0, 0.0], [0.0, -1.0, -1.0]]);

/// The middles of the edges of a cube, and four of them once more.
const fn with_last([a, b, c, d]: [[f64; 3]; 4]) -> [[f64; 3]; 16] {
    [
        [1.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
        [1.0, -1.0, 0.0],
        [-1.0, -1.0, 0.0],
        [1.0, 0.0, 1.0],
        [-1.0, 0.0, 1.0],
        [1.0, 0.0, -1.0],
        [-1.0, 0.0, -1.0],
        [0.0, 1.0, 1.0],
        [0.0, -1.0, 1.0],
        [0.0, 1.0, -1.0],
        [0.0, -1.0, -1.0],
        a,
        b,
        c,
        d,
    ]
}

/// Noise with pbrt's gradients.
pub fn noise(p: DVec3) -> f64 {
    noise_by(&OF_PBRT, p)
}

/// The sum over the corners of a cell: the slope along the corner's gradient, times three weights.
pub fn noise_by(gradients: &[[f64; 3]; 16], p: DVec3) -> f64 {
    let corner = p.floor();
    let hash = |before: u8, x: f64| PERMUTATION[(usize::from(before) + x.rem_euclid(256.0) as usize) % 256];
    let weight = |t: f64| t.powi(3) * (6.0 * t * t - 15.0 * t + 10.0);
    let mut sum = 0.0;
    for bits in 0..8 {
        let side = DVec3::from([0, 1, 2].map(|axis| f64::from(bits >> axis & 1)));
        let at = corner + side;
        let chosen = hash(hash(hash(0, at.x), at.y), at.z) % 16;
        let offset = p - at;
        let weights = offset.abs().to_array().map(|distance| weight(1.0 - distance));
        sum += weights.iter().product::<f64>() * DVec3::from(gradients[usize::from(chosen)]).dot(offset);
    }
    sum
}

/// The frequencies of octaves, as the shaders and pbrt compute them.
pub fn frequencies(count: u32) -> impl Iterator<Item = f32> {
    (0..count).scan(1.0_f32, |next, _| Some(std::mem::replace(next, *next * 1.99)))
}

/// Noise at each octave.
pub fn octaves(p: DVec3, count: u32) -> Vec<f64> {
    frequencies(count).map(|frequency| noise(f64::from(frequency) * p)).collect()
}

pub fn fbm(octaves: &[f64], roughness: f64) -> f64 {
    octaves.iter().rev().fold(0.0, |sum, octave| octave + roughness * sum)
}

pub fn wrinkled(octaves: &[f64], roughness: f64) -> f64 {
    octaves.iter().rev().fold(0.2, |sum, octave| octave.abs() + roughness * sum)
}

pub fn windy(p: DVec3) -> f64 {
    fbm(&octaves(0.1 * p, 3), 0.5).abs() * fbm(&octaves(p, 6), 0.5)
}

/// The place on the curves of marble, 0 to 6: each whole number begins a curve.
pub fn place_on_marble(phase: f64) -> f64 {
    3.0 + 3.0 * phase.sin()
}

/// The colour at a place, by de Casteljau's construction.
pub fn marble(place: f64) -> Rgb {
    let grey = Rgb::new(0.58, 0.58, 0.6);
    let (dark, blue) = (Rgb::splat(0.5), Rgb::new(0.2, 0.2, 0.33));
    let points = [grey, grey, grey, dark, Rgb::new(0.6, 0.59, 0.58), grey, grey, blue, grey];
    let first = (place as usize).min(5);
    let mut curve = points[first..first + 4].to_vec();
    while curve.len() > 1 {
        curve = curve.windows(2).map(|two| two[0].lerp(two[1], place - first as f64)).collect();
    }
    1.5 * curve[0]
}

/// Whether a point is in a disc of `dots`; none where rounding decides.
pub fn is_in_dot(at: DVec2) -> Option<bool> {
    let cell = (at + 0.5).floor();
    let noise = |x: f64, y: f64| noise(DVec3::new(cell.x + x, cell.y + y, 0.5));
    if noise(0.5, 0.5) <= 0.0 {
        return Some(false);
    }
    let distance = at.distance(cell + 0.15 * DVec2::new(noise(1.5, 2.8), noise(4.5, 9.8)));
    ((distance - 0.35).abs() > 1e-4).then_some(distance < 0.35)
}
