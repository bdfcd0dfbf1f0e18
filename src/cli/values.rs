//! Values as they are written on the command line; each is rejected here if no scene and no
//! device could make sense of it.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::image::file;
use crate::render::aov::{AOVS, Aov};
use crate::render::options::Options;
use crate::scene::mesh::tessellate as mesh;

pub fn workgroup_sizes() -> impl TypedValueParser<Value = u32> {
    PossibleValuesParser::new(["32", "64", "128"]).try_map(|size| size.parse::<u32>())
}

/// One of those that a command can write.
pub fn aov(is_offered: fn(&Aov) -> bool) -> impl TypedValueParser<Value = &'static Aov> {
    let offered = AOVS.iter().filter(|aov| is_offered(aov));
    PossibleValuesParser::new(offered.map(|aov| PossibleValue::new(aov.name).help(aov.help())))
        .try_map(|name| Aov::named(&name).ok_or("no such name"))
}

pub fn output_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match file::check_extension(&path) {
        Ok(()) => Ok(path),
        Err(_) => Err(format!("expected a file name ending in {}", file::WRITABLE_EXTENSIONS.replace("and", "or"))),
    }
}

pub fn scene_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match (path.file_stem(), path.extension()) {
        (Some(_), Some(extension)) if extension == "pbrt" => Ok(path),
        _ => Err("expected a file name ending in .pbrt".to_owned()),
    }
}

/// Whole numbers up to this are exact in f64.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// A number of photons: whole, also as in `5e8`.
pub fn photons(text: &str) -> Result<u64, String> {
    let exact = |value: &f64| *value >= 1.0 && *value <= MAX_EXACT && value.fract() == 0.0;
    let written_out = text.parse().ok().filter(|count| *count > 0);
    written_out
        .or_else(|| text.parse().ok().filter(exact).map(|value| value as u64))
        .ok_or_else(|| format!("expected a whole number from 1 to {}, such as 500000 or 5e8", u64::MAX))
}

pub fn positive_u32(text: &str) -> Result<u32, String> {
    whole_number(text, 1..=u32::MAX)
}

pub fn eye_paths(text: &str) -> Result<u32, String> {
    whole_number(text, Options::EYE_PATHS)
}

pub fn seed(text: &str) -> Result<u32, String> {
    whole_number(text, 0..=u32::MAX)
}

pub fn whole_number<T>(text: &str, range: RangeInclusive<T>) -> Result<T, String>
where
    T: FromStr + PartialOrd + Display,
{
    text.parse()
        .ok()
        .filter(|value| range.contains(value))
        .ok_or_else(|| format!("expected a whole number from {} to {}", range.start(), range.end()))
}

pub fn number(text: &str, accepted: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    text.parse().ok().filter(|&value| accepted(value)).ok_or_else(|| format!("expected {expected}"))
}

/// An initial radius as it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Radius {
    /// Scene units.
    Length(f64),
    /// Widths of a pixel where it is seen.
    Pixels(f64),
}

pub fn radius(text: &str) -> Result<Radius, String> {
    let expected = "a length above 0, from 1e-18 to 1e18, or pixels from 0.0625px to 64px";
    if let Some(pixels) = text.strip_suffix("px") {
        let [least, most] = Options::RADII_IN_PIXELS;
        return number(pixels, |pixels| (least..=most).contains(&pixels), expected).map(Radius::Pixels);
    }
    // The kernels square it in 32-bit floats.
    number(text, |radius| (1e-18..=1e18).contains(&radius), expected).map(Radius::Length)
}

pub fn alpha(text: &str) -> Result<f64, String> {
    // As it is on the device: not rounded to zero.
    let accepted = |alpha| (f64::from(f32::MIN_POSITIVE)..=1.0).contains(&alpha);
    number(text, accepted, "a number above 0 and at most 1")
}

pub fn tolerance(text: &str) -> Result<f64, String> {
    let [least, most] = mesh::TOLERANCES;
    number(text, |tolerance| (least..=most).contains(&tolerance), &format!("a number from {least:e} to {most}"))
}

pub fn cell_scale(text: &str) -> Result<f64, String> {
    let [least, most] = Options::CELL_SCALES;
    number(text, |scale| (least..=most).contains(&scale), &format!("a number from {least} to {most}"))
}

pub fn target_error(text: &str) -> Result<f64, String> {
    number(text, |error| error > 0.0 && error < f64::INFINITY, "a finite number above 0")
}

pub fn limit(text: &str) -> Result<f64, String> {
    let accepted = |limit: f64| limit.is_finite() && limit >= 0.0;
    number(text, accepted, "a finite number, 0 or more")
}

/// A number of GiB, in bytes.
pub fn gibibytes(text: &str) -> Result<u64, String> {
    const MOST: f64 = 1e6;
    let bytes = f64::from(1 << 30);
    number(text, |gib| gib > 0.0 && gib <= MOST, "a number of GiB above 0 and at most 1e6")
        .map(|gib| (gib * bytes) as u64)
}

pub fn seconds(text: &str) -> Result<Duration, String> {
    text.parse()
        .ok()
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .filter(|time| !time.is_zero())
        .ok_or_else(|| "expected a finite number of seconds above 0".to_owned())
}

pub fn resolution(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=65536).contains(side));
    text.split_once('x')
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or_else(|| "expected WIDTHxHEIGHT, each from 1 to 65536, such as 640x480".to_owned())
}
