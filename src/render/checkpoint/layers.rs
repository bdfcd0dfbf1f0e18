//! The form of an image's layers in the first line of a checkpoint.

use glam::DAffine3;
use serde::{Deserialize, Serialize};

use crate::image::film::CoordinateSystem;
use crate::image::layers::{Group, Groups, LayerForm};

/// A [`LayerForm`] with a group or more.
#[derive(Serialize, Deserialize)]
pub(super) struct LayerHeader {
    /// The names of the groups, in their order.
    groups: Vec<String>,
    of_film: bool,
    in_world_space: bool,
    /// The columns of the transforms.
    camera_from_render: [[f64; 3]; 4],
    world_from_render: [[f64; 3]; 4],
    photons: u64,
}

impl LayerHeader {
    /// Returns the header of a form; `None` if there are no layers.
    pub fn of(form: &LayerForm) -> Option<Self> {
        (!form.groups.is_empty()).then(|| Self {
            groups: form.groups.iter().map(|group| group.name().to_owned()).collect(),
            of_film: form.of_film,
            in_world_space: form.system == CoordinateSystem::World,
            camera_from_render: form.camera_from_render.to_cols_array_2d(),
            world_from_render: form.world_from_render.to_cols_array_2d(),
            photons: form.photons,
        })
    }

    /// Returns the form; `None` if there is no group, one is unknown, they are in another order, or a number makes no
    /// sense.
    pub fn form(&self) -> Option<LayerForm> {
        let named = |name: &String| Group::ALL.into_iter().find(|group| group.name() == name);
        let groups: Vec<Group> = self.groups.iter().map(named).collect::<Option<_>>()?;
        let set = Groups::of(&groups);
        let transforms =
            [self.camera_from_render, self.world_from_render].map(|rows| DAffine3::from_cols_array_2d(&rows));
        let [camera_from_render, world_from_render] = transforms;
        let is_invertible = |transform: DAffine3| transform.is_finite() && transform.matrix3.determinant() != 0.0;
        (set.iter().eq(groups) && !set.is_empty() && transforms.into_iter().all(is_invertible)).then_some(LayerForm {
            groups: set,
            of_film: self.of_film,
            system: if self.in_world_space { CoordinateSystem::World } else { CoordinateSystem::Camera },
            camera_from_render,
            world_from_render,
            photons: self.photons,
        })
    }
}
