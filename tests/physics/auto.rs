//! Numbers of photons and eye paths that a trial chooses: noise falls where it is.

use goblet::scene::Scene;
use goblet::{Auto, Choice, Options, Renderer};

use crate::support;

/// Grey ground as a camera above it sees it, with these shapes and lights.
fn ground(rest: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" 64 \"integer yresolution\" 64\nPixelFilter \"box\"\n\
         Integrator \"sppm\" \"integer maxdepth\" 8 \"integer photonsperiteration\" 16384\nLookAt 0 3 3 0 0 0 0 1 0\n\
         Camera \"perspective\" \"float fov\" 40\nWorldBegin\n\
         AttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-2 0 -2 -2 0 2 2 0 2 2 0 -2]\n\
         AttributeEnd\n{rest}"
    )
}

/// What a trial chooses, and the estimated error after some iterations: with the choice, and with the defaults.
fn compare(text: &str) -> (Choice, [f64; 2]) {
    let scene = Scene::parse(text, "test.pbrt", support::root()).expect("a scene");
    let auto = Auto { photons: true, eye_paths: true };
    let [chosen, usual] = [auto, Auto::default()].map(|auto| {
        let options = Options { auto, ..Options::default() };
        let mut renderer = Renderer::new(support::device(), &scene, &options).expect("a renderer");
        (0..16).for_each(|_| renderer.step().expect("an iteration"));
        let error = renderer.relative_error().expect("an estimate").expect("an error");
        support::assert_silent(renderer.device());
        (renderer.choice().copied(), error)
    });
    assert!(usual.0.is_none());
    let choice = chosen.0.expect("a choice");
    println!("{choice}\nerrors {:.4}, by default {:.4}", chosen.1, usual.1);
    (choice, [chosen.1, usual.1])
}

/// The soft shadow of a black ball: photons bring nothing.
#[test]
fn where_eye_paths_have_all_noise_they_get_more() {
    let text = ground(
        "AttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\nTranslate 0 .5 0\n\
         Shape \"sphere\" \"float radius\" .4\nAttributeEnd\n\
         AttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\nAreaLightSource \"diffuse\" \"rgb L\" [9 9 9]\n\
         Translate 1 4 -1\nShape \"sphere\" \"float radius\" .8\nAttributeEnd\n",
    );
    let (Choice { trial, usual, taken, .. }, [error, by_default]) = compare(&text);
    // Sums are subtracted from each other: a part in 10^15 is rounding.
    let [eye, photons] = trial.noise(usual);
    assert!(eye > 0.0 && photons < 1e-15 * eye, "{trial:?}");
    assert!(taken.eye_paths > usual.eye_paths, "{taken:?}");
    // A quarter looks for light that the trial has missed, rounded by an eighth at most.
    assert!((0.21..0.29).contains(&(taken.photons as f64 / usual.photons as f64)), "{taken:?}");
    assert!(error < by_default, "{error} {by_default}");
}

/// A lamp in a glass ball: eye paths find no light.
#[test]
fn where_photons_have_all_noise_there_are_more() {
    let text = ground(
        "Translate 0 1 0\nLightSource \"point\" \"rgb I\" [2 2 2]\nMaterial \"dielectric\"\n\
         Shape \"sphere\" \"float radius\" .3\n",
    );
    let (Choice { trial, usual, taken, .. }, [error, by_default]) = compare(&text);
    assert!(trial.eye_noise == 0.0 && trial.photon_noise > 0.0, "{trial:?}");
    assert!(taken.photons > usual.photons && taken.eye_paths == 1, "{taken:?}");
    assert!(error < by_default, "{error} {by_default}");
}
