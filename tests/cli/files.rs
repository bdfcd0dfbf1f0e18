//! Outputs: what they may not replace, what is written when one of them fails, and who may read them.

use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::process::Command;

use goblet::image::file;
use goblet::image::film::Image;

use crate::support::command::{self, Bench, LIGHT, Run, SCENE, scene};

const MESH: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 1\n1 0 1\n0 1 1\n3 0 1 2\n";
const READS: &str = r#"Include "lamp.pbrt"
LightSource "infinite" "string filename" "sky.png"
Texture "t" "spectrum" "imagemap" "string filename" "tex.png"
Material "conductor" "spectrum eta" "eta.spd"
Shape "plymesh" "string filename" "mesh.ply"
Material "diffuse" "texture reflectance" "t"
Shape "disk""#;

/// A scene that reads a file of each kind.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("scene.pbrt", scene(LIGHT, READS));
    bench.write("lamp.pbrt", LIGHT);
    bench.write("mesh.ply", MESH);
    bench.write("eta.spd", "400 1.5\n700 1.5\n");
    for name in ["sky.png", "tex.png"] {
        file::write(&bench.path(name), &Image::from_pixels(1, 1, vec![[0.5; 3]]).unwrap(), &[]).unwrap();
    }
    bench
}

fn assert_refused(bench: &Bench, arguments: &[&str], words: &[&str]) {
    let run = bench.run(arguments);
    run.assert_refused(&format!("{arguments:?}"), 2, words);
    run.assert_refused(&format!("{arguments:?}"), 2, &["this file", "expected another name for "]);
}

/// Each file of a folder, with its contents.
fn contents(bench: &Bench) -> Vec<(String, Vec<u8>)> {
    let names = fs::read_dir(bench.0.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut all: Vec<_> = names.map(|name| (name.clone(), bench.bytes(&name))).collect();
    all.sort();
    all
}

#[test]
fn no_output_of_a_render_replaces_an_input_or_another_output() {
    let bench = bench();
    bench.rendered(&["--iterations", "1", "-o", "x.exr", "--checkpoint", "kept.exr"]);
    fs::hard_link(bench.path("tex.png"), bench.path("hard.png")).unwrap();
    symlink("tex.png", bench.path("soft.png")).unwrap();
    symlink("new.exr", bench.path("dangling.exr")).unwrap();
    fs::remove_file(bench.path("x.exr")).unwrap();
    // The link leads nowhere: it is not read.
    let all = || {
        fs::remove_file(bench.path("dangling.exr")).unwrap();
        let all = contents(&bench);
        symlink("new.exr", bench.path("dangling.exr")).unwrap();
        all
    };
    let before = all();
    let cases: &[(&[&str], &[&str])] = &[
        (&["-o", "tex.png"], &["goblet: tex.png: the scene reads this file; expected another name for the image"]),
        (&["-o", "new.png", "-o", "./sky.png"], &["./sky.png: the scene reads this file (as sky.png)"]),
        (&["-o", "hard.png"], &["hard.png: the scene reads this file (as tex.png)"]),
        (&["-o", "soft.png"], &["soft.png: the scene reads this file (as tex.png)"]),
        (&["-o", "Tex.PNG"], &["Tex.PNG: the scene reads this file (as tex.png)"]),
        (&["--stats", "scene.pbrt"], &["scene.pbrt: the scene reads this file", "for the statistics"]),
        (&["--stats", "SCENE.PBRT"], &["SCENE.PBRT: the scene reads this file (as scene.pbrt)"]),
        (&["--stats", "lamp.pbrt"], &["lamp.pbrt: the scene reads this file"]),
        (&["--stats", "mesh.ply"], &["mesh.ply: the scene reads this file"]),
        (&["--checkpoint", "eta.spd"], &["eta.spd: the scene reads this file", "for the checkpoint"]),
        (&["--checkpoint", "scene.pbrt"], &["scene.pbrt: the scene reads this file"]),
        (&["-o", "x.exr", "-o", "x.exr"], &["x.exr: this file is also the image;"]),
        (&["-o", "x.exr", "-o", "X.EXR"], &["X.EXR: this file is also the image (as x.exr)"]),
        (&["-o", "new.exr", "-o", "dangling.exr"], &["dangling.exr: this file is also the image (as new.exr)"]),
        (&["-o", "x.exr", "--stats", "x.exr"], &["this file is also the image", "for the statistics"]),
        (&["--checkpoint", "c", "--stats", "c"], &["this file is also the checkpoint", "for the statistics"]),
        (&["--checkpoint", "default.exr"], &["default.exr: this file is also the checkpoint", "for the image"]),
        (&["--resume", "kept.exr", "-o", "kept.exr"], &["this file is also the checkpoint to resume"]),
        (&["--resume", "kept.exr", "--stats", "kept.exr"], &["this file is also the checkpoint to resume"]),
    ];
    for (arguments, words) in cases {
        assert_refused(&bench, &[&["render", "scene.pbrt"], *arguments].concat(), words);
    }
    #[cfg(feature = "view")]
    assert_refused(&bench, &["view", "scene.pbrt", "-o", "tex.png"], &["tex.png: the scene reads this file"]);
    assert!(all() == before, "a file has changed");
    // What is resumed is what is saved again.
    bench.rendered(&["--iterations", "2", "-o", "x.exr", "--resume", "kept.exr", "--checkpoint", "kept.exr"]);
}

/// A scene that is not to be trusted names what it reads.
#[test]
fn the_film_of_a_scene_replaces_nothing_that_it_reads() {
    let bench = bench();
    let before = bench.bytes("tex.png");
    for name in ["tex.png", "./tex.png", "TEX.png"] {
        let film = format!("\"string filename\" \"{name}\"");
        bench.write("scene.pbrt", scene(LIGHT, READS).replace("\"string filename\" \"default.exr\"", &film));
        assert_refused(&bench, &["render", "scene.pbrt"], &[&format!("{name}: the scene reads this file")]);
    }
    assert!(bench.bytes("tex.png") == before);
}

#[test]
fn no_command_replaces_what_it_reads() {
    let bench = bench();
    bench.rendered(&["--iterations", "1", "-o", "a.png", "-o", "b.png"]);
    fs::create_dir(bench.path("out")).unwrap();
    fs::copy(bench.path("a.png"), bench.path("out/setting-1-difference.png")).unwrap();
    for shard in ["0", "1"] {
        let (place, file) = (format!("{shard}/2"), format!("{shard}.exr"));
        bench.rendered(&["--radius-schedule", "global", "--iterations", "2", "--shard", &place, "--checkpoint", &file]);
    }
    let names = ["a.png", "b.png", "0.exr", "1.exr", "out/setting-1-difference.png", "scene.pbrt"];
    let before = names.map(|name| bench.bytes(name));
    let measure = ["measure", "scene.pbrt", "--vary", "photons=500", "-o", "out", "--reference"];
    let cases: &[(&[&str], &str)] = &[
        (&["compare", "a.png", "b.png", "--diff", "a.png"], "this file is also the image to compare"),
        (&["compare", "a.png", "b.png", "--diff", "B.png"], "this file is also the reference (as b.png)"),
        (&["merge", "0.exr", "1.exr", "-o", "1.exr"], "this file is also a checkpoint to merge"),
        (&["merge", "0.exr", "1.exr", "--checkpoint", "0.exr"], "this file is also a checkpoint to merge"),
        (&["merge", "0.exr", "1.exr", "--checkpoint", "x.exr", "-o", "x.exr"], "this file is also the image"),
        (&[&measure[..], &["out/setting-1-difference.png"]].concat(), "this file is also the reference"),
        (&["tessellate", "scene.pbrt", "-o", "scene.pbrt"], ": the scene reads this file"),
        (&["tessellate", "scene.pbrt", "-o", "lamp.pbrt"], ": the scene reads this file"),
    ];
    for (arguments, words) in cases {
        assert_refused(&bench, arguments, &[words]);
    }
    assert!(names.map(|name| bench.bytes(name)) == before, "a file has changed");
    assert_eq!(fs::read_dir(bench.path("out")).unwrap().count(), 1);
}

/// Runs goblet where no file can grow beyond some blocks of 512 bytes, as on a disk that is full.
fn run_with_room(bench: &Bench, blocks: u32, arguments: &[&str]) -> Run {
    let mut command = Command::new("sh");
    // Without the trap, the system kills who writes too much.
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_goblet")]).args(arguments).current_dir(bench.0.path());
    command::isolate(&mut command);
    Run::of(command.output().unwrap())
}

#[test]
fn an_output_that_fails_stops_no_other() {
    let bench = Bench::new();
    let outputs = ["-o", "a.exr", "-o", "a.png", "-o", "b.exr", "--checkpoint", "c", "--stats", "s.json"];
    let render = ["render", "scene.pbrt", "--resolution", "64x48"];
    bench.write("a.exr", "older");
    let run = run_with_room(&bench, 12, &[&render[..], &outputs].concat());
    assert_eq!(run.code, 1, "{run:?}");
    for word in ["goblet: a.exr: cannot write the image", "goblet: b.exr: cannot", "goblet: c: cannot", "wrote a.png"] {
        assert!(run.stderr.contains(word), "`{word}` in {run:?}");
    }
    assert_eq!(bench.bytes("a.exr"), b"older");
    assert!(!bench.path("b.exr").exists() && !bench.path("c").exists());
    assert_eq!(bench.json("s.json")["iterations"], 2);
    let picture = bench.bytes("a.png");
    bench.rendered(&[&render[2..], &outputs].concat());
    assert!(bench.bytes("a.png") == picture, "the picture is whole");
    assert_eq!(fs::read_dir(bench.0.path()).unwrap().count(), 6, "nothing else is left");
}

#[test]
fn merge_and_measure_write_what_they_can() {
    let bench = Bench::new();
    let shard = ["--radius-schedule", "global", "--shard", "0/1", "--checkpoint", "0.checkpoint"];
    bench.rendered(&[&["--resolution", "64x48"], &shard[..]].concat());
    let merge = ["merge", "0.checkpoint", "-o", "m.exr", "-o", "m.png", "--checkpoint", "m.checkpoint"];
    let run = run_with_room(&bench, 12, &merge);
    assert_eq!(run.code, 1, "{run:?}");
    assert!(["m.exr: cannot", "m.checkpoint: cannot"].iter().all(|word| run.stderr.contains(word)), "{run:?}");
    assert!(bench.path("m.png").exists() && !bench.path("m.exr").exists());

    // A folder stands where a result is to be.
    fs::create_dir_all(bench.path("out/results.csv")).unwrap();
    let measure = ["measure", "scene.pbrt", "--reference", "auto", "--budget", "0.1", "--repeat", "1", "-o", "out"];
    let run = bench.run(&measure);
    assert!(run.code == 1 && run.stderr.contains("goblet: out/results.csv: cannot write"), "{run:?}");
    for name in ["results.json", "report.html", "setting-1.exr"] {
        assert!(bench.path("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn modes_survive() {
    let bench = Bench::new();
    let body = "Shape \"revolution\" \"point2 P\" [ 0 0 .5 0 .6 .4 .6 1 ]";
    bench.write("scene.pbrt", format!("{SCENE}{body}"));
    let render = ["--iterations", "1", "-o", "a.exr", "-o", "a.png", "--checkpoint", "c", "--stats", "s.json"];
    let tessellate = ["tessellate", "scene.pbrt", "-o", "t.pbrt", "--tolerance", "0.01"];
    let names = ["a.exr", "a.png", "c", "s.json", "t.pbrt", "t-1.ply"];
    let mode = |name: &str| fs::metadata(bench.path(name)).unwrap().permissions().mode() & 0o7777;
    let run = || {
        bench.rendered(&render);
        assert_eq!(bench.run(&tessellate).code, 0);
    };
    run();
    let usual = mode("scene.pbrt");
    assert!(names.iter().all(|name| mode(name) == usual), "{:?}", names.map(mode));
    for name in names {
        fs::set_permissions(bench.path(name), Permissions::from_mode(0o640)).unwrap();
    }
    run();
    assert!(names.iter().all(|name| mode(name) == 0o640), "{:?}", names.map(mode));
}

#[test]
fn what_is_no_file_is_no_output() {
    let bench = Bench::new();
    assert!(Command::new("mkfifo").arg(bench.path("pipe.exr")).status().unwrap().success());
    for arguments in [
        ["-o", "pipe.exr"],
        ["--checkpoint", "/dev/stdout"],
        ["--stats", "/dev/null"],
        ["--stats", "/dev/stdout"],
        ["--stats", "pipe.exr"],
    ] {
        bench.render(&arguments).assert_refused(&format!("{arguments:?}"), 1, &["exists and is not a file"]);
    }
}
