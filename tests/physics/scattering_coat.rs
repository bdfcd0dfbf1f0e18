//! Coats that scatter light, against a random walk through pbrt-v4's layers.

use glam::DVec3;
use goblet::{DirectLight, Options};

use super::{EYE_ONLY, Shot, assert_near, assert_uniform, camera, scene_text, square};
use crate::support::layered::Layered;
use crate::support::random::Rng;
use crate::support::{self, mean};

const THIN: Layered = Layered { thickness: 0.1, albedo: 0.8, g: 0.0, reflectance: 0.5, eta: 1.5, alpha: 0.0 };

fn coated(coat: &Layered) -> String {
    let Layered { thickness, albedo, g, reflectance, eta, alpha } = *coat;
    format!(
        "Material \"coateddiffuse\" \"rgb reflectance\" [{reflectance} {reflectance} {reflectance}] \
         \"rgb albedo\" [{albedo} {albedo} {albedo}] \"float g\" {g} \"float thickness\" {thickness} \"float eta\" {eta} \
         \"float roughness\" {alpha} \"bool remaproughness\" false\n"
    )
}

fn at(cos: f64, phi: f64) -> DVec3 {
    let sin = (1.0 - cos * cos).sqrt();
    DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

fn seen_from(w: DVec3) -> String {
    let [x, y, z] = (4.0 * w).to_array();
    camera(&format!("{x} {y} {z}  0 0 0  0.1 1 0.2"), 0.2)
}

/// The share of even light that comes back towards the eye.
fn albedo(coat: &Layered, cos: f64) -> f64 {
    let world = format!("LightSource \"infinite\" \"rgb L\" [1 1 1]\n{}{}", coated(coat), square(1.0, 0.0));
    mean(&Shot { resolution: [16; 2], ..EYE_ONLY }.take(&seen_from(at(cos, 0.3)), &world).image)[0]
}

fn assert_albedos(coats: &[Layered], tolerance: f64) {
    let mut rng = Rng(1);
    let mut most: f64 = 0.0;
    for coat in coats {
        for cos in [0.95, 0.6, 0.3] {
            let (found, expected) = (albedo(coat, cos), coat.albedo(cos, 400_000, &mut rng));
            let off = found / expected - 1.0;
            println!("{coat:?} at {cos}: {found:.4}, walks {expected:.4}, off by {off:.4}");
            most = most.max(off.abs());
        }
    }
    assert!(most < tolerance, "off by {most}, more than {tolerance}");
}

#[test]
fn smooth_coats_have_the_albedo_of_a_random_walk() {
    let coats = [
        THIN,
        Layered { thickness: 0.01, albedo: 0.5, ..THIN },
        Layered { thickness: 1.0, ..THIN },
        Layered { thickness: 1.0, reflectance: 0.0, ..THIN },
        Layered { thickness: 1.0, g: 0.7, ..THIN },
        Layered { thickness: 0.3, g: 0.9, reflectance: 0.1, ..THIN },
        Layered { thickness: 1.0, g: -0.5, reflectance: 0.2, ..THIN },
        Layered { thickness: 5.0, albedo: 0.99, ..THIN },
        Layered { thickness: 0.5, albedo: 0.9, eta: 1.3, reflectance: 0.9, ..THIN },
        Layered { thickness: 2.0, albedo: 0.9, eta: 2.0, reflectance: 0.2, ..THIN },
    ];
    assert_albedos(&coats, 0.01);
}

#[test]
fn rough_coats_are_near_the_albedo_of_a_random_walk() {
    let coats = [
        Layered { thickness: 1.0, alpha: 0.1, ..THIN },
        Layered { thickness: 0.3, alpha: 0.3, ..THIN },
        Layered { thickness: 3.0, alpha: 0.3, albedo: 0.95, ..THIN },
    ];
    assert_albedos(&coats, 0.04);
}

/// Radiance by angle: the product of two functions of one angle each is not quite that of a walk.
#[test]
fn radiance_by_angle_is_near_that_of_a_random_walk() {
    let mut rng = Rng(2);
    for coat in [
        THIN,
        Layered { thickness: 1.0, ..THIN },
        Layered { thickness: 1.0, reflectance: 0.0, ..THIN },
        Layered { thickness: 5.0, albedo: 0.99, ..THIN },
        Layered { thickness: 0.5, g: 0.6, ..THIN },
    ] {
        let mut most: f64 = 0.0;
        for (from, to) in [
            (at(0.9, 0.0), at(0.9, 0.5)),
            (at(0.9, 0.0), at(0.4, 3.0)),
            (at(0.5, 0.0), at(0.7, 1.5)),
            (at(0.4, 0.0), at(0.4, 3.1)),
            (at(0.4, 0.0), at(0.4, 0.3)),
        ] {
            let [x, y, z] = from.to_array();
            let light = format!(
                "LightSource \"distant\" \"rgb L\" [1 1 1] \"point3 from\" [{x} {y} {z}] \"point3 to\" [0 0 0]\n"
            );
            let world = format!("{light}{}{}", coated(&coat), square(1.0, 0.0));
            let found = mean(&Shot { resolution: [16; 2], ..EYE_ONLY }.take(&seen_from(to), &world).image)[0] / from.z;
            let expected = coat.bsdf(from, to, 400_000, &mut rng);
            let off = found / expected - 1.0;
            println!("{coat:?} from {from:.2} to {to:.2}: {found:.4}, walks {expected:.4}, off by {off:.4}");
            most = most.max(off.abs());
        }
        assert!(most < 0.04, "{coat:?}: off by {most}");
    }
}

/// What absorbs nothing is as bright as the sky, whatever it scatters.
#[test]
fn white_scattering_coats_vanish_in_a_furnace() {
    for (thickness, g) in [(0.2, 0.5), (20.0, 0.0)] {
        let coat = Layered { thickness, albedo: 1.0, g, reflectance: 1.0, ..THIN };
        let sky = "LightSource \"infinite\" \"rgb L\" [1 1 1]";
        let world = format!("{sky}\n{}Rotate 40 1 2 0\n{}", coated(&coat), square(5.0, 0.0));
        let rendered = EYE_ONLY.take(&camera("0 0 4  0 0 0  0 1 0", 30.0), &world);
        assert_uniform(&format!("{coat:?}"), &rendered.image, [1.0; 3], 0.3);
    }
}

fn options(direct: DirectLight) -> Options {
    Options {
        resolution: Some([16; 2]),
        photons: Some(support::work(20_000, 80_000)),
        radius: Some(0.05),
        alpha: Some(1.0),
        eye_paths: Some(4),
        direct,
        ..Options::default()
    }
}

/// Photons carry the factor of the angle at which they arrive, and eye paths that at which they look.
#[test]
fn photons_and_eye_paths_agree_on_scattering_coats() {
    let light = "LightSource \"spot\" \"rgb I\" [9 9 9] \"point3 from\" [3 0 4] \"point3 to\" [0 0 0] \
        \"float coneangle\" 4 \"float conedeltaangle\" 0\n";
    let material = "Material \"coateddiffuse\" \"rgb reflectance\" [.9 .5 .1] \"rgb albedo\" [.5 .9 .99] \
        \"float thickness\" .7 \"float g\" .3\n";
    let world = format!("{light}{material}{}", square(0.5, 0.0));
    let lit = [DirectLight::Nee, DirectLight::Photons].map(|direct| {
        let text = scene_text(&camera("0 0 6  0 0 0  0 1 0", 2.0), &world);
        // The lobe of a visible point is chosen once an iteration.
        mean(&support::render(&text, &options(direct), 128).image)
    });
    assert_near("photons", lit[1], lit[0], 0.01);
}

/// Tables by textures, against coats of the same values everywhere.
#[test]
fn textured_scattering_is_that_of_each_point() {
    let board = |name: &str, class: &str, tex1: &str, tex2: &str| {
        format!("Texture \"{name}\" \"{class}\" \"checkerboard\" \"float uscale\" 1 \"float vscale\" 2 {tex1} {tex2}\n")
    };
    let textures = [
        board("t", "float", "\"float tex1\" .13", "\"float tex2\" 1.7"),
        board("a", "spectrum", "\"rgb tex1\" [.9 .5 .2]", "\"rgb tex2\" [.3 .7 .99]"),
        board("g", "float", "\"float tex1\" .2", "\"float tex2\" -.4"),
    ]
    .concat();
    let halves = |coat: &str| {
        let sky = "LightSource \"infinite\" \"rgb L\" [1 1 1]\n";
        let material = format!("Material \"coateddiffuse\" \"rgb reflectance\" [.9 .5 .1] {coat}\n");
        let world = format!("{sky}{textures}{material}{} \"point2 uv\" [0 0 1 0 1 1 0 1]", square(1.0, 0.0));
        let image = Shot { resolution: [16; 2], ..EYE_ONLY }.take(&camera("0 0 1  0 0 0  0 1 0", 60.0), &world).image;
        [16..112, 144..240].map(|pixels| {
            let count = pixels.len() as f64;
            [0, 1, 2].map(|c| image.pixels[pixels.clone()].iter().map(|pixel| f64::from(pixel[c])).sum::<f64>() / count)
        })
    };
    let [t, a, g] = ["\"texture thickness\" \"t\"", "\"texture albedo\" \"a\"", "\"texture g\" \"g\""];
    let values = |i: usize| {
        (
            ["\"float thickness\" .13", "\"float thickness\" 1.7"][i],
            ["\"rgb albedo\" [.9 .5 .2]", "\"rgb albedo\" [.3 .7 .99]"][i],
            ["\"float g\" .2", "\"float g\" -.4"][i],
        )
    };
    for by in [[true, false, false], [false, true, false], [false, false, true], [true, true, true]] {
        let pick =
            |is_texture: bool, texture: &'static str, value: &'static str| if is_texture { texture } else { value };
        // Values without a texture are those of the first kind of checks.
        let (t0, a0, g0) = values(0);
        let textured = halves(&format!("{} {} {}", pick(by[0], t, t0), pick(by[1], a, a0), pick(by[2], g, g0)));
        let of = |i: usize| {
            let (ti, ai, gi) = values(i);
            halves(&format!("{} {} {}", pick(by[0], ti, t0), pick(by[1], ai, a0), pick(by[2], gi, g0)))
        };
        assert_near(&format!("{by:?}, below"), textured[1], of(0)[1], 0.01);
        assert_near(&format!("{by:?}, above"), textured[0], of(1)[0], 0.01);
    }
}
