//! Draws the shapes of egui.

use std::mem;

use ash::vk;
use egui_ash_renderer::{Options, Renderer, RendererError};

use super::swapchain::Swapchain;
use crate::error::{Error, Result};
use crate::shared::DeviceShared;

/// The output of egui for a frame.
pub struct Interface {
    /// Shapes to draw.
    pub primitives: Vec<egui::ClippedPrimitive>,
    /// Textures to create or change, and those that are no longer needed.
    pub textures: egui::TexturesDelta,
    /// Pixels of a unit of egui.
    pub pixels_per_point: f32,
}

pub(super) struct Painter {
    renderer: Renderer,
    /// Textures that the frame in flight may need, and later ones do not.
    to_free: Vec<egui::TextureId>,
}

fn failed(error: RendererError) -> Error {
    Error::Interface(error.to_string())
}

impl Painter {
    pub fn new(device: &DeviceShared, physical: vk::PhysicalDevice, swapchain: &Swapchain) -> Result<Self> {
        let options = Options { srgb_framebuffer: swapchain.encodes_srgb(), ..Options::default() };
        let instance = &device.instance.shared.raw;
        let renderer =
            Renderer::with_default_allocator(instance, physical, device.raw.clone(), swapchain.pass, options);
        Ok(Self { renderer: renderer.map_err(failed)?, to_free: Vec::new() })
    }

    /// Creates, changes and frees textures. The last frame must have finished.
    pub fn take_textures(&mut self, device: &DeviceShared, textures: &egui::TexturesDelta) -> Result<()> {
        let to_free = mem::replace(&mut self.to_free, textures.free.clone());
        self.renderer.free_textures(&to_free).map_err(failed)?;
        self.renderer.set_textures(device.queue, device.command_pool, &textures.set).map_err(failed)
    }

    /// Records the drawing of an interface, inside of the render pass.
    pub fn paint(&mut self, commands: vk::CommandBuffer, extent: vk::Extent2D, interface: &Interface) -> Result<()> {
        let Interface { primitives, pixels_per_point, .. } = interface;
        self.renderer.cmd_draw(commands, extent, *pixels_per_point, primitives).map_err(failed)
    }
}
