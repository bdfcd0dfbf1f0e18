//! Ctrl-C, SIGTERM and SIGHUP: the first asks to stop, the second stops at once. Before there is
//! anything to keep, the first stops at once, too.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use signal_hook::consts::TERM_SIGNALS;
use signal_hook::{flag, low_level};

use crate::cli::{Failure, terminal};

/// What a process that a signal has stopped exits with.
pub const STOPPED: u8 = 130;
/// How often a render that loads its scene looks for a signal.
const LOOK: Duration = Duration::from_millis(50);

/// Whether somebody wants the render to stop.
pub struct Signals {
    received: Arc<AtomicBool>,
    /// Until the render begins.
    loading: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Signals {
    /// Listens from now on; until the render begins, the first signal ends the process.
    pub fn new() -> Result<Self, Failure> {
        let received = Arc::new(AtomicBool::new(false));
        let listen = || -> io::Result<_> {
            for signal in signals() {
                // In this order, or the first signal would already end the process.
                flag::register_conditional_shutdown(signal, STOPPED.into(), Arc::clone(&received))?;
                flag::register(signal, Arc::clone(&received))?;
            }
            let (begin, begun) = channel();
            let received = Arc::clone(&received);
            let thread = thread::Builder::new().name("signals".to_owned());
            Ok((begin, thread.spawn(move || exit_when_received(&received, &begun))?))
        };
        let loading = listen().map_err(Failure::Signals)?;
        Ok(Self { received, loading: Some(loading) })
    }

    /// From now on there is something to keep: the render is to end by itself.
    pub fn begin(&mut self) {
        if let Some((begin, thread)) = self.loading.take() {
            drop(begin);
            let _ = thread.join();
        }
    }

    /// Whether one has come.
    pub fn received(&self) -> bool {
        self.received.load(Ordering::Relaxed)
    }
}

/// Those to listen for.
fn signals() -> Vec<i32> {
    let mut signals = TERM_SIGNALS.to_vec();
    // A process that nohup has started is to outlive its terminal.
    #[cfg(unix)]
    if !goblet_host::is_ignored(signal_hook::consts::SIGHUP) {
        signals.push(signal_hook::consts::SIGHUP);
    }
    signals
}

fn exit_when_received(received: &AtomicBool, begun: &Receiver<()>) {
    while begun.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
        if received.load(Ordering::Relaxed) {
            terminal::say("goblet: stopped by a signal before the first iteration: no image is written");
            // What a usual exit runs would have to wait for threads that may be anywhere.
            low_level::exit(STOPPED.into());
        }
    }
}
