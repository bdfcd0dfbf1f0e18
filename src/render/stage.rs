//! What every pass of an iteration has at hand, and how a pass is dispatched and counted.

use std::time::Instant;

use bytemuck::Pod;
use goblet_host::{Device, Frame, Pass};

use crate::kernels::Counters;
use crate::render::buffers::Buffers;
use crate::render::error::RenderError;
use crate::render::pacing::Pace;
use crate::render::settings::Settings;

/// Where an iteration runs.
#[derive(Clone, Copy)]
pub struct Stage<'a> {
    /// The device.
    pub device: &'a Device,
    /// Its memory.
    pub buffers: &'a Buffers,
    /// The render.
    pub settings: &'a Settings,
    /// Asked between dispatches: whether the iteration is not wanted any more.
    pub gives_up: &'a dyn Fn() -> bool,
}

impl Stage<'_> {
    /// Whether the caller still wants the iteration.
    ///
    /// # Errors
    /// It does not.
    pub fn may_go_on(&self) -> Result<(), RenderError> {
        if (self.gives_up)() { Err(RenderError::GivenUp) } else { Ok(()) }
    }

    /// Runs a pass, in as many dispatches as its pace asks for; what was counted meanwhile.
    /// `push` is told the first invocation of each.
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
        while first < invocations {
            self.may_go_on()?;
            let count = pace.next(invocations - first);
            let start = Instant::now();
            let mut frame = self.device.frame()?;
            if first == 0 {
                frame.clear(&self.buffers.counters);
            }
            frame.dispatch(pass, push(first as u32), count);
            frame.run()?;
            pace.observe(count, start.elapsed());
            first += count;
        }
        Ok(self.device.read(&self.buffers.counters)?[0])
    }

    /// Runs what `record` records; what was counted meanwhile.
    ///
    /// # Errors
    /// The device fails.
    pub fn run_counted(&self, record: impl FnOnce(&mut Frame<'_>)) -> goblet_host::Result<Counters> {
        let mut frame = self.device.frame()?;
        frame.clear(&self.buffers.counters);
        record(&mut frame);
        frame.run()?;
        Ok(self.device.read(&self.buffers.counters)?[0])
    }
}

/// Whether no invocation was ended early.
pub fn finished(counters: &Counters, pass: &'static str, remedy: &'static str) -> Result<(), RenderError> {
    if counters.interrupted == 0 { Ok(()) } else { Err(RenderError::Interrupted { pass, remedy }) }
}
