//! The files that a command writes: none may be one that it reads, or another that it writes.

use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};

use super::Failure;
use super::terminal;
use crate::scene::Scene;

/// What outputs are called in messages.
pub const AN_IMAGE: &str = "the image";
/// As above.
pub const THE_CHECKPOINT: &str = "the checkpoint";
/// As above.
pub const THE_STATISTICS: &str = "the statistics";

/// What a command reads, and what it is about to write.
#[derive(Default)]
pub struct Files {
    inputs: Vec<Named>,
    /// With what each is, as in "the image".
    outputs: Vec<(&'static str, Named)>,
}

/// A file, and what there is to say of it to who would replace it.
struct Named {
    fact: String,
    path: PathBuf,
    identity: Identity,
}

impl Files {
    /// Adds what the command reads; `what` is a noun, as in "the reference".
    pub fn reads(self, what: &str, path: &Path) -> Self {
        self.takes(&format!("this file is also {what}"), path)
    }

    /// Adds a file that a scene reads, or is in.
    pub fn reads_for_scene(self, path: &Path) -> Self {
        self.takes("the scene reads this file", path)
    }

    fn takes(mut self, fact: &str, path: &Path) -> Self {
        self.inputs.push(Named::new(fact.to_owned(), path));
        self
    }

    /// Adds a scene with all that it reads.
    pub fn reads_scene(self, path: &Path, scene: &Scene) -> Self {
        scene.inputs.iter().fold(self.reads_for_scene(path), |files, input| files.reads_for_scene(input))
    }

    /// Adds what the command writes.
    pub fn writes<'a>(mut self, what: &'static str, paths: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        let named = |path: &PathBuf| (what, Named::new(format!("this file is also {what}"), path));
        self.outputs.extend(paths.into_iter().map(named));
        self
    }

    /// Compares each output with each file that it could replace.
    ///
    /// # Errors
    /// Two are the same file, whatever their names.
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

/// What a file is, under whatever name.
struct Identity {
    /// Its device and number there; none where it does not exist.
    number: Option<(u64, u64)>,
    /// Without links, `.` and `..`.
    path: PathBuf,
    /// The same in small letters.
    folded: String,
}

/// As many links are followed as Linux does.
const MAX_LINKS: u32 = 40;

impl Identity {
    fn of(path: &Path) -> Self {
        let path = resolved(path, MAX_LINKS);
        let number = fs::metadata(&path).ok().and_then(|metadata| number(&metadata));
        let folded = path.to_string_lossy().to_lowercase();
        Self { number, path, folded }
    }

    /// Whether both may be one file. Two that exist say so themselves. Of others, file systems
    /// differ in whether letters' case tells them apart, and it is taken not to.
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

/// The standard library does not tell: paths decide.
#[cfg(not(unix))]
fn number(_: &Metadata) -> Option<(u64, u64)> {
    None
}

/// The file's path without links, also of a file that is not there yet, and of a link to one.
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

/// Outputs as they are written: one that fails stops none of the others.
#[derive(Default)]
pub struct Written {
    last: Option<Failure>,
}

impl Written {
    /// Takes note of an output.
    pub fn note(&mut self, written: Result<(), Failure>) {
        if let Err(failure) = written
            && let Some(before) = self.last.replace(failure)
        {
            terminal::fail(&before);
        }
    }

    /// Says what has failed.
    pub fn say(self) {
        if let Some(failure) = self.last {
            terminal::fail(&failure);
        }
    }

    /// The last failure; the others are said.
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
