//! Files that others have written: they are read only if they are files, and what is read of
//! them takes no more memory than a budget.

use std::cell::Cell;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use goblet_host::machine_memory;

/// Memory that a scene, or an image by itself, may take once it is read.
///
/// A few kilobytes can ask for any amount: by a gzip stream, by a header, by subdivision. Whoever
/// makes something large asks for its memory first. What holds the scene on the device, and what
/// a render adds, comes on top.
#[derive(Debug)]
pub struct Budget {
    limit: u64,
    taken: Cell<u64>,
}

/// The least that a scene may take, unless something else is asked for.
const LEAST: u64 = 1 << 30;
/// The share of the machine's memory that a scene may take.
const SHARE: u64 = 16;

impl Default for Budget {
    /// A sixteenth of the machine's memory where that is known (on Linux), and at least 1 GiB.
    fn default() -> Self {
        Self::new(machine_memory().map_or(LEAST, |bytes| LEAST.max(bytes / SHARE)))
    }
}

impl Budget {
    /// Of so many bytes.
    pub fn new(limit: u64) -> Self {
        Self { limit, taken: Cell::new(0) }
    }

    /// Takes memory that is kept for as long as the scene.
    ///
    /// # Errors
    /// There is not so much left.
    pub fn take(&self, bytes: u64) -> Result<(), OverBudget> {
        self.check(bytes)?;
        self.taken.set(self.taken.get() + bytes);
        Ok(())
    }

    /// Makes sure that there is memory for what is needed for a moment.
    ///
    /// # Errors
    /// There is not so much left.
    pub fn check(&self, bytes: u64) -> Result<(), OverBudget> {
        let needed = self.taken.get().saturating_add(bytes);
        if needed > self.limit { Err(OverBudget { needed, limit: self.limit }) } else { Ok(()) }
    }

    /// Bytes that are left.
    pub fn left(&self) -> u64 {
        self.limit - self.taken.get()
    }

    /// Gives back what was taken and is not needed any more.
    pub fn give_back(&self, bytes: u64) {
        self.taken.set(self.taken.get().saturating_sub(bytes));
    }
}

/// What is read needs more memory than it may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub struct OverBudget {
    /// Bytes that would be taken in all.
    pub needed: u64,
    /// Bytes that may be taken.
    pub limit: u64,
}

impl fmt::Display for OverBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [needed, limit] = [self.needed, self.limit].map(|bytes| bytes as f64 / f64::from(1 << 20));
        write!(f, "{needed:.0} MiB of memory are needed in all; expected at most {limit:.0} MiB")
    }
}

impl From<OverBudget> for io::Error {
    fn from(over: OverBudget) -> Self {
        Self::other(over)
    }
}

/// Opens what is a file: a pipe may never begin, and a device may never end.
///
/// # Errors
/// It is something else, or cannot be opened.
pub fn open(path: &Path) -> io::Result<File> {
    let kind = fs::metadata(path)?.file_type();
    if kind.is_dir() {
        return Err(io::Error::other("it is a folder; expected a file"));
    }
    if !kind.is_file() {
        return Err(io::Error::other("it is a pipe or a device; expected a file"));
    }
    File::open(path)
}

/// All of a file.
///
/// # Errors
/// It is no file, cannot be read, or is longer than the budget has bytes left.
pub fn read(path: &Path, budget: &Budget) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    budget.check(file.metadata()?.len())?;
    read_to_end(file, budget)
}

/// All of a stream.
///
/// # Errors
/// It cannot be read, or is longer than the budget has bytes left.
pub fn read_to_end(stream: impl Read, budget: &Budget) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let most = budget.left().saturating_add(1);
    stream.take(most).read_to_end(&mut bytes)?;
    budget.check(bytes.len() as u64)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_over_the_budget_is_not_taken() {
        let budget = Budget::new(100);
        budget.take(60).unwrap();
        assert_eq!(budget.take(41), Err(OverBudget { needed: 101, limit: 100 }));
        assert_eq!(budget.check(u64::MAX), Err(OverBudget { needed: u64::MAX, limit: 100 }));
        assert_eq!(budget.left(), 40);
        budget.give_back(10);
        budget.take(50).unwrap();
        assert!(Budget::default().left() >= LEAST);
    }

    #[test]
    fn streams_end_where_the_budget_does() {
        let budget = Budget::new(100);
        assert_eq!(read_to_end(&[7; 100][..], &budget).unwrap().len(), 100);
        assert!(read_to_end(io::repeat(0), &budget).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn only_files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
        for path in [link.as_path(), folder.path(), Path::new("/dev/null")] {
            let error = read(path, &Budget::default()).unwrap_err();
            assert!(error.to_string().ends_with("expected a file"), "{error}");
        }
    }
}
