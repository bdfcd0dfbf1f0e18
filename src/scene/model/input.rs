//! Values of materials and lights.

use glam::DVec3;

/// Linear RGB, sRGB primaries.
pub type Rgb = DVec3;

/// A value that may vary over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input<T> {
    /// The same everywhere.
    Constant(T),
    /// A texture: an index into [`crate::scene::Scene::textures`].
    Texture(usize),
}
