//! tree_fill and accumulate_tree: photons find exactly the points that a search of all finds.

use bytemuck::Zeroable;
use glam::DVec3;
use goblet::kd_tree;
use goblet::kernels::{AccumulateTree, AccumulateTreePush, Counters, GridInfo, Specialization, TreeFill, TreeFillPush};

use crate::bench::{Bench, Rng, double};

/// A point's or a photon's place and packed normal.
struct Disc {
    position: [f32; 3],
    normal: u32,
    radius: f32,
}

/// What came of it.
struct Deposits {
    /// Photons of each point.
    counts: Vec<u32>,
    dispatches: u32,
}

/// Sends photons of weight 1 to points, with `invocations` of them at once.
fn accumulate(points: &[Disc], photons: &[Disc], invocations: u32) -> Deposits {
    let bench = Bench::new();
    let device = bench.device();
    let radius2 = |point: &Disc| point.radius * point.radius;
    let place = |disc: &Disc, w: f32| [disc.position[0], disc.position[1], disc.position[2], w];
    let visible: Vec<_> = points.iter().map(|point| place(point, radius2(point))).collect();
    let nodes = kd_tree::build(&visible);
    let node_count = nodes.len() as u32;
    let max_radius2 = points.iter().map(radius2).fold(0.0, f32::max).to_bits();

    let (tree_positions, tree_owners) = (bench.output(nodes.len()), bench.output(nodes.len()));
    let fill = TreeFill {
        visible_positions: &bench.upload(&visible),
        visible_normals: &bench.upload(&points.iter().map(|point| point.normal).collect::<Vec<_>>()),
        tree_nodes: &bench.upload(&nodes),
        tree_positions: &tree_positions,
        tree_owners: &tree_owners,
    };
    let records: Vec<_> = photons.iter().map(|photon| place(photon, f32::from_bits(photon.normal))).collect();
    let (flux_low, flux_high) =
        (bench.upload(&vec![0_u32; 4 * points.len()]), bench.upload(&vec![0_u32; 4 * points.len()]));
    let counters = bench.upload(&[Counters::zeroed()]);
    let add = AccumulateTree {
        photon_positions: &bench.upload(&records),
        photon_weights: &bench.upload(&vec![[1.0_f32, 2.0, 0.5, 0.0]; photons.len()]),
        grid_info: &bench.upload(&[GridInfo { max_radius2, filled: 0 }]),
        tree_positions: &tree_positions,
        tree_owners: &tree_owners,
        flux_low: &flux_low,
        flux_high: &flux_high,
        counters: &counters,
        places: &bench.output(invocations as usize),
    };
    let fill = device.pass(&fill, &Specialization::default(), 64).expect("a pass");
    let add = device.pass(&add, &Specialization::default(), 64).expect("a pass");
    let recorded = photons.len() as u32;
    let push = |resumed| AccumulateTreePush { recorded, stride: invocations, node_count, resumed, two: 2 };
    let mut frame = device.frame().expect("a frame");
    frame.dispatch(&fill, TreeFillPush { node_count }, node_count.into());
    let mut dispatches = 0;
    loop {
        frame.clear(&counters);
        frame.dispatch(&add, push(dispatches.min(1)), invocations.into());
        frame.run().expect("a run");
        dispatches += 1;
        let counted = bench.read(&counters)[0];
        assert_eq!((counted.interrupted, counted.saturated), (0, 0));
        if counted.unfinished == 0 {
            break;
        }
        frame = device.frame().expect("a frame");
    }
    let (low, high) = (bench.read(&flux_low), bench.read(&flux_high));
    let counts: Vec<u32> = low.chunks_exact(4).map(|words| words[3]).collect();
    for (point, count) in counts.iter().enumerate() {
        let sum = |channel: usize| u64::from(high[4 * point + channel]) << 32 | u64::from(low[4 * point + channel]);
        let unit = u64::from(*count) << 28;
        assert_eq!([sum(0), sum(1), sum(2)], [unit, 2 * unit, unit / 2], "flux of point {point}");
    }
    Deposits { counts, dispatches }
}

/// The octahedral map of `shaders/include/normal.glsl` in f64.
fn unpack_normal(packed: u32) -> DVec3 {
    let snorm = |bits: u32| (f64::from(bits as u16 as i16) / 32767.0).max(-1.0);
    let (x, y) = (snorm(packed), snorm(packed >> 16));
    let z = 1.0 - x.abs() - y.abs();
    let fold = |a: f64, b: f64| (1.0 - b.abs()) * if a >= 0.0 { 1.0 } else { -1.0 };
    let (x, y) = if z < 0.0 { (fold(x, y), fold(y, x)) } else { (x, y) };
    DVec3::new(x, y, z).normalize()
}

/// How many photons are on the point's disc, at least and at most: those within a part in
/// a million of an edge may go either way.
fn count_all(point: &Disc, photons: &[Disc]) -> [u32; 2] {
    const EDGE: f64 = 1e-6;
    let (p, n, radius) = (double(point.position), unpack_normal(point.normal), f64::from(point.radius));
    let inside_by = |photon: &Disc| {
        let d = double(photon.position) - p;
        let within = 1.0 - d.length() / radius;
        let flat = 0.25 - d.dot(n).abs() / radius;
        within.min(flat).min(n.dot(unpack_normal(photon.normal)) - 0.5)
    };
    let count = |edge: f64| photons.iter().filter(|photon| inside_by(photon) > edge).count() as u32;
    if point.radius == 0.0 { [0, 0] } else { [count(EDGE), count(-EDGE)] }
}

fn assert_counts(points: &[Disc], photons: &[Disc], counts: &[u32]) {
    let (mut fewest, mut most) = (0, 0);
    for (index, (point, count)) in points.iter().zip(counts).enumerate() {
        let [least, greatest] = count_all(point, photons);
        assert!((least..=greatest).contains(count), "point {index} has {count} photons of {least} to {greatest}");
        (fewest, most) = (fewest + least, most + greatest);
    }
    assert!(fewest > 0 && most - fewest <= 2 + fewest / 1000, "{fewest} to {most} pairs");
}

/// On the walls of a room and inside it; a tenth is no point at all.
fn scattered(rng: &mut Rng, count: usize, radii: [f64; 2]) -> Vec<Disc> {
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

#[test]
fn photons_find_every_point_that_they_reach() {
    let mut rng = Rng(11);
    for (count, radii) in [(1, [0.5, 2.0]), (2, [0.5, 2.0]), (100, [0.1, 1.0]), (3000, [0.01, 0.3]), (2500, [0.1, 9.0])]
    {
        let mut points = scattered(&mut rng, count, radii);
        // At least one is a point.
        points[0].radius = radii[1] as f32;
        let photons = scattered(&mut rng, 3001, [1.0, 1.0]);
        for invocations in [97, 3001, 4000] {
            assert_counts(&points, &photons, &accumulate(&points, &photons, invocations).counts);
        }
    }
}

/// As at a focus, where every node is in reach of every photon: more of them than a driver
/// lets one invocation go round.
#[test]
fn points_in_one_place_take_many_dispatches() {
    let disc = || Disc { position: [0.3, -0.4, 0.5], normal: 0, radius: 1e-3 };
    let points: Vec<_> = (0..70_001).map(|_| disc()).collect();
    let photons: Vec<_> = (0..48).map(|_| disc()).collect();
    let deposits = accumulate(&points, &photons, 32);
    assert!(deposits.counts.iter().all(|count| *count == 48));
    assert!(deposits.dispatches > 2, "{} dispatches", deposits.dispatches);
}

#[test]
fn nothing_to_find_is_no_work() {
    let mut rng = Rng(12);
    let photons = scattered(&mut rng, 100, [1.0, 1.0]);
    let points = [Disc { position: [0.0; 3], normal: 0, radius: 0.0 }];
    let deposits = accumulate(&points, &photons, 64);
    assert_eq!((deposits.counts[0], deposits.dispatches), (0, 1));
}
