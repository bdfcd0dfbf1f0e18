//! Cameras in odd places.

use super::{EYE_ONLY, SKY, assert_exact, camera, diffuse, lamp, render, square};
use crate::support::device;

/// Radiance grows with the square of the index where light enters glass.
#[test]
fn a_camera_in_glass_sees_radiance_times_the_squared_index() {
    let device = device();
    for eta in [1.5, 4.0, 0.5_f64] {
        let world = format!("{SKY}Material \"dielectric\" \"float eta\" {eta:?}\nShape \"sphere\"");
        // So near the middle that nothing is reflected totally.
        let image = EYE_ONLY.take_checked(&device, &camera("0 0 0  .1 .2 1  0 1 0", 60.0), &world).image;
        assert_exact(&format!("index {eta}"), &image, eta * eta, 1e-3);
    }
}

#[test]
fn a_camera_in_a_lamp_sees_its_light() {
    let device = device();
    for look in [".1 0 .2  0 0 1  0 1 0", ".99999 0 0  2 .1 0  0 1 0"] {
        let ball = lamp(3.0, "ReverseOrientation Shape \"sphere\"");
        assert_exact(look, &EYE_ONLY.take_checked(&device, &camera(look, 90.0), &ball).image, 3.0, 0.0);
        let two_sided = ball
            .replace("ReverseOrientation ", "")
            .replace("\"diffuse\" \"rgb L\"", "\"diffuse\" \"bool twosided\" true \"rgb L\"");
        assert_exact(look, &EYE_ONLY.take_checked(&device, &camera(look, 90.0), &two_sided).image, 3.0, 0.0);
    }
}

/// A camera on a surface looks away from it, or through it: not at it.
#[test]
fn a_camera_on_a_surface_sees_what_is_before_it() {
    let device = device();
    let floor = format!("{SKY}{}{}", diffuse(0.5), square(1.0, 0.0));
    assert_exact("up", &EYE_ONLY.take_checked(&device, &camera("0 0 0  0 0 1  0 1 0", 60.0), &floor).image, 1.0, 1e-6);
    assert_exact(
        "down",
        &EYE_ONLY.take_checked(&device, &camera("0 0 0  0 0 -1  0 1 0", 60.0), &floor).image,
        1.0,
        1e-6,
    );
    // A hair above it, it sees the surface.
    for height in [1e-3, 1e-6] {
        let look = camera(&format!("0 0 {height:?}  0 0 -1  0 1 0"), 60.0);
        assert_exact(&format!("{height} above"), &EYE_ONLY.take_checked(&device, &look, &floor).image, 0.5, 1e-5);
    }
}

/// All directions, from the middle of a lamp and from a corner of a room.
#[test]
fn a_camera_sees_in_all_directions() {
    let device = device();
    let ball = lamp(3.0, "ReverseOrientation Shape \"sphere\"");
    let image =
        render(&device, "LookAt .5 .2 0  1 0 0  0 0 1\nCamera \"spherical\"", &ball, &EYE_ONLY.options(), 1).image;
    assert_exact("all around", &image, 3.0, 0.0);
}
