//! accumulate_grid goes on where it had to stop, however its lanes take turns.

use bytemuck::Zeroable;
use goblet::kernels::{AccumulateGrid, AccumulateGridPush, Cell, Counters, GridInfo, Specialization};

use crate::bench::Bench;

/// Invocations that llvmpipe runs in lockstep.
const LANES: u32 = 8;
const CELLS: u32 = 1 << 16;
const RADIUS2: f32 = 0.01;

/// `cell_of` and `cell_hash` of `shaders/include/grid.glsl`, for a point with three equal
/// coordinates.
fn cell_of_diagonal(x: f32) -> u32 {
    let cell = (x / (2.0 * RADIUS2.sqrt())).floor() as i32 as u32;
    let mut h = cell.wrapping_mul(73_856_093) ^ cell.wrapping_mul(19_349_663) ^ cell.wrapping_mul(83_492_791);
    h ^= h >> 15;
    h = h.wrapping_mul(0x2c1b_3c6d);
    (h ^ (h >> 12)) & (CELLS - 1)
}

/// Each lane in turn has a photon among many points, while the others' photons meet none:
/// they wait for it, and llvmpipe counts its rounds as theirs too.
#[test]
fn lanes_that_are_busy_in_turn_are_not_ended() {
    const POINTS: u32 = 7900;
    let bench = Bench::new();
    let device = bench.device();
    let (here, far) = (0.3, 90.3);
    let photon = |index: u32| {
        let is_busy = index / LANES == index % LANES;
        let x = if is_busy { here } else { far };
        [x, x, x, 0.0_f32]
    };
    let recorded = LANES * LANES;
    let photons: Vec<_> = (0..recorded).map(photon).collect();
    let mut cells = vec![Cell::zeroed(); CELLS as usize];
    cells[cell_of_diagonal(here) as usize] = Cell { first: 0, count: POINTS };
    let owners: Vec<[u32; 2]> = (0..POINTS).map(|pixel| [0, pixel]).collect();
    let (low, high) = (vec![0_u32; 4 * POINTS as usize], vec![0_u32; 4 * POINTS as usize]);
    let (flux_low, counters) = (bench.upload(&low), bench.upload(&[Counters::zeroed()]));
    let kernel = AccumulateGrid {
        photon_positions: &bench.upload(&photons),
        photon_weights: &bench.upload(&vec![[1.0_f32; 4]; photons.len()]),
        grid_info: &bench.upload(&[GridInfo { max_radius2: RADIUS2.to_bits(), filled: POINTS }]),
        cells: &bench.upload(&cells),
        grid_positions: &bench.upload(&vec![[here, here, here, RADIUS2]; POINTS as usize]),
        grid_owners: &bench.upload(&owners),
        flux_low: &flux_low,
        flux_high: &bench.upload(&high),
        counters: &counters,
        places: &bench.output(LANES as usize),
    };
    let pass = device.pass(&kernel, &Specialization::default(), 64).expect("a pass");
    // Each dispatch lets a lane meet 4000 points.
    for resumed in [0, 1, 1, 1] {
        let push = AccumulateGridPush { recorded, stride: LANES, cell_mask: CELLS - 1, resumed, two: 2 };
        let mut frame = device.frame().expect("a frame");
        frame.clear(&counters);
        frame.dispatch(&pass, push, LANES.into());
        frame.run().expect("a run");
        assert_eq!(bench.read(&counters)[0].interrupted, 0);
    }
    assert_eq!(bench.read(&counters)[0].unfinished, 0);
    assert!(bench.read(&flux_low).chunks_exact(4).all(|words| words[3] == LANES));
}
