//! Visible points and photons, and which belong together by a search of all pairs.

use bytemuck::Zeroable;
use glam::DVec3;
use goblet::kernels::{Counters, PhotonRecord, RenderFeatures, Specialization, VisiblePoint};
use goblet_host::{Buffer, Frame};

use crate::fixture::{Fixture, Rng, double};

/// A point's or a photon's place and packed normal.
pub struct Disc {
    pub position: [f32; 3],
    pub normal: u32,
    pub radius: f32,
}

pub fn visible(points: &[Disc]) -> Vec<VisiblePoint> {
    points.iter().map(|point| VisiblePoint { position: point.position, normal: point.normal }).collect()
}

pub fn radii2(points: &[Disc]) -> Vec<f32> {
    points.iter().map(|point| point.radius * point.radius).collect()
}

/// Bits of the largest squared radius.
pub fn max_radius2(points: &[Disc]) -> u32 {
    radii2(points).into_iter().fold(0.0, f32::max).to_bits()
}

/// Photons of these weights in units of 2^28: 1, 2, 1/2.
pub fn records(photons: &[Disc]) -> Vec<PhotonRecord> {
    let record = |photon: &Disc| PhotonRecord {
        position: photon.position,
        normal: photon.normal,
        weight: [1.0, 2.0, 0.5],
        cell: 0,
    };
    photons.iter().map(record).collect()
}

/// The sums of some pixels.
pub struct Flux {
    pub red: Buffer<u32>,
    pub green: Buffer<u32>,
    pub blue: Buffer<u32>,
    pub counts: Buffer<u32>,
    pub counters: Buffer<Counters>,
}

impl Flux {
    pub fn new(fixture: &Fixture, pixels: usize) -> Self {
        Self::of(fixture, [(); 3].map(|()| vec![[0; 2]; pixels]))
    }

    /// With room for the photons on the inner halves of discs.
    pub fn with_inner(fixture: &Fixture, pixels: usize) -> Self {
        Self { counts: fixture.upload(&vec![0; 2 * pixels]), ..Self::new(fixture, pixels) }
    }

    /// Of these low and high words by channel, and no photons yet.
    pub fn of(fixture: &Fixture, channels: [Vec<[u32; 2]>; 3]) -> Self {
        let counts = fixture.upload(&vec![0; channels[0].len()]);
        let [red, green, blue] = channels.map(|words| fixture.upload(words.as_flattened()));
        Self { red, green, blue, counts, counters: fixture.upload(&[Counters::zeroed()]) }
    }

    /// The sums of each channel.
    pub fn sums(&self, fixture: &Fixture) -> [Vec<u64>; 3] {
        let sum = |words: &[u32]| u64::from(words[1]) << 32 | u64::from(words[0]);
        [&self.red, &self.green, &self.blue].map(|words| fixture.read(words).chunks_exact(2).map(sum).collect())
    }

    /// Dispatches until no invocation is unfinished; how often that was.
    pub fn add_all(&self, fixture: &Fixture, dispatch: impl Fn(&mut Frame<'_>, u32)) -> u32 {
        for dispatches in 0.. {
            let mut frame = fixture.device().frame().expect("a frame");
            frame.clear(&self.counters);
            dispatch(&mut frame, dispatches.min(1));
            frame.run().expect("a run");
            let counted = fixture.read(&self.counters)[0];
            assert_eq!((counted.interrupted, counted.saturated), (0, 0));
            if counted.unfinished == 0 {
                return dispatches + 1;
            }
        }
        unreachable!("a u32 has an end, but no dispatch goes on so long")
    }

    /// Photons of each point, whose flux must be theirs.
    pub fn counts(&self, fixture: &Fixture) -> Vec<u32> {
        let (sums, counts) = (self.sums(fixture), fixture.read(&self.counts));
        let counts: Vec<u32> = counts.into_iter().step_by(self.counts.len() as usize / sums[0].len()).collect();
        for (point, count) in counts.iter().enumerate() {
            let unit = u64::from(*count) << 28;
            assert_eq!(sums.each_ref().map(|sums| sums[point]), [unit, 2 * unit, unit / 2], "flux of point {point}");
        }
        counts
    }

    /// Photons on the inner half of each point's disc.
    pub fn inner(&self, fixture: &Fixture) -> Vec<u32> {
        fixture.read(&self.counts).into_iter().skip(1).step_by(2).collect()
    }
}

/// What kernels are for radii from the data: they count photons on the inner halves of discs.
pub fn with_data_radii() -> Specialization {
    let declared = Specialization::DECLARED;
    Specialization { render: RenderFeatures { has_data_radii: true, ..declared.render }, ..declared }
}

/// The octahedral map of `shaders/include/geometry/normal.glsl` in f64.
fn unpack_normal(packed: u32) -> DVec3 {
    let snorm = |bits: u32| (f64::from(bits as u16 as i16) / 32767.0).max(-1.0);
    let (x, y) = (snorm(packed), snorm(packed >> 16));
    let z = 1.0 - x.abs() - y.abs();
    let fold = |a: f64, b: f64| (1.0 - b.abs()) * if a >= 0.0 { 1.0 } else { -1.0 };
    let (x, y) = if z < 0.0 { (fold(x, y), fold(y, x)) } else { (x, y) };
    DVec3::new(x, y, z).normalize()
}

/// How many photons are on the point's disc and within a share of its radius, at least and at most: those within a
/// part in a million of an edge may go either way.
fn count_all(point: &Disc, photons: &[Disc], share: f64) -> [u32; 2] {
    const EDGE: f64 = 1e-6;
    let (p, n, radius) = (double(point.position), unpack_normal(point.normal), f64::from(point.radius));
    let inside_by = |photon: &Disc| {
        let d = double(photon.position) - p;
        let within = share - d.length() / radius;
        let flat = 0.25 - d.dot(n).abs() / radius;
        within.min(flat).min(n.dot(unpack_normal(photon.normal)) - 0.5)
    };
    let count = |edge: f64| photons.iter().filter(|photon| inside_by(photon) > edge).count() as u32;
    if point.radius == 0.0 { [0, 0] } else { [count(EDGE), count(-EDGE)] }
}

pub fn assert_counts(points: &[Disc], photons: &[Disc], counts: &[u32]) {
    assert_counts_within(points, photons, counts, 1.0);
}

/// The same for photons within a share of the radius.
pub fn assert_counts_within(points: &[Disc], photons: &[Disc], counts: &[u32], share: f64) {
    let (mut fewest, mut most) = (0, 0);
    for (index, (point, count)) in points.iter().zip(counts).enumerate() {
        let [least, greatest] = count_all(point, photons, share);
        assert!((least..=greatest).contains(count), "point {index} has {count} photons of {least} to {greatest}");
        (fewest, most) = (fewest + least, most + greatest);
    }
    assert!(fewest > 0 && most - fewest <= 2 + fewest / 1000, "{fewest} to {most} pairs");
}

/// On the walls of a room and inside it; a tenth is no point at all.
pub fn scattered(rng: &mut Rng, count: usize, radii: [f64; 2]) -> Vec<Disc> {
    let disc = |rng: &mut Rng| {
        let mut place = rng.cube(1.0);
        let flat = rng.below(4);
        if flat < 3 {
            place[flat] = [-1.0, 1.0][rng.below(2)];
        }
        let radius = if rng.chance(0.1) { 0.0 } else { rng.log_range(radii[0], radii[1]) as f32 };
        // Normals of a wall are alike, or nothing would be on a disc.
        let normal = if rng.chance(0.5) { 0x1000_2000 } else { rng.bits() as u32 };
        Disc { position: place.as_vec3().to_array(), normal, radius }
    };
    (0..count).map(|_| disc(rng)).collect()
}
