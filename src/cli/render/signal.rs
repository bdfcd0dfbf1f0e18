//! Ctrl-C and SIGTERM: the first asks to stop, the second stops at once.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::TERM_SIGNALS;
use signal_hook::flag;

use crate::cli::Failure;

/// What a process that a signal has stopped exits with.
pub const STOPPED: u8 = 130;

/// Whether somebody wants the render to stop.
pub struct Signals(Arc<AtomicBool>);

impl Signals {
    /// Listens from now on.
    pub fn new() -> Result<Self, Failure> {
        let received = Arc::new(AtomicBool::new(false));
        let register = || -> io::Result<()> {
            for signal in TERM_SIGNALS {
                // In this order, or the first signal would already end the process.
                flag::register_conditional_shutdown(*signal, STOPPED.into(), Arc::clone(&received))?;
                flag::register(*signal, Arc::clone(&received))?;
            }
            Ok(())
        };
        register().map_err(Failure::Signals)?;
        Ok(Self(received))
    }

    /// Whether one has come.
    pub fn received(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
