//! What a pixel keeps between iterations: its sums and its radius, over a million of them.

use bytemuck::Zeroable;
use goblet::kernels::{Counters, PixelState, Specialization, Update, UpdatePush};

use crate::discs::Flux;
use crate::fixture::{Fixture, Rng};
use crate::generated::{PixelState as State, Simulate};
use crate::sum::{Sum, number, to_term, words};

/// Iterations of a pixel, which are repeated, and those of one dispatch; as in simulate.comp.
const PERIOD: usize = 2500;
const ROUNDS: usize = 62_500;
const DISPATCHES: usize = 16;

/// What happens to a pixel in an iteration.
#[derive(Clone, Copy)]
struct Iteration {
    photons: u32,
    /// In the unit of the sums.
    radiance: f32,
}

/// A pixel's life.
struct Life {
    what: String,
    alpha: f32,
    iterations: Vec<Iteration>,
}

/// A share of photons that is kept, and how many there are.
fn lives() -> Vec<Life> {
    let mut rng = Rng(11);
    let mut lives = Vec::new();
    for alpha in [0.3, 0.5, 2.0 / 3.0, 0.9, 1.0_f32] {
        for (what, least, most, chance) in [
            ("none", 0, 0, 0.0),
            ("one now and then", 1, 1, 0.01),
            ("one", 1, 1, 1.0),
            ("123", 123, 123, 1.0),
            ("0 to 20", 0, 20, 1.0),
            ("10,000", 10_000, 10_000, 1.0),
            ("up to 5 million, half of the time", 1, 5_000_000, 0.5),
        ] {
            let mut photons =
                || if rng.chance(chance) { least + rng.below((most - least + 1) as usize) as u32 } else { 0 };
            let photons: Vec<u32> = (0..PERIOD).map(|_| photons()).collect();
            // Faint, usual and bright; some of it is below a sum's last bit.
            let scale = [1e-18, 1e-9, 1.0, 1e6, 1e11][rng.below(5)];
            let iterations =
                photons.into_iter().map(|photons| Iteration { photons, radiance: rng.range(0.0, scale) as f32 });
            lives.push(Life {
                what: format!("alpha {alpha}, photons: {what}"),
                alpha,
                iterations: iterations.collect(),
            });
        }
    }
    lives
}

/// The squared radius over the first, by Hachisuka and Jensen 2009, eq. 6 and 7, in f64.
struct Shrink {
    kept: f64,
    value: f64,
}

impl Shrink {
    fn live(&mut self, life: &Life) {
        let alpha = f64::from(life.alpha);
        for photons in life.iterations.iter().map(|iteration| f64::from(iteration.photons)).filter(|it| *it > 0.0) {
            let kept = self.kept + alpha * photons;
            self.value *= kept / (self.kept + photons);
            self.kept = kept;
        }
    }
}

/// The sum is that of all terms, to the last bit, so that the mean is off by half a bit of a
/// term at most. The radius is off by a few roundings, not by some for each iteration.
#[test]
fn a_million_iterations_drift_by_nothing() {
    let lives = lives();
    let fixture = Fixture::new();
    let iteration = |it: &Iteration| [it.photons, it.radiance.to_bits(), 0, 0];
    let iterations: Vec<[u32; 4]> = lives.iter().flat_map(|life| life.iterations.iter().map(iteration)).collect();
    let iterations = fixture.upload_texels(&iterations);
    let alphas = fixture.upload(&lives.iter().map(|life| life.alpha).collect::<Vec<_>>());
    let state = State { found_low: 0, found_high: 0, shrink: 1.0, rest: 0.0 };
    let states = fixture.upload_texels(&vec![state; lives.len()]);
    let sums = fixture.upload_texels(&vec![[0_u32; 4]; lives.len()]);
    let kernel = Simulate { iterations: &iterations, alphas: &alphas, states: &states, sums: &sums };

    let mut shrinks: Vec<Shrink> = lives.iter().map(|_| Shrink { kept: 0.0, value: 1.0 }).collect();
    let mut largest = 0.0_f64;
    for dispatch in 1..=DISPATCHES {
        fixture.run(&kernel, lives.len());
        let (states, sums) = (fixture.read_texels(&states), fixture.read_texels(&sums));
        for (((life, shrink), state), sum) in lives.iter().zip(&mut shrinks).zip(states).zip(sums) {
            (0..ROUNDS / PERIOD).for_each(|_| shrink.live(life));
            let drift = (f64::from(state.shrink) / shrink.value).sqrt() - 1.0;
            assert!(
                drift.abs() < 2e-6,
                "{}: the radius is off by {drift:e} after {} iterations",
                life.what,
                dispatch * ROUNDS
            );

            let repeats = (dispatch * ROUNDS / PERIOD) as u128;
            let expected = repeats * life.iterations.iter().map(|it| to_term(it.radiance)).sum::<u128>();
            assert_eq!(number(sum), expected, "{}", life.what);
            largest = largest.max(drift.abs());
        }
    }
    println!("after {} iterations, radii are off by a part of {largest:.1e} at most", DISPATCHES * ROUNDS);
}

/// One pixel with a photon, whose throughput has this in its red channel.
fn update(throughput: f32) -> (Sum, Counters) {
    update_after(Counters::zeroed(), throughput)
}

/// The same after passes that have counted something.
fn update_after(before: Counters, throughput: f32) -> (Sum, Counters) {
    let ([red, _], counters) = sums_after(before, throughput);
    (red, counters)
}

/// The same, with the sum of the second half's luminance, which is twice the red.
fn sums_after(before: Counters, throughput: f32) -> ([Sum; 2], Counters) {
    let fixture = Fixture::new();
    let flux = Flux::of(&fixture, [(); 3].map(|()| vec![[1 << 28, 0]]));
    fixture.device().write(&flux.counts, &[1]).expect("an upload");
    let sums = fixture.upload_group::<_, 4>(&[[0_u32; 4]]);
    let kernel = Update {
        visible_radii2: &fixture.upload_texels(&[0.01_f32]),
        visible_throughputs: &fixture.upload_texels(&[[throughput, 1.0, 1.0, 1.0]]),
        visible_radiances: &fixture.upload_texels(&[[0.0_f32; 4]]),
        pixel_states: &fixture.upload_texels(&[PixelState { found_low: 0, found_high: 0, shrink: 1.0, rest: 0.0 }]),
        sum_red: &sums[0],
        sum_green: &sums[1],
        sum_blue: &sums[2],
        sum_second: &sums[3],
        counters: &flux.counters,
        flux_red: &flux.red,
        flux_green: &flux.green,
        flux_blue: &flux.blue,
        flux_counts: &flux.counts,
    };
    let pass = fixture.device().pass(&kernel, &Specialization::DECLARED, 64).expect("a pass");
    let push = UpdatePush {
        luminance: [2.0, 0.0, 0.0],
        pixel_count: 1,
        alpha: 0.5,
        per_unit: 1.0,
        flux_scale: 0.01,
        half_of_rounds: 1,
        capacity: 7,
        rough_scale: 0.0,
        kept: 1.0,
        pad0: 0,
    };
    fixture.device().write(&flux.counters, &[before]).expect("counters");
    let mut frame = fixture.device().frame().expect("a frame");
    frame.dispatch(&pass, push, 1);
    frame.run().expect("a run");
    ([0, 3].map(|sum| fixture.read_texels(&sums[sum])[0]), fixture.read(&flux.counters)[0])
}

#[test]
fn what_is_not_a_number_is_dropped_and_what_is_too_bright_is_cut() {
    let (sum, counters) = update(3.0);
    assert_eq!((number(sum), counters.non_finite, counters.saturated), (3 << 56, 0, 0));
    let (sum, counters) = update(f32::NAN);
    assert_eq!((sum, counters.non_finite, counters.saturated), (words(0), 1, 0));
    for bright in [1e12, f32::INFINITY] {
        let (sum, counters) = update(bright);
        assert_eq!((number(sum), counters.non_finite, counters.saturated), (to_term(549_755_781_120.0), 0, 1));
    }
}

/// A white balance can give weights that add up to more than 1.
#[test]
fn a_luminance_that_is_too_bright_is_cut_too() {
    for (red, luminance) in [(3.0, 6.0), (549_755_781_120.0, 549_755_781_120.0), (1e12, 549_755_781_120.0)] {
        let ([_, second], _) = sums_after(Counters::zeroed(), red);
        assert_eq!(number(second), to_term(luminance), "{red}");
    }
}

/// In one submission, the passes before have counted; if one of them has not done all, the iteration is run again.
#[test]
fn an_iteration_that_is_not_complete_is_not_added() {
    let none = Counters::zeroed();
    let (sum, counters) = update_after(Counters { recorded: 7, ..none }, 3.0);
    assert_eq!((number(sum), counters.recorded), (3 << 56, 7));
    for before in
        [Counters { recorded: 8, ..none }, Counters { interrupted: 1, ..none }, Counters { unfinished: 1, ..none }]
    {
        assert_eq!(update_after(before, 3.0), (words(0), before));
    }
}
