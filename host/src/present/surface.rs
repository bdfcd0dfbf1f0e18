//! The surface of a window.

use std::sync::Arc;

use ash::{khr, vk};
use raw_window_handle::{HasDisplayHandle, HasWindowHandle, RawDisplayHandle};

use crate::error::{Context, Error, Result};
use crate::instance::Instance;
use crate::physical;

/// A window's Vulkan surface.
pub(super) struct Surface {
    pub handle: vk::SurfaceKHR,
    pub loader: khr::surface::Instance,
    instance: Instance,
    /// The window, kept alive.
    _window: Box<dyn std::any::Any>,
}

/// Returns the display connection of a window.
pub(super) fn display(window: &impl HasDisplayHandle) -> Result<RawDisplayHandle> {
    let handle = window.display_handle().map_err(|error| Error::NoPresentation(format!("this display ({error})")))?;
    Ok(handle.as_raw())
}

impl Surface {
    pub fn new<W: HasDisplayHandle + HasWindowHandle + 'static>(instance: &Instance, window: Arc<W>) -> Result<Self> {
        let display = display(&*window)?;
        let handle = window.window_handle();
        let raw = handle.map_err(|error| Error::NoPresentation(format!("this window ({error})")))?.as_raw();
        let shared = &instance.shared;
        // SAFETY: the window is kept until the surface is destroyed, and so is the instance.
        let handle = unsafe { ash_window::create_surface(&shared.entry, &shared.raw, display, raw, None) }
            .context("creating a surface")?;
        let loader = khr::surface::Instance::new(&shared.entry, &shared.raw);
        Ok(Self { handle, loader, instance: instance.clone(), _window: Box::new(window) })
    }

    /// Returns the index and the number of timestamp bits of the first queue family of a device that computes
    /// and draws on the surface.
    pub fn family(&self, physical: vk::PhysicalDevice) -> Result<Option<(u32, u32)>> {
        let vulkan = &self.instance.shared.raw;
        let wanted = vk::QueueFlags::COMPUTE | vk::QueueFlags::GRAPHICS;
        // SAFETY: `physical` belongs to the instance.
        let families = unsafe { vulkan.get_physical_device_queue_family_properties(physical) };
        if !physical::has_extension(vulkan, physical, khr::swapchain::NAME) {
            return Ok(None);
        }
        for (index, family) in (0..).zip(families) {
            // SAFETY: the family exists.
            let shows = unsafe { self.loader.get_physical_device_surface_support(physical, index, self.handle) };
            if family.queue_flags.contains(wanted) && shows.context("asking for a surface's families")? {
                return Ok(Some((index, family.timestamp_valid_bits)));
            }
        }
        Ok(None)
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: its swapchain is gone.
        unsafe { self.loader.destroy_surface(self.handle, None) };
    }
}
