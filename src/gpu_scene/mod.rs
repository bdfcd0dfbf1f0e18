//! A scene as arrays for the GPU: packing per family, bounding volume hierarchies, the camera, the features
//! that the kernels are specialised to, and the upload.

pub mod alias;
mod bvh;
pub mod camera;
mod collapse;
pub mod pack;
#[cfg(test)]
mod tests;
mod wide;
