//! grid_* and gather_grid: points find exactly the photons that a search of all finds.

use bytemuck::Zeroable;
use goblet::kernels::{
    Cell, Counters, GatherGrid, GatherGridPush, GridCount, GridExtent, GridFill, GridReserve, GridSize, GridSizePush,
    Specialization,
};

use crate::discs::{self, Disc, Flux, assert_counts, assert_counts_within, scattered};
use crate::fixture::{Fixture, Rng};

/// What came of it.
struct Gathered {
    /// Photons of each point.
    counts: Vec<u32>,
    dispatches: u32,
}

/// Sends photons of weight 1 to the points of an image, by a table of `cells` cells.
fn accumulate(points: &[Disc], width: u32, photons: &[Disc], cells: u32, workgroup_size: u32) -> Gathered {
    let fixture = Fixture::new();
    let flux = Flux::new(&fixture, points.len());
    let sizes = (cells, workgroup_size);
    let dispatches = gather(&fixture, &flux, points, width, photons, sizes, &Specialization::DECLARED);
    Gathered { counts: flux.counts(&fixture), dispatches }
}

/// Adds to the flux, and returns the number of dispatches.
fn gather(
    fixture: &Fixture,
    flux: &Flux,
    points: &[Disc],
    width: u32,
    photons: &[Disc],
    (cells, workgroup_size): (u32, u32),
    specialization: &Specialization,
) -> u32 {
    let device = fixture.device();
    let height = points.len() as u32 / width;
    let recorded = photons.len() as u32;
    let extent = GridExtent { by_photon: [0; 3], recorded, by_cell: [0; 3], cell_mask: cells - 1 };
    let grid_extent = &fixture.upload(&[extent]);
    let records = fixture.upload_texels(&discs::records(photons));
    let max_radius2 = fixture.upload(&[discs::max_radius2(points)]);
    let table = fixture.upload(&vec![Cell { first: 0, count: 0 }; cells as usize]);
    let grid_photons = device.texels("grid_photons", recorded.into()).expect("texels");
    let invocations = u64::from(width.next_multiple_of(8)) * u64::from(height.next_multiple_of(8)) / 2;

    macro_rules! pass {
        ($($kernel:tt)*) => { device.pass(&$($kernel)*, specialization, workgroup_size).expect("a pass") };
    }
    let count = pass!(GridCount { photons: &records, max_radius2: &max_radius2, grid_extent, cells: &table });
    let reserve = pass!(GridReserve { grid_filled: &fixture.upload(&[0_u32]), cells: &table, grid_extent });
    let fill = GridFill {
        photons: &records,
        max_radius2: &max_radius2,
        grid_extent,
        cells: &table,
        grid_photons: &grid_photons,
    };
    let fill = pass!(fill);
    let add = pass!(GatherGrid {
        visible_points: &fixture.upload_texels(&discs::visible(points)),
        visible_radii2: &fixture.upload_texels(&discs::radii2(points)),
        max_radius2: &max_radius2,
        grid_extent,
        cells: &table,
        grid_photons: &grid_photons,
        flux_red: &flux.red,
        flux_green: &flux.green,
        flux_blue: &flux.blue,
        flux_counts: &flux.counts,
        counters: &flux.counters,
        places: &fixture.output(invocations as usize),
    });
    let mut frame = device.frame().expect("a frame");
    frame.dispatch(&count, (), recorded.into());
    frame.dispatch(&reserve, (), cells.into());
    frame.dispatch(&fill, (), recorded.into());
    frame.run().expect("a run");
    let push = |resumed| GatherGridPush { width, height, resumed, offset: 0 };
    flux.add_all(fixture, |frame, resumed| frame.dispatch(&add, push(resumed), invocations))
}

/// Neighbouring pixels see points all over a room, of many sizes, and cells share a table that
/// is far too small or has room for all.
#[test]
fn points_find_every_photon_that_is_in_reach() {
    let mut rng = Rng(21);
    for (width, count, radii) in
        [(1, 1, [0.5, 2.0]), (2, 2, [0.5, 2.0]), (10, 100, [0.1, 1.0]), (50, 3000, [0.01, 0.3])]
    {
        let mut points = scattered(&mut rng, count, radii);
        // At least one is a point.
        points[0].radius = radii[1] as f32;
        let photons = scattered(&mut rng, 3001, [1.0, 1.0]);
        for (cells, workgroup_size) in [(1, 64), (64, 32), (4096, 64), (4096, 128)] {
            assert_counts(&points, &photons, &accumulate(&points, width, &photons, cells, workgroup_size).counts);
        }
    }
}

#[test]
fn photons_on_inner_halves_are_counted() {
    let mut rng = Rng(23);
    let [points, photons] =
        [(900, [0.05, 0.5]), (3001, [1.0, 1.0])].map(|(count, radii)| scattered(&mut rng, count, radii));
    let fixture = Fixture::new();
    let flux = Flux::with_inner(&fixture, points.len());
    gather(&fixture, &flux, &points, 30, &photons, (4096, 64), &discs::with_data_radii());
    assert_counts(&points, &photons, &flux.counts(&fixture));
    assert_counts_within(&points, &photons, &flux.inner(&fixture), 0.5_f64.sqrt());
}

/// As at a focus, where all points have all photons: more than a driver lets one invocation go
/// round.
#[test]
fn photons_in_one_place_take_many_dispatches() {
    let disc = || Disc { position: [0.3, -0.4, 0.5], normal: 0, radius: 1e-3 };
    let points: Vec<_> = (0..48).map(|_| disc()).collect();
    let photons: Vec<_> = (0..120_001).map(|_| disc()).collect();
    let gathered = accumulate(&points, 8, &photons, 1 << 17, 64);
    assert!(gathered.counts.iter().all(|count| *count == 120_001));
    assert!(gathered.dispatches > 2, "{} dispatches", gathered.dispatches);
}

#[test]
fn nothing_to_find_is_no_work() {
    let mut rng = Rng(22);
    let photons = scattered(&mut rng, 100, [1.0, 1.0]);
    let points = [Disc { position: [0.0; 3], normal: 0, radius: 0.0 }];
    let gathered = accumulate(&points, 1, &photons, 128, 64);
    assert_eq!((gathered.counts[0], gathered.dispatches), (0, 1));
}

/// The kernels of the grid run for every photon and every cell, however many there are, and for none if there was no
/// room for all.
#[test]
fn dispatches_have_an_invocation_for_each_photon_and_cell() {
    let fixture = Fixture::new();
    for workgroup_size in [32, 64, 128] {
        for recorded in [0, 1, 2, 3, 64, 65, 4096, 4097, 65_535 * 32, 65_535 * 32 + 1, 65_535 * 128 + 1, 1 << 24] {
            let counters = fixture.upload(&[Counters { recorded, ..Counters::zeroed() }]);
            let grid_extent = fixture.output::<GridExtent>(1);
            let max_radius2 = &fixture.output::<u32>(1);
            let pass = GridSize { counters: &counters, grid_extent: &grid_extent, max_radius2 };
            let pass = fixture.device().pass(&pass, &Specialization::DECLARED, workgroup_size).expect("a pass");
            for (capacity, found) in [(recorded, recorded), (recorded.wrapping_sub(1), recorded), (u32::MAX, recorded)]
            {
                let found = if found > capacity { 0 } else { found };
                let mut frame = fixture.device().frame().expect("a frame");
                frame.dispatch(&pass, GridSizePush { capacity, radius2: 0.0 }, 1);
                frame.run().expect("a run");
                let extent = fixture.read(&grid_extent)[0];
                let cells = found.next_power_of_two();
                assert_eq!((extent.recorded, extent.cell_mask), (found, cells - 1), "{recorded} of {capacity}");
                for (groups, elements) in [(extent.by_photon, found), (extent.by_cell, cells)] {
                    let invocations = groups.map(u64::from).iter().product::<u64>() * u64::from(workgroup_size);
                    let spare = invocations - u64::from(elements);
                    let row = u64::from(groups[1].max(1)) * u64::from(workgroup_size);
                    assert!(spare < row && groups.iter().all(|count| *count <= 65_535), "{groups:?} for {elements}");
                }
            }
        }
    }
}
