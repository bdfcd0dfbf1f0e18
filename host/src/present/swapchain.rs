//! The swapchain of a window.

use std::sync::Arc;

use ash::{khr, vk};

use super::surface::Surface;
use crate::error::{Context, Error, Result};
use crate::image::WHOLE;
use crate::shared::DeviceShared;

/// Supported formats. Pixels are copied as bytes in the screen's encoding, whether or not the format
/// encodes colours that are drawn.
const FORMATS: [vk::Format; 4] =
    [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM, vk::Format::B8G8R8A8_SRGB, vk::Format::R8G8B8A8_SRGB];

pub(super) struct Swapchain {
    pub extent: vk::Extent2D,
    /// Render pass that draws above the copied pixels.
    pub pass: vk::RenderPass,
    format: vk::SurfaceFormatKHR,
    mode: vk::PresentModeKHR,
    handle: vk::SwapchainKHR,
    targets: Vec<Target>,
    loader: khr::swapchain::Device,
    physical: vk::PhysicalDevice,
    device: Arc<DeviceShared>,
}

/// An image of the swapchain.
struct Target {
    image: vk::Image,
    view: vk::ImageView,
    framebuffer: vk::Framebuffer,
    /// Signalled when the image is ready to be shown.
    drawn: vk::Semaphore,
}

impl Swapchain {
    pub fn new(
        device: &Arc<DeviceShared>,
        surface: &Surface,
        physical: vk::PhysicalDevice,
        size: [u32; 2],
    ) -> Result<Self> {
        // SAFETY: device and surface are of one instance.
        let (formats, modes) = unsafe {
            (
                surface.loader.get_physical_device_surface_formats(physical, surface.handle),
                surface.loader.get_physical_device_surface_present_modes(physical, surface.handle),
            )
        };
        let formats = formats.context("listing surface formats")?;
        let format = FORMATS.iter().find_map(|wanted| formats.iter().find(|format| format.format == *wanted));
        let format = *format.ok_or_else(|| Error::NoPresentation(device.info.name.clone()))?;
        // The newest frame, without waiting for the screen to take the one before, where that can be had.
        let mailbox = modes.context("listing present modes")?.contains(&vk::PresentModeKHR::MAILBOX);
        let mut swapchain = Self {
            extent: vk::Extent2D::default(),
            pass: render_pass(device, format.format)?,
            format,
            mode: if mailbox { vk::PresentModeKHR::MAILBOX } else { vk::PresentModeKHR::FIFO },
            handle: vk::SwapchainKHR::null(),
            targets: Vec::new(),
            loader: khr::swapchain::Device::new(&device.instance.shared.raw, &device.raw),
            physical,
            device: Arc::clone(device),
        };
        swapchain.resize(surface, size)?;
        Ok(swapchain)
    }

    /// Creates the images again for the window's size. The last frame must have finished.
    pub fn resize(&mut self, surface: &Surface, size: [u32; 2]) -> Result<()> {
        // SAFETY: device and surface are of one instance; one thread uses the device.
        let capabilities = unsafe {
            self.device.raw.device_wait_idle().context("vkDeviceWaitIdle")?;
            surface.loader.get_physical_device_surface_capabilities(self.physical, surface.handle)
        }
        .context("asking for a surface's capabilities")?;
        let usage = vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::COLOR_ATTACHMENT;
        if !capabilities.supported_usage_flags.contains(usage) {
            return Err(Error::NoPresentation(self.device.info.name.clone()));
        }
        self.extent = extent(&capabilities, size);
        let most = if capabilities.max_image_count == 0 { u32::MAX } else { capabilities.max_image_count };
        let old = self.handle;
        let create = vk::SwapchainCreateInfoKHR::default()
            .surface(surface.handle)
            .min_image_count((capabilities.min_image_count + 1).min(most))
            .image_format(self.format.format)
            .image_color_space(self.format.color_space)
            .image_extent(self.extent)
            .image_array_layers(1)
            .image_usage(usage)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(capabilities.current_transform)
            .composite_alpha(composite_alpha(capabilities.supported_composite_alpha))
            .present_mode(self.mode)
            .clipped(true)
            .old_swapchain(old);
        // SAFETY: the device is idle, so nothing uses the old images.
        unsafe {
            self.handle = self.loader.create_swapchain(&create, None).context("vkCreateSwapchainKHR")?;
            self.destroy_targets();
            self.loader.destroy_swapchain(old, None);
            for image in self.loader.get_swapchain_images(self.handle).context("vkGetSwapchainImagesKHR")? {
                self.add_target(image)?;
            }
        }
        Ok(())
    }

    fn add_target(&mut self, image: vk::Image) -> Result<()> {
        let view = vk::ImageViewCreateInfo::default()
            .image(image)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(self.format.format)
            .subresource_range(WHOLE);
        self.targets.push(Target {
            image,
            view: vk::ImageView::null(),
            framebuffer: vk::Framebuffer::null(),
            drawn: vk::Semaphore::null(),
        });
        let (vulkan, index) = (&self.device.raw, self.targets.len() - 1);
        let target = &mut self.targets[index];
        // SAFETY: the image is the swapchain's; all is destroyed with it, and so far as it is made
        // if something fails.
        unsafe {
            target.view = vulkan.create_image_view(&view, None).context("vkCreateImageView")?;
            let views = [target.view];
            let framebuffer = vk::FramebufferCreateInfo::default()
                .render_pass(self.pass)
                .attachments(&views)
                .width(self.extent.width)
                .height(self.extent.height)
                .layers(1);
            target.framebuffer = vulkan.create_framebuffer(&framebuffer, None).context("vkCreateFramebuffer")?;
            let drawn = vk::SemaphoreCreateInfo::default();
            target.drawn = vulkan.create_semaphore(&drawn, None).context("vkCreateSemaphore")?;
        }
        Ok(())
    }

    /// Returns whether colours that are drawn must be linear.
    pub fn encodes_srgb(&self) -> bool {
        FORMATS[2..].contains(&self.format.format)
    }

    pub fn is_bgra(&self) -> bool {
        [FORMATS[0], FORMATS[2]].contains(&self.format.format)
    }

    pub fn image(&self, index: u32) -> vk::Image {
        self.targets[index as usize].image
    }

    pub fn drawn(&self, index: u32) -> vk::Semaphore {
        self.targets[index as usize].drawn
    }

    /// Returns the index of the next image, which is free once the semaphore is signalled; `None` if the
    /// window has changed.
    pub fn acquire(&self, acquired: vk::Semaphore) -> Result<Option<u32>> {
        // SAFETY: no frame is in flight, so the semaphore is free.
        match unsafe { self.loader.acquire_next_image(self.handle, u64::MAX, acquired, vk::Fence::null()) } {
            Ok((index, _)) => Ok(Some(index)),
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(None),
            Err(result) => Err(Error::Vulkan { call: "vkAcquireNextImageKHR", result }),
        }
    }

    /// Shows an image that was drawn. Returns false if the window has changed too much.
    pub fn present(&self, index: u32) -> Result<bool> {
        let (handles, indices, drawn) = ([self.handle], [index], [self.drawn(index)]);
        let present =
            vk::PresentInfoKHR::default().wait_semaphores(&drawn).swapchains(&handles).image_indices(&indices);
        // SAFETY: the image was acquired, and a submission signals the semaphore.
        match unsafe { self.loader.queue_present(self.device.queue, &present) } {
            // Where it does not fit quite, the window will say that it was resized.
            Ok(_) => Ok(true),
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(false),
            Err(result) => Err(Error::Vulkan { call: "vkQueuePresentKHR", result }),
        }
    }

    /// Begins the render pass on an image.
    pub fn begin_pass(&self, commands: vk::CommandBuffer, index: u32) {
        let begin = vk::RenderPassBeginInfo::default()
            .render_pass(self.pass)
            .framebuffer(self.targets[index as usize].framebuffer)
            .render_area(vk::Rect2D { offset: vk::Offset2D::default(), extent: self.extent });
        // SAFETY: the commands are being recorded, and the copy has left the image as the pass expects.
        unsafe { self.device.raw.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE) };
    }

    fn destroy_targets(&mut self) {
        for target in self.targets.drain(..) {
            // SAFETY: the device is idle; destroying a null handle does nothing.
            unsafe {
                self.device.raw.destroy_semaphore(target.drawn, None);
                self.device.raw.destroy_framebuffer(target.framebuffer, None);
                self.device.raw.destroy_image_view(target.view, None);
            }
        }
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        self.destroy_targets();
        // SAFETY: the screen has waited for the device; destroying a null handle does nothing.
        unsafe {
            self.loader.destroy_swapchain(self.handle, None);
            self.device.raw.destroy_render_pass(self.pass, None);
        }
    }
}

/// Returns the window's size where the system tells it, else `size` within the limits.
fn extent(capabilities: &vk::SurfaceCapabilitiesKHR, [width, height]: [u32; 2]) -> vk::Extent2D {
    let vk::SurfaceCapabilitiesKHR { current_extent, min_image_extent, max_image_extent, .. } = capabilities;
    if current_extent.width != u32::MAX {
        return *current_extent;
    }
    vk::Extent2D {
        width: width.clamp(min_image_extent.width, max_image_extent.width),
        height: height.clamp(min_image_extent.height, max_image_extent.height),
    }
}

fn composite_alpha(supported: vk::CompositeAlphaFlagsKHR) -> vk::CompositeAlphaFlagsKHR {
    let opaque = vk::CompositeAlphaFlagsKHR::OPAQUE;
    // Pixels are opaque whichever it is.
    if supported.contains(opaque) { opaque } else { vk::CompositeAlphaFlagsKHR::INHERIT }
}

/// Creates a render pass that keeps the copied pixels and leaves the image ready to be shown.
fn render_pass(device: &DeviceShared, format: vk::Format) -> Result<vk::RenderPass> {
    let attachments = [vk::AttachmentDescription::default()
        .format(format)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(vk::AttachmentLoadOp::LOAD)
        .store_op(vk::AttachmentStoreOp::STORE)
        .initial_layout(vk::ImageLayout::TRANSFER_DST_OPTIMAL)
        .final_layout(vk::ImageLayout::PRESENT_SRC_KHR)];
    let colors = [vk::AttachmentReference { attachment: 0, layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL }];
    let subpasses = [vk::SubpassDescription::default().color_attachments(&colors)];
    let dependencies = [vk::SubpassDependency::default()
        .src_subpass(vk::SUBPASS_EXTERNAL)
        .src_stage_mask(vk::PipelineStageFlags::TRANSFER)
        .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT)
        .dst_access_mask(vk::AccessFlags::COLOR_ATTACHMENT_READ | vk::AccessFlags::COLOR_ATTACHMENT_WRITE)];
    let create =
        vk::RenderPassCreateInfo::default().attachments(&attachments).subpasses(&subpasses).dependencies(&dependencies);
    // SAFETY: destroyed with the swapchain.
    unsafe { device.raw.create_render_pass(&create, None) }.context("vkCreateRenderPass")
}
