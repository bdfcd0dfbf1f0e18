//! Tests of shapes that are converted to other shapes.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::scene::{Geometry, Mesh, Scene};

fn parse(shape: &str) -> Result<Geometry, String> {
    let text = format!("WorldBegin LightSource \"infinite\"\nShape {shape}");
    Scene::parse(&text, "t", "").map(|mut scene| scene.shapes.remove(0).geometry).map_err(|error| error.to_string())
}

fn mesh(shape: &str) -> Arc<Mesh> {
    let Geometry::Mesh(mesh) = parse(shape).unwrap() else { panic!("no mesh: {shape}") };
    mesh
}

fn assert_refused(shape: &str, expected: &str) {
    let error = parse(shape).unwrap_err();
    assert!(error.starts_with("t:2:") && error.contains(expected), "{shape}:\n{error}");
}

fn area(mesh: &Mesh) -> f64 {
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
        0.5 * (b - a).cross(c - a).length()
    };
    mesh.triangles.iter().map(area).sum()
}

/// Fails unless the winding of every triangle agrees with the normals of its corners.
fn assert_turned_with_normals(mesh: &Mesh, sign: f64) {
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
        let normal = (b - a).cross(c - a).normalize();
        for corner in triangle {
            let other = mesh.normals[*corner as usize].normalize();
            assert!(sign * normal.dot(other) > 0.5, "{normal} {other}");
        }
    }
}

#[test]
fn a_whole_cylinder_is_a_body_of_revolution() {
    let Geometry::Revolution(profile) = parse("\"cylinder\" \"float zmin\" 3 \"float radius\" 2").unwrap() else {
        panic!("no body")
    };
    // The heights are exchanged, so that the profile runs upward.
    assert_eq!(profile.segments[0].points, [DVec2::new(2.0, 1.0), DVec2::new(2.0, 3.0)]);
    assert_refused("\"cylinder\" \"float zmin\" 1", "\"float zmin\" is 1; expected heights that differ");
}

#[test]
fn a_part_of_a_cylinder_is_a_fine_mesh() {
    let mesh = mesh("\"cylinder\" \"float radius\" 2 \"float zmax\" 3 \"float phimax\" 90");
    assert!((area(&mesh) / (4.0 * PI) - 1.0).abs() < 1e-5);
    assert_turned_with_normals(&mesh, 1.0);
    for ((p, n), uv) in mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs) {
        assert!((p.truncate() - 2.0 * n.truncate()).length() < 1e-12);
        let expected = DVec2::new(p.y.atan2(p.x) / (0.5 * PI), (p.z + 1.0) / 4.0);
        assert!((*uv - expected).length() < 1e-12, "{uv} {expected}");
    }
}

#[test]
fn a_parallelogram_is_two_triangles() {
    let mesh = mesh("\"bilinearmesh\" \"point3 P\" [0 0 0  2 0 0  1 1 0  3 1 0]");
    assert_eq!((mesh.triangles.len(), area(&mesh)), (2, 2.0));
    assert!(mesh.normals.is_empty());
    assert_eq!(mesh.uvs, [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE]);
}

/// The surface z = x y, whose properties are known in closed form.
#[test]
fn a_twisted_patch_has_its_own_normals() {
    let mesh = mesh("\"bilinearmesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 1]");
    assert_turned_with_normals(&mesh, 1.0);
    for ((p, n), uv) in mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs) {
        assert!((p.z - p.x * p.y).abs() < 1e-15 && p.truncate().distance(*uv) < 1e-15);
        assert!(n.normalize().distance(DVec3::new(-p.y, -p.x, 1.0).normalize()) < 1e-14);
    }
    // The integral of sqrt(1 + x^2 + y^2) over the unit square.
    assert!((area(&mesh) - 1.280_789).abs() < 2e-3, "{}", area(&mesh));
}

#[test]
fn neighbouring_patches_share_the_points_of_their_edge() {
    let mesh = mesh(
        "\"bilinearmesh\" \"integer indices\" [0 1 2 3  3 1 5 4] \
         \"point3 P\" [0 0 .1  .7 .1 0  0 .9 0  1 1.3 1  2.1 1 0.3  2 .3 .7] \"point2 uv\" [0 0 1 0 0 1 1 1 2 1 2 0]",
    );
    let half = mesh.positions.len() / 2;
    let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
    let on_edge = |points: &[DVec3], a: DVec3, b: DVec3| {
        let mut found: Vec<_> = points.iter().filter(|p| (**p - a).cross(b - a).length() < 1e-12).map(bits).collect();
        found.sort_unstable();
        found
    };
    let (a, b) = (DVec3::new(0.7, 0.1, 0.0), DVec3::new(1.0, 1.3, 1.0));
    let (before, after) = mesh.positions.split_at(half);
    let shared = on_edge(before, a, b);
    assert!(shared.len() > 8, "{}", shared.len());
    assert_eq!(shared, on_edge(after, a, b));
    assert_eq!(mesh.uvs[half + 1 + (half as f64).sqrt() as usize - 2], DVec2::new(1.0, 0.0));
}

#[test]
fn bad_patches_are_refused() {
    for (shape, expected) in [
        ("\"bilinearmesh\"", "has no \"point3 P\""),
        ("\"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]", "has 3 vertices and no \"integer indices\""),
        ("\"bilinearmesh\" \"point3 P\" [0 0 0] \"integer indices\" [0 0 0]", "has 3 values; expected 4 for each face"),
        ("\"bilinearmesh\" \"point3 P\" [0 0 0] \"integer indices\" [0 0 0 1]", "has 1 at position 3; expected 0 to 0"),
    ] {
        assert_refused(shape, expected);
    }
    // The image of an emitter is that of its light; pbrt samples the patch by the one that the shape names.
    let hint = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"string emissionfilename\" \"a.png\"";
    let scene = Scene::parse(&format!("WorldBegin\n{hint}"), "t", "").expect("a scene");
    assert_eq!(scene.shapes.len(), 1);
    let light = "AreaLightSource \"diffuse\" \"float power\" 1 Shape";
    for shape in ["\"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]", "\"cylinder\" \"float phimax\" 9"] {
        let error = Scene::parse(&format!("WorldBegin\n{light} {shape}"), "t", "").unwrap_err().to_string();
        assert!(error.contains("\"float power\" of a light") && error.starts_with("t:2:"), "{error}");
    }
}

/// An octahedron, counterclockwise as seen from outside.
const OCTAHEDRON: &str = "\"point3 P\" [1 0 0  -1 0 0  0 1 0  0 -1 0  0 0 1  0 0 -1] \
    \"integer indices\" [0 2 4  2 1 4  1 3 4  3 0 4  2 0 5  1 2 5  3 1 5  0 3 5]";

#[test]
fn limits_do_not_depend_on_levels() {
    // Distorted, so that no symmetry helps; corners have three to five neighbours.
    let shape = "\"point3 P\" [1 0 .2  -1 0 0  0 1.3 0  0 -1 0.1  0 .2 1  0 0 -1  1.5 .4 1.4] \
        \"integer indices\" [0 2 6  2 4 6  4 0 6  2 1 4  1 3 4  3 0 4  2 0 5  1 2 5  3 1 5  0 3 5]";
    let at = |levels: u32| mesh(&format!("\"loopsubdiv\" \"integer levels\" {levels} {shape}"));
    let (coarse, fine) = (at(0), at(3));
    assert_eq!(fine.triangles.len(), 64 * coarse.triangles.len());
    for i in 0..coarse.positions.len() {
        assert!(coarse.positions[i].distance(fine.positions[i]) < 1e-12, "{i}");
        // Tangents are between limits of neighbours, so they are only approximate.
        assert!(coarse.normals[i].normalize().dot(fine.normals[i].normalize()) > 0.9, "{i}");
    }
    // The boundary is shared by two: every edge has its opposite.
    let edges: std::collections::HashSet<_> =
        fine.triangles.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]).collect();
    assert_eq!(edges.len(), 3 * fine.triangles.len());
    assert!(edges.iter().all(|(a, b)| edges.contains(&(*b, *a))));
}

/// As in pbrt, normals point to the side from which faces are clockwise.
#[test]
fn normals_are_those_of_the_limit_and_pbrt() {
    let mesh = mesh(&format!("\"loopsubdiv\" \"integer levels\" 4 {OCTAHEDRON}"));
    assert_turned_with_normals(&mesh, -1.0);
    for corner in 0..6 {
        let [p, n] = [mesh.positions[corner], mesh.normals[corner]].map(DVec3::normalize);
        assert!(p.dot(n) < -1.0 + 1e-12, "{p} {n}");
    }
    // Each triangle's own normal is near those of its corners: the surface is smooth.
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
        let normal = (b - a).cross(c - a).normalize();
        for corner in triangle {
            assert!(normal.dot(mesh.normals[*corner as usize].normalize()) < -0.95);
        }
    }
}

/// A flat sheet of 3 x 3 squares of two triangles each: limits stay in the sheet, inner corners do not
/// move, and the normals on the boundary are the sheet's.
#[test]
fn flat_sheets_stay_flat() {
    let mut text = String::from("\"loopsubdiv\" \"integer levels\" 2 \"point3 P\" [");
    (0..16).for_each(|i| text += &format!("{} {} 5 ", i % 4, i / 4));
    text += "] \"integer indices\" [";
    for i in (0..12).filter(|i| i % 4 < 3) {
        text += &format!("{} {} {} {} {} {} ", i, i + 1, i + 5, i, i + 5, i + 4);
    }
    let mesh = mesh(&(text + "]"));
    assert_eq!(mesh.triangles.len(), 18 * 16);
    for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
        assert!((p.z - 5.0).abs() < 1e-12 && n.normalize().z < -1.0 + 1e-12, "{p} {n}");
    }
    for i in [5, 6, 9, 10] {
        assert!(mesh.positions[i].distance(DVec3::new((i % 4) as f64, (i / 4) as f64, 5.0)) < 1e-12);
    }
    assert_turned_with_normals(&mesh, -1.0);
}

#[test]
fn bad_surfaces_are_refused() {
    for (indices, expected) in [
        ("[0 1 1]", "has the vertex 1 twice in face 0"),
        ("[0 1 2 0 1 3]", "two faces with an edge from vertex 0 to 1, the second is 1"),
        ("[0 1 4]", "expected 0 to 3"),
        ("[0 1 -9223372036854775808]", "expected a whole number of at most 16 digits"),
        ("[0 1 2] \"integer levels\" 17", "expected a whole number from 0 to 16"),
        (
            "[0 1 2 3 2 1 1 0 3 0 2 3] \"integer levels\" 13",
            "13 levels make 268435456 triangles, which are too large: ",
        ),
    ] {
        let shape = format!("\"loopsubdiv\" \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1] \"integer indices\" {indices}");
        assert_refused(&shape, expected);
    }
    assert_refused("\"loopsubdiv\" \"point3 P\" [0 0 0]", "no \"integer indices\"");
}
