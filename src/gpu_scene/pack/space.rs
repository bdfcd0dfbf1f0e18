//! Render space, and bounds of shapes.

use glam::{DAffine3, DVec3};

use super::PackError;
use crate::scene::Shape;

/// Maximum radius of a scene's bounding sphere, in scene units: squares of lengths must stay finite in
/// every product of f64.
pub(super) const MAX_EXTENT: f64 = 1e30;

/// The map from world space to render space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSpace {
    /// Origin of render space, in world space.
    pub center: DVec3,
    /// Render units per scene unit, a power of two.
    pub scale: f64,
    /// Radius of the scene's bounding sphere, in render units, in (1/2, 1].
    pub radius: f64,
    /// Half extents of the scene's bounding box about the origin, in render units, widened for rounding.
    pub half_extent: DVec3,
}

/// Widening of the bounding box in render units: more than rounding moves a surface.
const PADDING: f64 = 1e-5;

impl RenderSpace {
    /// Returns the render space of bounds; `None` if they have no extent. Fails if they are too large.
    pub(super) fn of(bounds: &Bounds) -> Result<Option<Self>, PackError> {
        let half_diagonal = bounds.half_extent().length();
        if bounds.is_empty() || half_diagonal == 0.0 {
            return Ok(None);
        }
        if half_diagonal.is_nan() || half_diagonal > MAX_EXTENT {
            return Err(PackError::TooLarge(half_diagonal));
        }
        Ok(Some(Self::around(bounds.center(), bounds.half_extent())))
    }

    /// Returns the render space of a box with a centre and half extents in scene units.
    pub(super) fn around(center: DVec3, half_extent: DVec3) -> Self {
        let half_diagonal = half_extent.length();
        let scale = (-half_diagonal.log2().ceil()).exp2();
        let half_extent = scale * half_extent + PADDING;
        Self { center, scale, radius: half_diagonal * scale, half_extent }
    }

    /// Returns the projected area of the scene's bounding box along a unit vector, in square render units.
    pub fn shown_to(&self, direction: DVec3) -> f64 {
        self.faces().dot(direction.abs())
    }

    /// Returns the mean projected area over all directions: a quarter of the surface (Cauchy).
    pub fn mean_shown(&self) -> f64 {
        0.5 * self.faces().element_sum()
    }

    /// Returns the areas of the faces perpendicular to each axis.
    fn faces(&self) -> DVec3 {
        let e = self.half_extent;
        4.0 * DVec3::new(e.y * e.z, e.z * e.x, e.x * e.y)
    }

    /// Returns the transform from world space to render space.
    pub fn from_world(&self) -> DAffine3 {
        DAffine3::from_scale(DVec3::splat(self.scale)) * DAffine3::from_translation(-self.center)
    }
}

/// A bounding box; empty by default.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    lower: DVec3,
    upper: DVec3,
}

impl Default for Bounds {
    fn default() -> Self {
        Self { lower: DVec3::INFINITY, upper: DVec3::NEG_INFINITY }
    }
}

impl Bounds {
    pub fn is_empty(&self) -> bool {
        self.lower.cmpgt(self.upper).any()
    }

    pub fn center(&self) -> DVec3 {
        0.5 * (self.lower + self.upper)
    }

    pub fn half_extent(&self) -> DVec3 {
        0.5 * (self.upper - self.lower)
    }

    /// Returns the box between two corners.
    pub fn of(lower: DVec3, upper: DVec3) -> Self {
        Self { lower, upper }
    }

    /// Returns the box around points.
    pub fn around(points: &[DVec3]) -> Self {
        let mut bounds = Self::default();
        points.iter().for_each(|point| bounds.add(*point));
        bounds
    }

    pub fn lower(&self) -> DVec3 {
        self.lower
    }

    pub fn upper(&self) -> DVec3 {
        self.upper
    }

    /// Returns the intersection of two boxes; `None` if it is empty.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let common = Self { lower: self.lower.max(other.lower), upper: self.upper.min(other.upper) };
        (!common.is_empty()).then_some(common)
    }

    /// Extends the box to contain another one.
    pub fn unite(&mut self, other: &Self) {
        *self = Self { lower: self.lower.min(other.lower), upper: self.upper.max(other.upper) };
    }

    /// Returns the box with each side moved outwards by `by`.
    pub fn widened(&self, by: f64) -> Self {
        Self { lower: self.lower - by, upper: self.upper + by }
    }

    /// Extends the box to contain a point. A NaN makes the box infinite.
    pub fn add(&mut self, point: DVec3) {
        if point.is_nan() {
            // A transform has overflowed; `min` and `max` would ignore a NaN.
            *self = Self { lower: DVec3::NEG_INFINITY, upper: DVec3::INFINITY };
        }
        self.lower = self.lower.min(point);
        self.upper = self.upper.max(point);
    }

    /// Extends the box to contain a shape in world space.
    pub fn add_shape(&mut self, shape: &Shape) {
        let transform = &shape.world_from_object;
        shape.geometry.hull_all(|point| {
            self.add(transform.transform_point3(point));
            true
        });
    }

    /// Extends the box to contain another one after a transform.
    pub fn add_bounds(&mut self, transform: &DAffine3, bounds: &Bounds) {
        self.add_box(transform, bounds.lower, bounds.upper);
    }

    fn add_box(&mut self, transform: &DAffine3, lower: DVec3, upper: DVec3) {
        for corner in 0..8 {
            let pick = |bit: u32, low: f64, high: f64| if corner >> bit & 1 == 0 { low } else { high };
            let point = DVec3::new(pick(0, lower.x, upper.x), pick(1, lower.y, upper.y), pick(2, lower.z, upper.z));
            self.add(transform.transform_point3(point));
        }
    }
}
