//! Tests of whole files: their mesh, or the error.

use std::io::{Cursor, Write};

use proptest::prelude::*;

use super::*;

const HEADER: &str = "\
element vertex 4
property float x
property float y
property float z
property list uchar float weights
property float t
property float s
element face 2
property int id
property list uchar int vertex_indices
end_header
";

const ASCII_BODY: &str = "\
0 0 0 0 1 0
1 0 0 2 9 9 1 1
1 1 0 0 0 1
0 1 0 1 5 0 0
7 3 0 1 2
8 4 0 1 2 3";

fn parse(bytes: &[u8]) -> Result<Mesh, String> {
    read_mesh(&mut Cursor::new(bytes), bytes.len() as u64, &Budget::default()).map_err(|error| match error {
        PlyError::Unreadable(error) => error.to_string(),
        PlyError::Invalid(what) => what,
    })
}

fn ascii() -> String {
    format!("ply\nformat ascii 1.0\ncomment x\n{HEADER}{ASCII_BODY}")
}

#[test]
fn lines_end_as_on_any_system() {
    let expected = parse(ascii().as_bytes()).unwrap();
    for end in ["\r\n", "\r"] {
        assert_eq!(parse(ascii().replace('\n', end).as_bytes()).unwrap(), expected, "{end:?}");
        for big in [false, true] {
            // Only the header has lines.
            let header = binary_header(big);
            let body = &binary(big)[header.len()..];
            let mut bytes = header.replace('\n', end).into_bytes();
            bytes.extend(body);
            assert_eq!(parse(&bytes).unwrap(), expected, "{end:?}");
        }
    }
}

fn binary_header(big: bool) -> String {
    let order = if big { "big" } else { "little" };
    format!("ply\nformat binary_{order}_endian 1.0\n{HEADER}")
}

fn binary(big: bool) -> Vec<u8> {
    let mut bytes = binary_header(big).into_bytes();
    let float = |v: f32| {
        if big { v.to_be_bytes() } else { v.to_le_bytes() }
    };
    let int = |v: i32| {
        if big { v.to_be_bytes() } else { v.to_le_bytes() }
    };
    let vertices = [
        ([0.0, 0.0, 0.0], &[][..], [1.0, 0.0]),
        ([1.0, 0.0, 0.0], &[9.0, 9.0], [1.0, 1.0]),
        ([1.0, 1.0, 0.0], &[], [0.0, 1.0]),
        ([0.0, 1.0, 0.0], &[5.0], [0.0, 0.0]),
    ];
    for (position, weights, ts) in vertices {
        bytes.extend(position.map(float).concat());
        bytes.push(weights.len() as u8);
        weights.iter().for_each(|w| bytes.extend(float(*w)));
        bytes.extend(ts.map(float).concat());
    }
    for (id, face) in [(7, &[0, 1, 2][..]), (8, &[0, 1, 2, 3])] {
        bytes.extend(int(id));
        bytes.push(face.len() as u8);
        face.iter().for_each(|i| bytes.extend(int(*i)));
    }
    bytes
}

#[test]
fn all_formats_hold_the_same_mesh() {
    let mesh = parse(ascii().as_bytes()).unwrap();
    assert_eq!(mesh.positions.len(), 4);
    assert_eq!(mesh.positions[2], DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(mesh.uvs[2], DVec2::new(1.0, 0.0), "s is u, t is v");
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 2], [0, 2, 3]]);
    assert!(mesh.normals.is_empty());
    assert_eq!(parse(&binary(false)).unwrap(), mesh);
    assert_eq!(parse(&binary(true)).unwrap(), mesh);
}

#[test]
fn gzipped_files_are_read_and_bounded() {
    let read = |path: &Path| read(path, &Budget::default());
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("mesh.ply.gz");
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(ascii().as_bytes()).unwrap();
    let bytes = encoder.finish().unwrap();
    std::fs::write(&path, &bytes).unwrap();
    assert_eq!(read(&path).unwrap(), parse(ascii().as_bytes()).unwrap());
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    assert!(matches!(read(&path), Err(PlyError::Invalid(_))));
    let missing = directory.path().join("missing.ply");
    assert!(matches!(read(&missing), Err(PlyError::Unreadable(_))));
    std::fs::write(&path, &bytes).unwrap();
    let Err(PlyError::Invalid(what)) = crate::scene::mesh::ply::read(&path, &Budget::new(bytes.len() as u64 + 20))
    else {
        panic!()
    };
    assert!(what.contains("are to be read in all"), "{what}");
}

#[test]
fn broken_files_are_refused_with_a_reason() {
    let cases = [
        ("ply", "plx", "expected a PLY file"),
        ("ascii", "text", "unknown format `text`"),
        ("format ascii 1.0\n", "", "no `format` line"),
        ("element vertex 4", "element vertex -4", "count `-4`"),
        ("element vertex 4", "element vertex 1000000000000000000", "claims 1000000000000000000"),
        ("element vertex 4", "element vertex 99999999999999999999", "expected a whole number"),
        ("element vertex 4", "element vertex 5", "face 0 has 1 vertices"),
        ("element face 2", "element face 3", "the file ends within the faces"),
        ("element face 2", "element face 0", "no `face`"),
        ("element face", "element edge", "no `face`"),
        ("property float y", "property float why", "expected properties x, y and z"),
        ("vertex_indices", "corners", "expected a list property vertex_indices"),
        ("property float y", "property real y", "cannot read the header line `property real y`"),
        ("1 1 0 0 0 1", "1 nan 0 0 0 1", "vertex 2 has the coordinate NaN"),
        ("1 1 0 0 0 1", "1 1e999 0 0 0 1", "vertex 2 has the coordinate inf"),
        ("7 3 0 1 2", "7 3 0 1 4", "face 0 refers to vertex 4; expected 0 to 3"),
        ("7 3 0 1 2", "7 3 0 1 -1", "face 0 refers to vertex -1"),
        ("7 3 0 1 2", "7 5 0 1 2 3 0", "face 0 has 5 vertices; expected 3 or 4"),
        ("1 5 0 0", "-1 5 0 0", "a list of length -1"),
        ("end_header\n", "", "cannot read the header line"),
    ];
    for (from, to, expected) in cases {
        let text = ascii().replacen(from, to, 1);
        let error = parse(text.as_bytes()).unwrap_err();
        assert!(error.starts_with("byte "), "{error}");
        assert!(error.contains(expected), "{to}: {error}");
    }
    let whole = binary(false);
    for length in 0..whole.len() {
        assert!(parse(&whole[..length]).is_err(), "{length}");
    }
}

proptest! {
    #[test]
    fn mutations_never_panic(
        big in any::<bool>(),
        text in any::<bool>(),
        at in any::<prop::sample::Index>(),
        splice in prop::collection::vec(any::<u8>(), 0..12),
        cut in 0usize..12,
    ) {
        let mut bytes = if text { ascii().into_bytes() } else { binary(big) };
        let start = at.index(bytes.len());
        let end = (start + cut).min(bytes.len());
        bytes.splice(start..end, splice);
        if let Ok(mesh) = parse(&bytes) {
            let count = mesh.positions.len() as u32;
            prop_assert!(mesh.triangles.iter().flatten().all(|i| *i < count));
            prop_assert!(mesh.positions.iter().all(|p| p.is_finite()));
        }
    }
}
