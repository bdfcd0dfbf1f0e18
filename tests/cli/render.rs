//! The command as people run it: the files it writes, what it refuses and in which words.

use std::fs;

use goblet::base::input::Budget;
use goblet::image::file;
use goblet::image::film::Image;
use serde_json::Value;

use crate::support::command::{Bench, CACHE, LIGHT, Run, SCENE, scene};

const MESH: &str = r#"Shape "trianglemesh" "integer indices" [ 0 2 1 0 3 2 3 5 4 3 4 2 ] "point3 P" [ -2 -1 -2  2 -1 -2  2 -1 2  -2 -1 2  2 2 2  -2 2 2 ]"#;

fn assert_finite_and_lit(image: &Image) {
    let values = || image.pixels.iter().flatten();
    assert!(values().all(|value| value.is_finite() && *value >= 0.0));
    assert!(values().any(|value| *value > 0.0), "the image is black");
}

#[test]
fn a_wrong_scene_is_refused_at_its_place() {
    let texture = r#"Texture "t" "spectrum" "ptex" Material "diffuse" "texture reflectance" "t""#;
    let cases: &[(&str, &str, &str, &[&str])] = &[
        (LIGHT, r#"Include "scene.pbrt""#, "7:1", &["Include", "includes itself"]),
        (LIGHT, r#"Include "absent.pbrt""#, "7:9", &["cannot read absent.pbrt"]),
        (LIGHT, r#"LightSource "point" "rgb I" [ -1 0 0 ]"#, "7:21", &["\"rgb I\" is", "0 or more"]),
        ("xresolution\" 16", "xresolution\" 0", "1:12", &["\"integer xresolution\" is 0", "from 1"]),
        ("yresolution\" 12", "yresolution\" -3", "1:37", &["\"integer yresolution\" is -3", "from 1"]),
        ("radius\" 0.5\nW", "radius\" 0\nW", "5:74", &["\"float radius\" is 0", "a length from"]),
        ("radius\" 0.5\nW", "radius\" -1\nW", "5:74", &["\"float radius\" is -1", "a length from"]),
        ("radius\" 0.5\nW", "radius\" 1e30\nW", "5:74", &["\"float radius\" is 1", "a length from"]),
        ("iteration\" 500", "iteration\" 0", "5:40", &["\"integer photonsperiteration\" is 0", "at least 1"]),
        ("iteration\" 500", "iteration\" -5", "5:40", &["\"integer photonsperiteration\" is -5", "at least 1"]),
        ("maxdepth\" 6", "maxdepth\" 0", "5:19", &["\"integer maxdepth\" is 0", "from 1"]),
        ("pixelsamples\" 2", "pixelsamples\" 0", "4:23", &["\"integer pixelsamples\" is 0", "from 1"]),
        ("4 3 4 2 ]", "4 3 9 2 ]", "9:22", &["\"integer indices\" has 9 at position 10", "expected 0 to 5"]),
        ("4 3 4 2 ]", "4 3 -1 2 ]", "9:22", &["has -1 at position 10", "expected 0 to 5"]),
        ("[ -2 -1 -2", "[ -2 nan -2", "9:84", &["found `nan` as a value of \"point3 P\"", "expected a number"]),
        ("[ -2 -1 -2", "[ -2 1e999 -2", "9:84", &["`1e999` is not a finite number"]),
        ("\"sphere\" \"float radius\" 0.5", "\"curve\"", "12:7", &["not supported yet", "\"trianglemesh\""]),
        ("\"sphere\" \"float radius\" 0.5", "\"cube\"", "12:7", &["unknown Shape \"cube\"", "\"sphere\""]),
        ("\"sphere\" \"float radius\"", "\"sphere\" \"float size\"", "12:16", &["unknown parameter", "float radius"]),
        ("Material \"diffuse\"", texture, "8:24", &["Texture \"ptex\"", "not supported yet", "\"imagemap\""]),
        (
            "Material \"diffuse\"",
            "Material \"hair\"",
            "8:10",
            &["Material \"hair\" is not supported yet", "\"diffuse\""],
        ),
        ("WorldBegin", "WorldBegn", "6:1", &["unknown directive `WorldBegn`", "WorldBegin"]),
        ("AttributeEnd", "", "10:1", &["never ended", "AttributeEnd"]),
    ];
    let bench = Bench::new();
    for (from, to, place, words) in cases {
        let case = format!("`{from}` as `{to}`");
        bench.write("scene.pbrt", scene(from, to));
        let run = bench.render(&["-o", "x.exr"]);
        run.assert_refused(&case, 2, &[&format!("goblet: scene.pbrt:{place}: ")]);
        run.assert_refused(&case, 2, words);
        assert!(!bench.path("x.exr").exists());
    }
}

#[test]
fn what_is_no_scene_is_refused() {
    let noise: Vec<u8> = (0..4096_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    let cases: &[(&str, &[u8], &[&str])] = &[
        ("empty", b"", &["empty.pbrt:1:1: ", "expected a WorldBegin"]),
        ("comment", b"# nothing", &["comment.pbrt:1:10: ", "expected a WorldBegin"]),
        ("noise", &noise, &["noise.pbrt:1:"]),
        ("zeros", &[0; 1000], &["zeros.pbrt:1:1: "]),
        ("gzip", b"\x1f\x8b\x08broken", &["cannot read gzip.pbrt"]),
        ("wide", b"\xff\xfeW\0o\0", &["cannot read wide.pbrt", "UTF-16"]),
        ("string", b"Film \"rgb", &["string.pbrt:1:6: ", "unterminated string"]),
    ];
    let bench = Bench::new();
    for (name, bytes, words) in cases {
        let file = format!("{name}.pbrt");
        bench.write(&file, bytes);
        bench.run(&["render", &file, "-o", "x.exr"]).assert_refused(name, 2, words);
    }
    bench.run(&["render", "missing.pbrt"]).assert_refused("missing", 2, &["cannot read missing.pbrt", "No such file"]);
    bench.run(&["render", "."]).assert_refused("folder", 2, &["cannot read ."]);
}

#[test]
fn includes_that_go_round_are_refused() {
    let bench = Bench::new();
    bench.write("scene.pbrt", scene(LIGHT, "Include \"a.pbrt\""));
    bench.write("a.pbrt", "\nInclude \"b.pbrt\"");
    bench.write("b.pbrt", "Include \"a.pbrt\"");
    bench.render(&[]).assert_refused("a and b", 2, &["b.pbrt:1:1: ", "a.pbrt", "includes itself"]);
}

/// A square as a PLY file. In ASCII, `corner` and `index` replace a number each.
fn ascii_ply(corner: &str, index: &str) -> String {
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    format!("{header}-2 -1 -2\n2 -1 -2\n2 {corner} 2\n-2 -1 2\n3 0 2 1\n3 0 {index} 2\n")
}

fn binary_ply(corner: f32, index: i32) -> Vec<u8> {
    let header = ascii_ply("", "").replace("ascii", "binary_little_endian");
    let mut bytes = header.split_inclusive("end_header\n").next().unwrap().as_bytes().to_vec();
    let corners = [-2.0, -1.0, -2.0, 2.0, -1.0, -2.0, 2.0, corner, 2.0, -2.0, -1.0, 2.0];
    bytes.extend(corners.iter().flat_map(|value: &f32| value.to_le_bytes()));
    for face in [[0, 2, 1], [0, index, 2]] {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|index| index.to_le_bytes()));
    }
    bytes
}

#[test]
fn a_broken_mesh_is_refused() {
    let (text, binary) = (ascii_ply("-1", "3").into_bytes(), binary_ply(-1.0, 3));
    let cut = |bytes: &[u8], end: usize| bytes[..bytes.len() - end].to_vec();
    type Case<'a> = (&'a str, Option<Vec<u8>>, &'a [&'a str]);
    let cases: &[Case] = &[
        ("missing", None, &["cannot read mesh.ply", "No such file"]),
        ("empty", Some(vec![]), &["mesh.ply: byte 0: ", "ends within the header"]),
        ("no PLY", Some(SCENE.into()), &["expected a PLY file"]),
        ("header only", Some(text[..38].to_vec()), &["ends within the header"]),
        ("text, cut in the faces", Some(cut(&text, 8)), &["ends within the faces"]),
        ("text, cut in the vertices", Some(cut(&text, 30)), &["mesh.ply: byte "]),
        ("binary, cut in the faces", Some(cut(&binary, 5)), &["mesh.ply: byte "]),
        ("binary, cut in the vertices", Some(cut(&binary, 40)), &["element vertex claims 4 entries"]),
        ("text, NaN", Some(ascii_ply("nan", "3").into()), &["vertex 2 has the coordinate NaN", "finite"]),
        ("text, infinite", Some(ascii_ply("1e999", "3").into()), &["vertex 2 has the coordinate inf", "finite"]),
        ("text, a word", Some(ascii_ply("high", "3").into()), &["`high` is not a number"]),
        ("binary, NaN", Some(binary_ply(f32::NAN, 3)), &["vertex 2 has the coordinate NaN", "finite"]),
        ("text, index", Some(ascii_ply("-1", "4").into()), &["face 1 refers to vertex 4; expected 0 to 3"]),
        ("binary, index", Some(binary_ply(-1.0, -1)), &["face 1 refers to vertex -1; expected 0 to 3"]),
    ];
    let bench = Bench::new();
    bench.write("scene.pbrt", scene(MESH, r#"Shape "plymesh" "string filename" "mesh.ply""#));
    for (case, bytes, words) in cases {
        if let Some(bytes) = bytes {
            bench.write("mesh.ply", bytes);
        }
        let run = bench.render(&["-o", "x.exr"]);
        run.assert_refused(case, 2, &["goblet: scene.pbrt:9:17: "]);
        run.assert_refused(case, 2, words);
    }
    // The same square, whole, is rendered, and both forms alike.
    bench.write("mesh.ply", text);
    bench.rendered(&["-o", "text.exr"]);
    bench.write("mesh.ply", binary);
    bench.rendered(&["-o", "binary.exr"]);
    assert!(bench.bytes("text.exr") == bench.bytes("binary.exr"));
}

#[test]
fn a_wrong_option_is_refused() {
    let cases: &[(&[&str], &[&str])] = &[
        (&["--resolution", "0x0"], &["--resolution", "each from 1 to 65536"]),
        (&["--resolution", "65536x65536"], &["4294967296 pixels"]),
        (&["--radius", "0"], &["--radius", "a length above 0"]),
        (&["--radius", "-1"], &["--radius", "a length above 0"]),
        (&["--radius", "nan"], &["--radius", "a length above 0"]),
        (&["--radius", "1e30"], &["--radius", "a length above 0"]),
        (&["--radius", "1e12"], &["a radius of 1000000000000", "for a scene of this size"]),
        (&["--radius", "1e-12"], &["a radius of 0.000000000001", "for a scene of this size"]),
        (&["--photons", "0"], &["--photons", "from 1"]),
        (&["--photons", "99999999999"], &["'99999999999'", "from 1 to 2147483648"]),
        (&["--iterations", "0"], &["--iterations", "from 1"]),
        (&["--time", "0"], &["--time", "seconds above 0"]),
        (&["--alpha", "1.5"], &["--alpha", "at most 1"]),
        (&["-o", "x.jpg"], &["x.jpg", ".exr or .png"]),
        (&["-o", "x"], &["--output", ".exr or .png"]),
        (&["--hyperspeed"], &["unexpected argument '--hyperspeed'"]),
        (&["--device", "no such device"], &["no device matches \"no such device\"", "there are: 0 ("]),
        (&["--device", "99"], &["no device matches \"99\""]),
    ];
    let bench = Bench::new();
    for (arguments, words) in cases {
        let run = bench.render(arguments);
        run.assert_refused(&format!("{arguments:?}"), 2, words);
    }
    bench.run(&["render"]).assert_refused("no scene", 2, &["<SCENE>"]);
    bench.run(&["paint", "scene.pbrt"]).assert_refused("no such command", 2, &["paint"]);
    // As an option, so in the scene.
    bench.write("scene.pbrt", scene("radius\" 0.5\nW", "radius\" 1e12\nW"));
    bench.render(&[]).assert_refused("radius", 2, &["a radius of 1000000000000", "for a scene of this size"]);
    assert_eq!(fs::read_dir(bench.0.path()).unwrap().count(), 1, "no image was written");
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_the_render() {
    let bench = Bench::new();
    fs::create_dir(bench.path("folder.exr")).unwrap();
    for (arguments, words) in [
        (["-o", "missing/x.exr"], ["missing/x.exr: cannot write the image", "No such file"]),
        (["-o", "folder.exr"], ["folder.exr: cannot write the image", "not a file"]),
        (["--stats", "missing/x.json"], ["missing/x.json: cannot write the statistics", "No such file"]),
        (["--stats", "folder.exr"], ["folder.exr: cannot write the statistics", "directory"]),
    ] {
        let run = bench.render(&arguments);
        run.assert_refused(&format!("{arguments:?}"), 1, &words);
        assert!(!run.stderr.contains("wrote"), "{run:?}");
    }
    bench.write("scene.pbrt", scene("default.exr", "default.tiff"));
    bench.render(&[]).assert_refused("film", 1, &["default.tiff", "supported are .exr and .png"]);
}

fn none_by_pass() -> Value {
    serde_json::json!({ "eye": 0, "photon": 0, "gathering": 0, "update": 0 })
}

#[test]
fn a_camera_inside_glass_sees() {
    let bench = Bench::new();
    bench.write("scene.pbrt", scene("LookAt 0 0 -3  0 0 0", "LookAt 0 0 0  0 0 1"));
    bench.rendered(&["-o", "x.exr", "--stats", "x.json"]);
    assert_finite_and_lit(&bench.image("x.exr"));
    assert_eq!(bench.json("x.json")["non_finite"], none_by_pass());
}

#[test]
fn every_output_is_written_and_named() {
    let bench = Bench::new();
    let run = bench.rendered(&["-o", "x.exr", "-o", "x.png"]);
    assert_eq!(run.stdout, "");
    assert!(run.stderr.contains("wrote x.exr") && run.stderr.contains("wrote x.png"), "{run:?}");
    let (linear, picture) = (bench.image("x.exr"), bench.image("x.png"));
    assert_eq!([linear.width, linear.height, picture.width, picture.height], [16, 12, 16, 12]);
    assert_finite_and_lit(&linear);
    assert_finite_and_lit(&picture);
    assert!(!bench.path("default.exr").exists());

    // Without -o the film's name counts, and without that the scene's.
    bench.rendered(&["--iterations", "1", "--resolution", "8x4"]);
    assert_eq!((bench.image("default.exr").width, bench.image("default.exr").height), (8, 4));
    bench.write("scene.pbrt", scene(" \"string filename\" \"default.exr\"", ""));
    bench.rendered(&["--iterations", "1"]);
    assert!(bench.path("scene.exr").exists());
}

#[test]
fn warnings_name_their_place_and_quiet_is_silent() {
    let bench = Bench::new();
    bench.write("scene.pbrt", scene("\"sppm\" \"integer maxdepth\" 6", "\"path\"\n#"));
    let arguments = ["--photons", "500", "-o", "x.exr"];
    let run = bench.rendered(&arguments);
    assert!(run.stderr.contains("warning: scene.pbrt:5:12: Integrator \"path\" is rendered as \"sppm\""), "{run:?}");
    let run = bench.rendered(&[&arguments[..], &["--quiet"]].concat());
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
}

#[test]
fn stats_say_what_was_rendered() {
    let bench = Bench::new();
    bench.rendered(&["-o", "x.exr", "--stats", "x.json", "--photons", "501", "--iterations", "3"]);
    let stats = bench.json("x.json");
    let count = |key: &str| stats[key].as_u64().unwrap_or_else(|| panic!("{key} in {stats:#}"));
    let number = |value: &Value| value.as_f64().filter(|value| value.is_finite()).expect("a finite number");

    for key in ["device", "driver"] {
        assert!(!stats[key].as_str().unwrap().is_empty(), "{key}");
    }
    for (kind, expected) in [("triangles", 4), ("spheres", 1), ("point_lights", 1), ("dielectric_shapes", 1)] {
        assert_eq!(stats["scene"][kind], expected, "{kind} in {stats:#}");
    }
    assert_eq!((count("iterations"), count("photons")), (3, 3 * 501));
    let [seconds, radius] = [&stats["seconds"], &stats["radius"]];
    let parts = ["load", "build", "compile", "render"].map(|part| number(&seconds[part]));
    assert!(parts.iter().all(|part| *part >= 0.0) && parts.iter().sum::<f64>() <= number(&seconds["total"]));
    let rate = number(&stats["photons_per_second"]);
    assert!((rate * parts[3] / 1503.0 - 1.0).abs() < 1e-6, "{rate} photons/s");
    let passes = stats["passes"].as_object().unwrap();
    assert!(passes.contains_key("eye") && passes.contains_key("photon"), "{passes:?}");
    assert!(passes.values().all(|pass| number(pass) >= 0.0) && passes.values().any(|pass| number(pass) > 0.0));
    assert_eq!(number(&seconds["kd_build"]), 0.0, "there is no kd-tree");
    let [least, most] = ["min", "max"].map(|bound| number(&radius[bound]));
    assert!(0.0 < least && least < most && most <= 0.5 * (1.0 + 1e-6), "{radius}");
    assert!(count("device_memory_bytes") > 0);
    assert_eq!((&stats["non_finite"], &stats["saturated"]), (&none_by_pass(), &none_by_pass()));

    // Every photon ended in exactly one way.
    let ends = count("deposited") + count("absorbed") + count("escaped") + count("truncated");
    let lost = count("lost_in_glass") - count("eye_lost_in_glass");
    assert_eq!(count("emitted"), ends + lost, "{stats:#}");
    assert_eq!(count("emitted"), count("photons"), "{stats:#}");
    assert!(count("recorded") > 0 && count("deposited") > 0 && count("escaped") > 0, "{stats:#}");

    bench.rendered(&["-o", "x.exr", "--stats", "x.json", "--iterations", "1", "--lookup", "kd-tree"]);
    let stats = bench.json("x.json");
    let build = number(&stats["seconds"]["kd_build"]);
    assert!(build > 0.0 && build <= number(&stats["seconds"]["render"]), "{stats:#}");
    assert!(stats["passes"]["gather_tree"].is_number(), "{stats:#}");
}

#[test]
fn time_and_iterations_stop_a_render() {
    let bench = Bench::new();
    // The scene's own 2 iterations are no bound beside a time.
    bench.rendered(&["--time", "0.2", "-o", "x.exr", "--stats", "x.json"]);
    let stats = bench.json("x.json");
    assert!(stats["seconds"]["render"].as_f64().unwrap() >= 0.2 && stats["iterations"].as_u64().unwrap() >= 1);
    // Whichever comes first.
    bench.rendered(&["--time", "3600", "--iterations", "1", "-o", "x.exr", "--stats", "x.json"]);
    assert_eq!(bench.json("x.json")["iterations"], 1);
}

#[test]
fn the_same_command_gives_the_same_bytes() {
    let (first, second) = (Bench::new(), Bench::new());
    for bench in [&first, &second] {
        bench.rendered(&["-o", "x.exr", "-o", "x.png"]);
    }
    for name in ["x.exr", "x.png"] {
        assert!(first.bytes(name) == second.bytes(name), "{name}");
    }
    second.rendered(&["-o", "x.exr", "--seed", "1"]);
    assert!(first.bytes("x.exr") != second.bytes("x.exr"), "the seed does nothing");
}

#[test]
fn workgroup_and_batch_sizes_do_not_change_the_bytes() {
    let bench = Bench::new();
    bench.rendered(&["-o", "first.exr"]);
    for (workgroup, batch) in [("32", "500"), ("64", "77"), ("128", "1"), ("128", "333")] {
        bench.rendered(&["-o", "x.exr", "--workgroup-size", workgroup, "--batch-size", batch]);
        assert!(bench.bytes("x.exr") == bench.bytes("first.exr"), "workgroups of {workgroup}, batches of {batch}");
    }
}

#[test]
fn validation_has_nothing_to_say() {
    let bench = Bench::new();
    let run = bench.rendered(&["-o", "x.exr", "--validate"]);
    let lines: Vec<&str> = run.stderr.lines().collect();
    assert!(
        matches!(lines[..], [compiled, summary, "wrote x.exr"]
            if compiled.starts_with("compiled the kernels in ") && summary.starts_with("2 iterations in ")),
        "{run:?}"
    );
}

#[test]
fn whatever_is_in_the_way_of_the_cache_a_render_is_the_same() {
    let bench = Bench::new();
    bench.rendered(&["-o", "without.exr"]);
    bench.write("file", "kept");
    for folder in ["cache", "cache", "file", "file/below"] {
        let run = bench.command(&["render", "scene.pbrt", "-o", "with.exr"]).env(CACHE, folder).output().unwrap();
        let run = Run::of(run);
        assert!(run.code == 0 && bench.bytes("with.exr") == bench.bytes("without.exr"), "{folder}: {run:?}");
    }
    assert_eq!(bench.text("file"), "kept");
    // Where the driver gives its kernels away.
    if let Ok(files) = fs::read_dir(bench.path("cache")) {
        let names: Vec<_> = files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
        assert!(matches!(&names[..], [name] if name.starts_with("kernels-")), "{names:?}");
    }
}

#[test]
fn devices_are_listed() {
    let run = Bench::new().run(&["devices"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    assert!(run.stdout.starts_with("0  ") && run.stdout.contains("driver ") && run.stdout.contains("GiB"), "{run:?}");
    assert!(run.stdout.contains("; fits\n"), "{run:?}");
    assert!(run.stdout.contains("\n   arrays in "), "{run:?}");
}

/// The window of an EXR: its first pixel, and the size of the whole.
fn window(bench: &Bench, name: &str) -> ([i32; 2], [u32; 2]) {
    let layers =
        file::read_layers(&bench.path(name), file::Transfer::Srgb, file::Use::Light, &Budget::default()).unwrap();
    let window = layers.window.unwrap();
    (window.first, window.full)
}

/// What pbrt writes of a crop: its place in the whole image, whoever writes it.
#[test]
fn crops_keep_their_place() {
    let bench = Bench::new();
    bench.rendered(&["-o", "whole.exr"]);
    assert_eq!(window(&bench, "whole.exr"), ([0, 0], [16, 12]));
    for (name, crop, first, size) in [
        ("left", "\"float cropwindow\" [0 .5 0 1]", [0, 0], [8, 12]),
        ("right", "\"integer pixelbounds\" [8 16 0 12]", [8, 0], [8, 12]),
        ("middle", "\"integer pixelbounds\" [5 9 3 7]", [5, 3], [4, 4]),
    ] {
        bench.write("scene.pbrt", scene("\"string filename\"", &format!("{crop} \"string filename\"")));
        let (exr, png, checkpoint) = (format!("{name}.exr"), format!("{name}.png"), format!("{name}.ckpt"));
        bench.rendered(&["-o", &exr, "-o", &png, "--checkpoint", &checkpoint]);
        let image = bench.image(&exr);
        assert_eq!((window(&bench, &exr), [image.width, image.height]), ((first, [16, 12]), size));
        assert_eq!(bench.image(&png).width, size[0]);
        // Without the scene, the checkpoint has to know.
        assert_eq!(bench.run(&["merge", &checkpoint, "-o", "merged.exr"]).code, 0);
        assert!(bench.bytes("merged.exr") == bench.bytes(&exr), "{name}");
        bench.rendered(&["--resume", &checkpoint, "--iterations", "3", "-o", "more.exr"]);
        assert_eq!(window(&bench, "more.exr"), (first, [16, 12]));
        bench.rendered(&["--resolution", "32x24", "-o", "large.exr"]);
        assert_eq!(window(&bench, "large.exr"), (first.map(|at| 2 * at), [32, 24]));
    }
    // They are compared where both have pixels.
    for (image, reference, size) in [("middle", "whole", "4x4"), ("middle", "left", "3x4"), ("right", "middle", "1x4")]
    {
        let run = bench.run(&["compare", &format!("{image}.exr"), &format!("{reference}.exr"), "--diff", "d.png"]);
        assert!(run.code == 0 && run.stdout.contains(&format!("size       {size}\n")), "{run:?}");
        assert!(run.stderr.contains("compared where both have pixels"), "{run:?}");
    }
    let run = bench.run(&["compare", "left.exr", "right.exr"]);
    assert!(run.code == 2 && run.stderr.contains("no pixel in common"), "{run:?}");
    let run = bench.run(&["compare", "left.exr", "left.png"]);
    assert!(run.code == 0 && run.stderr.is_empty(), "{run:?}");
}

#[test]
fn scenes_of_nothing_are_rendered() {
    let bench = Bench::new();
    let sky = "LightSource \"infinite\" \"rgb L\" [ .25 .5 1 ]\n";
    let head = &SCENE[..SCENE.find("LightSource").unwrap()];
    let invisible = "AreaLightSource \"diffuse\" Shape \"sphere\" \"float alpha\" 0\n";
    let lamp = r#"AreaLightSource "diffuse" "rgb L" [ 0 0 0 ]"#;
    let speck = "Shape \"trianglemesh\" \"point3 P\" [ 1 1 1 1 1 1 1 1 1 ]\n";
    for (what, text, pixel, warning) in [
        ("no light", SCENE.replace(LIGHT, ""), [0.0; 3], "the scene has no light, or only black lights"),
        ("a black light", SCENE.replace("5 5 5", "0 0 0"), [0.0; 3], "the scene has no light, or only black lights"),
        ("a black lamp", SCENE.replace(LIGHT, lamp), [0.0; 3], "the scene has no light, or only black lights"),
        ("no shape", format!("{head}{sky}"), [0.25, 0.5, 1.0], "the scene has no shape"),
        ("nothing", head.to_owned(), [0.0; 3], "the scene has no shape"),
        ("an invisible lamp", format!("{head}{sky}{invisible}"), [0.25, 0.5, 1.0], ""),
        ("a point", format!("{head}{sky}{speck}"), [0.25, 0.5, 1.0], ""),
    ] {
        bench.write("scene.pbrt", text);
        // The defaults, and all options that take other kernels.
        for options in [&[][..], &["--direct", "photons", "--lookup", "kd-tree", "--radius-schedule", "global"]] {
            let run = bench.rendered(
                &[&["-o", "x.exr", "--stats", "s.json", "--checkpoint", "a.ckpt", "--validate"], options].concat(),
            );
            assert!(run.stderr.contains(warning), "{what}: {run:?}");
            let image = bench.image("x.exr");
            assert!(image.pixels.iter().all(|it| *it == pixel), "{what} {options:?}: {:?}", image.pixels[0]);
            let stats = bench.json("s.json");
            assert_eq!((&stats["emitted"], &stats["photons"]), (&0.into(), &0.into()), "{what}");
        }
        assert_eq!(bench.run(&["merge", "a.ckpt", "-o", "x.exr"]).code, 0, "{what}");
        assert_eq!(bench.image("x.exr").pixels[0], pixel, "{what}");
        assert_eq!(bench.run(&["info", "scene.pbrt"]).code, 0, "{what}");
    }
    let advice = bench.run(&["advise", "scene.pbrt", "--time", "1", "--probe", "1"]);
    assert_eq!(advice.code, 0, "{advice:?}");
}
