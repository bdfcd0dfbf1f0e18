//! The files that a scene names.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use flate2::read::MultiGzDecoder;

use super::error::{Location, SceneError};
use super::params::ParamList;
use super::registry::Kind;
use super::spectrum::Spectrum;
use crate::input::{self, Budget, Held};

/// The folder that a scene's file names are relative to.
pub(crate) fn directory(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// The same for every way to name a file.
pub(crate) fn identity(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
}

/// The text of a file, gzipped or not, and the memory that it takes.
pub(super) fn read_text(
    path: &Path,
    location: Option<&Location>,
    budget: &Arc<Budget>,
) -> Result<(String, Held), SceneError> {
    let read = || {
        let mut bytes = input::read(path, budget)?;
        let mut held = budget.hold(bytes.len() as u64)?;
        if bytes.starts_with(&[0x1f, 0x8b]) {
            bytes = input::read_to_end(MultiGzDecoder::new(&bytes[..]), budget)?;
            held = budget.hold(bytes.len() as u64)?;
        }
        if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
            return Err(io::Error::other("it is UTF-16; expected UTF-8"));
        }
        // Old scenes have comments in other encodings: what is not UTF-8 is replaced,
        // and an error only where it would mean something.
        let text = match String::from_utf8(bytes) {
            Ok(text) => text,
            Err(error) => {
                // A byte becomes three at most.
                budget.check(3 * error.as_bytes().len() as u64)?;
                String::from_utf8_lossy(error.as_bytes()).into_owned()
            }
        };
        held.grow((text.len() as u64).saturating_sub(held.bytes()))?;
        Ok((text, held))
    };
    read().map_err(|source| SceneError::Unreadable { path: path.to_path_buf(), location: location.cloned(), source })
}

/// Reads the spectra that are in files.
pub(super) fn read_spectra(params: &mut ParamList, directory: &Path, budget: &Arc<Budget>) -> Result<(), SceneError> {
    for param in &mut params.items {
        let Some(name) = param.text().filter(|name| param.kind == Kind::Spectrum && is_file(name)) else {
            continue;
        };
        let path = directory.join(name);
        let (text, _held) = read_text(&path, Some(&param.location), budget)?;
        // A digit and a blank at least are a number.
        let most = text.len().div_ceil(2) * size_of::<f64>();
        budget.check(most as u64).map_err(param.location.over())?;
        let numbers = numbers(&text).ok_or_else(|| {
            param.location.invalid(format!("{} is no spectrum; expected numbers, and # comments", path.display()))
        })?;
        param.set_numbers(numbers)?;
    }
    Ok(())
}

/// Whether the value of a spectrum names a file, as those that pbrt has by name do not.
fn is_file(name: &str) -> bool {
    Spectrum::named(name).is_none() && Path::new(name).extension().is_some()
}

/// The numbers of a file of pbrt's, with # comments.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let lines = text.split(['\n', '\r']).map(|line| line.split('#').next().unwrap_or_default());
    lines.flat_map(str::split_whitespace).map(|word| word.parse().ok().filter(|v: &f64| v.is_finite())).collect()
}
