//! Checkpoints: files from which a later run continues a render, or whose sums are added to those of other
//! shards.
//!
//! A file is a gzip stream, whose checksum detects a truncated file. It contains one line of JSON, then the
//! sums and the states of the pixels in their memory layout, little-endian.

pub(in crate::render) mod difference;
pub(in crate::render) mod error;
mod layers;

use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, BufRead, BufReader, BufWriter, Read, Write};
use std::path::Path;

use bytemuck::{Pod, Zeroable};
use flate2::Compression;
use flate2::bufread::GzDecoder;
use flate2::write::GzEncoder;
use glam::DMat3;
use goblet_host::Device;
use serde::{Deserialize, Serialize};

pub use difference::{Difference, Differences, To};
pub use error::CheckpointError;
use error::FORMAT;
use layers::LayerHeader;

use crate::base::input::{self, Budget};
use crate::base::output::Replacement;
use crate::image::estimate::{Estimate, Sum};
use crate::image::film::Window;
use crate::image::layers::{LayerForm, Layers};
use crate::kernels::PixelState;
use crate::render::counters::Tally;
use crate::render::frame::Frame;
use crate::render::identity::Identity;
use crate::render::options::MAX_SIDE;
use crate::render::radius::{FirstRadius, RadiusSchedule};
use crate::render::sequence::Shard;
use crate::scene::shorten;

/// The longest first line in bytes: enough for the counts of [`Shard::MAX_COUNT`] shards.
const MAX_HEADER: u64 = 1 << 22;
/// The largest number of pixels in an image; the sums and states of such an image take 20 GiB.
const MAX_PIXELS: u64 = 1 << 28;
/// Bytes of a pixel's sums and of its state.
const PIXEL_BYTES: u64 = 4 * size_of::<Sum>() as u64 + size_of::<PixelState>() as u64;
/// Bytes of a pixel's sums of a group of layers.
const GROUP_BYTES: u64 = 4 * size_of::<Sum>() as u64;
/// The largest ratio of the size of a file's contents to the size of the file, unless the image is small or
/// black.
const MAX_EXPANSION: u64 = 64;
/// The largest radius in render units: its square is finite in f32.
const MAX_RADIUS: f32 = 1e18;

/// The program, device and driver that made a checkpoint. With others, roundings may differ.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MadeBy {
    /// Version of goblet.
    pub version: String,
    /// The device's name.
    pub device: String,
    /// The driver's name and version.
    pub driver: String,
}

impl MadeBy {
    /// Returns this program's version with a device and its driver.
    pub fn new(device: &Device) -> Self {
        let info = device.info();
        let version = env!("CARGO_PKG_VERSION").to_owned();
        Self { version, device: info.name.clone(), driver: info.driver.clone() }
    }
}

impl fmt::Display for MadeBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "goblet {} on {} ({})", self.version, self.device, self.driver)
    }
}

/// The state of a render, or the merged results of shards.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// The scene and the options that determine the image.
    pub identity: Identity,
    /// The scene's file name, for messages.
    pub scene: String,
    /// The program, device and driver.
    pub made_by: MadeBy,
    /// The number of shards of the render.
    pub shards: u32,
    /// The number of iterations from each shard, by the index of the shard.
    pub done: BTreeMap<u32, u32>,
    /// The radius that visible points start with.
    pub first_radius: Option<FirstRadius>,
    /// The camera as image files describe it; `None` if the file does not tell.
    pub frame: Option<Frame>,
    /// Counts of how paths ended.
    pub tally: Tally,
    /// The sums of the image.
    pub estimate: Estimate,
    /// The state of each pixel; empty if shards were merged.
    pub states: Vec<PixelState>,
}

/// The first line of a file.
#[derive(Serialize, Deserialize)]
struct Header {
    goblet_checkpoint: u32,
    identity: Identity,
    scene: String,
    made_by: MadeBy,
    shards: u32,
    done: BTreeMap<u32, u32>,
    first_radius: Option<[f32; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    frame: Option<Frame>,
    tally: Tally,
    resolution: [u32; 2],
    /// For a part of an image: the position of its first pixel, and the size of the full image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    window: Option<[[u32; 2]; 2]>,
    unit: f64,
    /// The columns of the matrix, if the film has a white balance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    white_balance: Option<[[f64; 3]; 3]>,
    halves: [u64; 2],
    has_states: bool,
    /// The form of the layers, if there are any; their sums follow those of the image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    layers: Option<LayerHeader>,
}

impl Header {
    /// Returns the number of pixels; `None` if a value of the header is out of range or contradicts another.
    fn pixels(&self) -> Option<u64> {
        let [width, height] = self.resolution.map(u64::from);
        let iterations: u64 = self.done.values().map(|done| u64::from(*done)).sum();
        let fits = |[first, full]: [[u32; 2]; 2], side: usize| {
            let end = first[side].checked_add(self.resolution[side]);
            full[side] <= MAX_SIDE && end.is_some_and(|end| end <= full[side])
        };
        let sensible = self.window.is_none_or(|window| fits(window, 0) && fits(window, 1))
            && self.shards <= Shard::MAX_COUNT
            && width * height > 0
            && width * height <= MAX_PIXELS
            && self.unit.is_finite()
            && self.unit > 0.0
            && self.halves[0].checked_add(self.halves[1]) == Some(iterations)
            && self.done.keys().all(|index| *index < self.shards)
            && self.first_radius.is_none_or(are_radii);
        sensible.then_some(width * height)
    }
}

/// Returns whether the numbers are valid for a [`FirstRadius`].
fn are_radii([per_length, least, most]: [f32; 3]) -> bool {
    (0.0..=MAX_RADIUS).contains(&per_length) && 0.0 < least && least <= most && most <= MAX_RADIUS
}

/// Returns whether the values of a pixel's state are in range. With radii from the data it has sums of discs
/// (`shaders/include/lookup/data_radius.glsl`).
fn is_state(state: &PixelState, identity: &Identity) -> bool {
    let PixelState { found_low, found_high, shrink, rest } = *state;
    if !identity.has_schedule(RadiusSchedule::Data) {
        return (0.0..=1.0).contains(&shrink) && rest.abs() <= 1.0;
    }
    let [found, excess] = [found_low, found_high].map(f32::from_bits);
    [found, excess.abs(), shrink, rest].iter().all(|sum| (0.0..=f32::MAX).contains(sum)) && excess.abs() <= found
}

impl Checkpoint {
    /// Returns the number of iterations from a shard.
    ///
    /// # Errors
    /// The checkpoint cannot be continued as this shard: it is from other shards, or was merged.
    pub(crate) fn done_by(&self, shard: Shard) -> Result<u32, CheckpointError> {
        match self.done.get(&shard.index) {
            Some(done) if self.shards == shard.count && self.done.len() == 1 && !self.states.is_empty() => Ok(*done),
            _ => Err(self.other_shard(shard)),
        }
    }

    fn other_shard(&self, shard: Shard) -> CheckpointError {
        let name = |index: u32, count: u32| format!("shard {index}/{count}");
        let here = if shard.count == 1 { "whole".to_owned() } else { name(shard.index, shard.count) };
        let (there, expected) = match self.done.keys().next() {
            Some(_) if self.shards == 1 => ("a whole render".to_owned(), "no --shard".to_owned()),
            Some(index) if self.done.len() == 1 && !self.states.is_empty() => {
                (name(*index, self.shards), format!("--shard {index}/{}", self.shards))
            }
            _ => {
                let merged = format!("merged shards ({} of {})", shorten(&ranges(self.done.keys())), self.shards);
                (merged, "the checkpoint of one shard, or goblet merge".to_owned())
            }
        };
        CheckpointError::Shard { here, there, expected }
    }

    /// Adds the iterations of other shards.
    ///
    /// # Errors
    /// The other checkpoint is of another render, or has a shard that this one has too.
    pub fn merge(&mut self, other: &Self) -> Result<(), CheckpointError> {
        self.identity.check(&other.identity, To::Others)?;
        if self.shards != other.shards {
            return Err(CheckpointError::Shards { here: self.shards, there: other.shards });
        }
        let Estimate { resolution, unit, white_balance, ref layers, .. } = other.estimate;
        self.check_form(resolution, unit, white_balance, &layers.form)?;
        // A shard without iterations may not have a first radius yet.
        if let (Some(here), Some(there)) = (self.first_radius, other.first_radius)
            && here != there
        {
            return Err(CheckpointError::Radii);
        }
        if let Some(index) = self.done.keys().find(|index| other.done.contains_key(index)) {
            return Err(CheckpointError::Twice(*index));
        }
        self.estimate.add(&other.estimate);
        self.tally.merge(&other.tally);
        self.done.extend(&other.done);
        self.first_radius = self.first_radius.or(other.first_radius);
        self.frame = self.frame.or(other.frame);
        self.states = Vec::new();
        Ok(())
    }

    /// Checks the resolution, the unit, the white balance and the layers of the sums. They agree if the identity
    /// agrees, unless the file was forged.
    pub(crate) fn check_form(
        &self,
        resolution: [u32; 2],
        unit: f64,
        white_balance: Option<DMat3>,
        layers: &LayerForm,
    ) -> Result<(), CheckpointError> {
        if self.estimate.has_form(resolution, unit, white_balance, layers) {
            return Ok(());
        }
        Err(CheckpointError::Format("its sums are of another form than its options ask for".to_owned()))
    }

    /// Returns the indices of the shards that are not in the checkpoint.
    pub fn missing(&self) -> Vec<u32> {
        (0..self.shards).filter(|index| !self.done.contains_key(index)).collect()
    }

    /// Checks that a file can be written to `path`. Callers use it before a long render that ends with
    /// [`write`](Self::write).
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn check_writable(path: &Path) -> Result<(), CheckpointError> {
        Replacement::create(path).map(drop).map_err(CheckpointError::Write)
    }

    /// Writes the checkpoint atomically: `path` has either the old file or the whole new one.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), CheckpointError> {
        let mut replacement = Replacement::create(path).map_err(CheckpointError::Write)?;
        self.encode(BufWriter::new(&mut replacement))
            .and_then(|()| replacement.commit())
            .map_err(CheckpointError::Write)
    }

    fn encode(&self, file: impl Write) -> io::Result<()> {
        let header = Header {
            goblet_checkpoint: FORMAT,
            identity: self.identity.clone(),
            scene: self.scene.clone(),
            made_by: self.made_by.clone(),
            shards: self.shards,
            done: self.done.clone(),
            first_radius: self.first_radius.map(|radius| [radius.per_length, radius.least, radius.most]),
            frame: self.frame,
            tally: self.tally,
            resolution: self.estimate.resolution,
            window: window_of(&self.estimate),
            unit: self.estimate.unit,
            white_balance: self.estimate.white_balance.map(|matrix| matrix.to_cols_array_2d()),
            halves: self.estimate.halves,
            has_states: !self.states.is_empty(),
            layers: LayerHeader::of(&self.estimate.layers.form),
        };
        let mut out = GzEncoder::new(file, Compression::fast());
        serde_json::to_writer(&mut out, &header)?;
        out.write_all(b"\n")?;
        for sums in self.estimate.sums() {
            out.write_all(bytemuck::cast_slice(sums))?;
        }
        for sums in self.estimate.layers.sums.iter().flatten() {
            out.write_all(bytemuck::cast_slice(sums))?;
        }
        out.write_all(bytemuck::cast_slice(&self.states))?;
        out.finish()?.flush()
    }

    /// Reads a file. The budget of memory is a scene's default budget, and larger for a large file.
    ///
    /// # Errors
    /// The file cannot be read, or is not a whole checkpoint.
    pub fn read(path: &Path) -> Result<Self, CheckpointError> {
        let file = input::open(path).map_err(CheckpointError::Read)?;
        let length = file.metadata().map_err(CheckpointError::Read)?.len();
        let least = length.saturating_mul(MAX_EXPANSION);
        let budget = Budget::new(Budget::default().left().max(least));
        Self::decode(BufReader::new(file), &budget)
    }

    /// Reads the contents of a file.
    ///
    /// # Errors
    /// The contents are not a whole checkpoint, or take more memory than the budget has.
    pub fn decode(source: impl BufRead, budget: &Budget) -> Result<Self, CheckpointError> {
        let mut source = BufReader::new(GzDecoder::new(source));
        let mut line = Vec::new();
        (&mut source).take(MAX_HEADER).read_until(b'\n', &mut line).map_err(torn)?;
        // A file of another format may have other fields, so the number of the format is checked first.
        let version: Version = serde_json::from_slice(&line).map_err(|error| torn(error.into()))?;
        if version.goblet_checkpoint != FORMAT {
            return Err(CheckpointError::Version(version.goblet_checkpoint));
        }
        let header: Header = serde_json::from_slice(&line).map_err(|error| torn(error.into()))?;
        let unfit = || CheckpointError::Format("its numbers do not fit".to_owned());
        let pixels = header.pixels().ok_or_else(unfit)?;
        let form = header.layers.as_ref().map_or(Some(LayerForm::default()), LayerHeader::form).ok_or_else(unfit)?;
        budget.check(pixels * (PIXEL_BYTES + form.groups.len() as u64 * GROUP_BYTES)).map_err(|over| {
            let [width, height] = header.resolution;
            CheckpointError::Format(format!("for its {width}x{height} pixels, {over}"))
        })?;
        let mut sums = || read_array(&mut source, pixels).map_err(torn);
        let (radiance, second_half) = ([sums()?, sums()?, sums()?], sums()?);
        let mut group = || Ok([sums()?, sums()?, sums()?, sums()?]);
        let layers = form.groups.iter().map(|_| group()).collect::<Result<_, CheckpointError>>()?;
        let states = if header.has_states { read_array(&mut source, pixels).map_err(torn)? } else { Vec::new() };
        if !states.iter().all(|state| is_state(state, &header.identity)) {
            return Err(CheckpointError::Format("what its pixels remember makes no sense".to_owned()));
        }
        // The checksum follows the last byte, and nothing follows the checksum.
        let mut has_more = source.read(&mut [0]).map_err(torn)? > 0;
        has_more |= !source.into_inner().into_inner().fill_buf().map_err(torn)?.is_empty();
        if has_more {
            return Err(CheckpointError::Format("more data than expected".to_owned()));
        }
        let whole = Window::whole(header.resolution);
        let estimate = Estimate {
            resolution: header.resolution,
            window: header.window.map_or(whole, |[first, full]| Window { first: first.map(|side| side as i32), full }),
            unit: header.unit,
            white_balance: header.white_balance.map(|columns| DMat3::from_cols_array_2d(&columns)),
            halves: header.halves,
            radiance,
            second_half,
            layers: Layers { form, sums: layers },
        };
        Ok(Self {
            identity: header.identity,
            scene: header.scene,
            made_by: header.made_by,
            shards: header.shards,
            done: header.done,
            first_radius: header.first_radius.map(|[per_length, least, most]| FirstRadius { per_length, least, most }),
            frame: header.frame,
            tally: header.tally,
            estimate,
            states,
        })
    }
}

/// Returns the window for a header: first pixel and full size; `None` if it is the whole image.
fn window_of(estimate: &Estimate) -> Option<[[u32; 2]; 2]> {
    let Window { first, full } = estimate.window;
    (estimate.window != Window::whole(estimate.resolution)).then(|| [first.map(i32::cast_unsigned), full])
}

#[derive(Deserialize)]
struct Version {
    goblet_checkpoint: u32,
}

/// Returns numbers in increasing order as words, as in `0, 2-5, 7`.
pub fn ranges<'a>(numbers: impl Iterator<Item = &'a u32>) -> String {
    let mut ranges: Vec<[u32; 2]> = Vec::new();
    for number in numbers {
        match ranges.last_mut() {
            Some([_, last]) if last.checked_add(1) == Some(*number) => *last = *number,
            _ => ranges.push([*number; 2]),
        }
    }
    let words = ranges.into_iter().map(|[first, last]| match last - first {
        0 => first.to_string(),
        1 => format!("{first}, {last}"),
        _ => format!("{first}-{last}"),
    });
    words.collect::<Vec<_>>().join(", ")
}

fn torn(error: io::Error) -> CheckpointError {
    CheckpointError::Format(error.to_string())
}

/// Reads `length` items. Memory grows with the data that is read, and not with the length in the header.
fn read_array<T: Pod + Zeroable>(source: &mut impl Read, length: u64) -> io::Result<Vec<T>> {
    const ITEMS_AT_ONCE: u64 = 1 << 12;
    let mut items = Vec::new();
    while (items.len() as u64) < length {
        let (begin, more) = (items.len(), (length - items.len() as u64).min(ITEMS_AT_ONCE) as usize);
        items.try_reserve(more).map_err(|_| io::ErrorKind::OutOfMemory)?;
        items.resize(begin + more, T::zeroed());
        source.read_exact(bytemuck::cast_slice_mut(&mut items[begin..]))?;
    }
    Ok(items)
}

#[cfg(test)]
mod tests;
