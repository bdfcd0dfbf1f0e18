//! Glass and reflectances at their ends.

use super::{
    EYE_ONLY, SKY, Shot, assert_exact, assert_mean, assert_same, block, camera, diffuse, lamp, render, solid, square,
};
use crate::support::{device, mean};

/// Reflectance at an angle of incidence for unpolarised light.
fn reflectance(eta: f64, cos_i: f64) -> f64 {
    let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (eta * eta)).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// What a slab lets through with all reflections between its faces.
fn slab(reflectance: f64) -> f64 {
    (1.0 - reflectance) / (1.0 + reflectance)
}

fn glass(eta: f64) -> String {
    format!("Material \"dielectric\" \"float eta\" {eta:?}\n")
}

/// All light comes by photons, from the same places in the same directions.
#[test]
fn glass_that_does_not_refract_is_not_there() {
    let device = device();
    let shot =
        Shot { resolution: [16, 16], photons: 20_000, iterations: 2, radius: 0.3, alpha: 1.0, depth: 3, eye_paths: 4 };
    let options = goblet::Options { direct: goblet::DirectLight::Photons, ..shot.options() };
    let world = format!(
        "LightSource \"point\" \"point3 from\" [0 0 3] \"rgb I\" [9 9 9]\n{}{}",
        diffuse(0.5),
        square(2.0, 0.0)
    );
    let shoot = |glass: &str| {
        render(&device, &camera("3 0 3  0 0 0  0 0 1", 30.0), &format!("{world}{glass}"), &options, 2).image
    };
    let ball = |eta: f64| block(&format!("Translate 0 0 1\n{}Shape \"sphere\" \"float radius\" .6", glass(eta)));
    // As large as the ball, and met by no photon: the scene is the same size.
    let expected = shoot(&block(&format!("Translate 0 0 5\n{}Shape \"sphere\" \"float radius\" .6", glass(1.5))));
    assert!(mean(&expected)[0] > 0.1);
    assert_same("an index of 1", &shoot(&ball(1.0)), &expected, 1e-3);
    assert_same("an index of 1.0001", &shoot(&ball(1.0001)), &expected, 1e-2);
}

#[test]
fn glass_of_any_index_vanishes_in_a_furnace() {
    let device = device();
    let ball = || block("Translate -1.2 0 0\nShape \"sphere\"");
    let cube = || block(&format!("Translate 1.2 0 0\nRotate 30 1 2 3\nScale .6 .6 .6\n{}", solid([-1.0; 3], [1.0; 3])));
    for eta in [0.1, 0.5, 1.0, 1.0001, 4.0, 10.0] {
        let world = format!("{SKY}{}{}{}", glass(eta), ball(), cube());
        let rendered = EYE_ONLY.take_checked(&device, &camera("0 0 6  0 0 0  0 1 0", 45.0), &world);
        assert_exact(&format!("index {eta}"), &rendered.image, 1.0, 0.01);
        assert_eq!((rendered.tally.lost_in_glass, rendered.tally.immersed), (0, 0), "index {eta}");
    }
}

/// Down to a millionth of the scene's size.
#[test]
fn panes_of_any_index_and_thickness_let_through_what_fresnel_says() {
    let device = device();
    for (eta, thickness) in [(4.0, 0.1), (0.5, 0.1), (1.0001, 0.1), (1.5, 1e-4), (1.5, 1e-5), (1.5, 2e-6)] {
        let pane = solid([-1.0, -1.0, 0.0], [1.0, 1.0, thickness]);
        let world = format!("{}{}{pane}", lamp(2.0, &square(1.0, -0.5)), glass(eta));
        let rendered =
            Shot { iterations: 4, ..EYE_ONLY }.take_checked(&device, &camera("0 0 3  0 0 0  0 1 0", 1.0), &world);
        let what = format!("index {eta}, {thickness} thick");
        assert_mean(&what, &rendered.image, 2.0 * slab(reflectance(eta, 1.0)), 0.005);
        assert_eq!(rendered.tally.lost_in_glass, 0, "{what}");
    }
}

/// A rod that leads light by 66 total reflections; only its ends let light out.
#[test]
fn a_long_rod_loses_no_light() {
    const LENGTH: f64 = 125.0;
    let inside = (0.5_f64.sqrt() / 1.5).asin();
    assert!(LENGTH * inside.tan() > 64.0);
    let rod = solid([-0.5, -0.5, -LENGTH], [0.5, 0.5, 0.0]);
    let world = format!("{}{}{rod}", lamp(1.0, &square(50.0, -LENGTH - 1.0)), glass(1.5));
    let rendered =
        Shot { iterations: 2, ..EYE_ONLY }.take_checked(&device(), &camera("0 2 2  0 0 0  1 0 0", 4.0), &world);
    assert_mean("rod", &rendered.image, slab(reflectance(1.5, 0.5_f64.sqrt())), 0.005);
    assert_eq!(rendered.tally.lost_in_glass, 0);
}

/// A lamp in a room whose walls are a millionth of its size: nothing gets out.
#[test]
fn walls_of_a_millionth_let_nothing_through() {
    let device = device();
    let shot =
        Shot { resolution: [16, 16], photons: 4096, iterations: 4, radius: 0.2, alpha: 1.0, depth: 8, eye_paths: 4 };
    let inside_out = |mesh: String| block(&format!("ReverseOrientation\n{mesh}"));
    let world = |wall: f64| {
        format!(
            "LightSource \"point\" \"point3 from\" [0 0 0] \"rgb I\" [10 10 10]\n{}{}{}",
            diffuse(0.8),
            inside_out(solid([-1.0; 3], [1.0; 3])),
            solid([-1.0 - wall; 3], [1.0 + wall; 3])
        )
    };
    for wall in [1e-6, 1e-7] {
        for view in ["2 2 2  0 0 0  0 0 1", "0 -3 0  0 0 0  0 0 1"] {
            let outside = shot.take_checked(&device, &camera(view, 60.0), &world(wall));
            assert!(outside.tally.recorded > 10_000);
            assert_eq!(outside.image.pixels, vec![[0.0; 3]; 256], "a wall of {wall} from {view}");
        }
    }
    assert!(mean(&shot.take_checked(&device, &camera("0 -.5 0  0 1 0  0 0 1", 60.0), &world(1e-6)).image)[0] > 1.0);
}

/// After D - 1 reflections at most: a closed white room is as bright as paths are long, and
/// a black one has its lamp's light only.
#[test]
fn white_rooms_add_a_share_for_each_segment_and_black_ones_nothing() {
    let device = device();
    let room = |albedo: f64| {
        format!(
            "{}ReverseOrientation\nAreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\nShape \"sphere\" \"float radius\" 2",
            diffuse(albedo)
        )
    };
    for depth in [1, 20] {
        let shot =
            Shot { resolution: [8, 8], photons: 8192, iterations: 16, radius: 0.5, alpha: 1.0, depth, eye_paths: 4 };
        let look = camera("0.3 0.2 0.1  1 0.5 2  0 1 0", 90.0);
        // Its own light, direct light, and a photon for each of their segments but the first.
        let terms = 1.0 + f64::from(depth);
        assert_mean(&format!("white, {depth}"), &shot.take_checked(&device, &look, &room(1.0)).image, terms, 0.01);
        assert_exact("black", &shot.take_checked(&device, &look, &room(0.0)).image, 1.0, 0.0);
    }
}

/// A channel without light stays exactly black, whatever the others do.
#[test]
fn channels_without_light_stay_black() {
    let device = device();
    let shot =
        Shot { resolution: [16, 16], photons: 5000, iterations: 4, radius: 0.3, alpha: 1.0, depth: 8, eye_paths: 4 };
    let floor = |color: &str| format!("Material \"diffuse\" \"rgb reflectance\" [{color}]\n{}", square(2.0, 0.0));
    let wall =
        "Material \"diffuse\"\nShape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [-2 1 0 2 1 0 0 1 3]\n";
    let ball = |glass: &str| block(&format!("Translate 0 0 .6\n{glass}\nShape \"sphere\" \"float radius\" .5"));
    let light = |color: &str| format!("LightSource \"point\" \"point3 from\" [.5 -1 3] \"rgb I\" [{color}]\n");
    let tint = "Material \"dielectric\" \"rgb transmittance\" [1 0 1]";
    let worlds = [
        ("light", light("9 0 9") + &floor(".5 .5 .5") + wall + &ball("Material \"dielectric\"")),
        ("reflectance", light("9 9 9") + &floor(".5 0 1")),
        ("light and reflectance", light("0 9 9") + &floor("1 0 1") + wall),
    ];
    for (what, world) in worlds {
        let image = shot.take_checked(&device, &camera("0 -3 3  0 0 .3  0 0 1", 40.0), &world).image;
        let [red, green, blue] = mean(&image);
        assert_eq!(if what == "light and reflectance" { red.min(green) } else { green }, 0.0, "{what}");
        assert!(blue > 0.1, "{what}: {blue}");
    }
    // All that is seen through the glass has crossed it.
    let image = shot
        .take_checked(
            &device,
            &camera("0 0 9  0 0 0  0 1 0", 2.0),
            &(light("9 9 9") + &floor(".5 .5 .5") + &ball(tint)),
        )
        .image;
    let [red, green, _] = mean(&image);
    assert!(red > 0.01 && green == 0.0, "{red} {green}");
}

/// A black surface under a sky sends nothing back.
#[test]
fn black_surfaces_are_black() {
    let world = format!("{SKY}{}{}", diffuse(0.0), square(9.0, 0.0));
    let image =
        Shot { photons: 1000, ..EYE_ONLY }.take_checked(&device(), &camera("0 0 4  0 0 0  0 1 0", 40.0), &world).image;
    assert_eq!(image.pixels, vec![[0.0; 3]; 256]);
}
