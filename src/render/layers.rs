//! The device arrays of an image's layers: the values of an iteration, and their sums.

use goblet_host::{Buffer, Device, Frame, Texels};

use crate::image::estimate::Sum;
use crate::image::layers::{Group, Groups};
use crate::render::buffers::four;

/// The sums of an iteration's photons of caustics, as the flux of all photons: red, green, blue, and counts.
pub type CausticFlux = [Buffer<u32>; 4];

/// Words of a pixel in each array of a [`CausticFlux`].
const FLUX_WORDS: [u64; 4] = [2, 2, 2, 1];

/// The arrays of the layers that were asked for.
pub struct LayerArrays {
    /// The groups that there are.
    pub groups: Groups,
    /// The values of an iteration: a value of each pixel for each group, one group after the other.
    pub values: Texels<[f32; 4]>,
    /// The sums of each group.
    pub sums: Vec<[Texels<Sum>; 4]>,
    /// The flux of caustics; empty unless that group is there.
    pub caustic_flux: CausticFlux,
}

impl LayerArrays {
    /// Allocates the arrays for images of up to `pixels` pixels, and clears them. `None` if there is no group.
    ///
    /// # Errors
    /// The device has too little memory, or an array is larger than the device can bind.
    pub fn new(device: &Device, groups: Groups, pixels: u64) -> goblet_host::Result<Option<Self>> {
        if groups.is_empty() {
            return Ok(None);
        }
        let flux_pixels = if groups.has(Group::Caustic) { pixels } else { 0 };
        let [red, green, blue, counts] = FLUX_WORDS.map(|words| words * flux_pixels);
        let arrays = Self {
            groups,
            values: device.texels("layer_values", groups.len() as u64 * pixels)?,
            sums: groups.iter().map(|_| four(device, "layer_sums", pixels)).collect::<goblet_host::Result<_>>()?,
            caustic_flux: [
                device.buffer("caustic_red", red)?,
                device.buffer("caustic_green", green)?,
                device.buffer("caustic_blue", blue)?,
                device.buffer("caustic_counts", counts)?,
            ],
        };
        arrays.clear(device)?;
        Ok(Some(arrays))
    }

    /// Returns the bytes of the arrays; a device rounds the size of each array up.
    pub fn bytes(groups: Groups, pixels: u64) -> u64 {
        let value_and_sums = size_of::<[f32; 4]>() + 4 * size_of::<Sum>();
        let flux = if groups.has(Group::Caustic) { 4 * FLUX_WORDS.iter().sum::<u64>() } else { 0 };
        pixels.saturating_mul((groups.len() * value_and_sums) as u64 + flux)
    }

    /// Clears the sums.
    ///
    /// # Errors
    /// The device fails.
    pub fn clear(&self, device: &Device) -> goblet_host::Result<()> {
        let mut frame = device.frame()?;
        frame.clear_texels(&self.values);
        self.sums.iter().flatten().for_each(|sums| frame.clear_texels(sums));
        self.clear_caustics(&mut frame);
        frame.run()
    }

    /// Records commands that clear the flux of caustics, before the photons of an iteration.
    pub fn clear_caustics(&self, frame: &mut Frame<'_>) {
        self.caustic_flux.iter().for_each(|flux| frame.clear(flux));
    }

    /// Returns the flux of caustics, if that group is there.
    pub fn caustics(&self) -> Option<&CausticFlux> {
        self.groups.has(Group::Caustic).then_some(&self.caustic_flux)
    }

    /// Reads the sums of the first `pixels` pixels.
    ///
    /// # Errors
    /// The device fails.
    pub fn read(&self, device: &Device, pixels: u64) -> goblet_host::Result<Vec<[Vec<Sum>; 4]>> {
        let read = |sums: &[Texels<Sum>; 4]| {
            let [x, y, z, w] = sums.each_ref().map(|sums| device.read_first_texels(sums, pixels));
            Ok([x?, y?, z?, w?])
        };
        self.sums.iter().map(read).collect()
    }

    /// Writes the sums.
    ///
    /// # Errors
    /// The device fails.
    pub fn write(&self, device: &Device, sums: &[[Vec<Sum>; 4]]) -> goblet_host::Result<()> {
        let pairs = self.sums.iter().flatten().zip(sums.iter().flatten());
        pairs.into_iter().try_for_each(|(texels, sums)| device.write_texels(texels, sums))
    }
}
