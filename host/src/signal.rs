//! The disposition of signals.

use std::mem::MaybeUninit;

/// Returns whether this process ignores a signal. A process that `nohup` has started ignores `SIGHUP`.
pub fn is_ignored(signal: i32) -> bool {
    let mut action = MaybeUninit::<libc::sigaction>::zeroed();
    // SAFETY: with no new action, the present one is written to the place that is given.
    let outcome = unsafe { libc::sigaction(signal, std::ptr::null(), action.as_mut_ptr()) };
    // SAFETY: it is written, or as before: zeros, of which this type can be made.
    outcome == 0 && unsafe { action.assume_init() }.sa_sigaction == libc::SIG_IGN
}
