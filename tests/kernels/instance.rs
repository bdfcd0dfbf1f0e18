//! Instances: rays meet what they meet where the shapes are copied, and leave it as cleanly.

use std::fmt::Write;

use glam::DVec3;

use crate::fixture::{Fixture, Rng, double, single};
use crate::generated::{CrossInstances, Crossing, CrossingRay};
use crate::trace::{LIGHT, count_misses, icosphere, mesh_text, ray};
use crate::world::{World, affine};

fn cross(world: &World, rays: &[CrossingRay]) -> Vec<Crossing> {
    let fixture = Fixture::new();
    let world = world.upload(&fixture);
    let (rays, crossings) = (fixture.upload(rays), fixture.output(rays.len()));
    let kernel = CrossInstances { scene: world.bindings(), rays: &rays, crossings: &crossings };
    fixture.run(&kernel, rays.len() as usize);
    fixture.read(&crossings)
}

/// Where an object stands, as text.
struct Place {
    transform: String,
    mirrored: bool,
}

/// Turned, moved and stretched by up to `stretch`; every third is mirrored.
fn place(rng: &mut Rng, index: usize, center: DVec3, stretch: f64) -> Place {
    let axis = rng.direction();
    let mut scale = DVec3::from([0; 3].map(|_| rng.log_range(1.0 / stretch, 1.0)));
    scale *= rng.log_range(0.3, 1.0);
    let mirrored = index.is_multiple_of(3);
    scale.x *= if mirrored { -1.0 } else { 1.0 };
    let mut transform = String::new();
    for (directive, v) in [("Translate", center), ("Scale", scale)] {
        writeln!(transform, "{directive} {} {} {}", v.x, v.y, v.z).expect("text");
        writeln!(transform, "Rotate {} {} {} {}", rng.range(0.0, 360.0), axis.x, axis.y, axis.z).expect("text");
    }
    Place { transform, mirrored }
}

/// On a grid that keeps objects of size 1 apart.
fn places(rng: &mut Rng, count: usize, stretch: f64) -> Vec<Place> {
    let at = |i: usize, step: usize| 4.0 * ((i / step % 3) as f64 - 1.0);
    (0..count).map(|i| place(rng, i, DVec3::new(at(i, 1), at(i, 3), at(i, 9)), stretch)).collect()
}

/// A scene of an object's shapes at some places: meshes, and others. The object is far from
/// the origin of its own space; where it is copied, a mirror must not turn the others.
fn scene(meshes: &str, others: &str, places: &[Place], copied: bool) -> World {
    let shapes = |mirrored| {
        let turn = if copied && mirrored { "ReverseOrientation\n" } else { "" };
        format!("Translate 30 -20 10\nScale 5 5 5\n{meshes}{turn}{others}")
    };
    // Two far corners, so that bounds do not matter.
    let mut text = format!("WorldBegin\n{LIGHT}");
    text += &mesh_text(&[DVec3::splat(-8.0), DVec3::splat(-7.9), DVec3::new(-8.0, -8.0, -7.9)], &[[0, 1, 2]]);
    text += &mesh_text(&[DVec3::splat(8.0), DVec3::splat(7.9), DVec3::new(8.0, 8.0, 7.9)], &[[0, 1, 2]]);
    if !copied {
        write!(text, "ObjectBegin \"o\"\n{}ObjectEnd\n", shapes(false)).expect("text");
    }
    for place in places {
        let what = if copied { shapes(place.mirrored) } else { "ObjectInstance \"o\"\n".to_string() };
        let back = "Scale .2 .2 .2\nTranslate -30 20 -10\n";
        write!(text, "AttributeBegin\n{}{back}{what}AttributeEnd\n", place.transform).expect("text");
    }
    World::parse(&text).0
}

fn bumpy_mesh(levels: usize, rng: &mut Rng) -> String {
    let (mut points, triangles) = icosphere(levels);
    points.iter_mut().for_each(|point| *point *= rng.range(0.7, 1.0));
    mesh_text(&points, &triangles)
}

/// Sphere, cut sphere, disk and body of revolution, side by side.
const OTHERS: &str = "\
AttributeBegin Translate 1.3 0 0 Scale .3 .2 .4 Shape \"sphere\" AttributeEnd
AttributeBegin Translate 0 1.4 0 Shape \"sphere\" \"float radius\" .4 \"float zmax\" .2 AttributeEnd
AttributeBegin Translate 0 0 1.2 Rotate 20 1 0 0 Shape \"disk\" \"float innerradius\" .2 AttributeEnd
AttributeBegin Translate -1.3 0 0 Shape \"revolution\" \"point2 P\" [.1 -.5 .5 -.3 0 0 .3 .5] AttributeEnd
";

fn crossing(origin: DVec3, direction: DVec3, leaving: DVec3) -> CrossingRay {
    CrossingRay {
        origin: single(origin),
        pad0: 0.0,
        direction: single(direction),
        pad1: 0.0,
        leaving: single(leaving),
        pad2: 0.0,
    }
}

#[test]
fn instances_are_met_where_copies_are() {
    let mut rng = Rng(1);
    let places = places(&mut rng, 20, 3.0);
    let mesh = bumpy_mesh(2, &mut rng);
    let instanced = scene(&mesh, OTHERS, &places, false);
    let copied = scene(&mesh, OTHERS, &places, true);
    assert_eq!((instanced.instances.len(), copied.instances.len()), (20, 0));
    let rays: Vec<_> = (0..60_000)
        .map(|_| {
            let transform = affine(instanced.instances[rng.below(places.len())].render_from_object);
            let origin = rng.cube(0.5);
            let target = transform.transform_point3(rng.cube(0.4));
            crossing(origin, (target - origin) * rng.log_range(0.1, 10.0), rng.direction())
        })
        .collect();
    let (mut met, mut differ) = (0, 0);
    for ((ray, a), b) in rays.iter().zip(cross(&instanced, &rays)).zip(cross(&copied, &rays)) {
        let off = double(a.position) - double(b.position);
        let error = f64::from(a.error + b.error);
        let [normal, other] = [a.normal, b.normal].map(double);
        if a.t < 0.0 && b.t < 0.0 {
            continue;
        }
        // By an edge or a silhouette, rounding decides what is met.
        if a.t.min(b.t) < 0.0 || off.abs().max_element() > 50.0 * error || normal.dot(other).abs() < 0.99 {
            differ += 1;
            continue;
        }
        met += 1;
        assert!(normal.dot(other) > 0.99, "{ray:?}: {a:?} has the side of {b:?} behind");
        assert!(double(a.shading_normal).dot(double(b.shading_normal)) > 0.99, "{ray:?}: {a:?} {b:?}");
        assert!(normal.dot(off).abs() <= normal.abs().element_sum() * error, "{ray:?}: {a:?} is not on {b:?}");
        assert!(a.error < 4e-5, "{a:?}");
    }
    println!("{met} rays met what they should, {differ} something else");
    assert!(met > rays.len() / 4, "{met}");
    assert!(differ < met / 200, "{differ} of {met}");
}

#[test]
fn no_ray_slips_into_an_instance() {
    let mut rng = Rng(2);
    let places = places(&mut rng, 20, 10.0);
    let instanced = scene(&bumpy_mesh(2, &mut rng), "", &places, false);
    let rays: Vec<_> = (0..100_000)
        .map(|_| {
            // From the middle of an instance to a corner or an edge of its mesh.
            let transform = affine(instanced.instances[rng.below(places.len())].render_from_object);
            let triangle = &instanced.triangles[rng.below(320)];
            let [a, b] = [triangle.p0, triangle.p1].map(double);
            let target = a.lerp(b, if rng.chance(0.5) { 0.0 } else { rng.unit() });
            let origin = double(single(transform.transform_point3(0.1 * rng.cube(1.0))));
            ray(origin, transform.transform_point3(target) - origin)
        })
        .collect();
    assert_eq!(count_misses(&instanced, &rays), 0, "rays left an instance of a closed mesh");
}

/// Instances of a convex mesh: no ray that leaves one outward meets it again.
#[test]
fn rays_that_leave_an_instance_do_not_meet_it_again() {
    let mut rng = Rng(3);
    let (points, triangles) = icosphere(2);
    let places = places(&mut rng, 20, 10.0);
    let instanced = scene(&mesh_text(&points, &triangles), "", &places, false);
    let rays: Vec<_> = (0..200_000)
        .map(|_| {
            let transform = affine(instanced.instances[rng.below(places.len())].render_from_object);
            let normal = rng.direction();
            // The unit sphere of the file has radius 1/2 here.
            let target = transform.transform_point3(0.49 * normal);
            let origin = transform.transform_point3(0.8 * normal + rng.cube(0.3));
            // Often nearly along the surface.
            let outward = (transform.matrix3.inverse().transpose() * normal).normalize();
            let leaving = rng.direction();
            let along = leaving - leaving.dot(outward) * outward * (1.0 - rng.log_range(1e-8, 1.0));
            crossing(origin, target - origin, along.normalize())
        })
        .collect();
    let crossings = cross(&instanced, &rays);
    let met = crossings.iter().filter(|crossing| crossing.t > 0.0).count();
    assert!(met > rays.len() / 2, "{met}");
    for (ray, crossing) in rays.iter().zip(crossings) {
        // Other instances are further away.
        assert!(crossing.t_again < 0.0 || crossing.t_again > 0.02, "{ray:?} meets its instance again: {crossing:?}");
    }
}
