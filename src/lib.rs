//! goblet renders caustics: a progressive photon mapper that runs as Vulkan compute.
//!
//! A render takes five steps: read a [`scene::Scene`], open a [`Device`], make a [`Renderer`], run
//! iterations, and read the image. The image is complete after the first iteration. Each further
//! iteration lowers its noise and its blur.
//!
//! ```no_run
//! use std::sync::Arc;
//!
//! use goblet::scene::Scene;
//! use goblet::{DeviceOptions, Options, Renderer, open_device};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = Scene::load("scenes/cornell-caustic.pbrt")?;
//! let device = Arc::new(open_device(&DeviceOptions::default())?);
//! let options = Options { photons: Some(100_000), ..Options::default() };
//! let mut renderer = Renderer::new(device, &scene, &options)?;
//! for _ in 0..scene.integrator.iterations {
//!     renderer.step()?;
//! }
//! goblet::image::file::write("cornell-caustic.exr".as_ref(), &renderer.resolve()?, &[])?;
//! # Ok(())
//! # }
//! ```
//!
//! ```text
//! text or file ─ Scene::parse, Scene::load ─► Scene ─ Renderer::new ─► arrays and kernels on the device
//!
//! Renderer::step                  one iteration
//!     eye        traces paths from each pixel to visible points
//!     radius     gives each visible point its radius for this iteration
//!     photon     emits photons, and records where they meet a diffuse surface
//!     grid       sorts the records into cells
//!     gather     sums the photons within the radius of each visible point
//!     update     adds the iteration's image to the mean
//!
//! Renderer::resolve ─► image::film::Image ─ image::file::write ─► EXR, PNG
//! Renderer::checkpoint ─► render::checkpoint::Checkpoint ─ Renderer::resume ─► the same render, later
//! ```
//!
//! # Where to begin
//!
//! - [`scene::Scene::parse`] reads a scene from a string, and [`scene::Camera::looking_at`] makes a camera
//!   from an eye, a target and a field of view.
//! - [`Options`] says how to render; [`render::options::table::OPTIONS`] has the range, unit and help of each
//!   option.
//! - [`Prepared`] makes a renderer in two steps, and tells an [`Observer`] what it does: [`Activity`].
//! - [`Renderer::relative_error`] estimates the noise of the image so far.
//! - A [`Renderer`] is `Send`, and several of them may share a [`Device`].
//! - `examples/` has three programs: a render to a buffer, a callback after each iteration, and a study of
//!   a parameter.
//!
//! Radiance is in W/(m² sr), lengths are in scene units, angles in radians. The same scene, options,
//! device and driver give the same bytes.
//!
//! # Features
//!
//! All features are on by default. A program that uses the library needs none of them and can set
//! `default-features = false`.
//!
//! - `cli`: the program `goblet`.
//! - `study`: comparisons of settings, with charts, in the module `study`.
//! - `view`: the window of `goblet view`; implies `cli`.
//!
//! The crate `goblet-host` has all Vulkan code and all unsafe code. This crate has the physics.
#![forbid(unsafe_code)]
// The print macros panic if the reader of the output is gone; `cli::terminal` prints without a panic.
#![deny(clippy::print_stdout, clippy::print_stderr)]
#![cfg_attr(
    not(all(feature = "cli", feature = "study", feature = "view")),
    allow(dead_code, unused_imports, reason = "some items are there for a feature")
)]

pub mod base;
#[cfg(feature = "cli")]
pub mod cli;
pub mod geometry;
pub mod gpu_scene;
pub mod image;
pub mod kernels;
pub mod render;
pub mod scene;
#[cfg(feature = "study")]
pub mod study;
#[cfg(feature = "view")]
pub mod viewer;

pub use glam;
pub use goblet_host::{ArrayKind, Device, DeviceInfo, DeviceKind, Error as DeviceError};

pub use base::host_memory::OutOfHostMemory;
pub use gpu_scene::pack::{Envelopes, PackError, RevolutionSolver};
pub use render::activity::{Activity, Observer};
pub use render::counters::{ByPass, Tally};
pub use render::counts::{Auto, Choice, Counts, Trial};
pub use render::device::{DeviceOptions, open_device};
pub use render::error::RenderError;
pub use render::guide::guidance::Guidance;
pub use render::options::{Contribution, DirectLight, Integrator, LookupKind, Options, Sampler, Submission};
pub use render::radius::RadiusSchedule;
pub use render::renderer::{Aside, Prepared, Renderer};
pub use render::sequence::Shard;
pub use render::unsampled::Noise;
