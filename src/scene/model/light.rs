//! Lights that are not surfaces.

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use crate::image::film::Image;
use crate::scene::model::Rgb;

/// An image that gives the light in each direction: a texel has one colour, as in pbrt.
#[derive(Clone, Debug, PartialEq)]
pub struct LightImage {
    /// Pixels: finite, 0 or more, and not all black. The first row is the top one, v = 0.
    pub pixels: Arc<Image>,
    /// Transform of directions from the image's space to world space; its columns are orthogonal and of
    /// unit length.
    pub world_from_image: DMat3,
}

/// A rectangle through which alone a sky is seen, in world space. It is seen from the side to which
/// `edges[1]` x `edges[0]` points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Portal {
    /// A corner.
    pub corner: DVec3,
    /// The edges at the corner, perpendicular to each other.
    pub edges: [DVec3; 2],
}

/// A light that is not a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// Emits the same intensity in all directions from a point.
    Point {
        /// Position in world space.
        position: DVec3,
        /// Radiant intensity, W/sr; scale and power included.
        intensity: Rgb,
    },
    /// A point that emits within a cone.
    Spot {
        /// Position in world space.
        position: DVec3,
        /// Axis of the cone, unit length, world space.
        direction: DVec3,
        /// Radiant intensity on the axis, W/sr; scale and power included.
        intensity: Rgb,
        /// 1 minus the cosine of the angle at which the smooth falloff starts.
        falloff_start: f64,
        /// 1 minus the cosine of the angle beyond which the light emits nothing.
        falloff_end: f64,
    },
    /// Parallel light from infinitely far away.
    Distant {
        /// Direction in which the light travels, unit length, world space.
        direction: DVec3,
        /// Irradiance on a surface that faces the light, W/m².
        irradiance: Rgb,
    },
    /// A point whose intensity depends on the direction, by the equal-area map of
    /// [`crate::geometry::equal_area`].
    Goniometric {
        /// Position in world space.
        position: DVec3,
        /// Grey image whose pixels multiply the intensity.
        image: LightImage,
        /// Radiant intensity before the image's factor, W/sr; scale and power included.
        intensity: Rgb,
    },
    /// A point that projects an image, which fills a window on the plane z = 1 of the image's space; u
    /// grows with x, v with y.
    Projection {
        /// Position in world space.
        position: DVec3,
        /// Image whose pixels multiply the intensity.
        image: LightImage,
        /// Radiant intensity before the image's factor, W/sr; scale and power included.
        intensity: Rgb,
        /// Half the width and height of the window.
        half_extent: DVec2,
    },
    /// Radiance from infinitely far away that depends on the direction, by the equal-area map of
    /// [`crate::geometry::equal_area`].
    Sky {
        /// Image whose pixels multiply the radiance, by the direction to the sky.
        image: LightImage,
        /// Radiance before the image's factor, W/(m² sr); scale and illuminance included.
        radiance: Rgb,
        /// The window through which alone the sky is seen.
        portal: Option<Portal>,
    },
    /// The same radiance from every direction.
    Infinite {
        /// Radiance, W/(m² sr).
        radiance: Rgb,
    },
}

impl Light {
    /// Returns the type that a `LightSource` names.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Point { .. } => "point",
            Self::Spot { .. } => "spot",
            Self::Distant { .. } => "distant",
            Self::Goniometric { .. } => "goniometric",
            Self::Projection { .. } => "projection",
            Self::Sky { .. } | Self::Infinite { .. } => "infinite",
        }
    }

    /// Returns the position of a point that emits, in world space; `None` for light from infinitely far away.
    pub fn position(&self) -> Option<DVec3> {
        match self {
            Self::Point { position, .. }
            | Self::Spot { position, .. }
            | Self::Goniometric { position, .. }
            | Self::Projection { position, .. } => Some(*position),
            Self::Distant { .. } | Self::Sky { .. } | Self::Infinite { .. } => None,
        }
    }
}
