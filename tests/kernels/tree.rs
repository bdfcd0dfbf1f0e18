//! tree_fill and gather_tree: photons find exactly the points that a search of all finds.

use goblet::kernels::{GatherTree, GatherTreePush, Specialization, TreeFill, TreeFillPush};
use goblet::render::lookup::kd_tree;

use crate::discs::{self, Disc, Flux, assert_counts, assert_counts_within, scattered};
use crate::fixture::{Fixture, Rng};

/// What came of it.
struct Deposits {
    /// Photons of each point.
    counts: Vec<u32>,
    dispatches: u32,
}

/// Sends photons of weight 1 to points, with `invocations` of them at once.
fn accumulate(points: &[Disc], photons: &[Disc], invocations: u32) -> Deposits {
    let fixture = Fixture::new();
    let flux = Flux::new(&fixture, points.len());
    let dispatches = deposit(&fixture, &flux, points, photons, invocations, &Specialization::DECLARED);
    Deposits { counts: flux.counts(&fixture), dispatches }
}

/// Adds to the flux, and returns the number of dispatches.
fn deposit(
    fixture: &Fixture,
    flux: &Flux,
    points: &[Disc],
    photons: &[Disc],
    invocations: u32,
    specialization: &Specialization,
) -> u32 {
    let device = fixture.device();
    let radii2 = discs::radii2(points);
    let nodes = kd_tree::build(points.iter().map(|point| point.position).zip(radii2.iter().copied()));
    let node_count = nodes.len() as u32;

    let tree_points = device.texels("tree_points", nodes.len() as u64).expect("texels");
    let fill = TreeFill {
        visible_points: &fixture.upload_texels(&discs::visible(points)),
        visible_radii2: &fixture.upload_texels(&radii2),
        tree_nodes: &fixture.upload(&nodes),
        tree_points: &tree_points,
    };
    let add = GatherTree {
        photons: &fixture.upload_texels(&discs::records(photons)),
        max_radius2: &fixture.upload(&[discs::max_radius2(points)]),
        tree_points: &tree_points,
        flux_red: &flux.red,
        flux_green: &flux.green,
        flux_blue: &flux.blue,
        flux_counts: &flux.counts,
        counters: &flux.counters,
        places: &fixture.output(invocations as usize),
    };
    let fill = device.pass(&fill, &Specialization::DECLARED, 64).expect("a pass");
    let add = device.pass(&add, specialization, 64).expect("a pass");
    let recorded = photons.len() as u32;
    let push = |resumed| GatherTreePush { recorded, stride: invocations, node_count, resumed, offset: 0 };
    let mut frame = device.frame().expect("a frame");
    frame.dispatch(&fill, TreeFillPush { node_count }, node_count.into());
    frame.run().expect("a run");
    flux.add_all(fixture, |frame, resumed| frame.dispatch(&add, push(resumed), invocations.into()))
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

#[test]
fn photons_on_inner_halves_are_counted() {
    let mut rng = Rng(13);
    let [points, photons] =
        [(900, [0.05, 0.5]), (3001, [1.0, 1.0])].map(|(count, radii)| scattered(&mut rng, count, radii));
    let fixture = Fixture::new();
    let flux = Flux::with_inner(&fixture, points.len());
    deposit(&fixture, &flux, &points, &photons, 3001, &discs::with_data_radii());
    assert_counts(&points, &photons, &flux.counts(&fixture));
    assert_counts_within(&points, &photons, &flux.inner(&fixture), 0.5_f64.sqrt());
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
