//! `ObjectBegin`, `ObjectEnd` and `ObjectInstance`.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DAffine3;

use super::error::{Location, SceneError};
use super::lexer::shorten;
use super::model::{Instance, Shape};

/// Named groups of shapes, and where they are to stand.
#[derive(Debug, Default)]
pub(super) struct Objects {
    named: HashMap<Arc<str>, usize>,
    /// The one that shapes are added to.
    open: Option<Open>,
    /// Names are looked up at the end: a scene may use an object before it defines it.
    uses: Vec<(Arc<str>, Location, DAffine3)>,
}

#[derive(Debug)]
struct Open {
    index: usize,
    /// There was a warning of light in it.
    warned: bool,
}

impl Objects {
    pub fn begin(&mut self, name: &str, location: &Location) -> Result<(), SceneError> {
        if self.open.is_some() {
            return Err(location.invalid("ObjectBegin stands in an object; expected the ObjectEnd of that first"));
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

    /// The object that shapes belong to now.
    pub fn open(&self) -> Option<usize> {
        self.open.as_ref().map(|open| open.index)
    }

    /// Whether a shape that would emit is the first such in the open object.
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
        // Most uses are of an object that is there already: they share its name.
        let name = self.named.get_key_value(name).map_or_else(|| name.into(), |(known, _)| Arc::clone(known));
        self.uses.push((name, location.clone(), world_from_instance));
        Ok(())
    }

    /// The instances of objects that have shapes, and what is wrong with others.
    pub fn resolve(self, shapes: &[Shape]) -> (Vec<Instance>, Vec<SceneError>) {
        let mut has_shapes = vec![false; self.named.len()];
        shapes.iter().filter_map(|shape| shape.object).for_each(|object| has_shapes[object] = true);
        let mut instances = Vec::with_capacity(self.uses.len());
        let mut errors = Vec::new();
        for (name, location, world_from_instance) in self.uses {
            match self.named.get(&name).copied() {
                Some(object) if has_shapes[object] => instances.push(Instance { object, world_from_instance }),
                Some(_) => {}
                None => errors.push(location.invalid(format!(
                    "unknown object \"{}\"; expected one that ObjectBegin has named",
                    shorten(&name)
                ))),
            }
        }
        (instances, errors)
    }
}
