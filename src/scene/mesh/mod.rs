//! Triangle meshes: PLY files, and meshes in place of bodies of revolution.

pub(in crate::scene) mod ply;
pub mod tessellate;
