//! Passes that follow paths. If a driver limits the loops of an invocation, they continue interrupted paths in
//! further dispatches: see `shaders/include/kernel/interruption.glsl`.

use std::time::Instant;

use bytemuck::{Pod, Zeroable};
use goblet_host::{Compiling, Device, Pass};

use crate::kernels::{Counters, Eye, EyePush, GpuScene, PassFeatures, Photon, PhotonPush, Specialization};
use crate::render::buffers::Buffers;
use crate::render::error::RenderError;
use crate::render::pacing::Pace;
use crate::render::stage::Stage;

/// Invocations of one dispatch of a resumable pass, at most: each has a place to go on from.
/// Every workgroup size divides it.
pub(super) const PLACES: u64 = 1 << 13;

/// Where the invocations of a dispatch begin.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// The first invocation.
    pub offset: u32,
    /// 1 to go on from the places that the dispatch before has left, else 0.
    pub resumed: u32,
    /// Of `spread` consecutive invocations, one works.
    pub spread: u32,
}

/// What the passes that follow paths are compiled from.
pub struct PathKernels {
    /// The scene.
    pub scene: GpuScene,
    /// What it requires.
    pub specialization: Specialization,
    /// Invocations of a workgroup.
    pub workgroup_size: u32,
    /// Whether the lanes of a subgroup work together on a queue of rays.
    pub is_queue: bool,
}

impl PathKernels {
    /// The eye pass; a resumable one has memory for places.
    ///
    /// # Errors
    /// Out of memory, or the driver refuses the kernel.
    pub fn eye(
        &self,
        device: &Device,
        buffers: &Buffers,
        is_resumable: bool,
    ) -> goblet_host::Result<Compiling<EyePush>> {
        let Buffers { camera, filter_table, counters, .. } = buffers;
        let Buffers { visible_points, visible_throughputs, visible_radiances, rough_points, .. } = buffers;
        let places = &device.buffer("eye_places", if is_resumable { PLACES } else { 0 })?;
        let scene = self.scene.bindings();
        let kernel = Eye {
            scene,
            camera,
            filter_table,
            visible_points,
            visible_throughputs,
            visible_radiances,
            rough_points,
            counters,
            places,
        };
        device.compile(&kernel, &self.specialization(is_resumable), self.workgroup_size)
    }

    /// The photon pass; a resumable one has memory for places.
    ///
    /// # Errors
    /// Out of memory, or the driver refuses the kernel.
    pub fn photon(
        &self,
        device: &Device,
        buffers: &Buffers,
        is_resumable: bool,
    ) -> goblet_host::Result<Compiling<PhotonPush>> {
        let Buffers { photons, rough_photons, counters, guide_nodes, guide_lights, pilot_numbers, .. } = buffers;
        let places = &device.buffer("photon_places", if is_resumable { PLACES } else { 0 })?;
        let scene = self.scene.bindings();
        let kernel =
            Photon { scene, photons, rough_photons, counters, places, guide_nodes, guide_lights, pilot_numbers };
        device.compile(&kernel, &self.specialization(is_resumable), self.workgroup_size)
    }

    /// Returns what a pass is specialised to.
    pub(super) fn specialization(&self, is_resumable: bool) -> Specialization {
        Specialization {
            pass: PassFeatures { is_resumable, is_queue: self.is_queue, ..self.specialization.pass },
            ..self.specialization
        }
    }
}

/// A pass that follows paths.
pub struct PathPass<Push> {
    plain: Pass<Push>,
    /// The same with places to go on from, once the driver has ended an invocation early.
    resumable: Option<Pass<Push>>,
    workgroup_size: u32,
}

impl Start {
    /// All invocations, from the first one.
    pub const AT_FIRST: Self = Self { offset: 0, resumed: 0, spread: 1 };
}

impl<Push: Pod> PathPass<Push> {
    /// A pass that is not resumable yet.
    pub fn new(plain: Pass<Push>, workgroup_size: u32) -> Self {
        Self { plain, resumable: None, workgroup_size }
    }

    /// The pass as long as it need not be resumable.
    pub fn plain(&self) -> &Pass<Push> {
        &self.plain
    }

    /// Whether the driver has ended an invocation early, so that the pass needs places to go on from.
    pub fn is_resumable(&self) -> bool {
        self.resumable.is_some()
    }

    /// Follows all paths of some invocations; what was counted meanwhile. Where the driver ends
    /// an invocation early, `make_resumable` makes the pass that goes on, and all begins again.
    ///
    /// # Errors
    /// The device fails, or the caller gives the iteration up.
    pub fn run(
        &mut self,
        on: Stage<'_>,
        invocations: u64,
        pace: &mut Pace,
        make_resumable: impl FnOnce() -> goblet_host::Result<Pass<Push>>,
        push: impl Fn(Start) -> Push,
    ) -> Result<Counters, RenderError> {
        let pass = match &mut self.resumable {
            Some(pass) => pass,
            resumable => {
                let from = |offset| push(Start { offset, resumed: 0, spread: 1 });
                let counters = on.run_paced(&self.plain, invocations, pace, from)?;
                if counters.interrupted == 0 {
                    return Ok(counters);
                }
                resumable.insert(make_resumable()?)
            }
        };
        run_resumable(on, pass, self.workgroup_size, invocations, pace, push)
    }
}

/// Dispatches a resumable pass until no invocation is unfinished.
fn run_resumable<Push: Pod>(
    on: Stage<'_>,
    pass: &Pass<Push>,
    workgroup_size: u32,
    invocations: u64,
    pace: &mut Pace,
    push: impl Fn(Start) -> Push,
) -> Result<Counters, RenderError> {
    let mut counters = Counters::zeroed();
    let mut first = 0;
    while first < invocations {
        let count = pace.next(invocations - first).min(PLACES);
        let (mut resumed, mut spread) = (0, 1);
        loop {
            on.may_go_on()?;
            let begin = Instant::now();
            let mut frame = on.device.frame()?;
            if first == 0 && resumed == 0 {
                frame.clear(&on.buffers.counters);
            }
            frame.dispatch(pass, push(Start { offset: first as u32, resumed, spread }), count * u64::from(spread));
            frame.save(&on.buffers.counters);
            let before = std::mem::replace(&mut counters, frame.run_saved()?[0]);
            if resumed == 0 {
                pace.observe(count, begin.elapsed());
            }
            let stuck = counters.stuck != before.stuck;
            let unfinished = counters.unfinished != before.unfinished;
            if !stuck && !unfinished && spread == 1 {
                break;
            }
            // Those that were not stuck wait while others are alone.
            (resumed, spread) = (1, if stuck { workgroup_size } else { 1 });
        }
        first += count;
    }
    Ok(counters)
}
