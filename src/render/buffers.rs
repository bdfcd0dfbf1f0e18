//! The device arrays of a render. Each is declared once, with its element and its length. The bytes follow
//! from these, so that the need of memory is known before anything is allocated.

use goblet_host::{Device, DeviceKind, Extent, Frame, Texels};

use crate::gpu_scene::camera::View;
use crate::gpu_scene::pack::PackedScene;
use crate::image::estimate::Sum;
use crate::kernels::{
    Camera, Cell, Counters, EmissionNumbers, GuideLight, GuideNode, Light, PhotonRecord, PixelState, RoughPoint, TILE,
    VisiblePoint,
};
use crate::render::guide::guidance::PHOTONS_OF_ROUND;
use crate::render::guide::tree::MOST_NODES;
use crate::render::options::{Options, Resolved};
use crate::render::radius::RadiusSchedule;

/// The number of photons that one batch can record on any device, unless an iteration has fewer. With their copies in
/// the grid and its cells they take 72 MiB.
pub(crate) const LEAST_ROOM: u64 = 1 << 20;
/// The largest number on any device.
const MOST_ROOM: u64 = 1 << 24;
/// Bytes of a record, of its copy in the grid and of a cell.
const BYTES_OF_RECORD: u64 = 2 * size_of::<PhotonRecord>() as u64 + size_of::<Cell>() as u64;

/// Returns the number of photons for which a batch has room on a kind of device. On a GPU they take up to a sixteenth of
/// the memory, so that an iteration has few batches; on a CPU larger batches are no faster. `most_bytes` can be bound
/// at once.
pub(crate) fn room_for_records(kind: DeviceKind, memory_bytes: u64, most_bytes: u64) -> u64 {
    let room = match kind {
        DeviceKind::Cpu => LEAST_ROOM,
        _ => (memory_bytes / 16 / BYTES_OF_RECORD).clamp(LEAST_ROOM, MOST_ROOM),
    };
    room.min(most_bytes / size_of::<PhotonRecord>() as u64)
}

/// Declares a struct of device arrays, with the functions `allocate` and `bytes` of [`Sizes`]. A `Buffer` is
/// an array of words; `Texels` is an array that kernels load whole elements of; `Four` are four such arrays of
/// the same length, which are a group.
macro_rules! device_arrays {
    (
        $(#[$attribute:meta])* $visibility:vis struct $Name:ident($sizes:ident) {
            $($(#[$field_attribute:meta])* $field:ident: $Kind:ident<$Element:ty>[$length:expr],)*
        }
    ) => {
        $(#[$attribute])*
        $visibility struct $Name {
            $($(#[$field_attribute])* pub $field: device_arrays!(@type $Kind, $Element),)*
        }

        impl $Name {
            /// Allocates the arrays.
            ///
            /// # Errors
            /// The device has too little memory, or an array is larger than the device can bind.
            pub fn allocate(device: &Device, $sizes: &$crate::render::buffers::Sizes) -> goblet_host::Result<Self> {
                Ok(Self { $($field: device_arrays!(@allocate $Kind, device, stringify!($field), $length),)* })
            }

            /// Returns the bytes of the arrays; a device rounds the size of each array up.
            pub fn bytes($sizes: &$crate::render::buffers::Sizes) -> u64 {
                0 $(+ device_arrays!(@arrays $Kind) * u64::from($length) * size_of::<$Element>() as u64)*
            }
        }
    };
    (@type Four, $Element:ty) => { [goblet_host::Texels<$Element>; 4] };
    (@type $Kind:ident, $Element:ty) => { goblet_host::$Kind<$Element> };
    (@arrays Four) => { 4 };
    (@arrays $Kind:ident) => { 1 };
    (@allocate Four, $device:ident, $name:expr, $length:expr) => {
        $crate::render::buffers::four($device, $name, u64::from($length))?
    };
    (@allocate Buffer, $device:ident, $name:expr, $length:expr) => { $device.buffer($name, u64::from($length))? };
    (@allocate Texels, $device:ident, $name:expr, $length:expr) => { $device.texels($name, u64::from($length))? };
}
pub(in crate::render) use device_arrays;

/// Allocates four arrays of a group, of the same length.
///
/// # Errors
/// The same as for [`Device::group`].
pub fn four<T: bytemuck::Pod>(device: &Device, name: &'static str, length: u64) -> goblet_host::Result<[Texels<T>; 4]> {
    let mut group = device.group(name, &[Extent::of::<T>(name, length); 4])?;
    Ok([(); 4].map(|()| group.take()))
}

/// The sizes from which the lengths of arrays follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// The number of pixels of the image; each has a visible point.
    pub pixels: u64,
    /// The number of invocations that take pixels by tile: [`invocations_by_tile`].
    pub by_tile: u64,
    /// The largest number of photons that a batch can record.
    pub recorded: u64,
    /// Whether as many may be recorded on rough surfaces, where each pixel has a point.
    pub gathers_rough: bool,
    /// The number of lights that a guide chooses from; 0 without a guide.
    pub guided_lights: u64,
    /// The counts of photons that a pixel has.
    pub counts: u64,
}

impl Sizes {
    /// Returns the sizes for an image and an iteration. A path records at most one photon per segment; a batch has
    /// `room` for so many.
    pub fn new(
        resolution: [u32; 2],
        photons_per_iteration: u64,
        max_depth: u32,
        room: u64,
        gathers_rough: bool,
    ) -> Self {
        let most = photons_per_iteration.saturating_mul(u64::from(max_depth)).min(room);
        Self {
            pixels: resolution.map(u64::from).iter().product(),
            by_tile: invocations_by_tile(resolution),
            recorded: most.max(u64::from(max_depth)),
            gathers_rough,
            guided_lights: 0,
            counts: 1,
        }
    }

    /// Returns the sizes of a render of a packed scene. A batch has `room` for so many records.
    pub(crate) fn of_render(packed: &PackedScene, options: &Options, resolved: &Resolved, room: u64) -> Self {
        let Resolved { resolution, photons, max_depth, .. } = *resolved;
        let emits = |light: &&Light| options.is_guided() && light.emission_pmf > 0.0;
        Self::new(resolution, photons, max_depth, room, packed.features.has_rough_gather)
            .with_schedule(options.radius_schedule)
            .with_guide(packed.arrays.lights.iter().filter(emits).count() as u64)
    }

    /// Returns a length of what there is for rough surfaces: 0 where no photon is recorded on them.
    pub fn of_rough(&self, length: u64) -> u64 {
        if self.gathers_rough { length } else { 0 }
    }

    /// Returns the sizes for a guide that chooses from so many lights, 0 without a guide. The photons of a pilot's round
    /// mostly have room at once, however few an iteration has.
    fn with_guide(self, guided_lights: u64) -> Self {
        let least = if guided_lights > 0 { 2 * PHOTONS_OF_ROUND } else { 0 };
        Self { guided_lights, recorded: self.recorded.max(least), ..self }
    }

    /// Returns the sizes for a schedule of radii.
    fn with_schedule(self, schedule: RadiusSchedule) -> Self {
        Self { counts: if schedule == RadiusSchedule::Data { 2 } else { 1 }, ..self }
    }

    /// Returns whether an image of this size fits in arrays of these sizes.
    pub fn fit(&self, resolution: [u32; 2]) -> bool {
        let Self { pixels, by_tile, .. } = Self::new(resolution, 1, 1, 1, false);
        pixels <= self.pixels && by_tile <= self.by_tile
    }
}

/// Returns the number of invocations that cover the image with whole tiles. Invocations outside the image
/// have no pixel.
pub fn invocations_by_tile(resolution: [u32; 2]) -> u64 {
    resolution.map(|pixels| u64::from(pixels.next_multiple_of(TILE))).iter().product()
}

device_arrays! {
    /// The arrays that passes share; `shaders/` documents their contents. They are split by field, because a
    /// device may bind no more than 128 MiB of a buffer and 1 GiB of texels at once. Where arrays are in buffers,
    /// the four sums share one, so that no kernel binds more than 12: 128 MiB are then two million pixels.
    pub struct Buffers(sizes) {
        camera: Texels<Camera>[1_u32],
        /// Tables for sampling the pixel filter.
        filter_table: Texels<f32>[View::FILTER_TABLE],
        counters: Buffer<Counters>[1_u32],

        // Visible points of this round, by pixel.
        visible_points: Texels<VisiblePoint>[sizes.pixels],
        visible_radii2: Texels<f32>[sizes.pixels],
        visible_throughputs: Texels<[f32; 4]>[sizes.pixels],
        visible_radiances: Texels<[f32; 4]>[sizes.pixels],
        /// The bits of the largest squared radius, which is an f32.
        max_radius2: Buffer<u32>[1_u32],

        /// Photons that this batch has recorded.
        photons: Texels<PhotonRecord>[sizes.recorded],

        /// Rough surfaces on eye paths of this round, by pixel.
        rough_points: Texels<RoughPoint>[sizes.of_rough(sizes.pixels)],
        /// Photons that this batch has recorded on rough surfaces.
        rough_photons: Texels<PhotonRecord>[sizes.of_rough(sizes.recorded)],

        // Of guided emission.
        guide_nodes: Texels<GuideNode>[if sizes.guided_lights > 0 { MOST_NODES as u64 } else { 0 }],
        guide_lights: Texels<GuideLight>[sizes.guided_lights],
        pilot_numbers: Texels<EmissionNumbers>[if sizes.guided_lights > 0 { PHOTONS_OF_ROUND } else { 0 }],

        // Fixed-point sums of this iteration, two words per pixel, and the number of photons per pixel; with radii
        // from the data, also of those on the inner half of the disc. As many sums of rough points follow.
        flux_red: Buffer<u32>[2 * (sizes.pixels + sizes.of_rough(sizes.pixels))],
        flux_green: Buffer<u32>[2 * (sizes.pixels + sizes.of_rough(sizes.pixels))],
        flux_blue: Buffer<u32>[2 * (sizes.pixels + sizes.of_rough(sizes.pixels))],
        flux_counts: Buffer<u32>[sizes.counts * sizes.pixels],

        // Kept between iterations, by pixel.
        pixel_states: Texels<PixelState>[sizes.pixels],
        /// Of red, green and blue, and of the second half's luminance.
        sums: Four<Sum>[sizes.pixels],
    }
}

impl Buffers {
    /// Allocates the arrays, writes the view, and clears the sums.
    ///
    /// # Errors
    /// The same as for [`Buffers::allocate`].
    pub fn new(device: &Device, sizes: &Sizes, view: &View) -> goblet_host::Result<Self> {
        let buffers = Self::allocate(device, sizes)?;
        buffers.set_view(device, view)?;
        buffers.clear(device)?;
        Ok(buffers)
    }

    /// Writes the camera and the pixel filter.
    ///
    /// # Errors
    /// The device fails.
    pub fn set_view(&self, device: &Device, view: &View) -> goblet_host::Result<()> {
        device.write_texels(&self.camera, &[view.camera])?;
        device.write_texels(&self.filter_table, &view.filter_table)
    }

    /// Clears the results of all iterations. After it, no pixel has a visible point.
    ///
    /// # Errors
    /// The device fails.
    pub fn clear(&self, device: &Device) -> goblet_host::Result<()> {
        let mut frame = device.frame()?;
        self.clear_flux(&mut frame);
        frame.clear_texels(&self.pixel_states);
        frame.clear_texels(&self.visible_points);
        frame.clear_texels(&self.visible_radii2);
        frame.clear_texels(&self.visible_throughputs);
        frame.clear_texels(&self.rough_points);
        self.sums.iter().for_each(|sums| frame.clear_texels(sums));
        frame.run()
    }

    /// Records commands that clear the photons of an unfinished iteration.
    pub fn clear_flux(&self, frame: &mut Frame<'_>) {
        let Self { flux_red, flux_green, flux_blue, flux_counts, .. } = self;
        [flux_red, flux_green, flux_blue, flux_counts].into_iter().for_each(|flux| frame.clear(flux));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_have_more_room_on_a_card_with_more_memory() {
        const GIB: u64 = 1 << 30;
        let room = |kind, memory| room_for_records(kind, memory, 1 << 27);
        assert_eq!(room(DeviceKind::Cpu, 64 * GIB), 1 << 20);
        assert_eq!(room(DeviceKind::Integrated, GIB), 1 << 20);
        // 4 GiB over 16 are 256 MiB, in 72 bytes each.
        assert_eq!(room(DeviceKind::Discrete, 4 * GIB), (256 << 20) / 72);
        assert_eq!(room(DeviceKind::Discrete, 80 * GIB), 1 << 22, "128 MiB of 32 bytes each");
        assert_eq!(room_for_records(DeviceKind::Discrete, 80 * GIB, 4 * GIB), 1 << 24);
    }
}
