//! A render on disk: all that a later run needs to go on, and what one shard leaves for the
//! others.
//!
//! A file is a gzip stream, whose checksum tells a whole file from a torn one: one line of
//! JSON, then the sums and states of the pixels as they are in memory, little-endian.

pub(in crate::render) mod error;

use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, BufRead, BufReader, BufWriter, Read, Write};
use std::path::Path;

use bytemuck::{Pod, Zeroable};
use flate2::Compression;
use flate2::bufread::GzDecoder;
use flate2::write::GzEncoder;
use goblet_host::Device;
use serde::{Deserialize, Serialize};

pub use error::CheckpointError;
use error::FORMAT;

use crate::base::input::{self, Budget};
use crate::base::output::Replacement;
use crate::image::estimate::{Estimate, Sum};
use crate::image::film::Window;
use crate::kernels::PixelState;
use crate::render::counters::Tally;
use crate::render::identity::Identity;
use crate::render::options::MAX_SIDE;
use crate::render::radius::FirstRadius;
use crate::render::sequence::Shard;
use crate::scene::shorten;

/// The longest first line: enough for the counts of as many shards as there can be.
const MAX_HEADER: u64 = 1 << 22;
/// The largest image; its sums take 20 GiB.
const MAX_PIXELS: u64 = 1 << 28;
/// Bytes of a pixel's sums, and of what it remembers.
const PIXEL_BYTES: u64 = 4 * size_of::<Sum>() as u64 + size_of::<PixelState>() as u64;
/// No render's file expands by more, unless its image is small or black.
const MAX_EXPANSION: u64 = 64;
/// The largest radius, render units: its square is a number.
const MAX_RADIUS: f32 = 1e18;

/// Who made a checkpoint. Another maker's roundings may differ.
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
    /// This program on a device.
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

/// A render as it stood.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// What was rendered.
    pub identity: Identity,
    /// The scene's file name, for people.
    pub scene: String,
    /// Who did it.
    pub made_by: MadeBy,
    /// Among how many shards the iterations are shared.
    pub shards: u32,
    /// Iterations of each shard that are in it.
    pub done: BTreeMap<u32, u32>,
    /// The radius that visible points start with.
    pub first_radius: Option<FirstRadius>,
    /// What happened to paths.
    pub tally: Tally,
    /// The image.
    pub estimate: Estimate,
    /// What pixels remember; none where shards were merged.
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
    tally: Tally,
    resolution: [u32; 2],
    /// Of a part of an image: its first pixel, and the size of the whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    window: Option<[[u32; 2]; 2]>,
    unit: f64,
    halves: [u64; 2],
    has_states: bool,
}

impl Header {
    /// How many pixels there are, if everything it says makes sense.
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

/// Whether a [`FirstRadius`] is of such numbers.
fn are_radii([per_length, least, most]: [f32; 3]) -> bool {
    (0.0..=MAX_RADIUS).contains(&per_length) && 0.0 < least && least <= most && most <= MAX_RADIUS
}

/// Whether a pixel may remember this.
fn is_state(state: &PixelState) -> bool {
    (0.0..=1.0).contains(&state.shrink) && state.rest.abs() <= 1.0
}

impl Checkpoint {
    /// Iterations that it has of a shard.
    pub(crate) fn done_by(&self, shard: Shard) -> Result<u32, CheckpointError> {
        match self.done.get(&shard.index) {
            Some(done) if self.shards == shard.count && self.done.len() == 1 && !self.states.is_empty() => Ok(*done),
            _ => Err(CheckpointError::Shard {
                here: format!("{}/{}", shard.index, shard.count),
                there: self.shard_names(),
            }),
        }
    }

    /// As in `0/3` or `0,2/3`.
    fn shard_names(&self) -> String {
        let indices: Vec<String> = self.done.keys().map(u32::to_string).collect();
        format!("{}/{}", shorten(&indices.join(",")), self.shards)
    }

    /// Adds the iterations of other shards.
    ///
    /// # Errors
    /// They are of another render, or here already.
    pub fn merge(&mut self, other: &Self) -> Result<(), CheckpointError> {
        self.identity.check(&other.identity)?;
        let option =
            |name: &str, here: String, there: String| CheckpointError::Option { name: name.into(), here, there };
        if self.shards != other.shards {
            return Err(option("shards", self.shards.to_string(), other.shards.to_string()));
        }
        self.check_form(other.estimate.resolution, other.estimate.unit)?;
        // A shard without iterations may not know the radius yet.
        if let (Some(here), Some(there)) = (self.first_radius, other.first_radius)
            && here != there
        {
            return Err(option("first radius", format!("{here:?}"), format!("{there:?}")));
        }
        if let Some(index) = self.done.keys().find(|index| other.done.contains_key(index)) {
            return Err(CheckpointError::Twice(*index));
        }
        self.estimate.add(&other.estimate);
        self.tally.merge(&other.tally);
        self.done.extend(&other.done);
        self.first_radius = self.first_radius.or(other.first_radius);
        self.states = Vec::new();
        Ok(())
    }

    /// Checks that its sums are of this form. They are wherever the identity agrees, unless
    /// somebody made up the file.
    pub(crate) fn check_form(&self, resolution: [u32; 2], unit: f64) -> Result<(), CheckpointError> {
        if (self.estimate.resolution, self.estimate.unit) == (resolution, unit) {
            return Ok(());
        }
        Err(CheckpointError::Format("its sums are of another form than its options ask for".to_owned()))
    }

    /// Shards that are not in it.
    pub fn missing(&self) -> Vec<u32> {
        (0..self.shards).filter(|index| !self.done.contains_key(index)).collect()
    }

    /// Checks, before a long render, that [`write`](Self::write) will be able to.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn check_writable(path: &Path) -> Result<(), CheckpointError> {
        Replacement::create(path).map(drop).map_err(CheckpointError::Write)
    }

    /// Writes it, atomically: `path` holds the old file or the whole new one.
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
            tally: self.tally,
            resolution: self.estimate.resolution,
            window: window_of(&self.estimate),
            unit: self.estimate.unit,
            halves: self.estimate.halves,
            has_states: !self.states.is_empty(),
        };
        let mut out = GzEncoder::new(file, Compression::fast());
        serde_json::to_writer(&mut out, &header)?;
        out.write_all(b"\n")?;
        for sums in self.estimate.sums() {
            out.write_all(bytemuck::cast_slice(sums))?;
        }
        out.write_all(bytemuck::cast_slice(&self.states))?;
        out.finish()?.flush()
    }

    /// Reads a file. It may take a scene's default budget of memory, and more where the file is
    /// large.
    ///
    /// # Errors
    /// It cannot be read, or is not a whole checkpoint.
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
    /// They are not a whole checkpoint, or take more memory than the budget has.
    pub fn decode(source: impl BufRead, budget: &Budget) -> Result<Self, CheckpointError> {
        let mut source = BufReader::new(GzDecoder::new(source));
        let mut line = Vec::new();
        (&mut source).take(MAX_HEADER).read_until(b'\n', &mut line).map_err(torn)?;
        // Another format may have other fields: its number comes first.
        let version: Version = serde_json::from_slice(&line).map_err(|error| torn(error.into()))?;
        if version.goblet_checkpoint != FORMAT {
            return Err(CheckpointError::Version(version.goblet_checkpoint));
        }
        let header: Header = serde_json::from_slice(&line).map_err(|error| torn(error.into()))?;
        let pixels = header.pixels().ok_or_else(|| CheckpointError::Format("its numbers do not fit".to_owned()))?;
        budget.check(pixels * PIXEL_BYTES).map_err(|over| {
            let [width, height] = header.resolution;
            CheckpointError::Format(format!("for its {width}x{height} pixels, {over}"))
        })?;
        let mut sums = || read_array(&mut source, pixels).map_err(torn);
        let (radiance, second_half) = ([sums()?, sums()?, sums()?], sums()?);
        let states = if header.has_states { read_array(&mut source, pixels).map_err(torn)? } else { Vec::new() };
        if !states.iter().all(is_state) {
            return Err(CheckpointError::Format("what its pixels remember makes no sense".to_owned()));
        }
        // The checksum comes after the last byte, and nothing after that.
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
            halves: header.halves,
            radiance,
            second_half,
        };
        Ok(Self {
            identity: header.identity,
            scene: header.scene,
            made_by: header.made_by,
            shards: header.shards,
            done: header.done,
            first_radius: header.first_radius.map(|[per_length, least, most]| FirstRadius { per_length, least, most }),
            tally: header.tally,
            estimate,
            states,
        })
    }
}

/// A window that is not the whole image, as a header has it.
fn window_of(estimate: &Estimate) -> Option<[[u32; 2]; 2]> {
    let Window { first, full } = estimate.window;
    (estimate.window != Window::whole(estimate.resolution)).then(|| [first.map(i32::cast_unsigned), full])
}

#[derive(Deserialize)]
struct Version {
    goblet_checkpoint: u32,
}

fn torn(error: io::Error) -> CheckpointError {
    CheckpointError::Format(error.to_string())
}

/// Memory grows with what is there, not with what a header promises.
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
