//! Tests of renders in which an iteration fails.

use std::path::Path;

use clap::Parser;

use super::*;
use crate::cli::{Cli, Command};

const SCENE: &str = r#"Film "rgb" "integer xresolution" 16 "integer yresolution" 12
LookAt 0 0 -3  0 0 0  0 1 0
Camera "perspective" "float fov" 60
Integrator "sppm" "integer maxdepth" 6 "integer photonsperiteration" 500 "float radius" 0.5
WorldBegin
LightSource "point" "point3 from" [ 0 1.5 -1 ] "rgb I" [ 5 5 5 ]
Material "diffuse"
Shape "sphere" "float radius" 2
Material "dielectric"
Shape "sphere" "float radius" 0.5
"#;

/// Renders the scene of a folder with further options. Iteration number `fails`, counted from 1, fails.
fn render(folder: &Path, options: &[&str], fails: u32) -> Result<End, Failure> {
    let path = |name: &str| folder.join(name).display().to_string();
    let scene = path("scene.pbrt");
    let mut words = vec!["goblet".to_owned(), "render".to_owned(), scene, "--quiet".to_owned()];
    words.extend(options.iter().map(|word| if word.contains('.') { path(word) } else { (*word).to_owned() }));
    let Command::Render(args) = Cli::try_parse_from(words).unwrap().command else { panic!("not a render") };
    run_with(&args, |renderer| {
        if renderer.iterations() + 1 == fails {
            return Err(goblet_host::Error::DeviceLost { pass: "photon".to_owned() }.into());
        }
        renderer.step()
    })
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.pbrt"), SCENE).unwrap();
    folder
}

#[test]
fn a_failure_loses_no_finished_iteration() {
    let folder = folder();
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let outputs = ["-o", "failed.exr", "-o", "failed.png", "--checkpoint", "x.checkpoint", "--stats", "x.json"];
    let failure = render(folder.path(), &[&["--iterations", "5"], &outputs[..]].concat(), 3).unwrap_err();
    assert_eq!(failure.exit_code(), 1);
    assert_eq!(failure.to_string(), "the device was lost while it ran the pass photon");
    render(folder.path(), &["--iterations", "2", "-o", "two.exr", "-o", "two.png"], 0).unwrap();
    assert!(bytes("failed.exr") == bytes("two.exr") && bytes("failed.png") == bytes("two.png"));
    let stats: serde_json::Value = serde_json::from_slice(&bytes("x.json")).unwrap();
    assert_eq!(stats["iterations"], 2);

    let resume = ["--iterations", "5", "--resume", "x.checkpoint", "-o", "resumed.exr"];
    render(folder.path(), &resume, 0).unwrap();
    render(folder.path(), &["--iterations", "5", "-o", "five.exr"], 0).unwrap();
    assert!(bytes("resumed.exr") == bytes("five.exr"));
}

#[test]
fn a_failure_of_the_first_iteration_leaves_an_older_image_alone() {
    let folder = folder();
    let image = folder.path().join("x.exr");
    std::fs::write(&image, "older").unwrap();
    render(folder.path(), &["--iterations", "5", "-o", "x.exr"], 1).unwrap_err();
    assert_eq!(std::fs::read(&image).unwrap(), b"older");
}
