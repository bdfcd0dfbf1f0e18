//! Numbers of photons and iterations beyond 32 bits.

use goblet::render::checkpoint::Checkpoint;
use goblet::{ByPass, DirectLight, Options, RadiusSchedule, Renderer, Sampler, Shard};

use super::{Case, advance, energy};
use crate::support;
use crate::support::command::{self, Bench, LIGHT};

const PHOTONS: u64 = 131_076;

/// One iteration of 131,076 photons, whose numbers begin at `index` times that.
fn render(sampler: Sampler, index: u32) -> Renderer {
    let options = Options {
        resolution: Some([64, 48]),
        photons: Some(PHOTONS),
        // So that radii stay.
        alpha: Some(1.0),
        radius_schedule: RadiusSchedule::Global,
        direct: DirectLight::Photons,
        sampler,
        shard: Shard { index, count: 65_536 },
        ..Options::default()
    };
    // Few photons miss.
    let spot = "LightSource \"spot\" \"point3 from\" [ 0 1.5 -1 ] \"point3 to\" [ 0 -1 0.5 ] \"rgb I\" [ 5 5 5 ]";
    let scene = command::scene(LIGHT, spot);
    let mut renderer = Case { scene, ..Case::new("far", options) }.renderer(&support::device());
    advance(&mut renderer, 1);
    renderer
}

/// Iteration 65535 is of the same half of the rounds as the first, its 32767th turn, and has the
/// photons from 2^32 - 4 on. Their low words are those of the first iteration, but for four.
#[test]
fn photons_beyond_32_bits_are_new_ones() {
    for sampler in [Sampler::Pcg, Sampler::Sobol] {
        let [first, far] = [0, 65_535].map(|index| render(sampler, index));
        let [a, b] = [&first, &far].map(|renderer| *renderer.tally());
        assert_eq!((a.emitted, b.emitted, [a.saturated, b.saturated]), (PHOTONS, PHOTONS, [ByPass::default(); 2]));
        // A photon records six times at most.
        assert!(a.recorded.abs_diff(b.recorded) > 48, "{sampler:?}: the same photons again: {a:?} {b:?}");
        let ratio = b.recorded as f64 / a.recorded as f64;
        println!("{sampler:?}: {} and {} records", a.recorded, b.recorded);
        assert!((ratio - 1.0).abs() < 0.02, "{sampler:?}: {ratio} times as many records");
        let [dim, bright] = [&first, &far].map(|renderer| energy(&renderer.resolve().expect("an image")));
        assert!((bright / dim - 1.0).abs() < 0.05, "{sampler:?}: the energy is {bright} and was {dim}");
    }
}

/// A checkpoint with other counts than it has.
fn doctor(bench: &Bench, change: impl FnOnce(&mut Checkpoint)) {
    let path = bench.path("x.checkpoint");
    let mut checkpoint = Checkpoint::read(&path).unwrap();
    change(&mut checkpoint);
    checkpoint.write(&path).unwrap();
}

fn pretend(iterations: u32, photons: u64) -> impl FnOnce(&mut Checkpoint) {
    move |checkpoint| {
        checkpoint.done = [(0, iterations)].into();
        checkpoint.estimate.halves = [iterations.into(), 0];
        checkpoint.tally.emitted = u64::from(iterations) * photons;
    }
}

fn exr_number(bench: &Bench, key: &str) -> f64 {
    let headers = exr::meta::MetaData::read_from_file(bench.path("x.exr"), true).unwrap().headers;
    match headers[0].own_attributes.other[&exr::prelude::Text::from(key)] {
        exr::meta::attribute::AttributeValue::F64(number) => number,
        exr::meta::attribute::AttributeValue::I32(number) => number.into(),
        ref other => panic!("{key} is {other:?}"),
    }
}

#[test]
fn totals_go_on_beyond_32_bits() {
    const PHOTONS: u64 = 65_537;
    let bench = Bench::new();
    let options = ["--quiet", "--photons", "65537", "--checkpoint", "x.checkpoint", "-o", "x.exr"];
    let resume = ["--resume", "x.checkpoint", "--stats", "x.json"];
    bench.rendered(&[&options[..], &["--iterations", "1"]].concat());
    doctor(&bench, pretend(65_535, PHOTONS));
    bench.rendered(&[&options[..], &resume, &["--iterations", "65537"]].concat());

    let total = 65_537 * PHOTONS;
    assert!(total > 1 << 32);
    let stats = bench.json("x.json");
    assert_eq!((stats["photons"].as_u64(), stats["emitted"].as_u64()), (Some(total), Some(total)), "{stats:#}");
    assert_eq!(
        (exr_number(&bench, "goblet.photons"), exr_number(&bench, "goblet.iterations")),
        (total as f64, 65_537.0)
    );
    let merged = bench.run(&["merge", "x.checkpoint", "-o", "x.exr"]);
    assert_eq!((merged.code, exr_number(&bench, "goblet.photons")), (0, total as f64));
}

#[test]
fn the_last_iteration_that_can_be_counted_is_the_last() {
    let bench = Bench::new();
    let options = ["--quiet", "--checkpoint", "x.checkpoint", "-o", "x.exr"];
    bench.rendered(&[&options[..], &["--iterations", "1"]].concat());
    doctor(&bench, pretend(u32::MAX - 1, 500));
    for _ in 0..2 {
        let resume = ["--resume", "x.checkpoint", "--stats", "x.json", "--time", "60"];
        bench.rendered(&[&options[..], &resume].concat());
        let stats = bench.json("x.json");
        assert_eq!(stats["iterations"], u32::MAX);
        assert_eq!(stats["photons"], 500 * u64::from(u32::MAX));
    }
    // The sums of two such shards too.
    let checkpoint = Checkpoint::read(&bench.path("x.checkpoint")).unwrap();
    let [mut a, mut b] = [checkpoint.clone(), checkpoint];
    (a.shards, b.shards) = (2, 2);
    b.done = [(1, u32::MAX)].into();
    a.merge(&b).unwrap();
    assert_eq!(a.estimate.iterations(), 2 * u64::from(u32::MAX));
    a.write(&bench.path("x.checkpoint")).unwrap();
    let run = bench.run(&["merge", "x.checkpoint", "-o", "x.exr"]);
    assert_eq!(run.code, 0, "{run:?}");
    assert_eq!(exr_number(&bench, "goblet.iterations"), 2.0 * f64::from(u32::MAX));
}
