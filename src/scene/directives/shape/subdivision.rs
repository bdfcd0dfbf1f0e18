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

/// pbrt's default.
const LEVELS: u32 = 3;
/// More would not fit for any mesh.
const MOST_LEVELS: u32 = 16;

/// No half-edge: the other side of the surface's boundary.
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

/// How large a surface is.
struct Size {
    vertices: u64,
    triangles: u64,
}

impl Size {
    /// Bytes that it takes at most: as its limit is found, or as a mesh on the device.
    fn bytes(&self) -> u64 {
        let vectors = self.vertices * size_of::<DVec3>() as u64;
        let faces = self.triangles * size_of::<[u32; 3]>() as u64;
        let leaving = self.vertices * size_of::<u32>() as u64;
        // Faces and twins are alike; positions, and new ones or normals beside them.
        let limit = 2 * vectors + 2 * faces + leaving;
        limit.max(2 * vectors + faces + self.triangles * 2 * PACKED_TRIANGLE)
    }
}

/// A triangle mesh whose faces know their neighbours.
struct Surface {
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    /// Of each half-edge, the one that leads back in the next face, or [`NONE`].
    twins: Vec<u32>,
    /// Of each vertex, some half-edge that leaves it; [`NONE`] where no face has it.
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

    /// Its size after so many levels: a vertex more for each edge.
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

    /// The next half-edge that leaves a vertex, across the one given, or [`NONE`].
    fn turned(&self, half_edge: u32) -> u32 {
        match self.twins[half_edge as usize] {
            NONE => NONE,
            twin => next(twin),
        }
    }

    /// Neighbours of the vertex that a half-edge leaves, and whether it is on the boundary. They
    /// follow each other against the turn of faces, but with it on the boundary: as in pbrt, of
    /// whose normals this makes the sign.
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
        // Back from where the boundary leaves.
        ring.truncate(0);
        ring.push(self.point(next(half_edge)));
        while half_edge != NONE {
            ring.push(self.point(previous(half_edge)));
            half_edge = self.twins[previous(half_edge) as usize];
        }
        true
    }

    /// Weights a vertex and its ring: `inside` is the weight of each neighbour by their number,
    /// `boundary` that of the two on the boundary.
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

    /// Every face in four.
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
            // In the child in the middle.
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
            // Between the child in the middle and that of the next corner.
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

    /// The new vertex on an edge.
    fn middle(&self, half_edge: u32) -> DVec3 {
        let ends = self.point(half_edge) + self.point(next(half_edge));
        match self.twins[half_edge as usize] {
            NONE => 0.5 * ends,
            twin => 0.375 * ends + 0.125 * (self.point(previous(half_edge)) + self.point(previous(twin))),
        }
    }

    /// Vertices where endless refinement takes them, with the limit surface's normals.
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

/// Of each of so many neighbours of a vertex that moves (Warren's, as pbrt has them).
fn neighbour_weight(count: f64) -> f64 {
    if count == 3.0 { 3.0 / 16.0 } else { 3.0 / (8.0 * count) }
}

/// The same of a vertex that moves to its limit.
fn limit_weight(count: f64) -> f64 {
    1.0 / (count + 3.0 / (8.0 * neighbour_weight(count)))
}

/// A normal by two tangents.
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
