//! Photons that hardly ever reach what is seen: what is not known is not taken for known.

use serde_json::Value;

use crate::support::command::{Bench, Run};

/// A glass ball above a square floor from `-half` to `half`, under a sun. The floor fills the view.
fn under_the_sun(half: &str, floor: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" 64 \"integer yresolution\" 64\n\
         Sampler \"halton\" \"integer pixelsamples\" 64\nIntegrator \"sppm\" \"integer maxdepth\" 12\n\
         LookAt 0 2 3 0 0 0 0 1 0\nCamera \"perspective\" \"float fov\" 30\nWorldBegin\n\
         LightSource \"distant\" \"point3 from\" [1 3 1] \"point3 to\" [0 0 0] \"rgb L\" [3 3 3]\n\
         {floor}\nAttributeBegin Scale {half} 1 {half}\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-1 0 -1 -1 0 1 1 0 1 1 0 -1]\n\
         AttributeEnd\n{BALL}"
    )
}

const GREY: &str = "Material \"diffuse\"";
const BALL: &str = "Material \"dielectric\" Translate 0 .5 0 Shape \"sphere\" \"float radius\" .4\n";
const WARNING: &str = "warning: light of photons may be missing";

/// Renders without a guide, which would find the light.
fn render(bench: &Bench, scene: &str, arguments: &[&str]) -> (Run, Value) {
    bench.write("scene.pbrt", scene);
    let unguided = ["-o", "x.exr", "--stats", "x.json", "--quiet", "--guide", "off"];
    let run = bench.rendered(&[&unguided, arguments].concat());
    (run, bench.json("x.json"))
}

#[test]
fn a_sun_over_a_large_ground_is_said_to_miss_light() {
    let bench = Bench::new();
    let mut last = 0.0;
    for (half, warns) in [("3", false), ("30", true), ("100", true), ("1000", true)] {
        let (run, stats) = render(&bench, &under_the_sun(half, GREY), &[]);
        assert_eq!(run.stderr.contains(WARNING), warns, "{half}: {}", run.stderr);
        let number = |name: &str| stats[name].as_f64().unwrap_or_else(|| panic!("{name}: {stats:#}"));
        assert_eq!(number("recorded_share"), number("recorded") / number("emitted"));
        // A photon brings what the lamp sends through the scene's bounds, over their number: as the
        // square of the ground's size.
        let one = number("error_of_one_photon");
        assert!(one > 9.0 * last, "{half}: {one} after {last}");
        assert!(number("relative_error") >= one, "{stats:#}");
        last = one;
    }
    assert!(last > 1.0, "the light of one photon is {last} of what is seen of a ground of 1000");
    let guided = bench.rendered(&["-o", "x.exr", "--quiet"]);
    assert!(!guided.stderr.contains(WARNING), "{}", guided.stderr);
}

#[test]
fn photons_that_rightly_bring_nothing_are_no_reason_to_warn() {
    let bench = Bench::new();
    let bare = |floor| under_the_sun("1000", floor).replace(BALL, "");
    let black = "Material \"diffuse\" \"rgb reflectance\" [0 0 0]";
    for (what, scene, arguments) in [
        ("depth of 1", under_the_sun("1000", GREY), &["--max-depth", "1"][..]),
        ("a black floor", under_the_sun("1000", black), &[]),
        ("a bare plane", bare(GREY), &[]),
        ("a small bare plane", under_the_sun("3", GREY).replace(BALL, ""), &["--iterations", "2"]),
        (
            "a ball alone",
            format!("{}Shape \"sphere\" \"float radius\" .7", bare(GREY).split("AttributeBegin").next().unwrap()),
            &[],
        ),
    ] {
        let (run, stats) = render(&bench, &scene, &[&["--target-error", "0.5"], arguments].concat());
        assert_eq!(run.stderr, "", "{what}");
        assert!(stats["iterations"].as_u64() <= Some(8), "{what}: {stats:#}");
    }
}

#[test]
fn a_target_error_is_not_reached_by_what_was_never_sampled() {
    let bench = Bench::new();
    let target = ["--target-error", "0.08", "--iterations", "40"];
    let (_, stats) = render(&bench, &under_the_sun("3", GREY), &target);
    assert!(stats["iterations"].as_u64() < Some(40), "{stats:#}");
    let (run, stats) = render(&bench, &under_the_sun("1000", GREY), &target);
    assert_eq!(stats["iterations"], 40, "{stats:#}");
    assert!(run.stderr.contains(WARNING), "{}", run.stderr);
    let whole = stats["relative_error"].clone();
    // What is known does not depend on where a run was stopped.
    let checkpoint = ["--checkpoint", "x.checkpoint"];
    render(&bench, &under_the_sun("1000", GREY), &[&["--iterations", "9"], &checkpoint[..]].concat());
    let (_, stats) =
        render(&bench, &under_the_sun("1000", GREY), &[&target[..], &["--resume", "x.checkpoint"]].concat());
    assert_eq!((&stats["iterations"], &stats["relative_error"]), (&40.into(), &whole));
}

/// A room that a sky far outside could light through its door: black so far, and no error is known.
#[test]
fn a_black_image_that_photons_could_light_has_no_known_error() {
    let bench = Bench::new();
    let lamp = "AttributeBegin Translate 0 900 0 AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" 1 AttributeEnd\n";
    let shade = "AttributeBegin Translate 0 1.5 0 Rotate 90 1 0 0 Shape \"disk\" \"float radius\" 3000 AttributeEnd\n";
    let scene = under_the_sun("1000", GREY);
    let (before, after) = scene.split_once("LightSource").unwrap();
    let after = after.split_once('\n').unwrap().1;
    let dark = format!("{before}{lamp}{shade}{after}").replace("LookAt 0 2 3", "LookAt 0 1 3");
    let (run, stats) = render(&bench, &dark, &["--target-error", "0.1", "--iterations", "10"]);
    assert!(run.stderr.contains("the image is black"), "{}\n{stats:#}", run.stderr);
    assert_eq!((&stats["iterations"], &stats["relative_error"]), (&10.into(), &Value::Null), "{stats:#}");
}

/// Nothing of the light of a lamp as bright as numbers go is a number: that is a failure, and the
/// image is there for those who want to look.
#[test]
fn a_render_without_any_photon_fails() {
    let bench = Bench::new();
    let lamp = "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [2e38 2e38 2e38] Translate 0 1.5 0\n\
                Shape \"sphere\" \"float radius\" 1e-6 AttributeEnd";
    bench.write("scene.pbrt", under_the_sun("3", &format!("{lamp}\n{GREY}")).replace("LightSource \"distant\"", "#"));
    let run = bench.render(&["-o", "x.exr", "--iterations", "1"]);
    run.assert_refused("bright", 1, &["photon", "not finite", "wrote x.exr"]);
    assert_eq!(bench.image("x.exr").width, 64);
}
