//! The transforms of the graphics state. pbrt has two, at the start and at the end of the exposure, and
//! interpolates between them. Goblet ignores motion: objects stay at their place at the start time.

use glam::DAffine3;

use crate::scene::directives::state::{ENTRY_BYTES, SceneBuilder};
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::lexer::shorten;

/// The times whose transforms directives change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActiveTimes {
    pub start: bool,
    pub end: bool,
}

impl ActiveTimes {
    pub const ALL: Self = Self { start: true, end: true };
}

impl SceneBuilder {
    /// Sets the times whose transforms directives change.
    pub fn activate(&mut self, times: ActiveTimes) {
        self.state.active = times;
    }

    pub(in crate::scene) fn reset_transforms(&mut self) {
        self.state.active = ActiveTimes::ALL;
        self.state.world_from_object = DAffine3::IDENTITY;
        self.state.world_from_object_at_end = DAffine3::IDENTITY;
        self.coordinate_systems.insert("world".to_string(), [DAffine3::IDENTITY; 2]);
    }

    /// Replaces the current transform; fails if `transform` is `None`, which stands for invalid numbers.
    pub fn set_transform(
        &mut self,
        transform: Option<DAffine3>,
        directive: &str,
        location: &Location,
    ) -> Result<(), SceneError> {
        self.change_transforms(directive, location, |_| transform)
    }

    /// Multiplies the current transform from the right by `transform`, which thus applies first; fails if
    /// it is `None`.
    pub fn concat_transform(
        &mut self,
        transform: Option<DAffine3>,
        directive: &str,
        location: &Location,
    ) -> Result<(), SceneError> {
        self.change_transforms(directive, location, |current| transform.map(|t| current * t))
    }

    fn change_transforms(
        &mut self,
        directive: &str,
        location: &Location,
        change: impl Fn(DAffine3) -> Option<DAffine3>,
    ) -> Result<(), SceneError> {
        let state = &mut self.state;
        let times = [
            (state.active.start, &mut state.world_from_object),
            (state.active.end, &mut state.world_from_object_at_end),
        ];
        for (_, current) in times.into_iter().filter(|(active, _)| *active) {
            *current = checked(change(*current), directive, location)?;
        }
        Ok(())
    }

    pub fn name_coordinate_system(&mut self, name: String, location: &Location) -> Result<(), SceneError> {
        self.keep::<(String, [DAffine3; 2])>(name.len() + ENTRY_BYTES, location)?;
        let transforms = [self.state.world_from_object, self.state.world_from_object_at_end];
        self.coordinate_systems.insert(name, transforms);
        Ok(())
    }

    pub fn use_coordinate_system(&mut self, name: &str, location: &Location) -> Result<(), SceneError> {
        let Some(transforms) = self.coordinate_systems.get(name) else {
            return Err(location.invalid(format!(
                "unknown coordinate system \"{}\"; expected one that CoordinateSystem has named, \
                 \"camera\" or \"world\"",
                shorten(name)
            )));
        };
        [self.state.world_from_object, self.state.world_from_object_at_end] = *transforms;
        Ok(())
    }

    /// Warns once, for a directive at `location`, that motion is not rendered.
    pub(in crate::scene) fn warn_of_motion(&mut self, location: &Location) {
        if self.state.world_from_object != self.state.world_from_object_at_end && !self.warned_of_motion {
            self.warned_of_motion = true;
            self.warn(location, "motion is not rendered: everything stays at its place at the start time");
        }
    }
}

/// Returns the transform of a directive, or an error if it has none. A transform need not be invertible:
/// the directives that use it check that.
fn checked(transform: Option<DAffine3>, directive: &str, location: &Location) -> Result<DAffine3, SceneError> {
    transform.ok_or_else(|| {
        let expected = match directive {
            "LookAt" => "an eye and a look point that differ, and an up not along their line",
            "Rotate" => "an axis that is not zero",
            _ => "an affine matrix: 4th, 8th and 12th number 0, 16th number 1",
        };
        location.invalid(format!("{directive} is no transform; expected {expected}"))
    })
}
