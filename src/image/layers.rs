//! The layers of an image besides its radiance: properties of the first surface, parts of the light, and the square
//! of the radiance. Like the radiance, they are exact sums over iterations, so that shards add up to the last bit.
//!
//! A group has four sums per pixel. A render sums only the groups that its layers need.

use glam::{DAffine3, DVec3};

use crate::image::film::CoordinateSystem;
use crate::image::sum::{Sum, add, whole};

/// Four sums of each pixel. Values of surfaces are those of the first surface that an eye path meets, times the
/// pixel filter, in render space; a path that meets nothing adds 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Red, green and blue of the albedo; the weight of the paths that meet a surface.
    Albedo,
    /// The position.
    Position,
    /// The geometric normal on the side of the path.
    Normal,
    /// The shading normal on the side of the path.
    ShadingNormal,
    /// The change of a coordinate from a pixel to the one on its right, and to the one below; texture coordinates.
    Slope,
    /// Red, green and blue of the light without photons; the density of photons on the disc on which they are
    /// gathered, as a share of an iteration's photons.
    Light,
    /// Red, green and blue of the caustics.
    Caustic,
    /// Squares of red, green and blue after the white balance, each up to 2^39 times the square of the unit; the radius
    /// of the disc.
    Square,
}

impl Group {
    /// All groups, in the order in which their sums are kept.
    pub const ALL: [Self; 8] = [
        Self::Albedo,
        Self::Position,
        Self::Normal,
        Self::ShadingNormal,
        Self::Slope,
        Self::Light,
        Self::Caustic,
        Self::Square,
    ];

    /// Returns the name of the group in checkpoints and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "Albedo",
            Self::Position => "P",
            Self::Normal => "N",
            Self::ShadingNormal => "Ns",
            Self::Slope => "slope",
            Self::Light => "direct",
            Self::Caustic => "caustic",
            Self::Square => "square",
        }
    }

    /// Returns whether the group is of surfaces that eye paths meet.
    pub fn is_of_surface(self) -> bool {
        !matches!(self, Self::Light | Self::Caustic | Self::Square)
    }
}

/// A set of groups.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Groups(u8);

impl Groups {
    /// The groups of the layers that a `gbuffer` film of pbrt-v4 has.
    pub const OF_GBUFFER: Self =
        Self::of(&[Group::Albedo, Group::Position, Group::Normal, Group::ShadingNormal, Group::Slope, Group::Square]);

    /// Returns the set of some groups.
    pub const fn of(groups: &[Group]) -> Self {
        let mut set = 0;
        let mut index = 0;
        while index < groups.len() {
            set |= 1 << groups[index] as u8;
            index += 1;
        }
        Self(set)
    }

    /// Returns the groups that are in this set or in another.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns whether a group is in the set.
    pub fn has(self, group: Group) -> bool {
        self.0 & 1 << group as u8 != 0
    }

    /// Returns whether all groups of another set are in this one.
    pub fn has_all(self, other: Self) -> bool {
        self.with(other) == self
    }

    /// Returns whether there is no group.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns the number of groups.
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Returns the groups, in the order of [`Group::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Group> {
        Group::ALL.into_iter().filter(move |group| self.has(*group))
    }

    /// Returns the number of a group among those of the set; `None` if it is not in the set.
    pub fn place(self, group: Group) -> Option<usize> {
        self.iter().position(|other| other == group)
    }

    /// Returns the names of the groups, with commas between them.
    pub fn names(self) -> String {
        self.iter().map(Group::name).collect::<Vec<_>>().join(", ")
    }
}

/// The form of the layers' sums: only sums of the same form can be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerForm {
    /// The groups that there are.
    pub groups: Groups,
    /// Whether the film of the scene asks for its layers.
    pub of_film: bool,
    /// The coordinate system of positions, normals and slopes.
    pub system: CoordinateSystem,
    /// Transform from render space to camera space.
    pub camera_from_render: DAffine3,
    /// Transform from render space to world space.
    pub world_from_render: DAffine3,
    /// Photons per iteration.
    pub photons: u64,
}

impl Default for LayerForm {
    fn default() -> Self {
        Self {
            groups: Groups::default(),
            of_film: false,
            system: CoordinateSystem::default(),
            camera_from_render: DAffine3::IDENTITY,
            world_from_render: DAffine3::IDENTITY,
            photons: 0,
        }
    }
}

impl LayerForm {
    /// Returns the transform from render space to the coordinate system of the layers.
    pub fn from_render(&self) -> DAffine3 {
        match self.system {
            CoordinateSystem::Camera => self.camera_from_render,
            CoordinateSystem::World => self.world_from_render,
        }
    }

    /// Returns the vector in render space whose product with a movement is the change of the z coordinate of the
    /// layers.
    pub fn slope_axis(&self) -> DVec3 {
        self.from_render().matrix3.row(2)
    }

    /// Returns the length of a render unit in scene units.
    pub(super) fn length(&self) -> f64 {
        self.world_from_render.matrix3.x_axis.length()
    }
}

/// Sums of the layers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// The form of the sums.
    pub form: LayerForm,
    /// Four sums of each pixel for each group of the form, in units of 2^-56.
    pub sums: Vec<[Vec<Sum>; 4]>,
}

impl Layers {
    /// Adds the sums over other iterations, which have the same form.
    pub(super) fn add(&mut self, other: &Self) {
        let pairs = self.sums.iter_mut().flatten().zip(other.sums.iter().flatten());
        for (sums, more) in pairs {
            sums.iter_mut().zip(more).for_each(|(sum, more)| add(sum, *more));
        }
    }

    /// Returns the sums of each pixel in a group, in their smallest units; `None` if there is no such group.
    pub(super) fn sums(&self, group: Group) -> Option<impl Iterator<Item = [i128; 4]>> {
        let [x, y, z, w] = &self.sums[self.form.groups.place(group)?];
        let pixels = x.iter().zip(y).zip(z).zip(w);
        Some(pixels.map(|(((x, y), z), w)| [*x, *y, *z, *w].map(whole)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_of_groups_keep_their_order() {
        let groups = Groups::of(&[Group::Square, Group::Albedo]).with(Groups::of(&[Group::Slope, Group::Albedo]));
        assert_eq!(groups.iter().collect::<Vec<_>>(), [Group::Albedo, Group::Slope, Group::Square]);
        assert_eq!((groups.len(), groups.place(Group::Square), groups.place(Group::Light)), (3, Some(2), None));
        assert!(groups.has_all(Groups::of(&[Group::Slope])) && !groups.has_all(Groups::of(&[Group::Light])));
        assert_eq!(groups.names(), "Albedo, slope, square");
    }
}
