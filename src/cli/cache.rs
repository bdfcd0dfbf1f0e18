//! The user's folder for compiled kernels, and devices that use it.

use std::ffi::OsString;
use std::path::PathBuf;

use goblet_host::Device;

use crate::render::device::{self, DeviceOptions};

/// The variable that names another folder; empty, it turns the cache off.
const VARIABLE: &str = "GOBLET_CACHE";

/// Opens the device that `selector` names, or the first that can render, with the user's folder for compiled
/// kernels.
///
/// # Errors
/// There is no such device, it cannot render, or the validation layers are wanted and not installed.
pub fn open_device(selector: Option<&str>, validation: bool) -> goblet_host::Result<Device> {
    let cache = folder();
    device::open_device(&DeviceOptions { selector, validation, cache: cache.as_deref(), arrays: None })
}

/// Returns the folder for compiled kernels: the one that [`VARIABLE`] names, or that of this user. `None` if
/// there is none.
pub fn folder() -> Option<PathBuf> {
    // Unit tests run commands in their own process. The user's folder is not theirs.
    if cfg!(test) { None } else { from_environment(|name| std::env::var_os(name)) }
}

fn from_environment(value: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    if let Some(named) = value(VARIABLE) {
        return (!named.is_empty()).then(|| named.into());
    }
    // A relative path would be another folder for each working directory.
    let path = |name| value(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let caches = if cfg!(windows) {
        path("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        path("HOME").map(|home| home.join("Library/Caches"))
    } else {
        path("XDG_CACHE_HOME").or_else(|| path("HOME").map(|home| home.join(".cache")))
    };
    caches.map(|caches| caches.join("goblet"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(variables: &[(&str, &str)]) -> Option<PathBuf> {
        let value = |name: &str| variables.iter().find(|(other, _)| *other == name).map(|(_, value)| value.into());
        from_environment(value)
    }

    #[test]
    fn a_folder_that_is_named_comes_first_and_an_empty_name_is_none() {
        let home = [("HOME", "/home/x"), ("LOCALAPPDATA", "C:\\x")];
        assert_eq!(found(&[&home[..], &[(VARIABLE, "here")]].concat()), Some("here".into()));
        assert_eq!(found(&[&home[..], &[(VARIABLE, "")]].concat()), None);
        assert_eq!(found(&[]), None);
    }

    #[cfg(all(unix, not(target_os = "macos")))]
    #[test]
    fn the_folder_is_that_of_the_xdg_specification() {
        let home = ("HOME", "/home/x");
        assert_eq!(found(&[home]), Some("/home/x/.cache/goblet".into()));
        assert_eq!(found(&[home, ("XDG_CACHE_HOME", "/caches")]), Some("/caches/goblet".into()));
        for invalid in ["", "relative"] {
            assert_eq!(found(&[home, ("XDG_CACHE_HOME", invalid)]), Some("/home/x/.cache/goblet".into()));
        }
        assert_eq!(found(&[("HOME", "")]), None);
    }
}
