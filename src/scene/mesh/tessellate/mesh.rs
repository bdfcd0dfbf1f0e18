//! Vertices and triangles of a tessellation, and its file. They are computed on demand: the largest mesh
//! takes no more memory than its rings.

use std::f64::consts::TAU;
use std::io::{self, Write};

use glam::{DVec2, DVec3};

use super::{Ring, Tessellation};

/// One vertex, in the body's object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Position.
    pub position: DVec3,
    /// Normal of the true surface; unit length.
    pub normal: DVec3,
    /// Texture coordinates: the angle from the x axis towards the y axis, and the position along the
    /// profile; both in [0, 1].
    pub uv: DVec2,
}

impl Ring {
    fn is_pole(&self) -> bool {
        self.radius <= 0.0
    }

    fn vertices(&self, sectors: u32) -> u32 {
        if self.is_pole() { sectors } else { sectors + 1 }
    }
}

impl Tessellation {
    /// Returns the number of vertices.
    pub fn vertex_count(&self) -> u64 {
        self.strips.iter().flatten().map(|ring| u64::from(ring.vertices(self.sectors))).sum()
    }

    /// Returns the number of triangles.
    pub fn triangle_count(&self) -> u64 {
        let of_band = |band: &[Ring]| if band.iter().any(Ring::is_pole) { 1 } else { 2 };
        let per_sector: u64 = self.strips.iter().flat_map(|strip| strip.windows(2)).map(of_band).sum();
        per_sector * u64::from(self.sectors)
    }

    /// Returns the vertices, ring by ring.
    pub fn vertices(&self) -> impl Iterator<Item = Vertex> {
        let sectors = self.sectors;
        // A step is half a sector. The last corner equals the first one to the bit.
        let azimuth =
            move |step: u32| DVec2::from_angle(TAU * f64::from(step % (2 * sectors)) / f64::from(2 * sectors));
        let azimuths: Vec<DVec2> = (0..=2 * sectors).map(azimuth).collect();
        let side = if self.inside_out { -1.0 } else { 1.0 };
        self.strips.iter().flatten().flat_map(move |ring| {
            // A pole's vertices belong to sectors, so they have the azimuth of the sector's middle.
            let offset = usize::from(ring.is_pole());
            let azimuths: Vec<DVec2> = azimuths[offset..].iter().step_by(2).copied().collect();
            azimuths.into_iter().enumerate().map(move |(i, azimuth)| Vertex {
                position: (azimuth * ring.radius).extend(ring.height),
                normal: (azimuth * ring.normal.x).extend(ring.normal.y) * side,
                uv: DVec2::new((i as f64 + 0.5 * offset as f64) / f64::from(sectors), ring.along),
            })
        })
    }

    /// Returns the triangles as indices of vertices, counterclockwise as seen from outside.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        let mut first = 0;
        let mut bands = Vec::new();
        for strip in &self.strips {
            for (i, ring) in strip.iter().enumerate() {
                let next = first + ring.vertices(self.sectors);
                if let Some(above) = strip.get(i + 1) {
                    bands.push((first, next, ring.is_pole(), above.is_pole()));
                }
                first = next;
            }
        }
        let sectors = self.sectors;
        let of_band = move |(a, b, a_is_pole, b_is_pole): (u32, u32, bool, bool)| {
            let lower = move |i: u32| [a + i, a + i + 1, if b_is_pole { b + i } else { b + i + 1 }];
            let upper = move |i: u32| [a + i, b + i + 1, b + i];
            let of_sector = move |i| [(!a_is_pole).then(|| lower(i)), (!b_is_pole).then(|| upper(i))];
            (0..sectors).flat_map(of_sector).flatten()
        };
        let turn = |[a, b, c]: [u32; 3]| if self.inside_out { [a, c, b] } else { [a, b, c] };
        bands.into_iter().flat_map(of_band).map(turn)
    }

    /// Writes a binary PLY file: positions as doubles, for bodies far from their origin; normals and
    /// texture coordinates as floats.
    ///
    /// # Errors
    /// `out` fails.
    pub fn write_ply(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {}", self.vertex_count())?;
        for (kind, names) in [("double", &["x", "y", "z"][..]), ("float", &["nx", "ny", "nz", "u", "v"])] {
            for name in names {
                writeln!(out, "property {kind} {name}")?;
            }
        }
        writeln!(out, "element face {}", self.triangle_count())?;
        writeln!(out, "property list uchar int vertex_indices\nend_header")?;
        for vertex in self.vertices() {
            for coordinate in vertex.position.to_array() {
                out.write_all(&coordinate.to_le_bytes())?;
            }
            for value in vertex.normal.to_array().into_iter().chain(vertex.uv.to_array()) {
                out.write_all(&(value as f32).to_le_bytes())?;
            }
        }
        for triangle in self.triangles() {
            out.write_all(&[3])?;
            for index in triangle {
                out.write_all(&index.to_le_bytes())?;
            }
        }
        Ok(())
    }
}
