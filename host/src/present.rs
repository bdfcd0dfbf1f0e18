//! Shows images in a window, with an interface above them.

mod painter;
mod surface;
mod swapchain;

use std::path::Path;
use std::sync::Arc;

use ash::{khr, vk};
pub use painter::Interface;
use painter::Painter;
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use surface::Surface;
use swapchain::Swapchain;

use crate::buffer::Buffer;
use crate::device::Device;
use crate::error::{Context, Error, Result};
use crate::image::WHOLE;
use crate::instance::Instance;
use crate::physical::Requirements;
use crate::shared::DeviceShared;

/// A window's surface with a device that draws there. At most one frame is in flight.
pub struct Screen {
    painter: Painter,
    swapchain: Swapchain,
    frame: FrameInFlight,
    device: Device,
    surface: Surface,
}

/// Command buffer and synchronisation of the frame in flight.
struct FrameInFlight {
    commands: vk::CommandBuffer,
    finished: vk::Fence,
    acquired: vk::Semaphore,
    device: Arc<DeviceShared>,
}

impl Screen {
    /// Opens the device that `selector` names, or the first that fits, for a window of this size. The window
    /// is kept alive as long as the screen. `cache` is the folder of [`Instance::open`].
    ///
    /// # Errors
    /// As [`Instance::open`], or the device cannot draw there.
    pub fn new<W: HasDisplayHandle + HasWindowHandle + 'static>(
        window: Arc<W>,
        size: [u32; 2],
        selector: Option<&str>,
        requirements: &Requirements,
        validation: bool,
        cache: Option<&Path>,
    ) -> Result<Self> {
        let display = surface::display(&*window)?;
        let instance = Instance::with_extensions(validation, |_| {
            let names = ash_window::enumerate_required_extensions(display);
            Ok(names.map_err(|_| Error::NoPresentation("Vulkan".into()))?.to_vec())
        })?;
        let (physical, info) = instance.choose(selector, requirements)?;
        let surface = Surface::new(&instance, window)?;
        let name = info.name.clone();
        let family = surface.family(physical)?.ok_or_else(|| Error::NoPresentation(name.clone()))?;
        let extensions = [khr::swapchain::NAME];
        let row = requirements.texels_per_row;
        let device = Device::with_family(instance, physical, info, row, family, &extensions, cache)?;
        let swapchain = Swapchain::new(&device.shared, &surface, physical, size)?;
        let painter = Painter::new(&device.shared, physical, &swapchain)?;
        let frame = FrameInFlight::new(&device.shared)?;
        Ok(Self { painter, swapchain, frame, device, surface })
    }

    /// Returns the device, on which the pixels are computed.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Returns width and height of the window in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.swapchain.extent.width, self.swapchain.extent.height]
    }

    /// Returns whether pixels have blue in the lowest byte and red in the third; otherwise red is in the
    /// lowest and blue in the third.
    pub fn is_bgra(&self) -> bool {
        self.swapchain.is_bgra()
    }

    /// Waits until the last frame is drawn: until then the device reads its pixels.
    ///
    /// # Errors
    /// The device is lost.
    pub fn finish(&self) -> Result<()> {
        self.frame.wait()
    }

    /// Adapts to the window's size. `size` counts if the window does not tell its own.
    ///
    /// # Errors
    /// Out of memory, or the window is gone.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        self.frame.wait()?;
        self.swapchain.resize(&self.surface, size)
    }

    /// Shows pixels, row by row, with the interface above them. Returns false if the window has another size
    /// by now: call [`Screen::resize`] and show another frame. The pixels must not change before
    /// [`Screen::finish`]. Panics if there are fewer pixels than [`Screen::size`] says.
    ///
    /// # Errors
    /// The device is lost, or out of memory.
    pub fn show(&mut self, pixels: &Buffer<u32>, interface: Interface) -> Result<bool> {
        let [width, height] = self.size().map(u64::from);
        assert!(pixels.len() >= width * height, "not a pixel for each of the window");
        self.frame.wait()?;
        self.painter.take_textures(&self.device.shared, &interface.textures)?;
        let Some(image) = self.swapchain.acquire(self.frame.acquired)? else {
            return Ok(false);
        };
        self.record(image, pixels, &interface)?;
        self.frame.submit(self.swapchain.drawn(image))?;
        self.swapchain.present(image)
    }

    fn record(&mut self, image: u32, pixels: &Buffer<u32>, interface: &Interface) -> Result<()> {
        let vulkan = &self.device.shared.raw;
        let commands = self.frame.commands;
        let extent = self.swapchain.extent;
        let target = self.swapchain.image(image);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let barrier = [vk::ImageMemoryBarrier::default()
            .dst_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .old_layout(vk::ImageLayout::UNDEFINED)
            .new_layout(vk::ImageLayout::TRANSFER_DST_OPTIMAL)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(target)
            .subresource_range(WHOLE)];
        let layers = vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
        let region = [vk::BufferImageCopy::default().image_subresource(layers).image_extent(vk::Extent3D {
            width: extent.width,
            height: extent.height,
            depth: 1,
        })];
        let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        let (transfer, none) = (vk::PipelineStageFlags::TRANSFER, vk::DependencyFlags::empty());
        // SAFETY: the last frame has finished; everything lives until the next one has waited for
        // this, the pixels because nobody but the caller's thread uses the device.
        unsafe {
            vulkan.begin_command_buffer(commands, &begin).context("vkBeginCommandBuffer")?;
            vulkan.cmd_pipeline_barrier(commands, transfer, transfer, none, &[], &[], &barrier);
            vulkan.cmd_copy_buffer_to_image(commands, pixels.raw().handle, target, layout, &region);
        }
        self.swapchain.begin_pass(commands, image);
        self.painter.paint(commands, extent, interface)?;
        // SAFETY: the pass was begun; the recording is complete.
        unsafe {
            vulkan.cmd_end_render_pass(commands);
            vulkan.end_command_buffer(commands).context("vkEndCommandBuffer")
        }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // SAFETY: one thread uses the device. Its fields are used by nobody after this.
        let idle = unsafe { self.device.shared.raw.device_wait_idle() };
        // A lost device does nothing any more.
        let _ = idle;
    }
}

impl FrameInFlight {
    fn new(device: &Arc<DeviceShared>) -> Result<Self> {
        let allocate =
            vk::CommandBufferAllocateInfo::default().command_pool(device.command_pool).command_buffer_count(1);
        let signalled = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
        let mut frame = Self {
            commands: vk::CommandBuffer::null(),
            finished: vk::Fence::null(),
            acquired: vk::Semaphore::null(),
            device: Arc::clone(device),
        };
        let acquired = vk::SemaphoreCreateInfo::default();
        // SAFETY: destroyed on drop; the pool frees its command buffers.
        unsafe {
            frame.commands = device.raw.allocate_command_buffers(&allocate).context("vkAllocateCommandBuffers")?[0];
            frame.finished = device.raw.create_fence(&signalled, None).context("vkCreateFence")?;
            frame.acquired = device.raw.create_semaphore(&acquired, None).context("vkCreateSemaphore")?;
        }
        Ok(frame)
    }

    /// Waits for the last frame.
    fn wait(&self) -> Result<()> {
        // SAFETY: the fence was made signalled, or a submission signals it.
        unsafe { self.device.raw.wait_for_fences(&[self.finished], true, u64::MAX) }.context("vkWaitForFences")
    }

    fn submit(&self, drawn: vk::Semaphore) -> Result<()> {
        let (commands, acquired, drawn) = ([self.commands], [self.acquired], [drawn]);
        let submit = [vk::SubmitInfo::default()
            .wait_semaphores(&acquired)
            .wait_dst_stage_mask(&[vk::PipelineStageFlags::TRANSFER])
            .command_buffers(&commands)
            .signal_semaphores(&drawn)];
        // SAFETY: the recording is complete, and the frame before has finished.
        unsafe {
            self.device.raw.reset_fences(&[self.finished]).context("vkResetFences")?;
            self.device.raw.queue_submit(self.device.queue, &submit, self.finished).context("vkQueueSubmit")
        }
    }
}

impl Drop for FrameInFlight {
    fn drop(&mut self) {
        // SAFETY: the screen has waited for the device; destroying a null handle does nothing.
        unsafe {
            self.device.raw.destroy_semaphore(self.acquired, None);
            self.device.raw.destroy_fence(self.finished, None);
        }
    }
}
