//! Values of materials and lights.

use glam::DVec3;

/// Linear RGB in the sRGB primaries.
pub type Rgb = DVec3;

/// A value that may vary over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input<T> {
    /// One value everywhere.
    Constant(T),
    /// A value from a texture: the index into [`crate::scene::Scene::textures`].
    Texture(usize),
}
