//! Spectra from files.

use std::path::Path;
use std::sync::Arc;

use crate::base::input::Budget;
use crate::scene::format::error::SceneError;
use crate::scene::format::files::read_text;
use crate::scene::format::kind::Kind;
use crate::scene::format::params::ParamList;
use crate::scene::spectrum::Spectrum;

/// Replaces each spectrum parameter that names a file by the numbers in the file.
pub(in crate::scene) fn read_spectra(
    params: &mut ParamList,
    directory: &Path,
    budget: &Arc<Budget>,
) -> Result<(), SceneError> {
    for param in &mut params.items {
        let Some(name) = param.text().filter(|name| param.kind == Kind::Spectrum && is_file(name)) else {
            continue;
        };
        let path = directory.join(name);
        let (text, _held) = read_text(&path, Some(&param.location), budget)?;
        // A number takes at least two bytes: a digit and a blank.
        let most = text.len().div_ceil(2) * size_of::<f64>();
        budget.check(most as u64).map_err(param.location.over())?;
        let numbers = numbers(&text).ok_or_else(|| {
            param.location.invalid(format!("{} is no spectrum; expected numbers, and # comments", path.display()))
        })?;
        param.set_numbers(numbers)?;
    }
    Ok(())
}

/// Returns true if the value of a spectrum names a file: it has an extension, and pbrt has no spectrum of
/// that name.
fn is_file(name: &str) -> bool {
    Spectrum::named(name).is_none() && Path::new(name).extension().is_some()
}

/// Returns the numbers of a spectrum file, without its # comments; `None` if a word is not a finite number.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let lines = text.split(['\n', '\r']).map(|line| line.split('#').next().unwrap_or_default());
    lines.flat_map(str::split_whitespace).map(|word| word.parse().ok().filter(|v: &f64| v.is_finite())).collect()
}
