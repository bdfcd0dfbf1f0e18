//! The driver's cache of compiled kernels, and its file: what one process has compiled, the next one reads.
//!
//! The file saves time and nothing depends on it: if it cannot be read, used or written, kernels are compiled
//! without it. Several processes may use it at once, because it is only ever replaced as a whole.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use ash::vk;
use tempfile::Builder;

/// A larger file is not read, and so the next one begins without it: it does not grow for ever.
const MOST_BYTES: u64 = 64 << 20;

/// The first bytes of a file. A checksum follows, then the driver's data: few drivers check more of them than
/// their header.
const MAGIC: &[u8] = b"goblet 1";

/// Bytes of `VkPipelineCacheHeaderVersionOne`.
const HEADER_BYTES: usize = 32;

/// The cache that the driver uses when it compiles. Threads may share it.
pub(crate) struct PipelineCache {
    /// Null without a file, and if the driver could not make one.
    handle: vk::PipelineCache,
    file: Option<CacheFile>,
    /// The checksum of the data that the cache was made with.
    first: Option<u64>,
    is_used: AtomicBool,
}

impl PipelineCache {
    /// Creates the driver's cache from its file in `folder`. Without a folder there is no cache.
    pub fn open(device: &ash::Device, properties: &vk::PhysicalDeviceProperties, folder: Option<&Path>) -> Self {
        let file = folder.map(|folder| CacheFile::new(folder, properties));
        let data = file.as_ref().and_then(CacheFile::read);
        let handle = file.as_ref().and_then(|_| {
            let filled = data.as_deref().and_then(|data| create(device, data));
            filled.or_else(|| create(device, &[]))
        });
        let first = data.as_deref().map(checksum);
        Self { handle: handle.unwrap_or_default(), file, first, is_used: AtomicBool::new(false) }
    }

    /// Returns the cache to compile a kernel with; null if there is none.
    pub fn handle(&self) -> vk::PipelineCache {
        self.is_used.store(true, Ordering::Relaxed);
        self.handle
    }

    /// Writes the file if a kernel was compiled that it does not hold, and destroys the cache.
    ///
    /// # Safety
    /// Nothing uses the cache any more, and `device` is the one that it was opened with.
    pub unsafe fn close(&self, device: &ash::Device) {
        let is_used = self.is_used.load(Ordering::Relaxed) && self.handle != vk::PipelineCache::null();
        if let Some(file) = self.file.as_ref().filter(|_| is_used) {
            // SAFETY: the caller promises it.
            unsafe { self.save(device, file) };
        }
        // SAFETY: the caller promises it; destroying a null handle does nothing.
        unsafe { device.destroy_pipeline_cache(self.handle, None) };
    }

    /// # Safety
    /// As for [`close`](Self::close).
    unsafe fn save(&self, device: &ash::Device, file: &CacheFile) {
        let kept = file.read();
        // Another device or process has written the file meanwhile: what it has compiled stays there.
        let others = kept.as_deref().filter(|kept| self.first != Some(checksum(kept)));
        if let Some(other) = others.and_then(|others| create(device, others)) {
            // SAFETY: both are caches of this device, and nothing else uses them.
            unsafe {
                // Without the others' kernels the file is still of use.
                let _ = device.merge_pipeline_caches(self.handle, &[other]);
                device.destroy_pipeline_cache(other, None);
            }
        }
        // SAFETY: it is a cache of this device.
        let data = unsafe { device.get_pipeline_cache_data(self.handle) }.unwrap_or_default();
        // A cache with one more kernel is longer.
        let is_new = kept.is_none_or(|kept| kept.len() != data.len());
        if is_new && file.holds_kernels(&data) {
            // The next process compiles again.
            let _ = file.write(&data);
        }
    }

    /// Returns whether the driver was given the data of the file.
    #[cfg(test)]
    fn has_read(&self) -> bool {
        self.first.is_some()
    }
}

/// Returns a cache with these data; `None` if the driver refuses.
fn create(device: &ash::Device, data: &[u8]) -> Option<vk::PipelineCache> {
    let create = vk::PipelineCacheCreateInfo::default().initial_data(data);
    // SAFETY: the data are empty or those that this driver has given; `PipelineCache` destroys the cache.
    unsafe { device.create_pipeline_cache(&create, None) }.ok()
}

/// The file of a device and driver.
struct CacheFile {
    folder: PathBuf,
    path: PathBuf,
    /// What the data of this device and driver begin with.
    header: [u8; HEADER_BYTES],
}

impl CacheFile {
    fn new(folder: &Path, properties: &vk::PhysicalDeviceProperties) -> Self {
        let device = properties.device_name_as_c_str().unwrap_or_default().to_string_lossy();
        let uuid = properties.pipeline_cache_uuid;
        let name = file_name(&device, properties.driver_version, uuid);
        let header = header(properties.vendor_id, properties.device_id, uuid);
        Self { folder: folder.to_owned(), path: folder.join(name), header }
    }

    /// Returns whether data are of this device and driver, and are more than their header: some drivers give
    /// nothing else.
    fn holds_kernels(&self, data: &[u8]) -> bool {
        data.strip_prefix(&self.header).is_some_and(|kernels| !kernels.is_empty())
    }

    /// Returns the driver's data; `None` unless the file is whole and of this device and driver.
    fn read(&self) -> Option<Vec<u8>> {
        // A pipe would have to be waited for.
        let is_readable = fs::metadata(&self.path).is_ok_and(|file| file.is_file() && file.len() <= MOST_BYTES);
        let bytes = is_readable.then(|| fs::read(&self.path).ok())??;
        unsealed(&bytes).filter(|data| self.holds_kernels(data)).map(<[u8]>::to_vec)
    }

    /// Replaces the file as a whole.
    fn write(&self, data: &[u8]) -> io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        let mut file = Builder::new().prefix(".goblet-").suffix(".tmp").tempfile_in(&self.folder)?;
        // No wait for the disk: the checksum tells what a power cut leaves.
        file.write_all(&sealed(data))?;
        file.persist(&self.path)?;
        Ok(())
    }
}

/// Returns the name of the file of a device and driver, from what the driver says of itself.
fn file_name(device: &str, driver_version: u32, uuid: [u8; vk::UUID_SIZE]) -> String {
    let letters = device.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' });
    let device: String = letters.take(64).collect();
    let uuid: String = uuid.iter().map(|byte| format!("{byte:02x}")).collect();
    format!("kernels-{device}-{driver_version:08x}-{uuid}.bin")
}

/// Returns the header of the data of a device and driver, as Vulkan defines it for all drivers.
fn header(vendor: u32, device: u32, uuid: [u8; vk::UUID_SIZE]) -> [u8; HEADER_BYTES] {
    let version = vk::PipelineCacheHeaderVersion::ONE.as_raw().cast_unsigned();
    let words = [HEADER_BYTES as u32, version, vendor, device].map(u32::to_le_bytes);
    let mut header = [0; HEADER_BYTES];
    header[..16].copy_from_slice(words.as_flattened());
    header[16..].copy_from_slice(&uuid);
    header
}

fn sealed(data: &[u8]) -> Vec<u8> {
    [MAGIC, &checksum(data).to_le_bytes(), data].concat()
}

/// Returns the data of a file; `None` if it was cut, changed, or written by another program.
fn unsealed(bytes: &[u8]) -> Option<&[u8]> {
    let (sum, data) = bytes.strip_prefix(MAGIC)?.split_first_chunk()?;
    (u64::from_le_bytes(*sum) == checksum(data)).then_some(data)
}

/// FNV-1a of 64 bits.
fn checksum(data: &[u8]) -> u64 {
    data.iter().fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests;
