//! Numbers that a trial chooses are those of every part of a render.

use goblet::image::film::Image;
use goblet::render::checkpoint::Checkpoint;
use goblet::scene::Scene;
use goblet::{Auto, Options, RadiusSchedule, Renderer, Shard};

use crate::support;

/// A room with a lamp, whose shadows have more noise than the light of photons.
const SCENE: &str = r#"
Film "rgb" "integer xresolution" 40 "integer yresolution" 24
Integrator "sppm" "integer maxdepth" 4 "integer photonsperiteration" 20000
LookAt 0 2 4 0 .5 0 0 1 0
Camera "perspective" "float fov" 40
WorldBegin
AttributeBegin
AreaLightSource "diffuse" "rgb L" [9 9 9]
Translate 1 4 -1
Shape "sphere" "float radius" .8
AttributeEnd
Material "diffuse" "rgb reflectance" [.5 .5 .5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 0 -2 -2 0 2 2 0 2 2 0 -2]
Translate 0 .5 0
Shape "sphere" "float radius" .4
"#;

/// Renders with radii that do not depend on other iterations.
fn renderer(options: &Options) -> Renderer {
    let scene = Scene::parse(SCENE, "scene.pbrt", support::root()).expect("a scene");
    let options = Options { radius_schedule: RadiusSchedule::Global, ..options.clone() };
    Renderer::new(support::device(), &scene, &options).expect("a renderer")
}

fn advance(renderer: &mut Renderer, iterations: u32) {
    (0..iterations).for_each(|_| renderer.step().expect("an iteration"));
}

fn checkpoint(renderer: &Renderer) -> Checkpoint {
    renderer.checkpoint("scene.pbrt").expect("a checkpoint")
}

fn bits(image: &Image) -> Vec<[u32; 3]> {
    image.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

#[test]
fn parts_of_a_render_take_the_same_numbers() {
    let auto = Options { auto: Auto { photons: true, eye_paths: true }, ..Options::default() };
    let mut whole = renderer(&auto);
    let taken = whole.choice().expect("a choice").taken;
    assert!(taken.eye_paths > 4 && taken.photons < 20_000, "{taken:?}");
    advance(&mut whole, 5);
    let image = bits(&whole.resolve().expect("an image"));

    // Someone who gives these numbers gets the same image.
    let given = Options { photons: Some(taken.photons), eye_paths: Some(taken.eye_paths), ..Options::default() };
    let mut explicit = renderer(&given);
    advance(&mut explicit, 2);
    let early = checkpoint(&explicit);
    advance(&mut explicit, 3);
    assert!(explicit.choice().is_none() && bits(&explicit.resolve().expect("an image")) == image);

    let mut resumed = renderer(&auto);
    resumed.resume(&early).expect("the same numbers");
    advance(&mut resumed, 3);
    assert!(bits(&resumed.resolve().expect("an image")) == image, "resumed");

    let shard = |index, iterations| {
        let mut shard = renderer(&Options { shard: Shard { index, count: 2 }, ..auto.clone() });
        advance(&mut shard, iterations);
        checkpoint(&shard)
    };
    let mut merged = shard(0, 3);
    merged.merge(&shard(1, 2)).expect("shards of one render");
    assert!(bits(&merged.estimate.image()) == image, "shards");

    let usual = renderer(&Options::default()).resume(&early).expect_err("other numbers").to_string();
    assert!(usual.contains("eye paths per iteration") || usual.contains("photons per iteration"), "{usual}");
}

/// Neither batches nor workgroups change what a trial finds.
#[test]
fn a_trial_does_not_depend_on_how_it_is_run() {
    let auto = Options { auto: Auto { photons: true, eye_paths: true }, ..Options::default() };
    let trial = |options: &Options| renderer(options).choice().expect("a choice").trial;
    let plain = trial(&auto);
    let other = Options { batch_size: Some(1000), workgroup_size: Some(32), ..auto };
    assert_eq!(trial(&other), plain);
}
