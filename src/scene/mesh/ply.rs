//! PLY meshes: ASCII and both binary byte orders, gzipped or not.
//!
//! The file is read as a stream, and memory is allocated only for bytes that have been read: a header may
//! claim any number of vertices.

use std::io::{BufRead, BufReader};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;
use glam::{DVec2, DVec3};

pub(in crate::scene) use self::error::PlyError;
use self::header::{Element, Format, Header, Property, Scalar, Source};
use crate::base::input::{self, Budget, Counted};
use crate::scene::format::lexer::shorten;
use crate::scene::model::Mesh;

mod error;
mod header;
#[cfg(test)]
mod tests;

/// Maximum compression ratio of deflate.
const MAX_RATIO: u64 = 1032;

/// Reads the mesh in the file at `path`. The bytes read count towards the budget, and the mesh must fit
/// into the rest of it.
pub(in crate::scene) fn read(path: &Path, budget: &Budget) -> Result<Mesh, PlyError> {
    let file = input::open(path).map_err(PlyError::Unreadable)?;
    let length = file.metadata().map_err(PlyError::Unreadable)?.len();
    let mut file = BufReader::new(Counted { stream: file, budget });
    let start = file.fill_buf().map_err(PlyError::Unreadable)?;
    if start.starts_with(&[0x1f, 0x8b]) {
        let expanded = Counted { stream: MultiGzDecoder::new(file), budget };
        return read_mesh(&mut BufReader::new(expanded), length.saturating_mul(MAX_RATIO), budget);
    }
    read_mesh(&mut file, length, budget)
}

/// Reads a mesh from a stream of at most `length` bytes.
pub(in crate::scene) fn read_mesh(stream: &mut dyn BufRead, length: u64, budget: &Budget) -> Result<Mesh, PlyError> {
    let mut source = Source { stream, at: 0, length };
    let header = Header::read(&mut source)?;
    let mut body = Body {
        vertex_count: header.element("vertex", &source)?.count,
        face_count: header.element("face", &source)?.count,
        format: header.format,
        source,
        mesh: Mesh::default(),
        budget,
    };
    for element in &header.elements {
        body.check_count(element)?;
        match element.name.as_str() {
            "vertex" => body.read_vertices(element)?,
            "face" => body.read_faces(element)?,
            _ => body.skip(element)?,
        }
    }
    Ok(body.mesh)
}

/// The part of a file after the header.
struct Body<'a> {
    source: Source<'a>,
    format: Format,
    vertex_count: u64,
    face_count: u64,
    mesh: Mesh,
    budget: &'a Budget,
}

/// Number of faces between two checks of the memory left.
const FACES_AT_A_TIME: u64 = 1 << 16;

/// Names of texture coordinates, in the order in which pbrt tries them.
const UV_NAMES: [[&str; 2]; 4] = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];

impl Body<'_> {
    /// Fails if the rest of the file is too short for an element's count.
    fn check_count(&self, element: &Element) -> Result<(), PlyError> {
        let left = self.source.length.saturating_sub(self.source.at);
        let least = element.least_size(self.format);
        // The last number of an ASCII file needs no separator.
        if least > 0 && element.count > left.saturating_add(1) / least {
            return Err(self.source.invalid(format!(
                "element {} claims {} entries of at least {least} bytes, \
                 but at most {left} bytes follow",
                shorten(&element.name),
                element.count
            )));
        }
        if element.name == "vertex" && element.count > u64::from(u32::MAX) {
            return Err(self.source.invalid(format!("{} vertices; expected at most {}", element.count, u32::MAX)));
        }
        Ok(())
    }

    /// Fails if the budget has no memory for the mesh so far and `count` more entries of `bytes` bytes.
    fn check_memory(&self, count: u64, bytes: usize) -> Result<(), PlyError> {
        let more = count.saturating_mul(bytes as u64);
        self.budget.check(self.mesh.bytes().saturating_add(more)).map_err(|over| self.source.invalid(over))
    }

    fn scalar(&mut self, scalar: Scalar, during: &str) -> Result<f64, PlyError> {
        if self.format == Format::Ascii {
            let word = self.source.word(during)?;
            // C libraries may write a NaN as `nan(...)`.
            if word.trim_start_matches(['-', '+']).to_ascii_lowercase().starts_with("nan(") {
                return Ok(f64::NAN);
            }
            return word
                .parse()
                .map_err(|_| self.source.invalid(format!("`{}` is not a number, in {during}", shorten(&word))));
        }
        let big = self.format == Format::BigEndian;
        // Each width has its own arm, which converts the byte order.
        macro_rules! number {
            ($type:ty) => {{
                let bytes = self.source.exact(during)?;
                f64::from(if big { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) })
            }};
        }
        Ok(match scalar {
            Scalar::I8 => number!(i8),
            Scalar::U8 => number!(u8),
            Scalar::I16 => number!(i16),
            Scalar::U16 => number!(u16),
            Scalar::I32 => number!(i32),
            Scalar::U32 => number!(u32),
            Scalar::F32 => number!(f32),
            Scalar::F64 => number!(f64),
        })
    }

    fn list_length(&mut self, length: Scalar, during: &str) -> Result<u64, PlyError> {
        let value = self.scalar(length, during)?;
        if value < 0.0 || value.fract() != 0.0 || value > f64::from(u32::MAX) {
            return Err(self.source.invalid(format!("a list of length {value} in {during}")));
        }
        Ok(value as u64)
    }

    fn skip_property(&mut self, property: &Property, during: &str) -> Result<(), PlyError> {
        let count = match property.list {
            Some(length) => self.list_length(length, during)?,
            None => 1,
        };
        for _ in 0..count {
            self.scalar(property.scalar, during)?;
        }
        Ok(())
    }

    fn skip(&mut self, element: &Element) -> Result<(), PlyError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        let during = format!("element {}", shorten(&element.name));
        for _ in 0..element.count {
            for property in &element.properties {
                self.skip_property(property, &during)?;
            }
        }
        Ok(())
    }

    /// Returns, for each property, the index among x y z nx ny nz u v that it fills.
    fn vertex_slots(&self, element: &Element) -> Result<VertexSlots, PlyError> {
        let mut slots = vec![None; element.properties.len()];
        let mut fill = |names: &[&str], first: usize| {
            let found: Vec<usize> = names.iter().filter_map(|n| element.scalar_index(n)).collect();
            let all = found.len() == names.len();
            if all {
                for (i, property) in found.into_iter().enumerate() {
                    slots[property] = Some(first + i);
                }
            }
            all
        };
        if !fill(&["x", "y", "z"], 0) {
            let what = "the vertices have no position; expected properties x, y and z";
            return Err(self.source.invalid(what));
        }
        let normals = fill(&["nx", "ny", "nz"], 3);
        let uvs = UV_NAMES.iter().any(|names| fill(names, 6));
        Ok(VertexSlots { slots, normals, uvs })
    }

    fn read_vertices(&mut self, element: &Element) -> Result<(), PlyError> {
        let layout = self.vertex_slots(element)?;
        let bytes =
            size_of::<DVec3>() * (1 + usize::from(layout.normals)) + size_of::<DVec2>() * usize::from(layout.uvs);
        self.check_memory(element.count, bytes)?;
        for vertex in 0..element.count {
            let mut values = [0.0; 8];
            for (property, slot) in element.properties.iter().zip(&layout.slots) {
                match slot {
                    Some(slot) => values[*slot] = self.scalar(property.scalar, "the vertices")?,
                    None => self.skip_property(property, "the vertices")?,
                }
            }
            let [x, y, z, nx, ny, nz, u, v] = values;
            // Normals need not be finite: a triangle with a normal that is not finite uses its geometric
            // normal.
            if let Some(value) = [x, y, z, u, v].iter().find(|value| !value.is_finite()) {
                return Err(self
                    .source
                    .invalid(format!("vertex {vertex} has the coordinate {value}; expected a finite number")));
            }
            self.mesh.positions.push(DVec3::new(x, y, z));
            if layout.normals {
                self.mesh.normals.push(DVec3::new(nx, ny, nz));
            }
            if layout.uvs {
                self.mesh.uvs.push(DVec2::new(u, v));
            }
        }
        Ok(())
    }

    fn read_faces(&mut self, element: &Element) -> Result<(), PlyError> {
        let is_indices = |p: &Property| matches!(&*p.name, "vertex_indices" | "vertex_index");
        let indices = element.properties.iter().position(|p| is_indices(p) && p.list.is_some());
        let Some(indices) = indices else {
            let what = "the faces have no indices; expected a list property vertex_indices";
            return Err(self.source.invalid(what));
        };
        for face in 0..self.face_count {
            // The estimate is one triangle per face. A face of four vertices becomes two, so the check is
            // repeated.
            if face.is_multiple_of(FACES_AT_A_TIME) {
                self.check_memory(self.face_count - face, size_of::<[u32; 3]>())?;
            }
            for (i, property) in element.properties.iter().enumerate() {
                match property.list {
                    Some(length) if i == indices => self.read_face(face, length, property.scalar)?,
                    _ => self.skip_property(property, "the faces")?,
                }
            }
        }
        Ok(())
    }

    fn read_face(&mut self, face: u64, length: Scalar, scalar: Scalar) -> Result<(), PlyError> {
        let count = self.list_length(length, "the faces")?;
        if count != 3 && count != 4 {
            return Err(self.source.invalid(format!("face {face} has {count} vertices; expected 3 or 4")));
        }
        let mut corners = [0; 4];
        for corner in corners.iter_mut().take(count as usize) {
            let index = self.scalar(scalar, "the faces")?;
            let in_range = index >= 0.0 && index < self.vertex_count as f64;
            if !in_range || index.fract() != 0.0 {
                return Err(self.source.invalid(format!(
                    "face {face} refers to vertex {index}; expected 0 to {}",
                    self.vertex_count - 1
                )));
            }
            *corner = index as u32;
        }
        let [a, b, c, d] = corners;
        self.mesh.triangles.push([a, b, c]);
        if count == 4 {
            self.mesh.triangles.push([a, c, d]);
        }
        Ok(())
    }
}

/// Destinations of the properties of a vertex.
struct VertexSlots {
    slots: Vec<Option<usize>>,
    normals: bool,
    uvs: bool,
}
