//! The GPU's structs and kernels, as the build script reflects them from `shaders/`.

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));

/// The value of a specialization constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Constant {
    /// Of a bool.
    Flag(bool),
    /// Of a uint or float.
    Number(f64),
}

impl From<bool> for Constant {
    fn from(value: bool) -> Self {
        Self::Flag(value)
    }
}

impl From<u32> for Constant {
    fn from(value: u32) -> Self {
        Self::Number(value.into())
    }
}

impl From<f32> for Constant {
    fn from(value: f32) -> Self {
        Self::Number(value.into())
    }
}
