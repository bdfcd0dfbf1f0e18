//! The bodies that a shape consists of, and closed shapes.

use glam::DVec2;

use crate::scene::{Geometry, Mesh, Shape};

/// Returns, for each triangle of a mesh, the smallest index of the vertices that it is connected with.
pub(super) fn connected(mesh: &Mesh) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
        while parents[vertex as usize] != vertex {
            parents[vertex as usize] = parents[parents[vertex as usize] as usize];
            vertex = parents[vertex as usize];
        }
        vertex
    }
    for [a, b, c] in &mesh.triangles {
        for other in [*b, *c] {
            let [x, y] = [*a, other].map(|vertex| root(&mut parents, vertex));
            parents[x.max(y) as usize] = x.min(y);
        }
    }
    mesh.triangles.iter().map(|[a, _, _]| root(&mut parents, *a)).collect()
}

/// Returns true if a shape is closed, so that it hides the surface below it.
pub(super) fn is_closed(shape: &Shape) -> bool {
    match &shape.geometry {
        Geometry::Mesh(mesh) => {
            // A closed mesh has each edge once in each direction.
            let directed = |[a, b, c]: &[u32; 3]| [[*a, *b], [*b, *c], [*c, *a]];
            let mut edges: Vec<[u32; 2]> = mesh.triangles.iter().flat_map(directed).collect();
            let mut backwards: Vec<[u32; 2]> = edges.iter().map(|[from, to]| [*to, *from]).collect();
            edges.sort_unstable();
            backwards.sort_unstable();
            edges == backwards
        }
        Geometry::Sphere { radius, z_min, z_max, phi_max } => {
            *z_min <= -radius && z_max >= radius && *phi_max >= std::f64::consts::TAU
        }
        Geometry::Disk { .. } => false,
        Geometry::Revolution(profile) => {
            let ends = [profile.segments.first(), profile.segments.last()];
            let on_axis = |point: Option<&DVec2>| point.is_some_and(|point| point.x == 0.0);
            on_axis(ends[0].and_then(|segment| segment.points.first()))
                && on_axis(ends[1].and_then(|segment| segment.points.last()))
        }
    }
}
