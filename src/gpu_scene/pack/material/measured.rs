//! The table of a measured material, which `shaders/include/material/measured.glsl` reads.

use crate::scene::{Grid, Measured};

/// Returns the elements of a table: three with the sizes of its parts, then the azimuths and the polar angles of
/// incident directions, and the values of the grids, in the order of the fields of [`Measured`].
pub(in crate::gpu_scene::pack) fn table(measured: &Measured) -> Vec<[u32; 4]> {
    let sides = |grid: &Grid<f32>| [grid.width as u32, grid.height as u32];
    let pair = |[a, b]: [u32; 2], [c, d]: [u32; 2]| [a, b, c, d];
    let mut table = vec![
        pair(sides(&measured.normals), sides(&measured.projected_area)),
        pair(sides(&measured.visible_normals), sides(&measured.luminance)),
        [
            measured.azimuths.len() as u32,
            measured.polar_angles.len() as u32,
            u32::from(measured.is_isotropic()),
            measured.reduction,
        ],
    ];
    for angles in [&measured.azimuths, &measured.polar_angles] {
        table.extend((0..angles.len()).map(|i| node(angles, i)));
    }
    for grid in [&measured.normals, &measured.projected_area] {
        table.extend(corners(grid));
    }
    for grid in [&measured.visible_normals, &measured.luminance] {
        let slices = grid.values.chunks(grid.width * grid.height);
        slices.for_each(|slice| push_distribution(&mut table, grid.width, slice));
    }
    table.extend(measured.colors.values.iter().map(|[r, g, b]| bits([*r, *g, *b, 0.0])));
    table
}

fn bits(values: [f32; 4]) -> [u32; 4] {
    values.map(f32::to_bits)
}

/// Returns the element of an angle: it, and one over the distance to the next one.
fn node(angles: &[f32], i: usize) -> [u32; 4] {
    let step = angles.get(i + 1).map_or(1.0, |next| next - angles[i]);
    bits([angles[i], 1.0 / step, 0.0, 0.0])
}

/// Returns the elements of a grid. Each has the values at the corners of its cell: the place itself, the next in the
/// row, and both in the next row.
fn corners(grid: &Grid<f32>) -> impl Iterator<Item = [u32; 4]> {
    let (right, below) = (grid.width - 1, grid.height - 1);
    let at = move |x: usize, y: usize| grid.values[y.min(below) * grid.width + x.min(right)];
    let cell = move |x, y| bits([at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)]);
    (0..grid.height).flat_map(move |y| (0..grid.width).map(move |x| cell(x, y)))
}

/// Adds the elements of a slice that is a density, bilinear between its values: scaled to an integral of 1 if each
/// cell has an area of 1. Each element has its value, the next one in the row, the integral of the row before the
/// element, and the integral of all rows before its row.
fn push_distribution(table: &mut Vec<[u32; 4]>, width: usize, slice: &[f32]) {
    let along = |row: &[f32]| {
        let mut sum = 0.0;
        let mut sums = vec![0.0];
        for two in row.windows(2) {
            sum += 0.5 * (f64::from(two[0]) + f64::from(two[1]));
            sums.push(sum);
        }
        sums
    };
    let rows: Vec<Vec<f64>> = slice.chunks(width).map(along).collect();
    let totals: Vec<f64> = rows.iter().map(|sums| sums[width - 1]).collect();
    let all: f64 = totals.windows(2).map(|two| 0.5 * (two[0] + two[1])).sum();
    let mut before = 0.0;
    for (y, (row, sums)) in slice.chunks(width).zip(&rows).enumerate() {
        before += y.checked_sub(1).map_or(0.0, |above| 0.5 * (totals[above] + totals[y]));
        for (x, sum) in sums.iter().enumerate() {
            let next = row[(x + 1).min(width - 1)];
            let scaled = [f64::from(row[x]), f64::from(next), *sum, before].map(|value| (value / all) as f32);
            table.push(bits(scaled));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distribution_has_its_integrals() {
        let mut table = Vec::new();
        push_distribution(&mut table, 3, &[1.0, 3.0, 1.0, 0.0, 2.0, 2.0]);
        // Rows of 4 and 3, and so 3.5 in all.
        let expected = [
            [1.0, 3.0, 0.0, 0.0],
            [3.0, 1.0, 2.0, 0.0],
            [1.0, 1.0, 4.0, 0.0],
            [0.0, 2.0, 0.0, 3.5],
            [2.0, 2.0, 1.0, 3.5],
            [2.0, 2.0, 3.0, 3.5],
        ];
        for (element, expected) in table.iter().zip(expected) {
            let found = element.map(|word| f64::from(f32::from_bits(word)) * 3.5);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {expected:?}");
        }
    }

    #[test]
    fn cells_at_the_end_repeat_their_corners() {
        let grid = Grid { width: 2, height: 2, values: vec![1.0, 2.0, 3.0, 4.0] };
        let found: Vec<[f32; 4]> = corners(&grid).map(|element| element.map(f32::from_bits)).collect();
        let expected = [[1.0, 2.0, 3.0, 4.0], [2.0, 2.0, 4.0, 4.0], [3.0, 4.0, 3.0, 4.0], [4.0; 4]];
        assert_eq!(found, expected);
    }
}
