//! Where render space is, and what bounds a shape.

use glam::{DAffine3, DVec3};

use super::PackError;
use crate::scene::Shape;

/// The largest radius of a scene's bounding sphere, scene units: squares of lengths must
/// stay finite in every product of f64.
pub(super) const MAX_EXTENT: f64 = 1e30;

/// The map from world space to render space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSpace {
    /// The world point that becomes the origin.
    pub center: DVec3,
    /// Render units per scene unit, a power of two.
    pub scale: f64,
    /// Radius of the scene's bounding sphere, render units, in (1/2, 1].
    pub radius: f64,
    /// Half the edges of the scene's bounding box about the origin, render units; widened.
    pub half_extent: DVec3,
}

/// So much rounding cannot move a surface, render units.
const PADDING: f64 = 1e-5;

impl RenderSpace {
    /// Around what is in some bounds; nothing where that has no extent.
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

    /// Around a box, in scene units.
    pub(super) fn around(center: DVec3, half_extent: DVec3) -> Self {
        let half_diagonal = half_extent.length();
        let scale = (-half_diagonal.log2().ceil()).exp2();
        let half_extent = scale * half_extent + PADDING;
        Self { center, scale, radius: half_diagonal * scale, half_extent }
    }

    /// Area of the scene's bounding box as light that travels along a unit vector sees it, render
    /// units squared.
    pub fn shown_to(&self, direction: DVec3) -> f64 {
        self.faces().dot(direction.abs())
    }

    /// The mean of that over all directions: a quarter of the surface (Cauchy).
    pub fn mean_shown(&self) -> f64 {
        0.5 * self.faces().element_sum()
    }

    /// Areas of the faces across each axis.
    fn faces(&self) -> DVec3 {
        let e = self.half_extent;
        4.0 * DVec3::new(e.y * e.z, e.z * e.x, e.x * e.y)
    }

    /// The transform from world space.
    pub fn from_world(&self) -> DAffine3 {
        DAffine3::from_scale(DVec3::splat(self.scale)) * DAffine3::from_translation(-self.center)
    }
}

/// A box, of nothing at first.
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

    /// The box between two corners.
    pub fn of(lower: DVec3, upper: DVec3) -> Self {
        Self { lower, upper }
    }

    /// The box around points.
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

    /// What two boxes have in common.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let common = Self { lower: self.lower.max(other.lower), upper: self.upper.min(other.upper) };
        (!common.is_empty()).then_some(common)
    }

    /// Widens it by another one.
    pub fn unite(&mut self, other: &Self) {
        *self = Self { lower: self.lower.min(other.lower), upper: self.upper.max(other.upper) };
    }

    /// A box that reaches further on each side.
    pub fn widened(&self, by: f64) -> Self {
        Self { lower: self.lower - by, upper: self.upper + by }
    }

    /// Widens it by a point.
    pub fn add(&mut self, point: DVec3) {
        if point.is_nan() {
            // Transformed beyond all numbers; `min` and `max` would pass over it.
            *self = Self { lower: DVec3::NEG_INFINITY, upper: DVec3::INFINITY };
        }
        self.lower = self.lower.min(point);
        self.upper = self.upper.max(point);
    }

    /// Widens it by a shape in world space.
    pub fn add_shape(&mut self, shape: &Shape) {
        let transform = &shape.world_from_object;
        shape.geometry.hull_all(|point| {
            self.add(transform.transform_point3(point));
            true
        });
    }

    /// Widens it by another one that is transformed.
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
