//! What is beyond the ends is refused, with a reason and exit code 2.

use crate::support::command::{Bench, LIGHT, scene};

#[test]
fn what_no_number_can_hold_is_refused() {
    let bench = Bench::new();
    let refuse = |text: String, arguments: &[&str], words: &[&str]| {
        bench.write("scene.pbrt", text);
        let arguments = [&["-o", "x.exr"], arguments].concat();
        bench.render(&arguments).assert_refused(&format!("{words:?}"), 2, words);
        assert!(!bench.path("x.exr").exists(), "{words:?}");
    };
    let light = |intensity: &str| scene(LIGHT, &LIGHT.replace("5 5 5", intensity));
    refuse(light("1e39 1e39 1e39"), &[], &["the power of all lights", "expected 1e-30 to 1e30"]);
    refuse(light("1e-40 0 0"), &[], &["the power of all lights", "expected 1e-30 to 1e30"]);
    refuse(light("1e300 0 0"), &[], &["the power of all lights"]);
    let tiny = "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" 1e39 Shape \"sphere\" \"float radius\" 1e-25 AttributeEnd";
    refuse(scene(LIGHT, &tiny.replace("1e39", "[1e39 1e39 1e39]")), &[], &["a light has a radiance", "at most 3.4"]);

    let ball = |shape: &str| scene("Shape \"sphere\" \"float radius\" 0.5", shape);
    refuse(ball("Shape \"sphere\" \"float radius\" 1e31"), &[], &["a radius of", "expected at most 1e30"]);
    refuse(ball("Shape \"sphere\" \"float radius\" 1e400"), &[], &["scene.pbrt:12:", "not a finite number"]);
    let glass = |eta: &str| scene("Material \"dielectric\"", &format!("Material \"dielectric\" \"float eta\" {eta}"));
    for eta in ["0", "-1.5", "0.01", "1e6"] {
        refuse(glass(eta), &[], &["scene.pbrt:11:", "expected an index of refraction"]);
    }
    let white =
        |albedo: &str| scene("Material \"diffuse\"", &format!("Material \"diffuse\" \"rgb reflectance\" [{albedo}]"));
    refuse(white("1.5 0 0"), &[], &["scene.pbrt:8:"]);
    refuse(white("-.1 0 0"), &[], &["scene.pbrt:8:"]);

    for (arguments, words) in [
        (["--photons", "0"], "expected"),
        (["--photons", "3000000000"], "from 1 to 2147483648"),
        (["--resolution", "0x5"], "expected"),
        (["--resolution", "100000x1"], "each from 1 to 65536"),
        (["--resolution", "65536x65536"], "expected 1 to 268435456"),
        (["--radius", "1e-8"], "a radius of"),
        (["--radius", "1e9"], "a radius of"),
        (["--radius", "nan"], "expected"),
        (["--alpha", "0"], "expected a number above 0 and at most 1"),
        (["--alpha", "1.0001"], "expected a number above 0 and at most 1"),
        (["--max-depth", "0"], "expected"),
    ] {
        refuse(crate::support::command::SCENE.to_owned(), &arguments, &[words]);
    }
}

/// A lamp far smaller and brighter than the sums have room for: the image is cut, and the
/// command says so.
#[test]
fn what_does_not_fit_is_counted_by_pass_and_said() {
    let bench = Bench::new();
    bench.write(
        "scene.pbrt",
        "LookAt 0 0 -1e-5  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" .1\nWorldBegin\n\
         AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\nMaterial \"diffuse\"\n\
         Shape \"sphere\" \"float radius\" 1e-7 AttributeEnd\nTranslate 0 0 1 Shape \"disk\"",
    );
    let options = ["--resolution", "1x1", "--photons", "1000", "--iterations", "3", "--stats", "x.json", "-o", "x.exr"];
    let run = bench.rendered(&options);
    assert!(run.stderr.contains("warning: update: 3 sums saturated: the image is too dark there"), "{}", run.stderr);
    let stats = bench.json("x.json");
    assert_eq!(stats["saturated"], serde_json::json!({ "eye": 0, "photon": 0, "gathering": 0, "update": 3 }));
    let pixel = bench.image("x.exr").pixels[0][0];
    assert!(pixel > 0.05 && pixel < 1.0, "{pixel}");
}
