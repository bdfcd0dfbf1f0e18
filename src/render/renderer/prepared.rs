//! A scene that is prepared for a render, before the device has anything of it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use goblet_host::{Device, DeviceKind};

use super::{Base, Compiled, Renderer};
use crate::base::host_memory;
use crate::gpu_scene::camera::View;
use crate::gpu_scene::pack::{PackedScene, pack};
use crate::image::file;
use crate::render::activity::{Activity, Observer};
use crate::render::buffers::{Buffers, Sizes, room_for_records};
use crate::render::checkpoint::{Checkpoint, CheckpointError};
use crate::render::error::RenderError;
use crate::render::guide::lights::GuideLights;
use crate::render::identity::Identity;
use crate::render::layers::LayerArrays;
use crate::render::memory::MemoryNeed;
use crate::render::options::{Options, Resolved};
use crate::render::passes::Passes;
use crate::scene::Scene;

/// A scene whose hierarchy is built, with the checked options of a render. [`Prepared::build`] makes the [`Renderer`].
pub struct Prepared<'a> {
    scene: &'a Scene,
    options: &'a Options,
    observer: Observer,
    packed: PackedScene,
    base: Base,
    resolved: Resolved,
    view: View,
    identity: Identity,
    time: Duration,
}

impl<'a> Prepared<'a> {
    /// Builds the hierarchy of a scene, and checks the options. `observer` is told what is done here, by
    /// [`Prepared::build`], and by the renderer.
    ///
    /// # Errors
    /// The scene cannot be rendered, or an option is out of range.
    pub fn new(scene: &'a Scene, options: &'a Options, observer: Observer) -> Result<Self, RenderError> {
        let start = Instant::now();
        observer.tell(Activity::BuildingHierarchy);
        let packed = pack(scene, options.packing(scene))?;
        let base = Base {
            space: packed.space,
            mean_power: packed.mean_power,
            has_surfaces: packed.has_surfaces(),
            features: packed.features,
            material_features: packed.material_features,
            is_plane: scene.is_plane(),
        };
        let (resolved, view) = base.resolve(scene, options)?;
        let identity = Identity::new(scene, &packed, &view, options, &resolved);
        Ok(Self { scene, options, observer, packed, base, resolved, view, identity, time: start.elapsed() })
    }

    /// Checks that a checkpoint is of this render, except for numbers that a trial chooses ([`Options::auto`]).
    /// [`Renderer::resume`] checks these too.
    ///
    /// # Errors
    /// The checkpoint is of another render: the error has the differences.
    pub fn check(&self, checkpoint: &Checkpoint) -> Result<(), CheckpointError> {
        let auto = if self.options.responsive { Default::default() } else { self.options.auto };
        self.identity.check_except(&checkpoint.identity, auto)?;
        checkpoint.done_by(self.resolved.sequence.shard).map(drop)
    }

    /// Copies the scene to a device and compiles the kernels. Renders a trial if [`Options::auto`] asks for one.
    ///
    /// # Errors
    /// The host or the device does not have enough memory, or the device fails.
    pub fn build(self, device: Arc<Device>) -> Result<Renderer, RenderError> {
        let (scene, options) = (self.scene, self.options);
        let mut renderer = self.with_usual_counts(device)?;
        if options.auto.is_any() && !options.responsive {
            renderer.choose_counts(scene, options)?;
        }
        Ok(renderer)
    }

    /// The same with the usual numbers of photons and eye paths, where a trial is asked for.
    fn with_usual_counts(self, device: Arc<Device>) -> Result<Renderer, RenderError> {
        let Self { scene, options, observer, packed, base, resolved, view, identity, time } = self;
        let start = Instant::now();
        observer.tell(Activity::Uploading);
        let compiled = base.compiled(&device, options, &resolved, &view);
        let info = device.info();
        let room = room_for_records(info.kind, info.memory.total_bytes, info.max_buffer_bytes);
        let lights = if options.is_guided() { GuideLights::of(&packed.arrays.lights) } else { GuideLights::default() };
        let sizes = Sizes::of_render(&packed, options, &resolved, room);
        let memory = MemoryNeed::new(&packed, &sizes, compiled.lookup, resolved.layers);
        memory.check(&device)?;
        // Drivers and compilers abort the process if the host has no memory left.
        let on_host = if device.info().kind == DeviceKind::Cpu { memory.total() } else { 0 };
        let of_file = file::host_bytes(resolved.resolution, resolved.layers.len() as u64);
        host_memory::check("a render of this size", on_host.saturating_add(of_file))?;
        let gpu_scene = packed.arrays.upload(&device, &packed.info(resolved.max_depth, resolved.seed))?;
        let buffers = Buffers::new(&device, &sizes, &view)?;
        device.write_texels(&buffers.guide_lights, &lights.order)?;
        let layers = LayerArrays::new(&device, resolved.layers, sizes.pixels)?;
        let build_time = time + start.elapsed();

        let start = Instant::now();
        let Compiled { specialization, lookup, workgroup_size, .. } = &compiled;
        let arrays = (&buffers, layers);
        let constants = (specialization, *workgroup_size);
        let passes = Passes::new(&device, gpu_scene, arrays, &sizes, *lookup, constants, &observer)?;
        Ok(Renderer {
            settings: base.settings(scene, options, &resolved, &view),
            progress: base.progress(&device, options, &resolved, &view),
            exposure: scene.film.exposure,
            base,
            compiled,
            identity,
            sizes,
            buffers,
            passes,
            lights,
            warnings: packed.contacts.warnings(),
            choice: None,
            observer,
            build_time,
            compile_time: start.elapsed(),
            device,
        })
    }
}
