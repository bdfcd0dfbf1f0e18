//! Every buffer of the algorithm, with its one size formula.

use goblet_host::{Buffer, Device};

use crate::kernels::{Camera, Cell, Counters, GridInfo};

/// The most photons that one batch can record: 64 MiB a buffer, half of what the
/// smallest devices bind at once.
const MAX_RECORDED: u64 = 4 << 20;

/// Sizes of a render's buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Pixels of the image, and so visible points of an iteration.
    pub pixels: u64,
    /// Cells of the hash grid, a power of two not below the visible points.
    pub cells: u64,
    /// Photons that a batch has room to record.
    pub recorded: u64,
}

impl Sizes {
    /// Sizes for an image and an iteration. No batch can overflow: a path records at
    /// most one photon per segment.
    pub fn new(pixels: u64, photons_per_iteration: u64, max_depth: u32) -> Self {
        let most = photons_per_iteration.saturating_mul(u64::from(max_depth)).min(MAX_RECORDED);
        Self { pixels, cells: pixels.next_power_of_two(), recorded: most.max(u64::from(max_depth)) }
    }

    /// Photons of the largest batch whose records surely fit.
    pub fn max_batch(&self, max_depth: u32) -> u64 {
        (self.recorded / u64::from(max_depth)).max(1)
    }
}

/// Device memory of a render; `shaders/` documents the contents. Four-component arrays are split by field, since a device
/// may bind no more than 128 MiB at once.
pub struct Buffers {
    pub camera: Buffer<Camera>,
    pub counters: Buffer<Counters>,

    // Visible points of this iteration, by pixel.
    pub visible_positions: Buffer<[f32; 4]>,
    pub visible_normals: Buffer<u32>,
    pub visible_throughputs: Buffer<[f32; 4]>,

    // The hash grid over them.
    pub grid_info: Buffer<GridInfo>,
    pub cells: Buffer<Cell>,
    pub grid_positions: Buffer<[f32; 4]>,
    pub grid_owners: Buffer<[u32; 2]>,

    // Photons of this batch.
    pub photon_positions: Buffer<[f32; 4]>,
    pub photon_weights: Buffer<[f32; 4]>,

    // Fixed-point sums of this iteration, four words a pixel.
    pub flux_low: Buffer<u32>,
    pub flux_high: Buffer<u32>,

    // The running estimate, by pixel.
    pub pixel_flux: Buffer<[f32; 4]>,
    pub pixel_photons: Buffer<f32>,
    pub pixel_direct: Buffer<[f32; 4]>,
    pub image: Buffer<[f32; 4]>,
}

impl Buffers {
    /// Allocates and clears them.
    ///
    /// # Errors
    /// Out of device memory, or the image is larger than the device can bind.
    pub fn new(device: &Device, sizes: Sizes, camera: Camera, radius2: f32) -> goblet_host::Result<Self> {
        let Sizes { pixels, cells, recorded } = sizes;
        let buffers = Self {
            camera: device.upload("camera", &[camera])?,
            counters: device.buffer("counters", 1)?,
            visible_positions: device.buffer("visible_positions", pixels)?,
            visible_normals: device.buffer("visible_normals", pixels)?,
            visible_throughputs: device.buffer("visible_throughputs", pixels)?,
            grid_info: device.buffer("grid_info", 1)?,
            cells: device.buffer("cells", cells)?,
            grid_positions: device.buffer("grid_positions", pixels)?,
            grid_owners: device.buffer("grid_owners", pixels)?,
            photon_positions: device.buffer("photon_positions", recorded)?,
            photon_weights: device.buffer("photon_weights", recorded)?,
            flux_low: device.buffer("flux_low", 4 * pixels)?,
            flux_high: device.buffer("flux_high", 4 * pixels)?,
            pixel_flux: device.buffer("pixel_flux", pixels)?,
            pixel_photons: device.buffer("pixel_photons", pixels)?,
            pixel_direct: device.buffer("pixel_direct", pixels)?,
            image: device.buffer("image", pixels)?,
        };
        let mut frame = device.frame()?;
        frame.clear(&buffers.flux_low);
        frame.clear(&buffers.flux_high);
        frame.clear(&buffers.pixel_photons);
        frame.clear(&buffers.pixel_direct);
        frame.run()?;
        device.write(&buffers.pixel_flux, &vec![[0.0, 0.0, 0.0, radius2]; pixels as usize])?;
        Ok(buffers)
    }
}
