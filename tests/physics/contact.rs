//! Things stand on tables, on each other and in each other: what coincides is as if it were a
//! little apart, in whichever order a scene declares it, with a hierarchy and without.

use goblet::image::compare::compare;
use goblet::image::film::Image;

use super::{Shot, camera, solid, square};
use crate::support::{mean, work};

const SHOT: Shot =
    Shot { resolution: [32; 2], photons: 20_000, iterations: 4, radius: 0.08, alpha: 1.0, depth: 20, eye_paths: 4 };
/// Apart, by what everything that coincides is compared with.
const APART: f64 = 1e-3;
const GLASS: &str = "Material \"dielectric\" \"float eta\" 1.5\n";
const GREY: &str = "Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n";
const LAMP: &str = "LightSource \"point\" \"point3 from\" [0 0 3] \"rgb I\" [20 20 20]\n";

fn block(directives: &str) -> String {
    format!("AttributeBegin\n{directives}\nAttributeEnd\n")
}

fn raised(z: f64, directives: &str) -> String {
    block(&format!("Translate 0.013 0.007 {z:e}\nRotate 17 0 0 1\n{directives}"))
}

fn table() -> String {
    format!("{GREY}{}\n", square(2.0, 0.0))
}

/// Triangles out of sight, so many that the scene needs a hierarchy.
fn crumbs() -> String {
    let crumb = |i: u32| {
        let x = 1.5 + 0.01 * f64::from(i);
        format!("Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [{x} 9 2 {x} 9.01 2 {x} 9 2.01]\n")
    };
    format!("{GREY}{}", (0..30).map(crumb).collect::<String>())
}

/// A glass of a mesh, a body of revolution or a sphere, whose lowest points are at height 0.
fn standing() -> [(&'static str, String); 4] {
    [
        ("block", solid([-0.5, -0.5, 0.0], [0.5, 0.5, 0.6])),
        ("revolution", "Shape \"revolution\" \"integer degree\" 1 \"point2 P\" [0 0 .5 0 .5 .6 0 .6]".to_owned()),
        ("sphere", "Translate 0 0 .4 Shape \"sphere\" \"float radius\" .4".to_owned()),
        ("flat sphere", "Translate 0 0 .02 Scale 1 1 .05 Shape \"sphere\" \"float radius\" .4".to_owned()),
    ]
}

const ABOVE: &str = "0 -3 4  0 0 0  0 0 1";

/// Renders parts in both orders, flat and with a hierarchy, and holds each against the image of the
/// same parts apart. The quick form has each order once.
fn assert_as_apart(what: &str, look: &str, light: &str, apart: &[String], together: &[String]) {
    let view = camera(look, 40.0);
    let expected = SHOT.take(&view, &format!("{light}{}", apart.concat())).image;
    let mut backwards = together.to_vec();
    backwards.reverse();
    let flat = String::new;
    for (order, parts, hierarchies) in [
        ("in order", together, work(vec![flat()], vec![flat(), crumbs()])),
        ("backwards", &backwards[..], work(vec![crumbs()], vec![flat(), crumbs()])),
    ] {
        for more in hierarchies {
            let rendered = SHOT.take(&view, &format!("{light}{}{more}", parts.concat()));
            let tally = rendered.tally;
            assert_eq!([tally.lost_in_glass, tally.eye_lost_in_glass], [0; 2], "{what}: {tally:?}");
            let comparison = compare(&rendered.image, &expected).expect("images of one size");
            println!("{what}, {order}: energy {:.4}, relMSE {:.5}", comparison.energy_ratio, comparison.relmse);
            assert!((comparison.energy_ratio - 1.0).abs() < 0.01, "{what}, {order}: {comparison:?}");
            assert!(comparison.relmse < 0.01, "{what}, {order}: {comparison:?}");
        }
    }
}

#[test]
fn glass_stands_on_a_table() {
    for (name, glass) in standing() {
        let parts = |gap: f64| [format!("{GLASS}{}", raised(gap, &glass)), table()];
        for gap in work(&[0.0][..], &[0.0, 1e-7]) {
            assert_as_apart(&format!("{name} {gap:e}"), ABOVE, LAMP, &parts(APART), &parts(*gap));
        }
    }
}

/// In a closed box under the table there is no light, whatever the gap.
#[test]
fn no_light_leaks_through_a_table_under_glass() {
    let below =
        format!("{GREY}{}", block(&format!("ReverseOrientation\n{}", solid([-2.0, -2.0, -1.0], [2.0, 2.0, 0.0]))));
    for (name, glass) in standing() {
        for gap in work(&[0.0, 1e-6][..], &[0.0, 1e-8, 1e-6, 1e-5]) {
            let parts = [format!("{GLASS}{}", raised(*gap, &glass)), below.clone()];
            let image = SHOT.take(&camera("0 -1 -.5  0 0 0  0 0 1", 90.0), &format!("{LAMP}{}", parts.concat())).image;
            // A sphere is nearer to the table than rays can tell on a disc of a thousandth of its
            // radius: too small to be worth the time (src/gpu_scene/pack/contact/near.rs).
            let most = if name == "sphere" { 1e-3 } else { 0.0 };
            assert!(mean(&image)[0] <= most, "{name} {gap:e}: {:?}", mean(&image));
        }
    }
}

#[test]
fn blocks_of_glass_touch() {
    let cube = |low: [f64; 3], high: [f64; 3]| format!("{GLASS}{}\n", solid(low, high));
    let stacked = |gap: f64| {
        vec![cube([-0.4, -0.4, 0.01], [0.4, 0.4, 0.3]), cube([-0.4, -0.4, 0.3 + gap], [0.4, 0.4, 0.6 + gap]), table()]
    };
    let four = |gap: f64| {
        let at = |x: f64, y: f64| cube([x, y, 0.0], [x + 0.5, y + 0.5, 0.4]);
        let low = -0.5 - 0.5 * gap;
        let high = 0.5 * gap;
        vec![at(low, low), at(high, low), at(low, high), at(high, high), table()]
    };
    assert_as_apart("stacked", ABOVE, LAMP, &stacked(APART), &stacked(0.0));
    assert_as_apart("four", ABOVE, LAMP, &four(APART), &four(0.0));
}

#[test]
fn a_liquid_touches_its_glass() {
    let cup = "Shape \"revolution\" \"integer degree\" 1 \"point2 P\" [0 0 .5 0 .5 .6 .45 .6 .45 .05 0 .05]";
    let liquid = |gap: f64| {
        let (wall, bottom) = (0.45 - gap, 0.05 + gap);
        format!(
            "Material \"dielectric\" \"float eta\" 1.33\n{}",
            raised(
                0.0,
                &format!(
                    "Shape \"revolution\" \"integer degree\" 1 \"point2 P\" \
                     [0 {bottom} {wall} {bottom} {wall} .4 0 .4]"
                )
            )
        )
    };
    let parts = |gap: f64| [format!("{GLASS}{}", raised(0.0, cup)), liquid(gap), table()];
    assert_as_apart("liquid", ABOVE, LAMP, &parts(APART), &parts(0.0));
}

#[test]
fn sheets_lie_on_a_table() {
    let sheets = [
        ("pane", "Material \"thindielectric\"\n"),
        ("paper", "Material \"diffusetransmission\" \"rgb reflectance\" [.3 .3 .3] \"rgb transmittance\" [.5 .5 .5]\n"),
        ("decal", "Material \"diffuse\" \"rgb reflectance\" [.9 .1 .1]\n"),
    ];
    for (name, material) in sheets {
        let parts = |gap: f64| [format!("{material}{}", raised(gap, &square(0.6, 0.0))), table()];
        assert_as_apart(name, ABOVE, LAMP, &parts(APART), &parts(0.0));
    }
    // Holes in a decal show what is behind it.
    let holes = "Texture \"holes\" \"float\" \"checkerboard\" \"float uscale\" 4 \"float vscale\" 4 \
                 \"float tex1\" 0 \"float tex2\" 1\nMaterial \"diffuse\" \"rgb reflectance\" [.9 .1 .1]\n";
    let decal = "Shape \"trianglemesh\" \"texture alpha\" \"holes\" \"integer indices\" [0 1 2 0 2 3] \
                 \"point3 P\" [-.5 -.5 0 .5 -.5 0 .5 .5 0 -.5 .5 0] \"point2 uv\" [0 0 1 0 1 1 0 1]";
    let parts = |gap: f64| [format!("{holes}{}", raised(gap, decal)), table()];
    assert_as_apart("holes", ABOVE, LAMP, &parts(APART), &parts(0.0));
}

#[test]
fn a_lamp_lies_in_the_ceiling() {
    let lamps = [
        ("square", "Rotate 180 1 0 0 ".to_owned() + &square(0.4, 0.0)),
        ("disk", "Rotate 180 1 0 0 Shape \"disk\" \"float radius\" .4".to_owned()),
    ];
    for (name, shape) in lamps {
        let parts = |gap: f64| {
            let lamp = format!("AreaLightSource \"diffuse\" \"rgb L\" [3 3 3]\nTranslate 0 0 {}\n{shape}", 1.0 - gap);
            [format!("{GREY}{}", square(1.0, 1.0)), block(&lamp), format!("{GREY}{}", square(1.0, -0.5))]
        };
        assert_as_apart(name, "0 0 0  0.01 0 1  0 1 0", "", &parts(APART), &parts(0.0));
    }
}

#[test]
fn instances_stand_on_a_table() {
    let object = format!("ObjectBegin \"glass\"\n{GLASS}{}\nObjectEnd\n", solid([-0.2, -0.2, 0.0], [0.2, 0.2, 0.3]));
    let parts = |gap: f64| {
        let at = |x: f64| block(&format!("Translate {x} 0 {gap}\nObjectInstance \"glass\""));
        // Enough of them that they are not copied; the rest is out of sight.
        let far: String = (0..400).map(|i| block(&format!("Translate {} 40 9\nObjectInstance \"glass\"", i))).collect();
        [object.clone(), at(-0.4) + &at(0.4) + &far, table()].concat()
    };
    let view = camera(ABOVE, 40.0);
    let images: Vec<Image> =
        [APART, 0.0].iter().map(|gap| SHOT.take(&view, &format!("{LAMP}{}", parts(*gap))).image).collect();
    let comparison = compare(&images[1], &images[0]).expect("images of one size");
    println!("instances: energy {:.4}, relMSE {:.5}", comparison.energy_ratio, comparison.relmse);
    assert!((comparison.energy_ratio - 1.0).abs() < 0.01 && comparison.relmse < 0.01, "{comparison:?}");
}
