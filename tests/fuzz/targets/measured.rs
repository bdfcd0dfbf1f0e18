//! Files of measured materials, through the scene that names one.
#![no_main]

use std::sync::LazyLock;

use goblet::scene::Scene;
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));

const SCENE: &str =
    "WorldBegin LightSource \"infinite\" Material \"measured\" \"string filename\" \"fuzz.bsdf\" Shape \"disk\"";

fuzz_target!(|bytes: &[u8]| {
    std::fs::write(FOLDER.path().join("fuzz.bsdf"), bytes).expect("a file");
    let _ = Scene::parse(SCENE, "fuzz.pbrt", FOLDER.path());
});
