//! The files of a command. A file that the command writes must not be one that it reads, nor another file
//! that it writes.

use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};

use super::Failure;
use super::terminal;
use crate::scene::Scene;

/// The name of image outputs in messages.
pub const AN_IMAGE: &str = "the image";
/// The name of the checkpoint in messages.
pub const THE_CHECKPOINT: &str = "the checkpoint";
/// The name of the statistics in messages.
pub const THE_STATISTICS: &str = "the statistics";

/// The files that a command reads, and the files that it will write.
#[derive(Default)]
pub struct Files {
    inputs: Vec<Named>,
    /// Each output with its name in messages, as in "the image".
    outputs: Vec<(&'static str, Named)>,
}

/// A file, with the reason why it must not be replaced.
struct Named {
    fact: String,
    path: PathBuf,
    identity: Identity,
}

impl Files {
    /// Adds a file that the command reads. `what` is its name in messages, as in "the reference".
    pub fn reads(self, what: &str, path: &Path) -> Self {
        self.takes(&format!("this file is also {what}"), path)
    }

    /// Adds a scene file, or a file that a scene reads.
    pub fn reads_for_scene(self, path: &Path) -> Self {
        self.takes("the scene reads this file", path)
    }

    fn takes(mut self, fact: &str, path: &Path) -> Self {
        self.inputs.push(Named::new(fact.to_owned(), path));
        self
    }

    /// Adds a scene file and all files that the scene reads.
    pub fn reads_scene(self, path: &Path, scene: &Scene) -> Self {
        scene.inputs.iter().fold(self.reads_for_scene(path), |files, input| files.reads_for_scene(input))
    }

    /// Adds files that the command writes. `what` is their name in messages.
    pub fn writes<'a>(mut self, what: &'static str, paths: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        let named = |path: &PathBuf| (what, Named::new(format!("this file is also {what}"), path));
        self.outputs.extend(paths.into_iter().map(named));
        self
    }

    /// Compares each output with each input and each other output.
    ///
    /// # Errors
    /// Two of them are the same file, even if their names differ.
    pub fn check(&self) -> Result<(), Failure> {
        for (i, (what, output)) in self.outputs.iter().enumerate() {
            let others = self.inputs.iter().chain(self.outputs[..i].iter().map(|(_, other)| other));
            if let Some(other) = others.into_iter().find(|other| output.identity.may_be(&other.identity)) {
                return Err(Failure::SameFile {
                    path: output.path.clone(),
                    fact: other.fact.clone(),
                    other: other.path.clone(),
                    what,
                });
            }
        }
        Ok(())
    }
}

impl Named {
    fn new(fact: String, path: &Path) -> Self {
        Self { fact, path: path.to_owned(), identity: Identity::of(path) }
    }
}

/// The identity of a file, which does not depend on the name by which it is given.
struct Identity {
    /// The numbers of its device and its inode; `None` if the file does not exist.
    number: Option<(u64, u64)>,
    /// The path without links, `.` and `..`.
    path: PathBuf,
    /// The path in lower case.
    folded: String,
}

/// The largest number of links that are followed, as on Linux.
const MAX_LINKS: u32 = 40;

impl Identity {
    fn of(path: &Path) -> Self {
        let path = resolved(path, MAX_LINKS);
        let number = fs::metadata(&path).ok().and_then(|metadata| number(&metadata));
        let folded = path.to_string_lossy().to_lowercase();
        Self { number, path, folded }
    }

    /// Returns whether both may be the same file. If both exist, their numbers decide. Else their paths are
    /// compared without regard to case, because some file systems ignore case.
    fn may_be(&self, other: &Self) -> bool {
        match (self.number, other.number) {
            (Some(number), Some(other)) => number == other,
            _ => self.path == other.path || self.folded == other.folded,
        }
    }
}

#[cfg(unix)]
fn number(metadata: &Metadata) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    Some((metadata.dev(), metadata.ino()))
}

/// The standard library has no such numbers here, so paths decide.
#[cfg(not(unix))]
fn number(_: &Metadata) -> Option<(u64, u64)> {
    None
}

/// Returns the path of a file without links. The file, or the target of a link, need not exist.
fn resolved(path: &Path, links: u32) -> PathBuf {
    if let Ok(path) = fs::canonicalize(path) {
        return path;
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let folder = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
    let path = path.file_name().map_or_else(|| path.to_owned(), |name| folder.join(name));
    match fs::read_link(&path) {
        Ok(target) if links > 0 => resolved(&folder.join(target), links - 1),
        _ => path,
    }
}

/// The results of writing several outputs. A failed output does not stop the others.
#[derive(Default)]
pub struct Written {
    last: Option<Failure>,
}

impl Written {
    /// Notes the result of an output. An earlier failure is printed when another one follows.
    pub fn note(&mut self, written: Result<(), Failure>) {
        if let Err(failure) = written
            && let Some(before) = self.last.replace(failure)
        {
            terminal::fail(&before);
        }
    }

    /// Prints the last failure, if there is one.
    pub fn say(self) {
        if let Some(failure) = self.last {
            terminal::fail(&failure);
        }
    }

    /// Returns the last failure; the earlier ones are already printed.
    ///
    /// # Errors
    /// An output has failed.
    pub fn end(self) -> Result<(), Failure> {
        self.last.map_or(Ok(()), Err)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether an output of this name is refused beside an input `tex.png`, which exists, and an
    /// output `new.exr`, which does not.
    fn is_refused(folder: &Path, name: &str) -> bool {
        let new = [folder.join("new.exr"), folder.join(name)];
        Files::default().reads("the texture", &folder.join("tex.png")).writes("an image", &new).check().is_err()
    }

    #[test]
    fn files_are_told_apart_by_what_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        fs::write(folder.join("tex.png"), "texture").unwrap();
        fs::create_dir(folder.join("sub")).unwrap();
        fs::write(folder.join("apart.png"), "other").unwrap();
        for name in ["tex.png", "./tex.png", "sub/../tex.png", "new.exr", "NEW.EXR", "sub/../New.exr", "Tex.PNG"] {
            assert!(is_refused(folder, name), "{name}");
        }
        for name in ["apart.png", "tex.exr", "new.png", "sub/tex.png", "sub/new.exr"] {
            assert!(!is_refused(folder, name), "{name}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_are_what_they_lead_to() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        fs::write(folder.join("tex.png"), "texture").unwrap();
        fs::hard_link(folder.join("tex.png"), folder.join("hard.png")).unwrap();
        for (target, link) in
            [("tex.png", "soft.png"), ("new.exr", "dangling.exr"), ("dangling.exr", "twice.exr"), (".", "sub")]
        {
            symlink(target, folder.join(link)).unwrap();
        }
        symlink("round.exr", folder.join("round.exr")).unwrap();
        for name in ["hard.png", "soft.png", "dangling.exr", "twice.exr", "sub/tex.png", "sub/new.exr"] {
            assert!(is_refused(folder, name), "{name}");
        }
        assert!(!is_refused(folder, "round.exr"));
        // Where names that differ in case are two files, both may be used.
        fs::write(folder.join("Tex.png"), "other").unwrap();
        if fs::read(folder.join("tex.png")).unwrap() == b"texture" {
            assert!(!is_refused(folder, "Tex.png"));
        }
    }
}
