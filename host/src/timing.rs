//! Device time by pass, and the marker that tells which pass ran when a device was lost.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use ash::vk;

use crate::buffer::RawBuffer;
use crate::error::{Context, Result};
use crate::shared::DeviceShared;

/// Number of dispatches of a frame that are timed; later ones are not.
pub(crate) const MAX_TIMED: u32 = 256;

pub(crate) struct Timer {
    pub queries: vk::QueryPool,
    /// Index of the pass that the device began last; the device writes it.
    pub marker: RawBuffer,
    totals: Mutex<BTreeMap<&'static str, Duration>>,
    device: Arc<DeviceShared>,
}

impl Timer {
    pub fn new(device: &Arc<DeviceShared>) -> Result<Self> {
        let create = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2 * MAX_TIMED);
        let marker = RawBuffer::host(device, "crash marker", 4)?;
        let queries = match device.nanoseconds_per_tick {
            // SAFETY: destroyed with the timer.
            Some(_) => unsafe { device.raw.create_query_pool(&create, None) }.context("vkCreateQueryPool")?,
            None => vk::QueryPool::null(),
        };
        Ok(Self { queries, marker, totals: Mutex::default(), device: Arc::clone(device) })
    }

    /// Returns whether the pass with this index is timed.
    pub fn has(&self, pass: usize) -> bool {
        self.queries != vk::QueryPool::null() && pass < MAX_TIMED as usize
    }

    /// Adds the times of a finished frame's passes.
    pub fn collect(&self, passes: &[&'static str]) -> Result<()> {
        let timed = passes.len().min(MAX_TIMED as usize);
        let Some(period) = self.device.nanoseconds_per_tick.filter(|_| timed > 0) else {
            return Ok(());
        };
        let mut ticks = vec![0u64; 2 * timed];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: the frame has finished and wrote these queries.
        unsafe { self.device.raw.get_query_pool_results(self.queries, 0, &mut ticks, flags) }
            .context("vkGetQueryPoolResults")?;
        if let Ok(mut totals) = self.totals.lock() {
            for (name, pair) in passes.iter().zip(ticks.chunks_exact(2)) {
                let nanoseconds = pair[1].saturating_sub(pair[0]) as f64 * f64::from(period);
                *totals.entry(name).or_default() += Duration::from_nanos(nanoseconds as u64);
            }
        }
        Ok(())
    }

    pub fn totals(&self) -> Vec<(&'static str, Duration)> {
        let totals = self.totals.lock();
        totals.map(|totals| totals.iter().map(|(name, time)| (*name, *time)).collect()).unwrap_or_default()
    }
}

impl Drop for Timer {
    fn drop(&mut self) {
        // SAFETY: no frame is in flight; destroying a null handle does nothing.
        unsafe { self.device.raw.destroy_query_pool(self.queries, None) };
    }
}
