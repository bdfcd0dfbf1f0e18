//! `Shape "loopsubdiv"`: Loop's subdivision surface of a mesh, with the weights of pbrt.
//!
//! Half-edge 3 f + i leads from corner i of face f to the next one. Charles Loop, "Smooth
//! Subdivision Surfaces Based on Triangles", 1987; limits of points and tangents after Hoppe and
//! others, "Piecewise Smooth Surface Reconstruction", SIGGRAPH 1994.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::base::input::Budget;
use crate::scene::directives::shape::{check_copies, faces, no_indices, positions};
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::params::{Param, ParamList};
use crate::scene::model::Mesh;
use crate::scene::model::extent::PACKED_TRIANGLE;

/// pbrt's default number of levels.
const LEVELS: u32 = 3;
/// Maximum number of levels: with more, no mesh would fit in memory.
const MOST_LEVELS: u32 = 16;

/// No half-edge: the other side of an edge on the surface's boundary.
const NONE: u32 = u32::MAX;

pub(in crate::scene) fn mesh(params: &ParamList, budget: &Budget, location: &Location) -> Result<Mesh, SceneError> {
    check_copies(params, budget, location)?;
    let levels = params.integer("levels", 0, MOST_LEVELS)?.unwrap_or(LEVELS);
    let positions = positions("loopsubdiv", params, location)?;
    let param = params.get("indices").ok_or_else(|| no_indices("loopsubdiv", positions.len(), location))?;
    let faces = faces(param, positions.len())?;
    let mut surface = Surface::new(positions, faces, param)?;
    let size = surface.size_after(levels);
    let triangles = size.triangles;
    budget
        .check(size.bytes())
        .map_err(|over| location.too_large(&format!("{levels} levels make {triangles} triangles, which are "), over))?;
    if 3 * triangles > u64::from(NONE) {
        let what = format!("{levels} levels make {triangles} triangles; expected at most {}", NONE / 3);
        return Err(location.invalid(what));
    }
    for _ in 0..levels {
        surface = surface.refined();
    }
    Ok(surface.limit())
}

/// The size of a surface.
struct Size {
    vertices: u64,
    triangles: u64,
}

impl Size {
    /// Returns the maximum number of bytes of the surface: during the computation of its limit, or as a
    /// mesh on the device.
    fn bytes(&self) -> u64 {
        let vectors = self.vertices * size_of::<DVec3>() as u64;
        let faces = self.triangles * size_of::<[u32; 3]>() as u64;
        let leaving = self.vertices * size_of::<u32>() as u64;
        // Faces and twins take the same memory; new positions or normals exist besides positions.
        let limit = 2 * vectors + 2 * faces + leaving;
        limit.max(2 * vectors + faces + self.triangles * 2 * PACKED_TRIANGLE)
    }
}

/// A triangle mesh whose faces know their neighbours.
struct Surface {
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    /// For each half-edge, the opposite one in the neighbouring face, or [`NONE`].
    twins: Vec<u32>,
    /// For each vertex, a half-edge that leaves it; [`NONE`] if no face has the vertex.
    leaving: Vec<u32>,
}

fn next(half_edge: u32) -> u32 {
    half_edge - half_edge % 3 + (half_edge + 1) % 3
}

fn previous(half_edge: u32) -> u32 {
    half_edge - half_edge % 3 + (half_edge + 2) % 3
}

impl Surface {
    fn new(positions: Vec<DVec3>, faces: Vec<[u32; 3]>, param: &Param) -> Result<Self, SceneError> {
        let mut leaving = vec![NONE; positions.len()];
        let mut edges = HashMap::with_capacity(3 * faces.len());
        for (f, face) in faces.iter().enumerate() {
            for i in 0..3 {
                let (from, to) = (face[i], face[(i + 1) % 3]);
                let half_edge = (3 * f + i) as u32;
                leaving[from as usize] = half_edge;
                if from == to {
                    let what =
                        format!("{param} has the vertex {from} twice in face {f}; expected three different ones");
                    return Err(param.location.invalid(what));
                }
                if edges.insert((from, to), half_edge).is_some() {
                    return Err(param.location.invalid(format!(
                        "{param} has two faces with an edge from vertex {from} to {to}, the second is {f}; \
                         expected one at most on either side, turning the same way"
                    )));
                }
            }
        }
        let ends = |h: usize| (faces[h / 3][h % 3], faces[h / 3][(h + 1) % 3]);
        let twin = |h: usize| {
            let (from, to) = ends(h);
            edges.get(&(to, from)).copied().unwrap_or(NONE)
        };
        let twins = (0..3 * faces.len()).map(twin).collect();
        Ok(Self { positions, faces, twins, leaving })
    }

    /// Returns the size after a number of levels: each level adds a vertex per edge.
    fn size_after(&self, levels: u32) -> Size {
        let is_edge = |(h, twin): (usize, &u32)| *twin == NONE || (*twin as usize) < h;
        let mut edges = self.twins.iter().enumerate().filter(|edge| is_edge(*edge)).count() as u64;
        let mut size = Size { vertices: self.positions.len() as u64, triangles: self.faces.len() as u64 };
        for _ in 0..levels {
            size.vertices += edges;
            edges = 2 * edges + 3 * size.triangles;
            size.triangles *= 4;
        }
        size
    }

    fn origin(&self, half_edge: u32) -> u32 {
        self.faces[half_edge as usize / 3][half_edge as usize % 3]
    }

    fn point(&self, half_edge: u32) -> DVec3 {
        self.positions[self.origin(half_edge) as usize]
    }

    /// Returns the next half-edge that leaves the same vertex, across the given one, or [`NONE`].
    fn turned(&self, half_edge: u32) -> u32 {
        match self.twins[half_edge as usize] {
            NONE => NONE,
            twin => next(twin),
        }
    }

    /// Sets `ring` to the neighbours of the vertex that a half-edge leaves, and returns true if the vertex
    /// is on the boundary. Neighbours are in order against the orientation of faces, or with it if the
    /// vertex is on the boundary. This order gives normals the sign that they have in pbrt.
    fn ring(&self, leaving: u32, ring: &mut Vec<DVec3>) -> bool {
        ring.clear();
        let mut half_edge = leaving;
        loop {
            ring.push(self.point(next(half_edge)));
            let turned = self.turned(half_edge);
            if turned == leaving {
                return false;
            }
            if turned == NONE {
                break;
            }
            half_edge = turned;
        }
        // The vertex is on the boundary: the ring is collected again, backwards from the last half-edge.
        ring.truncate(0);
        ring.push(self.point(next(half_edge)));
        while half_edge != NONE {
            ring.push(self.point(previous(half_edge)));
            half_edge = self.twins[previous(half_edge) as usize];
        }
        true
    }

    /// Returns a weighted sum of a vertex and its ring: `inside` maps the number of neighbours to the
    /// weight of each one, `boundary` is the weight of each of the two neighbours on the boundary.
    fn smooth(&self, vertex: usize, ring: &mut Vec<DVec3>, inside: impl Fn(f64) -> f64, boundary: f64) -> DVec3 {
        let p = self.positions[vertex];
        if self.leaving[vertex] == NONE {
            return p;
        }
        if self.ring(self.leaving[vertex], ring) {
            return (1.0 - 2.0 * boundary) * p + boundary * (ring[0] + ring[ring.len() - 1]);
        }
        let count = ring.len() as f64;
        let weight = inside(count);
        (1.0 - count * weight) * p + weight * ring.iter().sum::<DVec3>()
    }

    /// Returns the surface with every face split into four.
    fn refined(&self) -> Self {
        let mut ring = Vec::new();
        let mut positions: Vec<DVec3> =
            (0..self.positions.len()).map(|v| self.smooth(v, &mut ring, neighbour_weight, 0.125)).collect();
        // Corner i of a face stays corner i of its child i.
        let child = |half_edge: u32| 12 * (half_edge / 3) + 4 * (half_edge % 3);
        let mut leaving: Vec<u32> = self.leaving.iter().map(|h| if *h == NONE { NONE } else { child(*h) }).collect();
        let mut middles = vec![NONE; self.twins.len()];
        for h in 0..self.twins.len() as u32 {
            let twin = self.twins[h as usize];
            if twin < h {
                middles[h as usize] = middles[twin as usize];
                continue;
            }
            middles[h as usize] = positions.len() as u32;
            positions.push(self.middle(h));
            // A half-edge of the child in the middle leaves the new vertex.
            leaving.push(12 * (h / 3) + 9 + h % 3);
        }
        let mut faces = Vec::with_capacity(4 * self.faces.len());
        let mut twins = vec![NONE; 12 * self.faces.len()];
        for (f, face) in self.faces.iter().enumerate() {
            let middle = |i: usize| middles[3 * f + i % 3];
            for i in 0..3 {
                let mut child = [0; 3];
                (child[i], child[(i + 1) % 3], child[(i + 2) % 3]) = (face[i], middle(i), middle(i + 2));
                faces.push(child);
            }
            faces.push([middle(0), middle(1), middle(2)]);
            self.link_children(f as u32, &mut twins);
        }
        Self { positions, faces, twins, leaving }
    }

    /// Sets the twins of the half-edges of a face's children.
    fn link_children(&self, face: u32, twins: &mut [u32]) {
        let half_edge = |face: u32, child: u32, i: u32| 12 * face + 3 * (child % 4) + i % 3;
        for i in 0..3 {
            // Link the child in the middle and the child of the next corner.
            let inner = [half_edge(face, 3, i), half_edge(face, (i + 1) % 3, i + 2)];
            twins[inner[0] as usize] = inner[1];
            twins[inner[1] as usize] = inner[0];
            let twin = self.twins[(3 * face + i) as usize];
            if twin != NONE {
                let (other, k) = (twin / 3, twin % 3);
                twins[half_edge(face, i, i) as usize] = half_edge(other, (k + 1) % 3, k);
                twins[half_edge(face, (i + 1) % 3, i) as usize] = half_edge(other, k, k);
            }
        }
    }

    /// Returns the new vertex on an edge.
    fn middle(&self, half_edge: u32) -> DVec3 {
        let ends = self.point(half_edge) + self.point(next(half_edge));
        match self.twins[half_edge as usize] {
            NONE => 0.5 * ends,
            twin => 0.375 * ends + 0.125 * (self.point(previous(half_edge)) + self.point(previous(twin))),
        }
    }

    /// Returns the mesh with vertices moved to their limits, and with the limit surface's normals.
    fn limit(mut self) -> Mesh {
        let mut ring = Vec::new();
        self.positions = (0..self.positions.len()).map(|v| self.smooth(v, &mut ring, limit_weight, 0.2)).collect();
        let normal = |(vertex, leaving): (usize, &u32)| match *leaving {
            NONE => DVec3::ZERO,
            leaving => {
                let on_boundary = self.ring(leaving, &mut ring);
                normal(self.positions[vertex], &ring, on_boundary)
            }
        };
        let normals = self.leaving.iter().enumerate().map(normal).collect();
        Mesh { positions: self.positions, normals, uvs: Vec::new(), triangles: self.faces }
    }
}

/// Returns the weight of each of `count` neighbours of a vertex in a refinement (Warren's weights, as in
/// pbrt).
fn neighbour_weight(count: f64) -> f64 {
    if count == 3.0 { 3.0 / 16.0 } else { 3.0 / (8.0 * count) }
}

/// Returns the weight of each of `count` neighbours of a vertex in its limit position.
fn limit_weight(count: f64) -> f64 {
    1.0 / (count + 3.0 / (8.0 * neighbour_weight(count)))
}

/// Returns a normal as the cross product of two tangents; not of unit length.
fn normal(p: DVec3, ring: &[DVec3], on_boundary: bool) -> DVec3 {
    let last = ring.len() - 1;
    if !on_boundary {
        let step = TAU / ring.len() as f64;
        let along =
            |wave: fn(f64) -> f64| ring.iter().enumerate().map(|(i, q)| wave(step * i as f64) * *q).sum::<DVec3>();
        return along(f64::cos).cross(along(f64::sin));
    }
    let across = match ring {
        [a, b] => *a + *b - 2.0 * p,
        [_, b, _] => *b - p,
        [a, b, c, d] => 2.0 * (*b + *c) - *a - *d - 2.0 * p,
        _ => {
            let step = PI / last as f64;
            let inner = |(i, q): (usize, &DVec3)| (2.0 - 2.0 * step.cos()) * (step * i as f64).sin() * *q;
            let middle: DVec3 = ring.iter().enumerate().take(last).skip(1).map(inner).sum();
            middle - step.sin() * (ring[0] + ring[last])
        }
    };
    (ring[last] - ring[0]).cross(across)
}
