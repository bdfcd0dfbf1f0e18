//! The command line.

use std::ffi::OsString;
use std::ops::RangeInclusive;
use std::path::PathBuf;

pub const USAGE: &str = "[--rays N] [--turns N] [--large] [--only TEXT] [--device DEVICE] [--write-rays FOLDER] \
                         [SCENE.pbrt..]
  --rays N             rays of each set; 1048576 by default
  --turns N            how often each set is measured; 5 by default
  --large              also a mesh of 10^7 triangles
  --only TEXT          only scenes whose names contain this
  --device DEVICE      index of the device, or part of its name
  --write-rays FOLDER  write the meshes and rays for benches/rays/embree.py, and measure nothing
  SCENE.pbrt..         scenes to measure as well";

/// Rays of a set: a tile of pixels at least, and what one dispatch of any device can trace at most.
const RAYS: RangeInclusive<u64> = 1 << 12..=1 << 22;
const TURNS: RangeInclusive<u64> = 1..=1000;

pub struct Arguments {
    pub rays: u64,
    pub turns: u64,
    pub large: bool,
    pub only: String,
    pub device: Option<String>,
    pub folder: Option<PathBuf>,
    pub scenes: Vec<PathBuf>,
}

impl Arguments {
    pub fn parse(mut words: impl Iterator<Item = OsString>) -> Result<Self, String> {
        let (rays, turns) = (1 << 20, 5);
        let mut parsed =
            Self { rays, turns, large: false, only: String::new(), device: None, folder: None, scenes: Vec::new() };
        while let Some(word) = words.next() {
            let mut value = |name: &str| words.next().ok_or_else(|| format!("{name}: expected a value"));
            match word.to_str() {
                Some("--rays") => parsed.rays = number("--rays", value("--rays")?, RAYS)?,
                Some("--turns") => parsed.turns = number("--turns", value("--turns")?, TURNS)?,
                Some("--large") => parsed.large = true,
                Some("--only") => parsed.only = text(value("--only")?)?,
                Some("--device") => parsed.device = Some(text(value("--device")?)?),
                Some("--write-rays") => parsed.folder = Some(value("--write-rays")?.into()),
                Some(option) if option.starts_with('-') => return Err(format!("unknown option `{option}`")),
                _ => parsed.scenes.push(word.into()),
            }
        }
        Ok(parsed)
    }
}

fn text(word: OsString) -> Result<String, String> {
    word.into_string().map_err(|word| format!("`{}` is not UTF-8", word.display()))
}

fn number(name: &str, word: OsString, range: RangeInclusive<u64>) -> Result<u64, String> {
    let number = word.to_str().and_then(|word| word.parse().ok()).filter(|number| range.contains(number));
    number.ok_or_else(|| format!("{name}: expected a whole number from {} to {}", range.start(), range.end()))
}
