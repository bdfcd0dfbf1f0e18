//! Checks that the host has memory for large arrays.
//!
//! A vector that cannot grow aborts the process, and finished iterations would be lost. So code that is about
//! to fill large vectors first asks the system for this memory. The system applies limits such as `ulimit -v`
//! and refuses requests that are too large for any memory. But Linux may grant more memory than there is, and
//! kill the process when the process uses it.

/// The host does not have enough memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("out of memory: {what} needs {} MiB more, which the system does not give", bytes.div_ceil(1 << 20))]
pub struct OutOfHostMemory {
    /// The use of the memory.
    pub what: &'static str,
    /// Bytes that were asked for.
    pub bytes: u64,
}

/// Checks that the system grants `bytes` bytes more: allocates them, and frees them unused.
///
/// # Errors
/// The system does not grant them.
pub fn check(what: &'static str, bytes: u64) -> Result<(), OutOfHostMemory> {
    let out_of_memory = OutOfHostMemory { what, bytes };
    let length = usize::try_from(bytes).map_err(|_| out_of_memory)?;
    Vec::<u8>::new().try_reserve_exact(length).map_err(|_| out_of_memory)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_memory_can_hold_is_refused() {
        check("a little", 1 << 20).unwrap();
        for bytes in [1 << 50, 1 << 62, u64::MAX] {
            assert_eq!(check("too much", bytes), Err(OutOfHostMemory { what: "too much", bytes }));
        }
    }
}
