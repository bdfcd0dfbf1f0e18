//! `Shape "bilinearmesh"`: bilinear patches between four corners, converted to meshes.
//!
//! A parallelogram is two triangles. If a patch is twisted, all patches of the mesh become grids as fine as
//! the most twisted one needs, so that there are no gaps between neighbours; the patch's own normals are
//! shading normals.

use glam::{DVec2, DVec3};

use crate::base::input::{Budget, OverBudget};
use crate::scene::directives::shape::{attributes, check_copies, faces, no_indices, positions};
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::params::ParamList;
use crate::scene::model::Mesh;

/// Maximum distance of a grid from its patch, in diagonals of the patch, unless the grid needs more than
/// [`MOST_CELLS`] cells.
const TOLERANCE: f64 = 2e-4;
/// Maximum number of cells of a patch along each side.
const MOST_CELLS: u32 = 32;
/// A patch with a smaller twist, in diagonals of the patch, is a parallelogram except for rounding.
const STRAIGHT: f64 = 1e-9;

pub(in crate::scene) fn mesh(params: &ParamList, budget: &Budget, location: &Location) -> Result<Mesh, SceneError> {
    check_copies(params, budget, location)?;
    let positions = positions("bilinearmesh", params, location)?;
    let patches = match params.get("indices") {
        Some(indices) => faces::<4>(indices, positions.len())?,
        None if positions.len() == 4 => vec![[0, 1, 2, 3]],
        None => return Err(no_indices("bilinearmesh", positions.len(), location)),
    };
    let (normals, uvs) = attributes(params, positions.len())?;
    let corners = |patch: &[u32; 4]| patch.map(|corner| positions[corner as usize]);
    let cells = patches.iter().map(|patch| cells(&corners(patch))).max().unwrap_or(1);
    let has_normals = cells > 1 || !normals.is_empty();
    let mut grid = room(patches.len(), cells, has_normals, budget).map_err(|over| {
        let what = format!("{} patches of {cells}x{cells} cells, for the most twisted of them, are", patches.len());
        location.too_large(&format!("{what} "), over)
    })?;
    for patch in &patches {
        let corner_uvs = if uvs.is_empty() {
            [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE]
        } else {
            patch.map(|corner| uvs[corner as usize])
        };
        let corner_normals = (!normals.is_empty())
            .then(|| patch.map(|corner| normals[corner as usize]))
            .filter(|normals| normals.iter().all(|normal| normal.is_finite()));
        add_grid(&mut grid, cells, patch, &corners(patch), (!normals.is_empty(), corner_normals), corner_uvs);
    }
    Ok(grid)
}

/// Returns an empty mesh with capacity for grids; fails if the budget has no memory for it.
fn room(patches: usize, cells: u32, has_normals: bool, budget: &Budget) -> Result<Mesh, OverBudget> {
    let cells = cells as usize;
    let vertices = patches * (cells + 1) * (cells + 1);
    let triangles = 2 * patches * cells * cells;
    let normals = if has_normals { vertices } else { 0 };
    let sizes =
        [(vertices + normals) * size_of::<DVec3>(), vertices * size_of::<DVec2>(), triangles * size_of::<[u32; 3]>()];
    budget.check(sizes.iter().sum::<usize>() as u64)?;
    Ok(Mesh {
        positions: Vec::with_capacity(vertices),
        normals: Vec::with_capacity(normals),
        uvs: Vec::with_capacity(vertices),
        triangles: Vec::with_capacity(triangles),
    })
}

/// Returns the deviation of a patch from a parallelogram. Corners are p00, p10, p01, p11.
fn twist([p00, p10, p01, p11]: &[DVec3; 4]) -> DVec3 {
    (*p11 - *p10) - (*p01 - *p00)
}

/// Returns the number of cells along each side of a patch. The distance of a cell's two triangles from the
/// patch is a quarter of the cell's twist, which is the patch's twist divided by the number of cells.
fn cells(corners: &[DVec3; 4]) -> u32 {
    let [p00, p10, p01, p11] = corners;
    let diagonal = p00.distance(*p11).max(p10.distance(*p01));
    let twist = twist(corners).length() / diagonal;
    if twist.is_nan() || twist <= STRAIGHT {
        return 1;
    }
    let least = (0.25 * twist / TOLERANCE).sqrt().ceil().min(f64::from(MOST_CELLS));
    // Neighbours in other meshes fit if one number of cells divides the other.
    (least as u32).next_power_of_two().max(2)
}

fn add_grid(
    mesh: &mut Mesh,
    cells: u32,
    patch: &[u32; 4],
    corners: &[DVec3; 4],
    // Whether the mesh has normals, and the normals of the patch.
    (has_normals, normals): (bool, Option<[DVec3; 4]>),
    uvs: [DVec2; 4],
) {
    let first = mesh.positions.len() as u32;
    let [p00, p10, p01, _] = *corners;
    for j in 0..=cells {
        for i in 0..=cells {
            let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(cells));
            let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
            mesh.positions.push(point(patch, corners, weights));
            mesh.uvs.push((0..4).map(|corner| weights[corner] * uvs[corner]).sum());
            if let Some(normals) = &normals {
                mesh.normals.push((0..4).map(|corner| weights[corner] * normals[corner]).sum());
            } else if cells > 1 {
                let twist = twist(corners);
                mesh.normals.push((p10 - p00 + v * twist).cross(p01 - p00 + u * twist));
            } else if has_normals {
                mesh.normals.push(DVec3::NAN);
            }
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let a = first + j * (cells + 1) + i;
            let [b, c, d] = [a + 1, a + cells + 2, a + cells + 1];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
}

/// Returns a weighted sum of corners. Corners of an edge are added in the order of the mesh's vertices, so
/// that the patch on the other side has the same points to the bit.
fn point(patch: &[u32; 4], corners: &[DVec3; 4], weights: [f64; 4]) -> DVec3 {
    let mut order = [0, 1, 2, 3];
    order.sort_by_key(|corner| patch[*corner]);
    order.into_iter().filter(|corner| weights[*corner] > 0.0).map(|corner| weights[corner] * corners[corner]).sum()
}
