//! The passes of an image's layers. `shaders/passes/surface_layers.comp` finds the first surface of eye paths,
//! `light_layers.comp` computes the parts of the light and the properties of the discs, `layer_sums.comp` adds the values
//! of both to the sums.

use std::sync::Arc;

use bytemuck::Zeroable;
use goblet_host::{Compiling, Device, Frame, Pass};

use super::path::{PLACES, PathKernels, PathPass, Start};
use crate::image::layers::{Group, Groups};
use crate::kernels::{
    LayerSums, LayerSumsPush, LightLayers, LightLayersPush, NONE, SceneFeatures, Specialization, SurfaceLayers,
    SurfaceLayersPush,
};
use crate::render::buffers::{Buffers, invocations_by_tile};
use crate::render::error::RenderError;
use crate::render::layers::LayerArrays;
use crate::render::progress::Progress;
use crate::render::sequence::IterationIndex;
use crate::render::stage::Stage;

/// The passes of the layers that were asked for, with their arrays.
pub struct LayerPasses {
    /// The arrays.
    pub arrays: LayerArrays,
    /// `None` if no layer is of surfaces.
    surfaces: Option<PathPass<SurfaceLayersPush>>,
    light: Pass<LightLayersPush>,
    /// For each group.
    sums: Vec<Pass<LayerSumsPush>>,
    kernels: Arc<PathKernels>,
}

impl LayerPasses {
    pub(super) fn new(
        device: &Device,
        buffers: &Buffers,
        arrays: LayerArrays,
        kernels: &Arc<PathKernels>,
    ) -> goblet_host::Result<Self> {
        let (specialization, size) = (&kernels.specialization, kernels.workgroup_size);
        let Buffers { visible_radii2, visible_throughputs, visible_radiances, counters, .. } = buffers;
        let Buffers { flux_red, flux_green, flux_blue, flux_counts, .. } = buffers;
        let LayerArrays { values: layer_values, caustic_flux, .. } = &arrays;
        let [caustic_red, caustic_green, caustic_blue, _] = caustic_flux;
        let light = LightLayers {
            visible_radii2,
            visible_throughputs,
            visible_radiances,
            caustic_red,
            caustic_green,
            caustic_blue,
            layer_values,
            counters,
            flux_red,
            flux_green,
            flux_blue,
            flux_counts,
        };
        let sums = arrays.sums.iter().map(|[layer_x, layer_y, layer_z, layer_w]| {
            let kernel = LayerSums { layer_values, layer_x, layer_y, layer_z, layer_w, counters };
            device.pass(&kernel, specialization, size)
        });
        let surfaces = if arrays.groups.iter().any(Group::is_of_surface) {
            Some(PathPass::new(surfaces(kernels, device, buffers, &arrays, false)?.finish()?, size))
        } else {
            None
        };
        Ok(Self {
            light: device.pass(&light, specialization, size)?,
            sums: sums.collect::<goblet_host::Result<_>>()?,
            surfaces,
            kernels: Arc::clone(kernels),
            arrays,
        })
    }

    /// Returns the number of kernels that [`LayerPasses::new`] compiles.
    pub(super) fn kernels(arrays: &LayerArrays) -> u32 {
        let has_surfaces = arrays.groups.iter().any(Group::is_of_surface);
        1 + arrays.sums.len() as u32 + u32::from(has_surfaces)
    }

    pub(super) fn warm_up(&self, frame: &mut Frame<'_>) {
        if let Some(surfaces) = &self.surfaces {
            let nothing = [NONE; 5];
            let [albedo_group, position_group, normal_group, shading_group, slope_group] = nothing;
            let groups = SurfaceLayersPush {
                albedo_group,
                position_group,
                normal_group,
                shading_group,
                slope_group,
                paths: 1,
                spread: 1,
                ..Zeroable::zeroed()
            };
            frame.dispatch(surfaces.plain(), groups, 1);
        }
        frame.dispatch(&self.light, Zeroable::zeroed(), 1);
        self.sums.iter().for_each(|sums| frame.dispatch(sums, Zeroable::zeroed(), 1));
    }

    /// Finds what the eye paths of a round meet first. The visible points of that round are on the device.
    ///
    /// # Errors
    /// The device fails, or the caller gives the iteration up.
    pub fn meet_surfaces(
        &mut self,
        on: Stage<'_>,
        index: IterationIndex,
        progress: &Progress,
    ) -> Result<(), RenderError> {
        let Self { arrays, surfaces: pass, kernels, .. } = self;
        let Some(pass) = pass else { return Ok(()) };
        // Eye paths have this segment and more, so that their pace is short enough.
        let mut pace = progress.schedule.paces.eye;
        for path in 0..on.settings.eye_paths {
            let resumable = || surfaces(kernels, on.device, on.buffers, arrays, true)?.finish();
            let push = |start| surface_push(on, index, path, start);
            pass.run(on, invocations_by_tile(on.settings.resolution), &mut pace, resumable, push)?;
        }
        Ok(())
    }

    /// Records the commands that do so in one dispatch for each path.
    pub fn record_surfaces(&self, on: Stage<'_>, index: IterationIndex, frame: &mut Frame<'_>) {
        let Some(pass) = &self.surfaces else { return };
        for path in 0..on.settings.eye_paths {
            let push = surface_push(on, index, path, Start::AT_FIRST);
            frame.dispatch(pass.plain(), push, invocations_by_tile(on.settings.resolution));
        }
    }

    /// Whether the driver cannot follow all paths in one dispatch.
    pub fn is_resumable(&self) -> bool {
        self.surfaces.as_ref().is_some_and(PathPass::is_resumable)
    }

    /// Clears the flux of caustics, before the photons of an iteration.
    ///
    /// # Errors
    /// The device fails.
    pub fn clear_caustics(&self, on: Stage<'_>) -> Result<(), RenderError> {
        if self.arrays.caustics().is_none() {
            return Ok(());
        }
        let mut frame = on.device.frame()?;
        self.record_clear(&mut frame);
        Ok(frame.run()?)
    }

    /// Records the commands that do so.
    pub fn record_clear(&self, frame: &mut Frame<'_>) {
        if self.arrays.caustics().is_some() {
            self.arrays.clear_caustics(frame);
        }
    }

    /// Records the commands that find the light of an iteration by its ways, before the update pass clears its flux.
    pub fn record_light(&self, on: Stage<'_>, rough_scale: f32, frame: &mut Frame<'_>) {
        let settings = on.settings;
        let [light_group, caustic_group, square_group] =
            [Group::Light, Group::Caustic, Group::Square].map(|group| place(settings.layers.groups, group));
        if [light_group, caustic_group, square_group] == [NONE; 3] {
            return;
        }
        let balance = settings.white_balance.unwrap_or(glam::DMat3::IDENTITY);
        let push = LightLayersPush {
            balance: [0, 1, 2].map(|row| balance.row(row).extend(0.0).as_vec4().to_array()),
            per_unit: (1.0 / settings.unit) as f32,
            flux_scale: settings.flux_scale() as f32,
            per_photon: (1.0 / settings.photons as f64) as f32,
            pixel_count: settings.pixels() as u32,
            capacity: on.buffers.photons.len() as u32,
            light_group,
            caustic_group,
            square_group,
            rough_scale,
            pad0: 0,
            pad1: 0,
            pad2: 0,
        };
        frame.dispatch(&self.light, push, settings.pixels());
    }

    /// Records the commands that add the values of an iteration to the sums. As the update pass, they do nothing for an
    /// iteration that is not finished.
    pub fn record_sums(&self, on: Stage<'_>, frame: &mut Frame<'_>) {
        let (pixels, capacity) = (on.settings.pixels(), on.buffers.photons.len() as u32);
        for (group, sums) in (0..).zip(&self.sums) {
            frame.dispatch(sums, LayerSumsPush { pixel_count: pixels as u32, group, capacity, pad0: 0 }, pixels);
        }
    }
}

/// Returns the number of a group among others, as kernels have it.
fn place(groups: Groups, group: Group) -> u32 {
    groups.place(group).map_or(NONE, |place| place as u32)
}

/// Compiles the pass of surfaces; a resumable one has memory for places.
fn surfaces(
    kernels: &PathKernels,
    device: &Device,
    buffers: &Buffers,
    arrays: &LayerArrays,
    is_resumable: bool,
) -> goblet_host::Result<Compiling<SurfaceLayersPush>> {
    let Buffers { camera, filter_table, counters, .. } = buffers;
    let places = &device.buffer("surface_places", if is_resumable { PLACES } else { 0 })?;
    let scene = kernels.scene.bindings();
    let kernel = SurfaceLayers { scene, camera, filter_table, layer_values: &arrays.values, counters, places };
    let all = kernels.specialization(is_resumable);
    // Triangles have texture coordinates if they are asked for: src/render/renderer.rs.
    let has_textures = all.scene.has_textures || arrays.groups.has(Group::Slope);
    let specialization = Specialization { scene: SceneFeatures { has_textures, ..all.scene }, ..all };
    device.compile(&kernel, &specialization, kernels.workgroup_size)
}

fn surface_push(
    on: Stage<'_>,
    index: IterationIndex,
    path: u32,
    Start { offset, resumed, spread }: Start,
) -> SurfaceLayersPush {
    let settings = on.settings;
    let place = |group| place(settings.layers.groups, group);
    SurfaceLayersPush {
        slope_axis: settings.layers.slope_axis().normalize_or_zero().as_vec3().to_array(),
        turn: index.turn,
        half_of_rounds: index.half,
        path,
        paths: settings.eye_paths,
        pixel_count: settings.pixels() as u32,
        albedo_group: place(Group::Albedo),
        position_group: place(Group::Position),
        normal_group: place(Group::Normal),
        shading_group: place(Group::ShadingNormal),
        slope_group: place(Group::Slope),
        offset,
        resumed,
        spread,
    }
}
