//! Memory of the machine.

use std::fs;

/// Returns the bytes of memory that the machine has, where the system tells them (on Linux).
pub fn total_memory() -> Option<u64> {
    memory_info("MemTotal:")
}

/// Returns the bytes of memory that processes could allocate now without swapping, where the system
/// tells them (on Linux).
pub(crate) fn available_memory() -> Option<u64> {
    memory_info("MemAvailable:")
}

fn memory_info(key: &str) -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}
