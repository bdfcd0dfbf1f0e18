//! Every buffer of the algorithm, with its one size formula.

use goblet_host::{Buffer, Device, Frame, Texels};

use crate::gpu_scene::camera::View;
use crate::image::estimate::Sum;
use crate::kernels::{Camera, Cell, Counters, GridPlace, PhotonRecord, PixelState, TILE, VisiblePoint};

/// The most photons that one batch can record: 32 MiB.
const MAX_RECORDED: u64 = 1 << 20;

/// Sizes of a render's buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Width and height of the image, which has a visible point per pixel.
    pub resolution: [u32; 2],
    /// Photons that a batch has room to record.
    pub recorded: u64,
}

impl Sizes {
    /// Sizes for an image and an iteration. A path records at most one photon per segment.
    pub fn new(resolution: [u32; 2], photons_per_iteration: u64, max_depth: u32) -> Self {
        let most = photons_per_iteration.saturating_mul(u64::from(max_depth)).min(MAX_RECORDED);
        Self { resolution, recorded: most.max(u64::from(max_depth)) }
    }

    /// Bytes of [`Buffers`] and of a hash grid, about; a device rounds up.
    pub fn bytes(&self) -> u64 {
        let pixels: u64 = self.resolution.map(u64::from).iter().product();
        let of = |size: usize| size as u64;
        let visible = of(size_of::<VisiblePoint>() + size_of::<f32>() + 2 * size_of::<[f32; 4]>());
        let flux = of(7 * size_of::<u32>());
        let kept = of(size_of::<PixelState>() + 4 * size_of::<Sum>());
        let photons = self.recorded * of(2 * size_of::<PhotonRecord>());
        let cells = self.recorded.next_power_of_two() * of(size_of::<Cell>());
        pixels * (visible + flux + kept)
            + invocations_by_tile(self.resolution) / 2 * of(size_of::<GridPlace>())
            + photons
            + cells
    }
}

/// Invocations that have a pixel each, and some that have none: whole tiles.
pub fn invocations_by_tile(resolution: [u32; 2]) -> u64 {
    resolution.map(|pixels| u64::from(pixels.next_multiple_of(TILE))).iter().product()
}

/// Device memory of a render; `shaders/` documents the contents. Arrays are split by field: a
/// device may bind no more than 128 MiB of a buffer and 1 GiB of texels at once.
pub struct Buffers {
    /// Invocations that take pixels by tile, at most.
    pub most_by_tile: u64,
    pub camera: Texels<Camera>,
    pub filter_table: Texels<f32>,
    pub counters: Buffer<Counters>,

    // Visible points of this round, by pixel.
    pub visible_points: Texels<VisiblePoint>,
    pub visible_radii2: Texels<f32>,
    pub visible_throughputs: Texels<[f32; 4]>,
    pub visible_radiances: Texels<[f32; 4]>,
    /// Bits of the largest squared radius.
    pub max_radius2: Buffer<u32>,

    // Photons of this batch.
    pub photons: Texels<PhotonRecord>,

    // Fixed-point sums of this iteration, two words a pixel, and its photons.
    pub flux_red: Buffer<u32>,
    pub flux_green: Buffer<u32>,
    pub flux_blue: Buffer<u32>,
    pub flux_counts: Buffer<u32>,

    // What is kept between iterations, by pixel.
    pub pixel_states: Texels<PixelState>,
    pub sum_red: Texels<Sum>,
    pub sum_green: Texels<Sum>,
    pub sum_blue: Texels<Sum>,
    pub sum_second: Texels<Sum>,
}

impl Buffers {
    /// Allocates them, and clears the sums.
    ///
    /// # Errors
    /// Out of device memory, or the image is larger than the device can bind.
    pub fn new(device: &Device, sizes: Sizes, view: &View) -> goblet_host::Result<Self> {
        let Sizes { resolution, recorded } = sizes;
        let pixels = resolution.map(u64::from).iter().product();
        let buffers = Self {
            most_by_tile: invocations_by_tile(resolution),
            camera: device.upload_texels("camera", &[view.camera])?,
            filter_table: device.upload_texels("filter_table", &view.filter_table)?,
            counters: device.buffer("counters", 1)?,
            visible_points: device.texels("visible_points", pixels)?,
            visible_radii2: device.texels("visible_radii2", pixels)?,
            visible_throughputs: device.texels("visible_throughputs", pixels)?,
            visible_radiances: device.texels("visible_radiances", pixels)?,
            max_radius2: device.buffer("max_radius2", 1)?,
            photons: device.texels("photons", recorded)?,
            flux_red: device.buffer("flux_red", 2 * pixels)?,
            flux_green: device.buffer("flux_green", 2 * pixels)?,
            flux_blue: device.buffer("flux_blue", 2 * pixels)?,
            flux_counts: device.buffer("flux_counts", pixels)?,
            pixel_states: device.texels("pixel_states", pixels)?,
            sum_red: device.texels("sum_red", pixels)?,
            sum_green: device.texels("sum_green", pixels)?,
            sum_blue: device.texels("sum_blue", pixels)?,
            sum_second: device.texels("sum_second", pixels)?,
        };
        buffers.clear(device)?;
        Ok(buffers)
    }

    /// Whether an image of this size fits.
    pub fn fit(&self, resolution: [u32; 2]) -> bool {
        let pixels: u64 = resolution.map(u64::from).iter().product();
        pixels <= self.flux_counts.len() && invocations_by_tile(resolution) <= self.most_by_tile
    }

    /// Forgets all iterations.
    ///
    /// # Errors
    /// The device fails.
    pub fn clear(&self, device: &Device) -> goblet_host::Result<()> {
        let mut frame = device.frame()?;
        self.clear_flux(&mut frame);
        frame.clear_texels(&self.pixel_states);
        self.sums().into_iter().for_each(|sums| frame.clear_texels(sums));
        frame.run()
    }

    /// Forgets the photons of an unfinished iteration.
    pub fn clear_flux(&self, frame: &mut Frame<'_>) {
        let Self { flux_red, flux_green, flux_blue, flux_counts, .. } = self;
        [flux_red, flux_green, flux_blue, flux_counts].into_iter().for_each(|flux| frame.clear(flux));
    }

    /// The sums of red, green, blue, and of the second half's luminance.
    pub fn sums(&self) -> [&Texels<Sum>; 4] {
        [&self.sum_red, &self.sum_green, &self.sum_blue, &self.sum_second]
    }
}
