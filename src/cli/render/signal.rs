//! Handling of Ctrl-C, SIGTERM and SIGHUP. The first signal asks the render to stop, the second ends the
//! process at once. Before the render begins, the first signal ends the process at once too.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use signal_hook::consts::TERM_SIGNALS;
use signal_hook::{flag, low_level};

use crate::cli::{Failure, terminal};

/// The exit code of a process that a signal has stopped.
pub const STOPPED: u8 = 130;
/// The time between two looks for a signal while the scene is loaded.
const LOOK: Duration = Duration::from_millis(50);

/// The listener for signals.
pub struct Signals {
    received: Arc<AtomicBool>,
    /// The thread that ends the process at a signal, until the render begins.
    loading: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Signals {
    /// Starts to listen. Until the render begins, the first signal ends the process.
    ///
    /// # Errors
    /// The operating system does not let the process listen for signals.
    pub fn new() -> Result<Self, Failure> {
        let received = Arc::new(AtomicBool::new(false));
        let listen = || -> io::Result<_> {
            for signal in signals() {
                // The shutdown is registered first; in the other order, the first signal would end the
                // process.
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

    /// Notes that the render begins. From now on, the first signal only sets the flag of
    /// [`Signals::received`].
    pub fn begin(&mut self) {
        if let Some((begin, thread)) = self.loading.take() {
            drop(begin);
            let _ = thread.join();
        }
    }

    /// Returns whether a signal has come.
    pub fn received(&self) -> bool {
        self.received.load(Ordering::Relaxed)
    }
}

/// Returns the signals to listen for.
fn signals() -> Vec<i32> {
    let mut signals = TERM_SIGNALS.to_vec();
    // A process that was started with nohup must outlive its terminal.
    #[cfg(unix)]
    if !goblet_host::is_ignored(signal_hook::consts::SIGHUP) {
        signals.push(signal_hook::consts::SIGHUP);
    }
    signals
}

fn exit_when_received(received: &AtomicBool, begun: &Receiver<()>) {
    while begun.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
        if received.load(Ordering::Relaxed) {
            terminal::say_at_last("goblet: stopped by a signal before the first iteration: no image is written");
            // A normal exit runs handlers that would have to wait for threads in any state.
            low_level::exit(STOPPED.into());
        }
    }
}
