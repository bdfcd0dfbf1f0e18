//! Scene text, and what becomes of it for the device. There are no files beside it.
#![no_main]

use goblet::RevolutionSolver;
use goblet::gpu_scene::pack::pack;
use goblet::scene::Scene;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(scene) = Scene::parse(text, "fuzz.pbrt", "/nonexistent") {
        let _ = pack(&scene, RevolutionSolver::default());
    }
});
