//! The device, memory and settings that all passes of an iteration use, and functions that dispatch a pass
//! and read its counters.

use std::time::Instant;

use bytemuck::{Pod, Zeroable};
use goblet_host::{Device, Frame, Pass};

use crate::kernels::Counters;
use crate::render::activity::Observer;
use crate::render::buffers::Buffers;
use crate::render::error::RenderError;
use crate::render::guide::lights::GuideLights;
use crate::render::pacing::Pace;
use crate::render::settings::Settings;

/// The device, memory and settings of an iteration.
#[derive(Clone, Copy)]
pub struct Stage<'a> {
    /// The device.
    pub device: &'a Device,
    /// The arrays on the device.
    pub buffers: &'a Buffers,
    /// The settings of the render.
    pub settings: &'a Settings,
    /// What a guide knows of the scene's lights.
    pub lights: &'a GuideLights,
    /// Who is told what the iteration does.
    pub observer: &'a Observer,
    /// A function that is called between dispatches; it returns true to give the iteration up.
    pub gives_up: &'a dyn Fn() -> bool,
}

impl Stage<'_> {
    /// Asks the caller whether to continue the iteration.
    ///
    /// # Errors
    /// The caller gives the iteration up.
    pub fn may_go_on(&self) -> Result<(), RenderError> {
        if (self.gives_up)() { Err(RenderError::GivenUp) } else { Ok(()) }
    }

    /// Runs a pass in dispatches whose size its pace chooses, and returns the counters. `push` makes the push
    /// constants from the first invocation of a dispatch.
    ///
    /// # Errors
    /// The device fails, or the caller gives the iteration up.
    pub fn run_paced<Push: Pod>(
        &self,
        pass: &Pass<Push>,
        invocations: u64,
        pace: &mut Pace,
        push: impl Fn(u32) -> Push,
    ) -> Result<Counters, RenderError> {
        let mut first = 0;
        let mut counters = Counters::zeroed();
        while first < invocations {
            self.may_go_on()?;
            let count = pace.next(invocations - first);
            let start = Instant::now();
            let mut frame = self.device.frame()?;
            if first == 0 {
                frame.clear(&self.buffers.counters);
            }
            frame.dispatch(pass, push(first as u32), count);
            frame.save(&self.buffers.counters);
            counters = frame.run_saved()?[0];
            pace.observe(count, start.elapsed());
            first += count;
        }
        Ok(counters)
    }

    /// Runs the commands that `record` records, and returns the counters.
    ///
    /// # Errors
    /// The device fails.
    pub fn run_counted(&self, record: impl FnOnce(&mut Frame<'_>)) -> goblet_host::Result<Counters> {
        let mut frame = self.device.frame()?;
        frame.clear(&self.buffers.counters);
        record(&mut frame);
        frame.save(&self.buffers.counters);
        Ok(frame.run_saved()?[0])
    }
}

/// Checks that the driver ended no invocation early. `remedy` is a change that would avoid the error.
///
/// # Errors
/// The driver ended an invocation early.
pub fn finished(counters: &Counters, pass: &'static str, remedy: &'static str) -> Result<(), RenderError> {
    if counters.interrupted == 0 { Ok(()) } else { Err(RenderError::Interrupted { pass, remedy }) }
}
