//! Reads files that are not trusted: only regular files, and within a budget of memory.

use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use goblet_host::machine_memory;

/// A limit for the memory of a scene, or of a single image.
///
/// A file of a few kilobytes can ask for any amount of memory: by a gzip stream, a header, or subdivision.
/// So code that makes something large takes its memory from the budget first. The budget also limits the
/// bytes that are read of all files together, since a scene can include files or expand objects without
/// end. The memory of a render itself is not part of it.
#[derive(Debug)]
pub struct Budget {
    limit: u64,
    /// Bytes that are taken for as long as the scene.
    kept: AtomicU64,
    /// Bytes that are taken while the scene is read.
    held: AtomicU64,
    /// Bytes that will be taken once the scene is read.
    packed: AtomicU64,
    read: AtomicU64,
    /// The option that raises the limit, for messages.
    option: Option<&'static str>,
}

/// The least default limit in bytes.
const LEAST: u64 = 1 << 30;
/// The default limit is the machine's memory divided by this.
const SHARE: u64 = 16;

impl Default for Budget {
    /// Returns a budget of a sixteenth of the machine's memory where that is known (on Linux), and at least
    /// 1 GiB.
    fn default() -> Self {
        static MACHINE: OnceLock<Option<u64>> = OnceLock::new();
        Self::new(MACHINE.get_or_init(machine_memory).map_or(LEAST, |bytes| LEAST.max(bytes / SHARE)))
    }
}

impl Budget {
    /// Returns a budget of `limit` bytes.
    pub fn new(limit: u64) -> Self {
        let [kept, held, packed, read] = std::array::from_fn(|_| AtomicU64::new(0));
        Self { limit, kept, held, packed, read, option: None }
    }

    /// Makes messages say that this option raises the limit.
    #[must_use]
    pub fn raised_by(mut self, option: &'static str) -> Self {
        self.option = Some(option);
        self
    }

    /// Returns a budget with the same limit, of which nothing is taken.
    pub fn anew(&self) -> Self {
        Self { option: self.option, ..Self::new(self.limit) }
    }

    /// Takes memory that is kept for as long as the scene.
    ///
    /// # Errors
    /// The budget has less left.
    pub fn take(&self, bytes: u64) -> Result<(), OverBudget> {
        self.check(bytes)?;
        self.fits(self.once_read(), bytes, Need::Memory)?;
        self.kept.fetch_add(bytes, Ordering::Relaxed);
        Ok(())
    }

    /// Takes memory that is needed once the scene is read, and not while it is.
    ///
    /// # Errors
    /// The budget will have less left.
    pub fn take_later(&self, bytes: u64) -> Result<(), OverBudget> {
        self.fits(self.once_read(), bytes, Need::Memory)?;
        self.packed.fetch_add(bytes, Ordering::Relaxed);
        Ok(())
    }

    fn once_read(&self) -> u64 {
        self.kept.load(Ordering::Relaxed) + self.packed.load(Ordering::Relaxed)
    }

    fn while_read(&self) -> u64 {
        self.kept.load(Ordering::Relaxed) + self.held.load(Ordering::Relaxed)
    }

    /// Takes memory until the returned value is dropped.
    ///
    /// # Errors
    /// The budget has less left.
    pub fn hold(self: &Arc<Self>, bytes: u64) -> Result<Held, OverBudget> {
        let mut held = Held { budget: Arc::clone(self), bytes: 0 };
        held.grow(bytes)?;
        Ok(held)
    }

    /// Checks that the budget has this memory left, without taking it.
    ///
    /// # Errors
    /// The budget has less left.
    pub fn check(&self, bytes: u64) -> Result<(), OverBudget> {
        self.fits(self.while_read(), bytes, Need::Memory)
    }

    /// Counts bytes that are read of files, or that are expanded again as if they were read again.
    ///
    /// # Errors
    /// All bytes that were read are more than the limit.
    pub fn read(&self, bytes: u64) -> Result<(), OverBudget> {
        self.fits(self.read.load(Ordering::Relaxed), bytes, Need::Reading)?;
        self.read.fetch_add(bytes, Ordering::Relaxed);
        Ok(())
    }

    fn fits(&self, before: u64, bytes: u64, need: Need) -> Result<(), OverBudget> {
        let needed = before.saturating_add(bytes);
        if needed <= self.limit {
            return Ok(());
        }
        Err(OverBudget { need, needed, limit: self.limit, option: self.option })
    }

    /// Returns the bytes that are left.
    pub fn left(&self) -> u64 {
        self.limit.saturating_sub(self.while_read())
    }

    /// Gives back memory that was taken by [`take`](Self::take).
    pub fn give_back(&self, bytes: u64) {
        self.kept.fetch_sub(bytes.min(self.kept.load(Ordering::Relaxed)), Ordering::Relaxed);
    }
}

/// Memory that is given back when this is dropped.
#[derive(Debug)]
pub struct Held {
    budget: Arc<Budget>,
    bytes: u64,
}

impl Held {
    /// Takes more memory.
    ///
    /// # Errors
    /// The budget has less left.
    pub fn grow(&mut self, bytes: u64) -> Result<(), OverBudget> {
        self.budget.check(bytes)?;
        self.budget.held.fetch_add(bytes, Ordering::Relaxed);
        self.bytes += bytes;
        Ok(())
    }

    /// Returns its budget.
    pub fn budget(&self) -> &Arc<Budget> {
        &self.budget
    }

    /// Gives memory back; at most all.
    pub fn shrink(&mut self, bytes: u64) {
        let bytes = bytes.min(self.bytes);
        self.budget.held.fetch_sub(bytes, Ordering::Relaxed);
        self.bytes -= bytes;
    }

    /// Returns the bytes that it has taken.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Counts its bytes as read once more.
    ///
    /// # Errors
    /// All bytes that were read are more than the limit.
    pub fn read_again(&self) -> Result<(), OverBudget> {
        self.budget.read(self.bytes)
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.shrink(self.bytes);
    }
}

/// The use of a budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// Memory is taken.
    Memory,
    /// Bytes are read.
    Reading,
}

/// A budget is exceeded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub struct OverBudget {
    /// The use.
    pub need: Need,
    /// Bytes that are needed in all.
    pub needed: u64,
    /// The limit in bytes.
    pub limit: u64,
    /// The option that raises the limit.
    pub option: Option<&'static str>,
}

impl fmt::Display for OverBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [needed, limit] = [self.needed, self.limit].map(|bytes| bytes as f64 / f64::from(1 << 20));
        match self.need {
            Need::Memory => write!(f, "{needed:.0} MiB of memory are needed in all")?,
            Need::Reading => write!(f, "{needed:.0} MiB are to be read in all, repetitions included")?,
        }
        write!(f, "; expected at most {limit:.0} MiB")?;
        match self.option {
            Some(option) => write!(f, " ({option} allows more)"),
            None => Ok(()),
        }
    }
}

impl From<OverBudget> for io::Error {
    fn from(over: OverBudget) -> Self {
        Self::other(over)
    }
}

/// Opens a regular file. Others are refused: a pipe may never begin, and a device may never end.
///
/// # Errors
/// It is not a regular file, or cannot be opened.
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

/// Returns the contents of a file.
///
/// # Errors
/// It is not a regular file, cannot be read, or is longer than the budget has bytes left.
pub fn read(path: &Path, budget: &Budget) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    budget.check(file.metadata()?.len())?;
    read_to_end(file, budget)
}

/// Returns the rest of a stream.
///
/// # Errors
/// It cannot be read, or is longer than the budget has bytes left.
pub fn read_to_end(stream: impl Read, budget: &Budget) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let most = budget.left().saturating_add(1);
    stream.take(most).read_to_end(&mut bytes)?;
    budget.check(bytes.len() as u64)?;
    budget.read(bytes.len() as u64)?;
    Ok(bytes)
}

/// A stream whose bytes a budget counts as they are read.
pub struct Counted<'a, R> {
    /// The stream.
    pub stream: R,
    /// The budget.
    pub budget: &'a Budget,
}

impl<R: Read> Read for Counted<'_, R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let count = self.stream.read(into)?;
        self.budget.read(count as u64)?;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_over_the_budget_is_not_taken() {
        let budget = Arc::new(Budget::new(100));
        budget.take(60).unwrap();
        assert_eq!(budget.take(41).unwrap_err().needed, 101);
        assert_eq!(budget.check(u64::MAX).unwrap_err().needed, u64::MAX);
        assert_eq!(budget.left(), 40);
        let mut held = budget.hold(30).unwrap();
        held.grow(5).unwrap();
        assert!(held.grow(6).is_err());
        assert_eq!(budget.left(), 5);
        drop(held);
        assert_eq!(budget.left(), 40);
        budget.give_back(10);
        budget.take(50).unwrap();
        assert_eq!(budget.left(), 0);
        assert!(Budget::default().left() >= LEAST);
    }

    #[test]
    fn what_is_packed_takes_the_place_of_what_is_held() {
        let budget = Arc::new(Budget::new(100));
        budget.take(20).unwrap();
        let held = budget.hold(70).unwrap();
        budget.take_later(75).unwrap();
        assert!(budget.take_later(6).is_err());
        assert!(budget.take(6).is_err());
        budget.take(5).unwrap();
        drop(held);
        assert_eq!(budget.left(), 75);
        assert!(budget.take(1).is_err());
    }

    #[test]
    fn streams_end_where_the_budget_does() {
        let budget = Budget::new(100);
        assert_eq!(read_to_end(&[7; 100][..], &budget).unwrap().len(), 100);
        assert!(read_to_end(io::repeat(0), &budget).is_err());
        // All of it is read already.
        assert!(read_to_end(&[7; 1][..], &budget).is_err());
    }

    #[test]
    fn messages_say_what_raises_the_limit() {
        let error = Budget::new(1 << 20).raised_by("--more").check(3 << 20).unwrap_err().to_string();
        assert_eq!(error, "3 MiB of memory are needed in all; expected at most 1 MiB (--more allows more)");
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
