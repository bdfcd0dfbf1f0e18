//! Files of spectra, through a scene that names one for a light, for a material, and for an index.
#![no_main]

use std::sync::LazyLock;

use goblet::scene::Scene;
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));

const USES: [&str; 3] = [
    "LightSource \"point\" \"spectrum I\" \"fuzz.spd\"",
    "Material \"diffuse\" \"spectrum reflectance\" \"fuzz.spd\"",
    "Material \"conductor\" \"spectrum eta\" \"fuzz.spd\"",
];

fuzz_target!(|bytes: &[u8]| {
    std::fs::write(FOLDER.path().join("fuzz.spd"), bytes).expect("a file");
    for line in USES {
        let text = format!("WorldBegin LightSource \"infinite\" {line} Shape \"sphere\"");
        let _ = Scene::parse(&text, "fuzz.pbrt", FOLDER.path());
    }
});
