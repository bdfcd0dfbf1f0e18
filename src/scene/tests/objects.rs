//! Tests of `ObjectBegin`, `ObjectEnd` and `ObjectInstance`.

use glam::DVec3;

use crate::scene::tests::{assert_refused, in_world, message, parse};

#[test]
fn objects_have_shapes_and_places() {
    let scene = in_world(
        "Translate 1 0 0\nObjectInstance \"late\"\n\
         ObjectBegin \"late\"\nScale 2 2 2\nReverseOrientation\nShape \"sphere\"\nShape \"disk\"\nObjectEnd\n\
         Translate 0 5 0\nObjectInstance \"late\"\nObjectBegin \"empty\"\nObjectEnd\nObjectInstance \"empty\"",
    )
    .unwrap();
    assert_eq!(scene.shapes.iter().map(|shape| shape.object).collect::<Vec<_>>(), [Some(0), Some(0), None]);
    let turned: Vec<bool> = scene.shapes.iter().map(|shape| shape.reverse_orientation).collect();
    assert_eq!(turned, [true, true, false]);
    // As in pbrt, the transform at ObjectBegin is part of the transforms of the object's shapes, and so is
    // the one at ObjectInstance.
    let at = |shape: usize| scene.shapes[shape].world_from_object.transform_point3(DVec3::X);
    assert_eq!((at(0), at(2)), (DVec3::new(3.0, 0.0, 0.0), DVec3::new(2.0, 5.0, 0.0)));
    let places: Vec<DVec3> = scene.instances.iter().map(|i| i.world_from_instance.translation).collect();
    assert_eq!(places, [DVec3::new(1.0, 0.0, 0.0), DVec3::new(1.0, 5.0, 0.0)]);
    assert!(scene.instances.iter().all(|instance| instance.object == 0));
}

#[test]
fn shapes_of_objects_emit_nothing() {
    let scene = in_world(
        "AreaLightSource \"diffuse\"\nObjectBegin \"o\"\nShape \"sphere\"\nShape \"disk\"\nObjectEnd\nShape \"sphere\"",
    )
    .unwrap();
    let emit: Vec<bool> = scene.shapes.iter().map(|shape| shape.emission.is_some()).collect();
    assert_eq!(emit, [false, false, true, true]);
    let warnings: Vec<_> = scene.warnings.iter().filter(|warning| warning.contains("of an object")).collect();
    assert!(matches!(&warnings[..], [warning] if warning.starts_with("t.pbrt:4:1: ")), "{warnings:?}");
}

#[test]
fn objects_are_not_nested() {
    for (world, expected) in [
        ("ObjectBegin \"a\"\nObjectBegin \"b\"", "3:1: ObjectBegin stands in an object"),
        ("ObjectBegin \"a\"\nObjectInstance \"a\"", "3:1: ObjectInstance stands in an object"),
        ("ObjectBegin \"a\"", "2:1: this block is never ended; expected ObjectEnd"),
        ("ObjectEnd", "2:1: this ends a block that was never begun"),
        (
            "ObjectBegin \"a\"\nAttributeEnd",
            "3:1: found AttributeEnd; expected ObjectEnd for what begins at t.pbrt:2:1",
        ),
        ("ObjectBegin \"a\"\nAttributeBegin\nObjectEnd", "4:1: found ObjectEnd; expected AttributeEnd"),
        ("ObjectBegin \"a\"\nObjectEnd\nObjectBegin \"a\"\nObjectEnd", "4:1: an object \"a\" exists already"),
        ("ObjectInstance \"b\"", "2:1: unknown object \"b\""),
    ] {
        assert_refused(world, expected);
    }
    assert!(message(parse("ObjectBegin \"a\"")).contains("before WorldBegin"));
}
