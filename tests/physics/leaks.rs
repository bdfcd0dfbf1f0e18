//! Light stays where it belongs.

use super::{Shot, camera, solid, square};
use crate::support::mean;

/// A lamp in a room with walls thinner than the radius. Outside, a ground continues just
/// below the room's floor: nearer to its photons than the radius, but not on its surface.
#[test]
fn no_light_leaks_through_thin_walls_or_to_a_lower_floor() {
    let inside_out = |mesh: String| format!("AttributeBegin\nReverseOrientation\n{mesh}\nAttributeEnd\n");
    let room = |z: f64, wall: f64| {
        let inner = inside_out(solid([-1.0, -1.0, z], [1.0, 1.0, 2.0]));
        if wall == 0.0 {
            inner
        } else {
            inner + &solid([-1.0 - wall, -1.0 - wall, z - 0.001], [1.0 + wall, 1.0 + wall, 2.0 + wall])
        }
    };
    let shot =
        Shot { resolution: [32; 2], photons: 4096, iterations: 8, radius: 0.2, alpha: 1.0, depth: 8, eye_paths: 4 };
    for wall in [0.0, 0.01] {
        let world = format!(
            "LightSource \"point\" \"point3 from\" [0 0 1] \"rgb I\" [10 10 10]\n\
             Material \"diffuse\" \"rgb reflectance\" [.8 .8 .8]\n{}{}",
            room(0.06, wall),
            square(4.0, 0.0)
        );
        let outside = shot.take(&camera("3 2 1.5  1 0 .3  0 0 1", 50.0), &world);
        assert!(outside.tally.recorded > 10_000);
        let lit = outside.image.pixels.iter().filter(|pixel| **pixel != [0.0; 3]).count();
        assert_eq!(lit, 0, "pixels outside a wall of {wall}");
        let inside = shot.take(&camera("-.5 -.5 1  1 0 .3  0 0 1", 50.0), &world);
        assert!(mean(&inside.image)[0] > 1.0);
    }
}

/// On one floor, light reaches past the foot of a wall by the radius and no further.
#[test]
fn light_passes_under_a_wall_no_further_than_the_radius() {
    const RADIUS: f64 = 0.2;
    let world = format!(
        "LightSource \"point\" \"point3 from\" [-1 0 1] \"rgb I\" [10 10 10]\n\
         Material \"diffuse\" \"rgb reflectance\" [.8 .8 .8]\n\
         AttributeBegin\nReverseOrientation\n{}\nAttributeEnd\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [0 -2 0  0 2 0  0 2 2  0 -2 2]",
        solid([-2.0, -2.0, 0.0], [2.0, 2.0, 2.0])
    );
    // Pixels are 1/16 wide on the floor.
    let shot = Shot {
        resolution: [32; 2],
        photons: 200_000,
        iterations: 1,
        radius: RADIUS,
        alpha: 1.0,
        depth: 8,
        eye_paths: 4,
    };
    let image = shot.take(&camera("1 0 1  1 0 0  0 1 0", 90.0), &world).image;
    let mut near = 0.0;
    for (index, pixel) in image.pixels.iter().enumerate() {
        // Screen right is -x: the wall is on the right.
        let from_wall = 2.0 - (index % 32) as f64 / 16.0;
        if from_wall > RADIUS + 1.0 / 16.0 {
            assert_eq!(*pixel, [0.0; 3], "{from_wall} from the wall");
        } else {
            near += f64::from(pixel[0]);
        }
    }
    assert!(near > 0.0);
}

/// Rays among many instances that stand in each other take more rounds of loops than llvmpipe
/// allows an invocation. Fewer eye paths in one dispatch take fewer.
#[test]
fn instances_that_stand_in_each_other_are_seen() {
    let mut world = String::from(
        "LightSource \"infinite\" \"rgb L\" [1 1 1]\nMaterial \"dielectric\"\n\
         ObjectBegin \"bead\" Shape \"sphere\" \"float radius\" .05 ObjectEnd\n",
    );
    for i in 0..6000 {
        let (x, y) = (0.02 * f64::from(i % 80) - 0.8, 0.02 * f64::from(i / 80));
        world += &format!("AttributeBegin Translate {x} {y} .8 ObjectInstance \"bead\" AttributeEnd\n");
    }
    let shot =
        Shot { resolution: [16; 2], photons: 1, iterations: 1, radius: 0.1, alpha: 1.0, depth: 20, eye_paths: 4 };
    let image = shot.take(&camera("0 1 3.5  0 1 0  0 1 0", 45.0), &world).image;
    assert!(image.pixels.iter().all(|pixel| *pixel == [1.0; 3] || pixel.iter().all(|channel| *channel < 1.01)));
    assert!(mean(&image)[0] > 0.3);
}
