//! The numerically hard parts of the shaders against f64 twins.
//!
//! Each kernel of `tests/kernels/` includes the shader code that renders and applies it to
//! arrays of inputs. Tolerances are derived in place, in units of `EPS`: half a unit in the
//! last place of 1, the largest relative error of one fp32 operation.

#[path = "kernels/bench.rs"]
mod bench;
#[path = "kernels/bsdf.rs"]
mod bsdf;
#[path = "kernels/discs.rs"]
mod discs;
#[path = "kernels/emission.rs"]
mod emission;
#[path = "kernels/flux.rs"]
mod flux;
#[path = "kernels/grid.rs"]
mod grid;
#[path = "kernels/instance.rs"]
mod instance;
#[path = "kernels/interruption.rs"]
mod interruption;
#[path = "kernels/light.rs"]
mod light;
#[path = "kernels/light_image.rs"]
mod light_image;
#[path = "kernels/newton.rs"]
mod newton;
#[path = "kernels/normal.rs"]
mod normal;
#[path = "kernels/quadric.rs"]
mod quadric;
#[path = "kernels/random.rs"]
mod random;
#[path = "kernels/revolution/mod.rs"]
mod revolution;
#[path = "kernels/rough.rs"]
mod rough;
#[path = "kernels/sampling.rs"]
mod sampling;
#[path = "kernels/statistics.rs"]
mod statistics;
#[path = "kernels/sum.rs"]
mod sum;
mod support;
#[path = "kernels/surface.rs"]
mod surface;
#[path = "kernels/texture.rs"]
mod texture;
#[path = "kernels/tone_map.rs"]
mod tone_map;
#[path = "kernels/trace.rs"]
mod trace;
#[path = "kernels/tree.rs"]
mod tree;
#[path = "kernels/triangle.rs"]
mod triangle;
#[path = "kernels/update.rs"]
mod update;
#[path = "kernels/world.rs"]
mod world;

/// The kernels of `tests/kernels/`, and what they share with those that render.
mod generated {
    pub use goblet::kernels::*;
    pub use goblet_test_kernels::*;
}
