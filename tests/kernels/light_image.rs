//! light_image.glsl: lights that show an image, from the scene's text to their photons.

use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};
use goblet::geometry::equal_area;
use goblet::gpu_scene::pack::Packing;
use goblet::image::film::Image;

use crate::fixture::{Fixture, Rng, UNBOUNDED, double, single};
use crate::generated::{
    EmitPhotons, Emitted, Escape, GUIDE_LEAF, GuideLight, GuideNode, MeetSkies, NONE, Specialization, Viewpoint,
};
use crate::light::see;
use crate::statistics::{assert_near, assert_uniform, cells};
use crate::support::ImageFile;
use crate::world::World;

const COUNT: usize = 1 << 18;
/// Where a place in f64 and its twin in fp32 may be in different texels.
const NEAR_EDGE: f64 = 1e-4;

/// Colours from 0.1 to 10, a quarter of them black, and one that outshines all.
fn spots(width: u32, height: u32) -> Image {
    let mut rng = Rng(u64::from(width * height));
    let mut color = || if rng.chance(0.25) { [0.0; 3] } else { [(); 3].map(|()| rng.log_range(0.1, 10.0) as f32) };
    let mut pixels: Vec<[f32; 3]> = (0..width * height).map(|_| color()).collect();
    pixels[(width * height / 3) as usize] = [500.0, 400.0, 300.0];
    Image::from_pixels(width, height, pixels).expect("an image")
}

/// A light of an image under a transform that turns and mirrors, above a ball.
fn world(light: &str, image: &Image) -> World {
    world_for(light, image, false)
}

/// The same for emission with or without a guide.
fn world_for(light: &str, image: &Image, is_guided: bool) -> World {
    let file = ImageFile::new(image);
    let text = format!(
        "WorldBegin\nShape \"sphere\"\nTranslate .3 .2 .1\nRotate 40 1 2 3\nScale -2 2 2\n\
         LightSource {light} \"string filename\" \"{}\"",
        file.path().display()
    );
    World::parse_for(&text, Packing { is_guided, ..Packing::default() }).0
}

/// What the transform of [`world`] makes of the axes.
fn turned() -> DMat3 {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 40_f64.to_radians());
    turn * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0))
}

/// Emits photons without a guide, and with one that changes no number.
fn emit(world: &World, is_guided: bool) -> Vec<Emitted> {
    let fixture = Fixture::new();
    let world = world.upload(&fixture);
    let emitted = fixture.output(COUNT);
    let leaf = GuideNode { axis: GUIDE_LEAF, lower: 0, at: 0.0, value: 1.0 };
    let light = GuideLight { end: 1.0, light: 0, pad0: 0, pad1: 0 };
    let (guide_nodes, guide_lights) = (&fixture.upload_texels(&[leaf]), &fixture.upload_texels(&[light]));
    let kernel = EmitPhotons { scene: world.bindings(), guide_nodes, guide_lights, emitted: &emitted };
    let mut specialization = Specialization::DECLARED;
    specialization.render.has_guide = is_guided;
    fixture.run_specialized(&kernel, &specialization, COUNT);
    fixture.read(&emitted)
}

/// The texel at a place, unless it is near another one.
fn texel(image: &Image, place: DVec2) -> Option<usize> {
    let at = place * DVec2::new(image.width.into(), image.height.into());
    let distance = (at - at.round()).abs().min_element();
    (distance > NEAR_EDGE).then(|| at.y as usize * image.width as usize + at.x as usize)
}

fn color(image: &Image, index: usize) -> DVec3 {
    double(image.pixels[index])
}

/// Samples fall into texels by the weights of these, and evenly within each.
fn assert_chosen(image: &Image, weight: impl Fn(usize) -> f64, places: &[DVec2], what: &str) {
    let mut counts = vec![0_u32; image.pixels.len()];
    for index in places.iter().filter_map(|place| texel(image, *place)) {
        counts[index] += 1;
    }
    let sum: f64 = (0..counts.len()).map(&weight).sum();
    let total: f64 = counts.iter().map(|count| f64::from(*count)).sum();
    let (mut chi2, mut freedom) = (0.0, -1.0);
    for (index, count) in counts.iter().enumerate() {
        let expected = total * weight(index) / sum;
        if expected == 0.0 {
            assert_eq!(*count, 0, "{what}: black texel {index}");
            continue;
        }
        chi2 += (f64::from(*count) - expected).powi(2) / expected;
        freedom += 1.0;
    }
    let limit = freedom + 6.0 * (2.0_f64 * freedom).sqrt() + 12.0;
    assert!(chi2 <= limit, "{what}: chi squared {chi2:.1} of {freedom} degrees of freedom");

    let size = DVec2::new(image.width.into(), image.height.into());
    let within = places.iter().map(|place| (*place * size).fract().to_array());
    assert_uniform(&cells(within, 8), &format!("{what}, within texels"));
}

fn mean_of_channels(color: DVec3) -> f64 {
    color.element_sum() / 3.0
}

/// The direction in the image's space that a place stands for, on a window of two by one.
fn through_window(place: DVec2, half: f64) -> DVec3 {
    DVec3::new((2.0 * place.x - 1.0) * 2.0 * half, (2.0 * place.y - 1.0) * half, 1.0)
}

#[test]
fn a_sky_is_emitted_by_its_texels() {
    let image = spots(16, 16);
    for is_guided in [false, true] {
        let world = world_for("\"infinite\" \"float scale\" 3", &image, is_guided);
        let emitted = emit(&world, is_guided);
        let to_image = turned().transpose();
        let places: Vec<DVec2> =
            emitted.iter().map(|photon| equal_area::place(to_image * -double(photon.direction))).collect();
        assert_chosen(&image, |i| mean_of_channels(color(&image, i)), &places, "sky");

        let radius = f64::from(world.info.radius);
        let average = image.pixels.iter().map(|pixel| double(*pixel)).sum::<DVec3>() / 256.0;
        // Parallel light enters through the faces of the scene's box that it sees; the mean over all
        // directions is a quarter of the box's surface (Cauchy).
        let half = double(world.info.half_extent);
        let faces = 4.0 * DVec3::new(half.y * half.z, half.z * half.x, half.x * half.y);
        let mean_shown = 0.5 * faces.element_sum();
        let power = 3.0 * average * 4.0 * PI * mean_shown;
        assert_near(world.info.mean_power.into(), mean_of_channels(power), 1e-6, "power of a sky");
        for (photon, place) in emitted.iter().zip(&places) {
            let Some(index) = texel(&image, *place) else { continue };
            // A photon has the texel's colour, and the power of what the box shows its direction.
            let shown = faces.dot(double(photon.direction).abs());
            let expected = color(&image, index) / mean_of_channels(color(&image, index)) * (shown / mean_shown);
            assert!((double(photon.weight) - expected).length() < 1e-4, "{photon:?}: {expected}");
            assert!((double(photon.origin).dot(double(photon.direction)) + radius).abs() < 1e-5, "{photon:?}");
        }
    }
}

#[test]
fn a_goniometric_light_has_its_poles_along_y_and_is_grey() {
    let image = spots(16, 16);
    for is_guided in [false, true] {
        let world = world_for("\"goniometric\" \"rgb I\" [1 2 3] \"float power\" 5", &image, is_guided);
        let emitted = emit(&world, is_guided);
        let axes = turned();
        let to_image = DMat3::from_cols(axes.x_axis, axes.z_axis, axes.y_axis).transpose();
        let places: Vec<DVec2> =
            emitted.iter().map(|photon| equal_area::place(to_image * double(photon.direction))).collect();
        assert_chosen(&image, |i| mean_of_channels(color(&image, i)), &places, "goniometric light");
        for photon in &emitted {
            assert!((double(photon.weight) - DVec3::new(0.5, 1.0, 1.5)).length() < 1e-4, "{photon:?}");
            assert!(photon.origin == emitted[0].origin);
        }
    }
}

#[test]
fn a_projector_fills_its_window() {
    let image = spots(32, 16);
    let half = 35_f64.to_radians().tan();
    let emitted = emit(&world("\"projection\" \"float fov\" 70", &image), false);
    let axes = turned();
    let to_image = DMat3::from_cols(axes.x_axis, -axes.y_axis, axes.z_axis).transpose();
    let places: Vec<DVec2> = emitted
        .iter()
        .map(|photon| {
            let w = to_image * double(photon.direction);
            0.5 + 0.5 * w.truncate() / w.z / DVec2::new(2.0 * half, half)
        })
        .collect();
    let middle = |i: usize| DVec2::new((i % 32) as f64 + 0.5, (i / 32) as f64 + 0.5) / DVec2::new(32.0, 16.0);
    let solid_angle = |place: DVec2| through_window(place, half).length().powi(-3);
    let weight = |i: usize| mean_of_channels(color(&image, i)) * solid_angle(middle(i));
    assert_chosen(&image, weight, &places, "projector");
    for (photon, place) in emitted.iter().zip(&places) {
        let Some(index) = texel(&image, *place) else { continue };
        let share = solid_angle(*place) / solid_angle(middle(index));
        let expected = share * color(&image, index) / mean_of_channels(color(&image, index));
        assert!((double(photon.weight) - expected).length() < 1e-4, "{photon:?}: {expected}");
    }
}

/// No texel is black, so that 1 / pdf covers the sphere.
#[test]
fn next_event_estimation_finds_a_sky_with_the_pdf_it_says() {
    let mut image = spots(8, 8);
    image.pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|value| value.clamp(0.5, 20.0)));
    let world = world("\"infinite\"", &image);
    let mut rng = Rng(7);
    let view = |_| Viewpoint {
        from: [0.1, 0.2, 0.3],
        u_light: rng.unit_f32(),
        u: [rng.unit_f32(), rng.unit_f32()],
        light: NONE,
        pad0: 0.0,
    };
    let seen = see(&world, &(0..COUNT).map(view).collect::<Vec<_>>());
    let count = seen.len() as f64;
    let (mut whole, mut first, mut second) = (0.0, DVec3::ZERO, DVec3::ZERO);
    let to_image = turned().transpose();
    for seen in &seen {
        let w = double(seen.wi);
        let share = 1.0 / (f64::from(seen.pdf) * count);
        whole += share;
        first += share * w;
        second += share * w * w;
        assert_eq!(seen.uses_mis, 1);
        let Some(index) = texel(&image, equal_area::place(to_image * w)) else { continue };
        assert_eq!(seen.radiance, image.pixels[index]);
    }
    assert_near(whole, 4.0 * PI, 0.005, "the sphere");
    assert!(first.length() < 0.08, "{first} is not 0");
    assert!(second.distance(DVec3::splat(4.0 * PI / 3.0)) < 0.05, "{second} is not a third of the sphere");
}

/// A ray that leaves the scene meets the sum of all skies, less what next-event estimation is
/// the better technique for.
#[test]
fn rays_meet_the_sky_that_is_in_their_direction() {
    let image = spots(16, 16);
    let mut world = world("\"infinite\" \"float scale\" 2", &image);
    world.info.infinite = [1.0, 2.0, 3.0];
    let average = image.pixels.iter().map(|pixel| mean_of_channels(double(*pixel))).sum::<f64>() / 256.0;
    let mut rng = Rng(5);
    let poles = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| turned() * axis);
    let mut directions: Vec<DVec3> = poles.into_iter().chain(poles.map(|pole| -pole)).collect();
    directions.extend((0..100_000).map(|_| rng.direction()));
    let escape = |(i, direction): (usize, &DVec3)| Escape {
        direction: single(*direction),
        bsdf_pdf: [UNBOUNDED, 0.3, 0.0][i % 3],
    };
    let escapes: Vec<Escape> = directions.iter().enumerate().map(escape).collect();

    let fixture = Fixture::new();
    let gpu = world.upload(&fixture);
    let (inputs, radiances) = (fixture.upload(&escapes), fixture.output::<[f32; 4]>(escapes.len()));
    fixture.run(&MeetSkies { scene: gpu.bindings(), escapes: &inputs, radiances: &radiances }, escapes.len());
    let to_image = turned().transpose();
    let mut compared = 0;
    for (escape, [r, g, b, _]) in escapes.iter().zip(fixture.read(&radiances)) {
        let place = equal_area::place(to_image * double(escape.direction).normalize());
        let Some(index) = texel(&image, place) else { continue };
        let color = color(&image, index);
        let pdf = mean_of_channels(color) / (4.0 * PI * average);
        let bsdf_pdf = f64::from(escape.bsdf_pdf);
        let weight = bsdf_pdf.powi(2) / (bsdf_pdf.powi(2) + pdf * pdf).max(f64::MIN_POSITIVE);
        let expected = DVec3::new(1.0, 2.0, 3.0) + 2.0 * color * weight;
        let error = double([r, g, b]).distance(expected) / expected.length();
        assert!(error < 1e-5, "{escape:?}: {:?} is not {expected}", [r, g, b]);
        compared += 1;
    }
    assert!(compared > 99_000, "{compared} directions are in the middle of a texel");
}
