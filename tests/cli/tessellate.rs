//! `goblet tessellate` as people run it: what it writes, what that is worth, what it refuses.

use std::f64::consts::{PI, TAU};
use std::fs;

use glam::DVec2;
use goblet::Options;
use goblet::geometry::bezier::Curve;
use goblet::image::film::Image;
use goblet::scene::{Geometry, Mesh, Scene};

use crate::support;
use crate::support::command::{Bench, Run};

/// A cylinder with a cone on top. The cases below replace its body.
const SCENE: &str = r#"# A tower.
Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string filename" "tower.exr"
LookAt 0 -6 1  0 0 1  0 0 1
Camera "perspective" "float fov" 40
WorldBegin
LightSource "point" "rgb I" [ 5 5 5 ]
Shape "revolution" "integer degree" 1 "point2 P" [ 0 0  1 0  1 2  0 3 ] # closed
"#;

const BODY: &str = r#"Shape "revolution" "integer degree" 1 "point2 P" [ 0 0  1 0  1 2  0 3 ]"#;

fn scene(body: &str) -> String {
    SCENE.replace(BODY, body)
}

/// A folder with this scene in it.
fn bench(scene: &str) -> Bench {
    let bench = Bench::new();
    bench.write("scene.pbrt", scene);
    bench
}

fn tessellate(bench: &Bench, arguments: &[&str]) -> Run {
    let run = bench.run(&[&["tessellate"], arguments].concat());
    assert_eq!(run.stdout, "");
    run
}

/// Writes `x.pbrt`, and reads it again.
fn tessellated(bench: &Bench, tolerance: &str) -> Scene {
    let run = tessellate(bench, &["scene.pbrt", "-o", "x.pbrt", "--tolerance", tolerance]);
    assert_eq!(run.code, 0, "{run:?}");
    Scene::load(bench.path("x.pbrt")).unwrap()
}

fn assert_refused(bench: &Bench, arguments: &[&str], code: i32, words: &[&str]) {
    let files = bench.files();
    tessellate(bench, arguments).assert_refused(&arguments.join(" "), code, words);
    assert_eq!(bench.files(), files, "{arguments:?} has written something");
}

fn mesh(scene: &Scene, shape: usize) -> &Mesh {
    match &scene.shapes[shape].geometry {
        Geometry::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

/// Surface area, and the volume inside, which is positive where the outside is out.
fn area_and_volume(mesh: &Mesh) -> [f64; 2] {
    assert_eq!((mesh.normals.len(), mesh.uvs.len()), (mesh.positions.len(), mesh.positions.len()));
    let mut sums = [0.0; 2];
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
        let normal = (b - a).cross(c - a);
        sums[0] += 0.5 * normal.length();
        sums[1] += a.dot(normal) / 6.0;
    }
    sums
}

fn assert_close(found: [f64; 2], expected: [f64; 2], relative: f64) {
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= relative * expected.abs(), "{found} instead of {expected}");
    }
}

#[test]
fn the_scene_stays_but_for_the_body() {
    let bench = bench(SCENE);
    let run = tessellate(&bench, &["scene.pbrt", "-o", "x.pbrt"]);
    assert_eq!(run.code, 0, "{run:?}");
    assert_eq!(bench.text("x.pbrt"), scene(r#"Shape "plymesh" "string filename" "x-1.ply""#));
    assert_eq!(bench.files(), ["scene.pbrt", "x-1.ply", "x.pbrt"]);
    let written = Scene::load(bench.path("x.pbrt")).unwrap();
    let triangles = mesh(&written, 0).triangles.len();
    assert_eq!(run.stderr, format!("wrote x-1.ply: {triangles} triangles\nwrote x.pbrt\n"));

    // The same again, over what is there; then there is nothing left to do.
    let before = fs::read(bench.path("x-1.ply")).unwrap();
    assert_eq!(tessellate(&bench, &["scene.pbrt", "-o", "x.pbrt", "--tolerance", "0.0001"]).code, 0);
    assert!(fs::read(bench.path("x-1.ply")).unwrap() == before);
    let run = tessellate(&bench, &["x.pbrt", "-o", "y.pbrt"]);
    assert_eq!(run.stderr, "wrote y.pbrt, a copy: the scene has no Shape \"revolution\"\n");
    assert_eq!(bench.text("y.pbrt"), bench.text("x.pbrt"));
}

#[test]
fn areas_and_volumes_are_those_of_the_bodies() {
    let tower = [PI + 2.0 * TAU + PI * 2.0_f64.sqrt(), 2.0 * PI + PI / 3.0];
    let bench = bench(SCENE);
    assert_close(area_and_volume(mesh(&tessellated(&bench, "1e-5"), 0)), tower, 1e-4);

    // By Simpson's rule, which is exact enough.
    let points = [(0.0, 0.0), (1.0, 0.1), (1.5, 0.5), (0.5, 1.0), (1.0, 1.2), (0.0, 2.0)];
    let numbers: Vec<String> = points.iter().map(|(u, v)| format!("{u} {v}")).collect();
    let body = format!("Shape \"revolution\" \"integer degree\" 5 \"point2 P\" [ {} ]", numbers.join(" "));
    let curve = Curve { points: points.map(DVec2::from).to_vec() };
    let way = Curve { points: curve.hodograph() };
    let (steps, mut sums) = (2000, [0.0; 2]);
    for i in 0..=steps {
        let t = f64::from(i) / f64::from(steps);
        let weight = if i == 0 || i == steps { 1.0 } else { f64::from(2 + 2 * (i % 2)) } / f64::from(3 * steps);
        sums[0] += weight * TAU * curve.at(t).x * way.at(t).length();
        sums[1] += weight * PI * curve.at(t).x.powi(2) * way.at(t).y;
    }
    bench.write("scene.pbrt", scene(&body));
    assert_close(area_and_volume(mesh(&tessellated(&bench, "1e-5"), 0)), sums, 1e-4);
    assert_close(area_and_volume(mesh(&tessellated(&bench, "1e-3"), 0)), sums, 1e-2);
    // A mirror turns a body of revolution inside out.
    bench.write("scene.pbrt", scene(&format!("Scale 1 -1 1\n{body}")));
    assert_close(area_and_volume(mesh(&tessellated(&bench, "1e-5"), 0)), [sums[0], -sums[1]], 1e-4);
}

#[test]
fn equal_bodies_share_a_file_unless_mirrored() {
    let other = BODY.replace("2  0 3", "2  0 4");
    let body = format!("{BODY} \"float alpha\" 1\n{other} ReverseOrientation {BODY} Scale -1 1 1 {BODY} {BODY}");
    let bench = bench(&scene(&body));
    let written = tessellated(&bench, "1e-2");
    assert_eq!(bench.files(), ["scene.pbrt", "x-1.ply", "x-2.ply", "x-3.ply", "x.pbrt"]);
    let file = |i: u32| format!("Shape \"plymesh\" \"string filename\" \"x-{i}.ply\"");
    let [first, other, mirrored] = [1, 2, 3].map(file);
    let expected =
        format!("{first} \"float alpha\" 1\n{other} ReverseOrientation {first} Scale -1 1 1 {mirrored} {mirrored}");
    assert_eq!(bench.text("x.pbrt"), scene(&expected));
    assert_eq!(written.shapes.len(), 5);
}

#[test]
fn the_same_side_of_a_mesh_is_out() {
    let device = support::device();
    for reverse in ["", "ReverseOrientation "] {
        for mirror in ["", "Scale 1 -2 1 "] {
            let shine = "AreaLightSource \"diffuse\" \"rgb L\" [ 1 2 3 ]\n";
            let text = scene(&format!("{shine}{reverse}{mirror}{BODY}")).replace("rgb I\" [ 5 5 5", "rgb I\" [ 0 0 0");
            let bench = bench(&text);
            let brightness = |name: &str| {
                let scene = Scene::load(bench.path(name)).unwrap();
                let options = Options { photons: Some(256), seed: Some(7), ..Options::default() };
                support::mean(&support::render_scene(&device, &scene, &options, 4).image)
            };
            tessellated(&bench, "1e-3");
            let [body, mesh] = ["scene.pbrt", "x.pbrt"].map(brightness);
            let case = format!("{reverse}{mirror}");
            let lit = reverse.is_empty() == mirror.is_empty();
            assert!(if lit { body[0] > 0.05 } else { body == [0.0; 3] }, "{case}: {body:?}");
            for (body, mesh) in body.iter().zip(mesh) {
                // A triangle seen edge-on may show either side by rounding, a millionth of what it emits.
                assert!((body - mesh).abs() <= 0.1 * body + 1e-6, "{case}: {body} and {mesh}");
            }
        }
    }
}

#[test]
fn included_text_and_defaults_are_put_in_place() {
    let body = "Attribute \"shape\" \"integer degree\" 1\nInclude \"parts/body.pbrt\" # from outside\n";
    let bench = bench(&scene(body));
    bench.write("parts/body.pbrt", "Include \"parts/shape.pbrt\"\n# a comment");
    bench.write("parts/shape.pbrt", "Shape \"revolution\" \"point2 P\" [ 0 0  1 0  1 2  0 3 ]");
    let written = tessellated(&bench, "1e-2");
    assert_eq!((written.shapes.len(), written.warnings.len()), (1, 0));
    let expected = "Attribute \"shape\" \"integer degree\" 1\n\
                    Shape \"plymesh\" \"string filename\" \"x-1.ply\"\n\n# a comment\n # from outside\n";
    assert_eq!(bench.text("x.pbrt"), scene(expected));
    // An included file is as much a part of the scene as the first one.
    bench.write("parts/scene.pbrt", bench.text("scene.pbrt").replace("parts/body", "body"));
    bench.write("parts/body.pbrt", BODY);
    assert_refused(
        &bench,
        &["parts/scene.pbrt", "-o", "parts/body.pbrt"],
        2,
        &["parts/body.pbrt: the scene reads this"],
    );
    assert_eq!(bench.text("parts/body.pbrt"), BODY);
}

#[test]
fn files_are_found_from_the_folder_of_the_output() {
    let text = "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"t.png\"\n\
                Shape \"plymesh\" \"string filename\" \"meshes/square.ply\"\n";
    let bench = bench("");
    bench.write("in/scene.pbrt", scene(&format!("{text}Include \"meshes/body.pbrt\"")));
    bench.write("in/meshes/body.pbrt", format!("{BODY} Shape \"plymesh\" \"string filename\" \"meshes/square.ply\""));
    let square = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 1\nproperty list uchar int vertex_indices\nend_header\n\
                  0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
    bench.write("in/meshes/square.ply", square);
    goblet::image::file::write(&bench.path("in/t.png"), &Image::new(1, 1), &[]).unwrap();
    fs::create_dir(bench.path("out")).unwrap();
    for (output, prefix) in
        [("out/x.pbrt", "../in/"), ("x.pbrt", "in/"), ("in/meshes/x.pbrt", "../"), ("in/x.pbrt", "")]
    {
        let run = tessellate(&bench, &["in/scene.pbrt", "--output", output, "--tolerance", "0.01"]);
        assert_eq!(run.code, 0, "{run:?}");
        assert!(run.stderr.contains(&format!("wrote {}: ", output.replace(".pbrt", "-1.ply"))), "{run:?}");
        let written = bench.text(output);
        for file in ["t.png", "meshes/square.ply"] {
            assert!(written.contains(&format!("\"string filename\" \"{prefix}{file}\"")), "{written}");
        }
        assert!(written.contains("\"string filename\" \"tower.exr\""), "{written}");
        assert!(written.contains("\"string filename\" \"x-1.ply\""), "{written}");
        let scene = Scene::load(bench.path(output)).unwrap();
        assert_eq!(scene.shapes.len(), 3);
        assert_eq!((mesh(&scene, 0).triangles.len(), mesh(&scene, 2).triangles.len()), (2, 2));
    }
}

#[test]
fn what_cannot_be_done_is_refused() {
    let bench = bench(SCENE);
    for value in ["0", "-1", "9e-8", "0.11", "nan", "inf", "fine"] {
        let words = ["--tolerance", "a number from 1e-7 to 0.1"];
        assert_refused(&bench, &["scene.pbrt", "-o", "x.pbrt", "--tolerance", value], 2, &words);
    }
    assert_refused(&bench, &["scene.pbrt"], 2, &["--output <OUT>"]);
    assert_refused(&bench, &["scene.pbrt", "-o", "x.ply"], 2, &["a file name ending in .pbrt"]);
    assert_refused(&bench, &["absent.pbrt", "-o", "x.pbrt"], 2, &["cannot read absent.pbrt"]);
    for same in ["scene.pbrt", "./scene.pbrt"] {
        assert_refused(&bench, &["scene.pbrt", "-o", same], 2, &["scene.pbrt: the scene reads this file"]);
    }
    assert_eq!(bench.text("scene.pbrt"), SCENE);
    assert_refused(
        &bench,
        &["scene.pbrt", "-o", "missing/x.pbrt"],
        1,
        &["missing/x.pbrt: cannot write", "No such file"],
    );
    fs::create_dir(bench.path("x-1.ply")).unwrap();
    assert_refused(&bench, &["scene.pbrt", "-o", "x.pbrt"], 1, &["x-1.ply: cannot write", "not a file"]);

    // A mesh that the scene reads already would be lost.
    assert_eq!(tessellate(&bench, &["scene.pbrt", "-o", "y.pbrt"]).code, 0);
    bench.write("both.pbrt", bench.text("y.pbrt") + BODY);
    assert_refused(&bench, &["both.pbrt", "-o", "y.pbrt"], 2, &["y-1.ply: the scene reads this file"]);

    let waves: String = (0..=900).map(|i| format!(" {} {i}", if i % 3 == 1 { 50 } else { 10 })).collect();
    for (body, words) in [
        ("Shape \"revolution\"", &["scene.pbrt:7:7: ", "has no \"point2 P\""][..]),
        (&format!("{BODY} \"float radius\" 1"), &["scene.pbrt:7:73: unknown parameter"]),
        (&format!("Shape \"revolution\" \"point2 P\" [{waves} ]"), &["scene.pbrt:7:1: a mesh within 1e-7", "gives"]),
        (
            &format!("AreaLightSource \"diffuse\" \"float power\" 5 {BODY}"),
            &["scene.pbrt:7:43: ", "\"float power\", which every triangle"],
        ),
    ] {
        bench.write("scene.pbrt", scene(body));
        assert_refused(&bench, &["scene.pbrt", "-o", "z.pbrt", "--tolerance", "1e-7"], 2, words);
    }
}

/// Each mesh takes the place of its own body, whatever is left out before it, and whatever else
/// is kept as a profile.
#[test]
fn bodies_that_are_not_rendered_keep_their_places() {
    let other = r#"Shape "revolution" "integer degree" 1 "point2 P" [ 5 0  5 7 ]"#;
    for left_out in [
        format!("Material \"interface\" {other} Material \"diffuse\""),
        format!("{other} \"float alpha\" 0"),
        format!("AttributeBegin Scale 1 1 0 {other} AttributeEnd"),
        "Shape \"cylinder\" \"float radius\" 5".to_owned(),
    ] {
        let bench = bench(&scene(&format!("{left_out}\n{BODY}")));
        let scene = tessellated(&bench, "1e-3");
        let mesh = scene.shapes.iter().find_map(|shape| match &shape.geometry {
            Geometry::Mesh(mesh) => Some(mesh),
            _ => None,
        });
        let top = mesh.expect("a mesh").positions.iter().map(|p| p.z).fold(0.0, f64::max);
        assert_eq!(top, 3.0, "{left_out}");
        let text = bench.text("x.pbrt");
        assert!(text.contains(&left_out) && text.matches("plymesh").count() == 1, "{text}");
    }
}
