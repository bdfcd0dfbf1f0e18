//! Images that hold arrays, row by row.

use std::sync::Arc;

use ash::vk;

use crate::error::{Context, Error, Result};
use crate::memory::Memory;
use crate::shared::DeviceShared;

/// Rows of a guard zone after texels, besides the rest of their last row.
pub(crate) const GUARD_ROWS: u64 = 1;

/// An image with memory of its own, always in the general layout between commands. Its texels have one word
/// or four.
pub(crate) struct RawImage {
    pub name: &'static str,
    pub image: vk::Image,
    pub view: vk::ImageView,
    pub texel_bytes: u32,
    pub per_row: u32,
    /// Number of texels that hold elements.
    texels: u64,
    memory: Option<Memory>,
    device: Arc<DeviceShared>,
}

impl RawImage {
    /// Allocates an image for a number of texels, with a guard zone of `guard_rows` rows after their last one.
    pub fn new(
        device: &Arc<DeviceShared>,
        name: &'static str,
        texels: u64,
        texel_bytes: u32,
        guard_rows: u64,
    ) -> Result<Self> {
        let per_row = device.texels_per_row;
        let rows = texels.div_ceil(u64::from(per_row)) + guard_rows;
        let bytes_per_row = u64::from(per_row) * u64::from(texel_bytes);
        let limit = u64::from(device.info.max_image_rows) * bytes_per_row;
        if rows > u64::from(device.info.max_image_rows) {
            return Err(Error::BufferTooLarge { buffer: name.to_owned(), bytes: rows * bytes_per_row, limit });
        }
        let format = if texel_bytes == 4 { vk::Format::R32_UINT } else { vk::Format::R32G32B32A32_UINT };
        let transfers = vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
        let usage = vk::ImageUsageFlags::STORAGE | transfers;
        let create = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width: per_row, height: rows as u32, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        // SAFETY: both formats and usages are mandatory; destroyed on drop.
        let image = unsafe { device.raw.create_image(&create, None) }.context("vkCreateImage")?;
        let device = Arc::clone(device);
        let view = vk::ImageView::null();
        let mut raw = Self { name, image, view, texel_bytes, per_row, texels, memory: None, device };
        raw.bind(format)?;
        Ok(raw)
    }

    fn bind(&mut self, format: vk::Format) -> Result<()> {
        let vulkan = &self.device.raw;
        // SAFETY: the image was just made by this device.
        let needs = unsafe { vulkan.get_image_memory_requirements(self.image) };
        let memory = Memory::new(&self.device, self.name, needs, [vk::MemoryPropertyFlags::DEVICE_LOCAL; 2])?;
        // SAFETY: fresh memory of the required size, bound once, as long-lived as the image.
        unsafe { vulkan.bind_image_memory(self.image, memory.handle, 0) }.context("vkBindImageMemory")?;
        self.memory = Some(memory);
        let create = vk::ImageViewCreateInfo::default()
            .image(self.image)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(format)
            .subresource_range(WHOLE);
        // SAFETY: the image has memory; the view is destroyed on drop.
        self.view = unsafe { vulkan.create_image_view(&create, None) }.context("vkCreateImageView")?;
        Ok(())
    }

    /// Returns the bytes of a row.
    pub fn row_bytes(&self) -> u64 {
        u64::from(self.per_row) * u64::from(self.texel_bytes)
    }

    /// Returns the regions that `bytes` bytes of a buffer fill from a row on: whole rows, then part of one.
    pub fn regions(&self, first_row: u64, bytes: u64) -> Vec<vk::BufferImageCopy> {
        let whole = bytes / self.row_bytes() * self.row_bytes();
        let parts = [(0, whole), (whole, bytes - whole)].into_iter().filter(|(_, bytes)| *bytes > 0);
        parts
            .map(|(offset, bytes)| self.region(first_row + offset / self.row_bytes(), bytes).buffer_offset(offset))
            .collect()
    }

    /// Returns the region of `bytes` bytes from a row on: whole rows, or part of one.
    fn region(&self, first_row: u64, bytes: u64) -> vk::BufferImageCopy {
        let rows = (bytes / self.row_bytes()) as u32;
        let (width, height) = match rows {
            0 => ((bytes / u64::from(self.texel_bytes)) as u32, 1),
            rows => (self.per_row, rows),
        };
        place(vk::Offset3D { x: 0, y: first_row as i32, z: 0 }, vk::Extent3D { width, height, depth: 1 })
    }

    /// Returns the regions of the guard zone.
    pub fn guard_regions(&self) -> Vec<vk::BufferImageCopy> {
        guard_regions(self.texels, self.per_row, self.texel_bytes)
    }

    /// Returns the bytes of the guard zone.
    pub fn guard_bytes(&self) -> u64 {
        let extents = self.guard_regions().into_iter().map(|region| region.image_extent);
        extents.map(|extent| u64::from(extent.width) * u64::from(extent.height)).sum::<u64>()
            * u64::from(self.texel_bytes)
    }
}

/// Returns the copy between a region of an image and the start of a buffer.
fn place(offset: vk::Offset3D, extent: vk::Extent3D) -> vk::BufferImageCopy {
    let layers = vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
    vk::BufferImageCopy::default().image_subresource(layers).image_offset(offset).image_extent(extent)
}

/// Returns the guard zone of an image whose first `texels` texels hold elements: the rest of the row in
/// which they end, then whole rows.
fn guard_regions(texels: u64, per_row: u32, texel_bytes: u32) -> Vec<vk::BufferImageCopy> {
    let used = (texels % u64::from(per_row)) as u32;
    let rows = texels.div_ceil(u64::from(per_row)) as i32;
    let rest = if used == 0 { 0 } else { per_row - used };
    let part =
        place(vk::Offset3D { x: used as i32, y: rows - 1, z: 0 }, vk::Extent3D { width: rest, height: 1, depth: 1 });
    let whole = place(
        vk::Offset3D { x: 0, y: rows, z: 0 },
        vk::Extent3D { width: per_row, height: GUARD_ROWS as u32, depth: 1 },
    );
    let whole = whole.buffer_offset(u64::from(rest) * u64::from(texel_bytes));
    [part, whole].into_iter().filter(|region| region.image_extent.width > 0).collect()
}

/// All of an image.
pub(crate) const WHOLE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

impl Drop for RawImage {
    fn drop(&mut self) {
        // SAFETY: frames wait for the device before they return, so nothing uses it;
        // destroying a null handle does nothing.
        unsafe {
            self.device.raw.destroy_image_view(self.view, None);
            self.device.raw.destroy_image(self.image, None);
        }
    }
}
