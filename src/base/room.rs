//! Room in the host's memory for what options make large.
//!
//! A vector that cannot grow ends the process, and leaves no time to keep what there is. So who is
//! about to fill large ones asks before. The answer is the system's: it knows of limits such as
//! `ulimit -v`, and of requests that no memory could ever hold. Linux promises more than it has,
//! and ends a process that takes it at its word.

/// The host has no room.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("out of memory: {what} needs {bytes} bytes more, which the system does not give")]
pub struct NoRoom {
    /// What it is for.
    pub what: &'static str,
    /// How much.
    pub bytes: u64,
}

/// Asks for so many bytes and gives them back untouched, which takes no time.
///
/// # Errors
/// The system does not give them.
pub fn check(what: &'static str, bytes: u64) -> Result<(), NoRoom> {
    let no_room = NoRoom { what, bytes };
    let length = usize::try_from(bytes).map_err(|_| no_room)?;
    Vec::<u8>::new().try_reserve_exact(length).map_err(|_| no_room)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_memory_can_hold_is_refused() {
        check("a little", 1 << 20).unwrap();
        for bytes in [1 << 50, 1 << 62, u64::MAX] {
            assert_eq!(check("too much", bytes), Err(NoRoom { what: "too much", bytes }));
        }
    }
}
