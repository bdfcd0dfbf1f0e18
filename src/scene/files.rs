//! The files that a scene names.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;

use super::error::{Location, SceneError};
use super::params::{ParamList, Values};
use super::registry::Kind;
use super::spectrum::Spectrum;

/// The folder that a scene's file names are relative to.
pub(crate) fn directory(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// The same for every way to name a file.
pub(crate) fn identity(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
}

/// The longest text that is read: a device file or a gzip bomb never ends.
const MAX_TEXT: u64 = 1 << 30;

/// The text of a file, gzipped or not.
pub(super) fn read_text(path: &Path, location: Option<&Location>) -> Result<String, SceneError> {
    let unreadable = |source| SceneError::Unreadable { path: path.to_path_buf(), location: location.cloned(), source };
    let file = fs::File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    file.take(MAX_TEXT + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.starts_with(&[0x1f, 0x8b]) {
        let mut expanded = Vec::new();
        let mut decoder = MultiGzDecoder::new(&bytes[..]).take(MAX_TEXT + 1);
        decoder.read_to_end(&mut expanded).map_err(unreadable)?;
        bytes = expanded;
    }
    if bytes.len() as u64 > MAX_TEXT {
        let what = format!("it holds more than {MAX_TEXT} bytes of text");
        return Err(unreadable(io::Error::other(what)));
    }
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(unreadable(io::Error::other("it is UTF-16; expected UTF-8")));
    }
    // Old scenes have comments in other encodings: what is not UTF-8 is replaced,
    // and an error only where it would mean something.
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Reads the spectra that are in files.
pub(super) fn read_spectra(params: &mut ParamList, directory: &Path) -> Result<(), SceneError> {
    for param in &mut params.items {
        let Some(name) = param.text().filter(|name| param.kind == Kind::Spectrum && is_file(name)) else {
            continue;
        };
        let path = directory.join(name);
        let text = read_text(&path, Some(&param.location))?;
        let numbers = numbers(&text).ok_or_else(|| {
            param.location.invalid(format!("{} is no spectrum; expected numbers, and # comments", path.display()))
        })?;
        param.values = Values::Numbers(numbers);
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
