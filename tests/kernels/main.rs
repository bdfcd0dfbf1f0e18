//! The numerically hard parts of the shaders against f64 twins.
//!
//! Each kernel of `tests/kernels/` includes the shader code that renders and applies it to
//! arrays of inputs. Tolerances are derived in place, in units of `EPS`: half a unit in the
//! last place of 1, the largest relative error of one fp32 operation.

mod absorption;
mod bsdf;
mod bump;
mod circle;
mod discs;
mod dispersion;
mod emission;
mod fixture;
mod flux;
mod grid;
mod guard;
mod guide;
mod instance;
mod interruption;
mod layers;
mod light;
mod light_image;
mod measured;
mod newton;
mod noise;
mod normal;
mod quadric;
mod radius;
mod random;
mod revolution;
mod rough;
mod sampling;
mod statistics;
mod subgroup;
mod sum;
#[path = "../support/mod.rs"]
mod support;
mod surface;
mod texture;
mod tone_map;
mod trace;
mod tree;
mod triangle;
mod update;
mod world;

/// The kernels of `tests/kernels/`, and what they share with those that render.
mod generated {
    pub use goblet::kernels::*;
    pub use goblet_test_kernels::*;
}
