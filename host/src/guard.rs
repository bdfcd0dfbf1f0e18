//! Guard zones, for tests. On a guarded device, memory that kernels can reach follows every array. It is
//! filled with a pattern, and every frame that dispatched a kernel checks that the pattern is intact. New
//! arrays are filled with the pattern, too. Other devices have no guard zones, and pay nothing for them.

use std::ops::Range;
use std::sync::{Arc, Mutex, Weak};

use ash::vk;

use crate::buffer::RawBuffer;
use crate::error::Result;
use crate::image::{GUARD_ROWS, RawImage};
use crate::recording::{Recorder, Recording};
use crate::shared::DeviceShared;

/// Bytes of a guard zone after a buffer, or after an array in a buffer.
pub(crate) const GUARD_BYTES: u64 = 4096;
/// Bytes of guard zones that one transfer checks.
const SCRATCH_BYTES: u64 = 8 << 20;

/// Alignment of copies of guard zones: the bytes of the largest texel.
const ALIGNMENT: u64 = 16;

/// The guard zone of an array. What has one in a buffer has a name and a range of bytes.
enum Guarded {
    Buffer(&'static str, Weak<RawBuffer>, Range<u64>),
    Image(Weak<RawImage>),
}

/// The guard zones of a device.
pub(crate) struct Guards {
    word: u32,
    /// The word repeated, as long as the longest guard zone.
    pattern: Vec<u8>,
    /// Host buffer to which guard zones are copied.
    scratch: RawBuffer,
    /// Host buffer with the pattern, from which guard zones are filled again.
    fresh: RawBuffer,
    arrays: Mutex<Vec<Guarded>>,
    broken: Mutex<Vec<String>>,
}

impl Guards {
    pub fn new(device: &Arc<DeviceShared>, word: u32) -> Result<Self> {
        let longest = (GUARD_ROWS + 1) * u64::from(device.texels_per_row) * 16;
        let pattern = word.to_ne_bytes().repeat(longest as usize / 4);
        let fresh = RawBuffer::host(device, "guard pattern", longest)?;
        fresh.map_write(&pattern);
        let scratch = RawBuffer::host(device, "guard scratch", SCRATCH_BYTES)?;
        Ok(Self { word, pattern, scratch, fresh, arrays: Mutex::default(), broken: Mutex::default() })
    }

    /// Fills a new buffer with the pattern, and watches its guard zones, each after the array of a name.
    pub fn watch_buffer(
        &self,
        recorder: Recorder<'_>,
        buffer: &Arc<RawBuffer>,
        zones: impl Iterator<Item = (&'static str, Range<u64>)>,
    ) -> Result<()> {
        let mut recording = recorder.begin()?;
        recording.fill(buffer, 0..buffer.bytes, self.word);
        recording.submit()?;
        self.watch(zones.map(|(name, range)| Guarded::Buffer(name, Arc::downgrade(buffer), range)));
        Ok(())
    }

    /// Fills a new image with the pattern, and watches its guard zone.
    pub fn watch_image(&self, recorder: Recorder<'_>, image: &Arc<RawImage>) -> Result<()> {
        let mut recording = recorder.begin()?;
        recording.fill_image(image, [self.word; 4]);
        recording.submit()?;
        self.watch([Guarded::Image(Arc::downgrade(image))].into_iter());
        Ok(())
    }

    fn watch(&self, zones: impl Iterator<Item = Guarded>) {
        if let Ok(mut arrays) = self.arrays.lock() {
            arrays.extend(zones);
        }
    }

    /// Fills the guard zone of an image with the pattern again, after all of the image was cleared.
    pub fn renew(&self, recording: &mut Recording<'_>, image: &RawImage) {
        recording.copy_to_regions(&self.fresh, image, &image.guard_regions());
    }

    /// Returns a message for each guard zone that was found broken.
    pub fn broken(&self) -> Vec<String> {
        self.broken.lock().map(|broken| broken.clone()).unwrap_or_default()
    }

    /// Checks all guard zones after these passes. A broken one is reported once and watched no longer.
    pub fn check(&self, recorder: Recorder<'_>, passes: &[&'static str]) -> Result<()> {
        let (Ok(mut arrays), Ok(mut broken)) = (self.arrays.lock(), self.broken.lock()) else {
            return Ok(());
        };
        let zones: Vec<Zone> = arrays.drain(..).filter_map(Zone::of).collect();
        for zones in zones.chunks((SCRATCH_BYTES / self.fresh.bytes) as usize) {
            let mut recording = recorder.begin()?;
            let mut end = 0;
            for zone in zones {
                zone.copy(&mut recording, &self.scratch, end);
                end += zone.bytes.next_multiple_of(ALIGNMENT);
            }
            recording.submit()?;
            let mut bytes = vec![0; end as usize];
            self.scratch.map_read(&mut bytes);
            let mut rest = &bytes[..];
            for zone in zones {
                let found = &rest[..zone.bytes as usize];
                rest = &rest[zone.bytes.next_multiple_of(ALIGNMENT) as usize..];
                if found == &self.pattern[..found.len()] {
                    arrays.push(zone.downgrade());
                } else {
                    let byte = found.iter().zip(&self.pattern).position(|(a, b)| a != b).unwrap_or(0);
                    let (passes, name) = (passes.join(", "), zone.name);
                    broken.push(format!("{passes}: wrote {byte} bytes after the end of {name}"));
                }
            }
        }
        Ok(())
    }
}

/// The guard zone of an array that still exists.
struct Zone {
    array: Array,
    name: &'static str,
    bytes: u64,
}

enum Array {
    Buffer(Arc<RawBuffer>, Range<u64>),
    Image(Arc<RawImage>),
}

impl Zone {
    fn of(guarded: Guarded) -> Option<Self> {
        Some(match guarded {
            Guarded::Buffer(name, buffer, range) => {
                let buffer = buffer.upgrade()?;
                Self { name, bytes: range.end - range.start, array: Array::Buffer(buffer, range) }
            }
            Guarded::Image(image) => {
                let image = image.upgrade()?;
                Self { name: image.name, bytes: image.guard_bytes(), array: Array::Image(image) }
            }
        })
    }

    fn downgrade(&self) -> Guarded {
        match &self.array {
            Array::Buffer(buffer, range) => Guarded::Buffer(self.name, Arc::downgrade(buffer), range.clone()),
            Array::Image(image) => Guarded::Image(Arc::downgrade(image)),
        }
    }

    /// Records a copy of it to a buffer, from byte `offset` on.
    fn copy(&self, recording: &mut Recording<'_>, to: &RawBuffer, offset: u64) {
        match &self.array {
            Array::Buffer(buffer, range) => recording.copy(buffer, range.start, to, offset, self.bytes),
            Array::Image(image) => {
                let moved = |region: vk::BufferImageCopy| region.buffer_offset(region.buffer_offset + offset);
                let regions: Vec<_> = image.guard_regions().into_iter().map(moved).collect();
                recording.copy_from_regions(image, to, &regions);
            }
        }
    }
}
