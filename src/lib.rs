//! goblet renders caustics: a progressive photon mapper that runs as Vulkan compute.
//!
//! Load a [`scene::Scene`], open a device, make a [`Renderer`], step it, resolve and write:
//!
//! ```no_run
//! use std::rc::Rc;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = goblet::scene::Scene::load("scenes/cornell-caustic.pbrt")?;
//! let device = Rc::new(goblet::open_device(None, false)?);
//! let mut renderer = goblet::Renderer::new(device, &scene, &goblet::Options::default())?;
//! for _ in 0..scene.integrator.iterations {
//!     renderer.step()?;
//! }
//! goblet::image::file::write("cornell-caustic.exr".as_ref(), &renderer.resolve()?, &[])?;
//! # Ok(())
//! # }
//! ```
//!
//! `src/render/iteration.rs` is the algorithm in one page, `shaders/` the passes that it dispatches.
//! This crate knows physics and no Vulkan; `goblet-host` knows Vulkan and no physics.
#![forbid(unsafe_code)]
// They panic where nobody reads them: `cli::terminal` prints.
#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod base;
pub mod cli;
pub mod geometry;
pub mod gpu_scene;
pub mod image;
pub mod kernels;
pub mod render;
pub mod scene;
pub mod study;
#[cfg(feature = "view")]
pub mod viewer;

pub use base::room::NoRoom;
pub use gpu_scene::pack::{Envelopes, PackError, RevolutionSolver};
pub use render::counters::{ByPass, Tally};
pub use render::error::RenderError;
pub use render::options::{Contribution, DirectLight, Integrator, LookupKind, Options, Sampler};
pub use render::radius::RadiusSchedule;
pub use render::renderer::{Aside, Renderer, open_device};
pub use render::sequence::Shard;
pub use render::unsampled::Noise;
