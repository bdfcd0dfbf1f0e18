//! Renders whose state is kept in memory, to be continued later.

use super::Renderer;
use crate::kernels::VisiblePoint;
use crate::render::checkpoint::{Checkpoint, CheckpointError};
use crate::render::error::RenderError;

/// The state of a render in memory: a checkpoint, and the visible points of the last iteration.
pub struct Aside {
    checkpoint: Checkpoint,
    visible_points: Vec<VisiblePoint>,
    visible_radii2: Vec<f32>,
    visible_throughputs: Vec<[f32; 4]>,
    response: Option<f64>,
}

impl Renderer {
    /// Copies the state of the render to memory: the data of a checkpoint, and the visible points that
    /// [`Renderer::path_lengths`] and similar functions read.
    ///
    /// # Errors
    /// The device fails.
    pub fn put_aside(&self) -> Result<Aside, RenderError> {
        let (buffers, pixels) = (&self.buffers, self.settings.pixels());
        Ok(Aside {
            checkpoint: self.checkpoint("")?,
            visible_points: self.device.read_first_texels(&buffers.visible_points, pixels)?,
            visible_radii2: self.device.read_first_texels(&buffers.visible_radii2, pixels)?,
            visible_throughputs: self.device.read_first_texels(&buffers.visible_throughputs, pixels)?,
            response: self.progress.response,
        })
    }

    /// Continues a render of the same scene with the same options that was put aside.
    ///
    /// # Errors
    /// The same as for [`Renderer::resume`].
    pub fn take_up(&mut self, aside: &Aside) -> Result<(), CheckpointError> {
        self.resume(&aside.checkpoint)?;
        self.device.write_texels(&self.buffers.visible_points, &aside.visible_points)?;
        self.device.write_texels(&self.buffers.visible_radii2, &aside.visible_radii2)?;
        self.device.write_texels(&self.buffers.visible_throughputs, &aside.visible_throughputs)?;
        self.progress.response = aside.response;
        Ok(())
    }
}
