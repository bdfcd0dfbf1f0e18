//! Parsers of values on the command line. They reject a value that no scene and no device could use.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::base::names::Named;
use crate::image::exposure::{Exposure, MAX_STOPS};
use crate::image::file;
use crate::render::aov::{AOVS, Aov};
use crate::render::options::values::{number, whole_number};
pub use crate::render::options::values::{resolution, seconds, target_error};
use crate::scene::mesh::tessellate as mesh;

/// Returns the parser of the name of an AOV.
pub fn aov() -> impl TypedValueParser<Value = &'static Aov> {
    let value = |aov: &Aov| {
        let alias = Some(aov.alias).filter(|alias| !alias.is_empty());
        PossibleValue::new(aov.name).aliases(alias).help(aov.help())
    };
    PossibleValuesParser::new(AOVS.iter().map(value)).try_map(|name| Aov::named(&name).ok_or("no such name"))
}

/// Returns the parser of the name of a value.
pub fn named<T: Named + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let value = |(name, line): &(&'static str, &'static str)| PossibleValue::new(*name).help(line.trim());
    PossibleValuesParser::new(T::NAMES.iter().map(value)).try_map(|name| T::from_name(&name))
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

/// Reads the exposure of pictures: a number of stops, or `auto`.
pub fn exposure(text: &str) -> Result<Exposure, String> {
    if text == "auto" {
        return Ok(Exposure::Auto);
    }
    let most = f64::from(MAX_STOPS);
    let expected = format!("a number of stops from -{most} to {most}, or auto");
    number(text, |stops| stops.abs() <= most, &expected).map(|stops| Exposure::Stops(stops as f32))
}

pub fn positive_u32(text: &str) -> Result<u32, String> {
    whole_number(text, 1..=u32::MAX)
}

pub fn tolerance(text: &str) -> Result<f64, String> {
    let [least, most] = mesh::TOLERANCES;
    number(text, |tolerance| (least..=most).contains(&tolerance), &format!("a number from {least:e} to {most}"))
}

pub fn limit(text: &str) -> Result<f64, String> {
    let accepted = |limit: f64| limit.is_finite() && limit >= 0.0;
    number(text, accepted, "a finite number, 0 or more")
}

pub fn positive(text: &str) -> Result<f64, String> {
    number(text, |value| value.is_finite() && value > 0.0, "a finite number above 0")
}

/// Reads a number of GiB and returns it in bytes.
pub fn gibibytes(text: &str) -> Result<u64, String> {
    const MOST: f64 = 1e6;
    let bytes = f64::from(1 << 30);
    number(text, |gib| gib > 0.0 && gib <= MOST, "a number of GiB above 0 and at most 1e6")
        .map(|gib| (gib * bytes) as u64)
}
