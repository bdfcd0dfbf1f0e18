//! The kd-tree over visible points.

use std::time::{Duration, Instant};

use bytemuck::Zeroable;
use goblet_host::{Buffer, Device, Frame, Pass};

use super::deposit::{deposit, of_caustics};
use crate::kernels::{GatherTree, GatherTreePush, Specialization, TreeFill, TreeFillPush, TreePlace, TreePoint};
use crate::render::buffers::{Buffers, Sizes, device_arrays};
use crate::render::counters::Tally;
use crate::render::error::RenderError;
use crate::render::layers::CausticFlux;
use crate::render::lookup::kd_tree;
use crate::render::pacing::Schedule;
use crate::render::stage::Stage;

/// The largest number of invocations that add photons. Each has a place in memory from which an unfinished
/// invocation continues.
const MAX_INVOCATIONS: u32 = 1 << 18;

device_arrays! {
    /// The tree's arrays, for a visible point per pixel.
    pub struct TreeArrays(sizes) {
        /// Pixel and axis of each node.
        tree_nodes: Buffer<u32>[sizes.pixels],
        tree_points: Texels<TreePoint>[sizes.pixels],
        places: Buffer<TreePlace>[MAX_INVOCATIONS],
    }
}

/// A left-balanced kd-tree, and the passes that fill and use it.
pub struct KdTree {
    arrays: TreeArrays,
    fill: Pass<TreeFillPush>,
    gather: Pass<GatherTreePush>,
    /// The same for photons of caustics alone.
    gather_caustics: Option<Pass<GatherTreePush>>,
    node_count: u32,
    host_time: Duration,
}

impl KdTree {
    /// Compiles the passes and allocates the tree.
    ///
    /// # Errors
    /// The device has too little memory, or the driver refuses a kernel.
    pub fn new(
        device: &Device,
        (buffers, caustics): (&Buffers, Option<&CausticFlux>),
        sizes: &Sizes,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let Buffers { visible_points, visible_radii2, max_radius2, counters, .. } = buffers;
        let Buffers { photons, flux_red, flux_green, flux_blue, flux_counts, .. } = buffers;
        let arrays = TreeArrays::allocate(device, sizes)?;
        let TreeArrays { tree_nodes, tree_points, places } = &arrays;
        let fill = TreeFill { visible_points, visible_radii2, tree_nodes, tree_points };
        let gather = |[flux_red, flux_green, flux_blue, flux_counts]: [&Buffer<u32>; 4],
                      specialization: &Specialization| {
            let kernel = GatherTree {
                photons,
                max_radius2,
                tree_points,
                counters,
                places,
                flux_red,
                flux_green,
                flux_blue,
                flux_counts,
            };
            device.pass(&kernel, specialization, workgroup_size)
        };
        Ok(Self {
            fill: device.pass(&fill, specialization, workgroup_size)?,
            gather: gather([flux_red, flux_green, flux_blue, flux_counts], specialization)?,
            gather_caustics: caustics
                .map(|caustics| gather(caustics.each_ref(), &of_caustics(specialization)))
                .transpose()?,
            arrays,
            node_count: 0,
            host_time: Duration::ZERO,
        })
    }

    /// Runs each pass once without work, because a driver may compile a kernel at its first dispatch.
    pub fn warm_up(&self, frame: &mut Frame<'_>) {
        frame.dispatch(&self.fill, Zeroable::zeroed(), 1);
        self.gathers().for_each(|gather| frame.dispatch(gather, Zeroable::zeroed(), 1));
    }

    /// Indexes the visible points. If they are not `new`, only their radii have changed; the tree does not
    /// depend on radii and is not built again.
    ///
    /// # Errors
    /// The device fails.
    pub fn build(&mut self, on: Stage<'_>, new: bool) -> Result<(), RenderError> {
        let Stage { device, buffers, settings, .. } = on;
        if new {
            let start = Instant::now();
            let points = device.read_first_texels(&buffers.visible_points, settings.pixels())?;
            let radii2 = device.read_first_texels(&buffers.visible_radii2, settings.pixels())?;
            let positions = points.iter().map(|point| point.position);
            let nodes = kd_tree::build(positions.zip(radii2));
            device.write(&self.arrays.tree_nodes, &nodes)?;
            self.node_count = nodes.len() as u32;
            self.host_time += start.elapsed();
        }
        let mut frame = device.frame()?;
        frame.dispatch(&self.fill, TreeFillPush { node_count: self.node_count }, self.node_count.into());
        frame.run()?;
        Ok(())
    }

    /// Adds each of the `recorded` photons to the visible points on whose discs it lies. An invocation takes
    /// [`Schedule::per_invocation`] photons, or more if there would be more than [`MAX_INVOCATIONS`]
    /// invocations.
    ///
    /// # Errors
    /// The device fails, the driver ends the pass early, or the caller gives the iteration up.
    pub fn gather(&self, on: Stage<'_>, recorded: u32, schedule: &mut Schedule) -> Result<Tally, RenderError> {
        let stride = recorded.div_ceil(schedule.per_invocation() as u32).min(MAX_INVOCATIONS);
        let node_count = self.node_count;
        let push = |offset, resumed| GatherTreePush { recorded, stride, node_count, resumed, offset };
        let mut tally = Tally::default();
        for gather in self.gathers() {
            let pace = &mut schedule.paces.gather;
            tally.merge(&deposit(on, ("gather_tree", gather), stride.into(), pace, push)?);
        }
        Ok(tally)
    }

    /// The pass that adds all photons, and the one that adds those of caustics.
    fn gathers(&self) -> impl Iterator<Item = &Pass<GatherTreePush>> {
        [&self.gather].into_iter().chain(&self.gather_caustics)
    }

    /// Returns the time that the host has spent on trees so far, including the transfer of points and nodes.
    pub fn host_time(&self) -> Duration {
        self.host_time
    }
}
