//! The `ObjectBegin`, `ObjectEnd` and `ObjectInstance` directives.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::lexer::shorten;
use crate::scene::model::{Instance, Shape};

/// Named groups of shapes, and their instances.
#[derive(Debug, Default)]
pub(in crate::scene) struct Objects {
    named: HashMap<Arc<str>, usize>,
    /// The object that shapes are added to, if one is open.
    open: Option<Open>,
    /// Instances: name of the object, place in the file, and transform. Names are looked up at the end,
    /// because a scene may use an object before it defines it.
    uses: Vec<(Arc<str>, Location, DAffine3)>,
}

#[derive(Debug)]
struct Open {
    index: usize,
    /// Whether a warning about an emitting shape was given.
    warned: bool,
}

impl Objects {
    pub fn begin(&mut self, name: &str, location: &Location) -> Result<(), SceneError> {
        if self.open.is_some() {
            return Err(location.invalid("ObjectBegin stands in an object; expected ObjectEnd before it"));
        }
        let index = self.named.len();
        if self.named.insert(name.into(), index).is_some() {
            return Err(
                location.invalid(format!("an object \"{}\" exists already; expected a new name", shorten(name)))
            );
        }
        self.open = Some(Open { index, warned: false });
        Ok(())
    }

    pub fn end(&mut self) {
        self.open = None;
    }

    /// Returns the index of the object that is open.
    pub fn open(&self) -> Option<usize> {
        self.open.as_ref().map(|open| open.index)
    }

    /// Returns true for the first call per open object: for its first shape with an area light.
    pub fn is_first_emitter(&mut self) -> bool {
        self.open.as_mut().is_some_and(|open| !std::mem::replace(&mut open.warned, true))
    }

    pub fn instance(
        &mut self,
        name: &str,
        location: &Location,
        world_from_instance: DAffine3,
    ) -> Result<(), SceneError> {
        if self.open.is_some() {
            return Err(location.invalid("ObjectInstance stands in an object; expected it after ObjectEnd"));
        }
        // Most instances are of an object that is already defined, and share its name.
        let name = self.named.get_key_value(name).map_or_else(|| name.into(), |(known, _)| Arc::clone(known));
        self.uses.push((name, location.clone(), world_from_instance));
        Ok(())
    }

    /// Returns the instances of objects that have shapes, and the errors of other instances.
    pub fn resolve(self, shapes: &[Shape]) -> (Vec<Instance>, Vec<SceneError>) {
        let mut boxes: Vec<Option<[DVec3; 2]>> = vec![None; self.named.len()];
        for (shape, object) in shapes.iter().filter_map(|shape| Some((shape, shape.object?))) {
            let [lower, upper] = boxes[object].get_or_insert([DVec3::INFINITY, DVec3::NEG_INFINITY]);
            shape.geometry.hull_all(|point| {
                let point = shape.world_from_object.transform_point3(point);
                (*lower, *upper) = (lower.min(point), upper.max(point));
                true
            });
        }
        let mut instances = Vec::with_capacity(self.uses.len());
        let mut errors = Vec::new();
        for (name, location, world_from_instance) in self.uses {
            match self.named.get(&name).map(|object| (*object, boxes[*object])) {
                Some((object, Some(corners))) if stays_finite(&world_from_instance, corners) => {
                    instances.push(Instance { object, world_from_instance });
                }
                Some((_, Some(_))) => errors.push(location.invalid(
                    "coordinates overflow, in the object or by the instance's transform; expected smaller numbers",
                )),
                Some((_, None)) => {}
                None => errors.push(location.invalid(format!(
                    "unknown object \"{}\"; expected one that ObjectBegin has named",
                    shorten(&name)
                ))),
            }
        }
        (instances, errors)
    }
}

/// Returns true if the images of all points of a box under `transform` are finite, and so is the product of
/// `transform` with the transform of any shape in the box.
fn stays_finite(transform: &DAffine3, corners: [DVec3; 2]) -> bool {
    let most = corners[0].abs().max(corners[1].abs());
    let linear = transform.matrix3;
    let sizes = linear.x_axis.abs() * most.x + linear.y_axis.abs() * most.y + linear.z_axis.abs() * most.z;
    (sizes + transform.translation.abs()).is_finite()
}
