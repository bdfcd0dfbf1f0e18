//! Curves and maps of the plane and the sphere, in f64, without a scene or a device.

pub mod bezier;
pub mod equal_area;
