//! Files that are replaced as a whole: after a crash, on a full disk and for every reader, a name stands for
//! the old file or for the whole new file.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

/// Temporary files are named `.goblet-RANDOM.tmp` and lie beside the file that they replace. One stays
/// there only if the process is killed while it writes; nothing reads it, and it can be deleted.
const PREFIX: &str = ".goblet-";
const SUFFIX: &str = ".tmp";

/// Replaces the file at `path` by a file that holds `bytes`.
///
/// # Errors
/// As [`Replacement::create`] and [`Replacement::commit`].
pub(crate) fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut replacement = Replacement::create(path)?;
    replacement.write_all(bytes)?;
    replacement.commit()
}

/// A new file that is to replace another: a temporary file in the same directory, which is deleted on
/// drop unless it is committed. It has the mode of the file that it replaces and, where the system
/// allows it, that file's owner and group.
pub(crate) struct Replacement {
    file: NamedTempFile,
    target: PathBuf,
}

impl Replacement {
    /// Creates an empty file that is to replace the one at `path`. A link at `path` is followed: the
    /// file behind it is replaced.
    ///
    /// # Errors
    /// The directory does not exist or takes no new file, or at `path` there is something that is
    /// read-only or not a file.
    pub fn create(path: &Path) -> io::Result<Self> {
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let existing = fs::metadata(&target).ok();
        if let Some(existing) = &existing {
            if existing.is_dir() {
                return Err(io::Error::other("it exists and is a directory, not a file"));
            }
            if !existing.is_file() {
                return Err(io::Error::other("it exists and is not a file"));
            }
            // A rename would replace it all the same.
            if existing.permissions().readonly() {
                return Err(io::Error::other("it exists and is read-only"));
            }
        }
        let directory = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let file = create_temporary(directory, existing.is_some()).map_err(|reason| {
            let directory = directory.display();
            io::Error::new(reason.kind(), format!("directory {directory}: {reason}"))
        })?;
        if let Some(existing) = existing {
            take_permissions(file.as_file(), &existing)?;
        }
        Ok(Self { file, target })
    }

    /// Puts the file in its place, once all of it is on the disk.
    ///
    /// # Errors
    /// The disk or the directory takes no more.
    pub fn commit(self) -> io::Result<()> {
        // Without this, a power cut after the rename could leave an empty file.
        self.file.as_file().sync_all()?;
        self.file.persist(self.target)?;
        Ok(())
    }
}

impl Write for Replacement {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.as_file_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_file_mut().flush()
    }
}

/// Creates a temporary file. It has the usual mode of a new file; one that replaces another can be
/// read by its owner alone, until it gets the other's mode.
fn create_temporary(directory: &Path, replaces: bool) -> io::Result<NamedTempFile> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    if replaces {
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    }
    #[cfg(not(unix))]
    let _ = replaces;
    Builder::new().prefix(PREFIX).suffix(SUFFIX).make_in(directory, |path| options.open(path))
}

/// Gives a file the mode of another and, where the system allows it, that one's owner and group.
fn take_permissions(file: &File, existing: &fs::Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        // Only the superuser gives files away; others may choose among their own groups.
        let _ = fchown(file, Some(existing.uid()), Some(existing.gid()))
            .or_else(|_| fchown(file, None, Some(existing.gid())));
    }
    // Some file systems have no modes.
    match file.set_permissions(existing.permissions()) {
        Err(reason) if reason.kind() != io::ErrorKind::Unsupported => Err(reason),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_as_a_whole_and_nothing_else_is_left() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("x");
        replace(&path, b"old").unwrap();
        let mut replacement = Replacement::create(&path).unwrap();
        replacement.write_all(b"new").unwrap();
        let temporary = replacement.file.path().file_name().unwrap().to_str().unwrap().to_owned();
        assert!(temporary.starts_with(PREFIX) && temporary.ends_with(SUFFIX), "{temporary}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        replacement.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        // One that is not committed, too.
        Replacement::create(&path).unwrap().write_all(b"never").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed() {
        let directory = tempfile::tempdir().unwrap();
        let [path, link] = ["x", "link"].map(|name| directory.path().join(name));
        replace(&path, b"old").unwrap();
        std::os::unix::fs::symlink("x", &link).unwrap();
        replace(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }

    #[test]
    fn the_error_names_the_directory() {
        let directory = tempfile::tempdir().unwrap();
        let missing = directory.path().join("missing");
        let error = replace(&missing.join("x"), b"").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        let text = error.to_string();
        assert!(text.starts_with(&format!("directory {}: ", missing.display())) && !text.contains(PREFIX), "{text}");
    }

    #[cfg(unix)]
    #[test]
    fn a_mode_survives_its_file() {
        use std::os::unix::fs::PermissionsExt;
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("x");
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o7777;
        let beside = directory.path().join("beside");
        fs::write(&beside, "").unwrap();
        replace(&path, b"x").unwrap();
        assert_eq!(mode(&path), mode(&beside), "a new file has the usual mode");
        for private in [0o640, 0o600, 0o664, 0o755] {
            fs::set_permissions(&path, fs::Permissions::from_mode(private)).unwrap();
            let replacement = Replacement::create(&path).unwrap();
            assert_eq!(mode(replacement.file.path()), private, "while it is written");
            replacement.commit().unwrap();
            assert_eq!(mode(&path), private, "{private:o}");
        }
        // Before it has the other's mode, nobody else may read what could be private.
        let temporary = create_temporary(directory.path(), true).unwrap();
        assert_eq!(mode(temporary.path()) & 0o077, 0);
    }
}
