//! Renders against images of an unbiased renderer that is not a photon mapper: linear
//! radiance, at the settings that each scene states.
//!
//! The bounds on relMSE are 1.15 times what another photon mapper reaches at the same
//! radius, photons, iterations and depth.

use goblet::Options;
use goblet::image::compare::{Gates, compare};
use goblet::image::file::read;
use goblet::scene::Scene;

use crate::support;

#[test]
fn cornell_caustic_matches_the_reference() {
    assert_matches("cornell-caustic", 0.00330, 0.015);
}

#[test]
fn caustic_point_matches_the_reference() {
    assert_matches("caustic-point", 0.01584, 0.015);
}

#[test]
fn lights_match_the_reference() {
    assert_matches("lights", 0.00875, 0.015);
}

#[test]
fn revolution_matches_the_reference() {
    assert_matches("revolution", 0.01333, 0.015);
}

#[test]
fn rough_surfaces_match_the_reference() {
    assert_matches("rough", 0.00841, 0.015);
}

#[test]
fn layered_surfaces_match_the_reference() {
    assert_matches("layers", 0.01863, 0.015);
}

#[test]
fn spectra_match_the_reference() {
    assert_matches("spectra", 0.01753, 0.015);
}

#[test]
fn textures_match_the_reference() {
    assert_matches("textures", 0.00750, 0.015);
}

#[test]
fn shapes_match_the_reference() {
    assert_matches("shapes", 0.01917, 0.015);
}

/// The reference absorbs by wavelength, which differs from absorption in three channels where colours are strong:
/// the mean may differ by more. Other photon mappers ignore media: the bound on relMSE is about ten times that of the
/// reference itself.
#[test]
fn absorbing_media_match_the_reference() {
    assert_matches("tinted", 0.0100, 0.02);
}

#[test]
fn bumps_match_the_reference() {
    assert_matches("bumps", 0.01700, 0.02);
}

/// The reference follows single wavelengths, and so does goblet: colours that glass splits are those of the same curves.
#[test]
fn split_colors_match_the_reference() {
    assert_matches("prism", 0.03300, 0.02);
}

/// Renders a scene as it asks to be rendered, and compares.
fn assert_matches(name: &str, max_relmse: f64, max_energy: f64) {
    let folder = support::root().join("tests/reference");
    let scene = Scene::load(folder.join(format!("{name}.pbrt"))).expect("a scene");
    assert_eq!(scene.integrator.iterations, 64);
    assert_eq!(scene.integrator.photons_per_iteration, Some(65536));

    let rendered = support::render_scene(&support::device(), &scene, &Options::default(), 64);
    let reference = read(&folder.join(format!("{name}.exr"))).expect("a reference");
    let comparison = compare(&rendered.image, &reference).expect("images of one size");
    let gates = Gates { max_relmse: Some(max_relmse), max_energy: Some(max_energy) };
    let failures = comparison.failures(&gates);
    assert!(failures.is_empty(), "{failures:#?}\n{comparison:#?}");
    println!(
        "{name}: relMSE {:.5} of {max_relmse}, energy {:.4}",
        comparison.relmse_trimmed, comparison.energy_ratio_trimmed
    );
}
