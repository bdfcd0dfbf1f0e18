//! What an observer is told of a render.

use std::sync::{Arc, Mutex};

use goblet::image::layers::{Group, Groups};
use goblet::scene::Scene;
use goblet::{Activity, Auto, LookupKind, Observer, Options, Prepared, open_device};

use crate::support::{self, command};

/// Returns what an observer is told until one iteration is rendered, and the number of kernels that have run.
fn told(text: &str, options: &Options) -> (Vec<Activity>, usize) {
    let scene = Scene::parse(text, "scene.pbrt", support::root()).expect("a scene");
    let told = Arc::new(Mutex::new(Vec::new()));
    let tell = Arc::clone(&told);
    let observer = Observer::new(move |activity| tell.lock().unwrap().push(activity));
    // Of this render alone.
    let device = Arc::new(open_device(&support::device_options()).expect("a device"));
    let prepared = Prepared::new(&scene, options, observer).expect("a scene that can be rendered");
    let mut renderer = prepared.build(Arc::clone(&device)).expect("a renderer");
    renderer.step().expect("an iteration");
    support::assert_silent(&device);
    let told = told.lock().unwrap().clone();
    (told, device.pass_times().len())
}

#[test]
fn each_activity_is_told_in_its_order() {
    let (told, kernels) = told(command::SCENE, &Options::default());
    let all = kernels as u32;
    let is_compiling = |activity: &&Activity| matches!(activity, Activity::CompilingKernels { .. });
    let compiling: Vec<_> = told.iter().filter(is_compiling).copied().collect();
    assert_eq!(compiling.first(), Some(&Activity::CompilingKernels { done: 0, all }));
    assert_eq!(compiling.last(), Some(&Activity::CompilingKernels { done: all, all }));
    let others: Vec<_> = told.iter().filter(|activity| !is_compiling(activity)).copied().collect();
    use Activity::{BuildingHierarchy, Pilot, Rendering, Uploading};
    assert_eq!(others, [BuildingHierarchy, Uploading, Rendering, Pilot, Rendering]);
    let place = |activity| told.iter().position(|other| *other == activity);
    assert!(place(Uploading) < place(compiling[0]) && place(*compiling.last().unwrap()) < place(Rendering));
}

#[test]
fn a_trial_is_one_activity() {
    let options = Options { auto: Auto { photons: true, eye_paths: true }, ..Options::default() };
    let (told, _) = told(command::SCENE, &options);
    let after: Vec<_> = told.iter().skip_while(|activity| **activity != Activity::Trial).collect();
    assert_eq!(after, [&Activity::Trial, &Activity::Rendering, &Activity::Pilot, &Activity::Rendering]);
}

/// Kernels of one name count as often as they are compiled.
#[test]
fn all_kernels_are_counted_whatever_a_render_needs() {
    let tree = Options { lookup: LookupKind::KdTree, ..Options::default() };
    let (caustics, surface) = (Groups::of(&[Group::Caustic]), Groups::of(&[Group::Albedo, Group::Normal]));
    let cases = [
        (&tree, 0),
        // The gather pass is there twice.
        (&Options { layers: caustics, ..Options::default() }, 1),
        // The sums are those of each group.
        (&Options { layers: surface, ..Options::default() }, 1),
    ];
    for (options, twice) in cases {
        let (told, kernels) = told(command::SCENE, options);
        let all = kernels as u32 + twice;
        assert!(told.contains(&Activity::CompilingKernels { done: all, all }), "{options:?}: {all} in {told:?}");
    }
}
