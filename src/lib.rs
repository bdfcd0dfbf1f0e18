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
//! goblet::output::write("cornell-caustic.exr".as_ref(), &renderer.resolve()?, &[])?;
//! # Ok(())
//! # }
//! ```
//!
//! `src/iteration.rs` is the algorithm in one page, `shaders/` the passes that it dispatches.
//! This crate knows physics and no Vulkan; `goblet-host` knows Vulkan and no physics.
#![forbid(unsafe_code)]
// They panic where nobody reads them: `cli::terminal` prints.
#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod advise;
mod alias;
pub mod bezier;
mod buffers;
mod bvh;
#[doc(hidden)]
pub mod chart;
pub mod checkpoint;
pub mod cli;
mod color;
pub mod compare;
pub mod estimate;
pub mod film;
mod identity;
pub mod input;
mod iteration;
#[doc(hidden)]
pub mod kd_tree;
pub mod kernels;
mod lookup;
#[doc(hidden)]
pub mod machine;
pub mod measure;
#[doc(hidden)]
pub mod octahedral;
mod options;
pub mod output;
#[doc(hidden)]
pub mod pack;
mod path_pass;
mod radius;
mod renderer;
mod room;
pub mod scene;
mod schedule;
mod sequence;
mod tally;
pub mod tessellate;
mod unsampled;
mod upload;
mod view;
#[cfg(feature = "view")]
mod window;

pub use options::{Contribution, DirectLight, Integrator, LookupKind, Options, Sampler};
pub use pack::{Envelopes, PackError, RevolutionSolver};
pub use radius::RadiusSchedule;
pub use renderer::{Aside, RenderError, Renderer, open_device};
pub use room::NoRoom;
pub use sequence::Shard;
pub use tally::{ByPass, Tally};
pub use unsampled::Noise;
