//! Traces the sets in turn, and takes the times.

use std::time::{Duration, Instant};

use goblet::Device;
use goblet::kernels::NONE;
use goblet_host::{Pass, Texels};
use goblet_test_kernels::{ASKS_ANY, ASKS_NEAREST, TraceRays, TraceRaysPush, TracedHit};

use crate::Result;
use crate::prepare::Prepared;
use crate::sets::{Rays, Set, WORKGROUP_SIZE};

/// What is asked about a ray.
pub const QUESTIONS: [u32; 2] = [ASKS_NEAREST, ASKS_ANY];

/// Seconds of one dispatch.
#[derive(Clone, Copy, Debug)]
pub struct Times {
    /// User and system time of the process; on a CPU, the device is a part of it.
    pub cpu: f64,
    pub wall: f64,
}

/// Where the kernel writes hits: one for all cases.
pub struct Answers {
    nearest: Texels<TracedHit>,
    any: Texels<u32>,
}

impl Answers {
    /// Allocates answers for sets of `count` rays.
    pub fn new(device: &Device, count: u64) -> Result<Self> {
        Ok(Self { nearest: device.texels("hits", count)?, any: device.texels("any_hits", count)? })
    }
}

/// A set of rays in a scene, what was asked of it and how long that took: for the nearest hit, and for any.
pub struct Case {
    pub scene: String,
    pub triangles: usize,
    pub set: Set,
    pub count: u64,
    pub times: [Vec<Times>; 2],
    pub hits: [usize; 2],
    invocations: u64,
    pass: Pass<TraceRaysPush>,
}

impl Case {
    pub fn new(device: &Device, scene: &Prepared, rays: Rays, answers: &Answers) -> Result<Self> {
        let Rays { set, texels, count, invocations } = rays;
        let Answers { nearest, any } = answers;
        let kernel = TraceRays { scene: scene.gpu.bindings(), rays: &texels, hits: nearest, any_hits: any };
        let pass = device.pass(&kernel, &scene.specialization, WORKGROUP_SIZE)?;
        let (scene, triangles) = (scene.name.clone(), scene.triangles);
        let (times, hits) = Default::default();
        Ok(Self { scene, triangles, set, count, times, hits, invocations, pass })
    }

    fn trace(&self, device: &Device, asks: u32) -> Result<Times> {
        let (cpu, wall) = (cpu_time(), Instant::now());
        let mut frame = device.frame()?;
        frame.dispatch(&self.pass, TraceRaysPush { count: self.count as u32, asks }, self.invocations);
        frame.run()?;
        Ok(Times { cpu: (cpu_time() - cpu).as_secs_f64(), wall: wall.elapsed().as_secs_f64() })
    }

    fn count_hits(&mut self, device: &Device, answers: &Answers) -> Result<()> {
        let nearest = device.read_first_texels(&answers.nearest, self.count)?;
        let any = device.read_first_texels(&answers.any, self.count)?;
        self.hits = [
            nearest.iter().filter(|hit| hit.primitive != NONE).count(),
            any.iter().filter(|primitive| **primitive != NONE).count(),
        ];
        Ok(())
    }
}

/// Measures all cases in turn, every second time in the opposite order: what else the machine does then
/// slows all of them alike.
pub fn measure(device: &Device, cases: &mut [Case], answers: &Answers, turns: u64) -> Result<()> {
    // The first dispatch compiles, and finds memory that nobody has touched yet.
    for case in &mut *cases {
        QUESTIONS.into_iter().try_for_each(|asks| case.trace(device, asks).map(|_| ()))?;
        case.count_hits(device, answers)?;
    }
    for turn in 0..turns {
        for i in 0..cases.len() {
            let i = if turn % 2 == 0 { i } else { cases.len() - 1 - i };
            for (question, asks) in QUESTIONS.into_iter().enumerate() {
                let times = cases[i].trace(device, asks)?;
                cases[i].times[question].push(times);
            }
        }
    }
    Ok(())
}

/// CPU time of this process, with that of its threads that have ended.
#[cfg(unix)]
fn cpu_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Duration::try_from(time).unwrap_or_default()
}

/// Not known here.
#[cfg(not(unix))]
fn cpu_time() -> Duration {
    Duration::ZERO
}
