//! A scene as arrays for the GPU: packing by family, hierarchies, the camera, the features that
//! the kernels are compiled for, and the upload.

mod alias;
mod bvh;
pub(crate) mod camera;
pub mod pack;
#[cfg(test)]
mod tests;
