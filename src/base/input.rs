//! Files that others have written: they are read only if they are files, and what is read of
//! them takes no more memory than a budget.

use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use goblet_host::machine_memory;

/// Memory that a scene, or an image by itself, may take once it is read.
///
/// A few kilobytes can ask for any amount: by a gzip stream, by a header, by subdivision. Whoever
/// makes something large asks for its memory first. Nor may more bytes be read than that, of all
/// files together: what is inherited, included or expanded again and again never ends. What a
/// render adds comes on top.
#[derive(Debug)]
pub struct Budget {
    limit: u64,
    /// For as long as the scene.
    kept: AtomicU64,
    /// While it is read.
    held: AtomicU64,
    /// Once it is read.
    packed: AtomicU64,
    read: AtomicU64,
    /// What raises the limit, for messages.
    option: Option<&'static str>,
}

/// The least that a scene may take, unless something else is asked for.
const LEAST: u64 = 1 << 30;
/// The share of the machine's memory that a scene may take.
const SHARE: u64 = 16;

impl Default for Budget {
    /// A sixteenth of the machine's memory where that is known (on Linux), and at least 1 GiB.
    fn default() -> Self {
        static MACHINE: OnceLock<Option<u64>> = OnceLock::new();
        Self::new(MACHINE.get_or_init(machine_memory).map_or(LEAST, |bytes| LEAST.max(bytes / SHARE)))
    }
}

impl Budget {
    /// Of so many bytes.
    pub fn new(limit: u64) -> Self {
        let [kept, held, packed, read] = std::array::from_fn(|_| AtomicU64::new(0));
        Self { limit, kept, held, packed, read, option: None }
    }

    /// Messages say that this option raises the limit.
    #[must_use]
    pub fn raised_by(mut self, option: &'static str) -> Self {
        self.option = Some(option);
        self
    }

    /// As large a one, of which nothing is taken.
    pub fn anew(&self) -> Self {
        Self { option: self.option, ..Self::new(self.limit) }
    }

    /// Takes memory that is kept for as long as the scene.
    ///
    /// # Errors
    /// There is not so much left.
    pub fn take(&self, bytes: u64) -> Result<(), OverBudget> {
        self.check(bytes)?;
        self.fits(self.once_read(), bytes, Need::Memory)?;
        self.kept.fetch_add(bytes, Ordering::Relaxed);
        Ok(())
    }

    /// Takes memory that is kept, but for which there is need only once all is read.
    ///
    /// # Errors
    /// There will not be so much left.
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

    /// Takes memory until what is returned is dropped.
    ///
    /// # Errors
    /// There is not so much left.
    pub fn hold(self: &Arc<Self>, bytes: u64) -> Result<Held, OverBudget> {
        let mut held = Held { budget: Arc::clone(self), bytes: 0 };
        held.grow(bytes)?;
        Ok(held)
    }

    /// Makes sure that there is memory for what is needed for a moment.
    ///
    /// # Errors
    /// There is not so much left.
    pub fn check(&self, bytes: u64) -> Result<(), OverBudget> {
        self.fits(self.while_read(), bytes, Need::Memory)
    }

    /// Counts bytes of files that are read, or of what is as if it were read again.
    ///
    /// # Errors
    /// They are more than the memory that may be taken.
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

    /// Bytes that are left.
    pub fn left(&self) -> u64 {
        self.limit.saturating_sub(self.while_read())
    }

    /// Gives back what was taken and is not needed any more.
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
    /// Takes some more.
    ///
    /// # Errors
    /// There is not so much left.
    pub fn grow(&mut self, bytes: u64) -> Result<(), OverBudget> {
        self.budget.check(bytes)?;
        self.budget.held.fetch_add(bytes, Ordering::Relaxed);
        self.bytes += bytes;
        Ok(())
    }

    /// The budget that it is of.
    pub fn budget(&self) -> &Arc<Budget> {
        &self.budget
    }

    /// Gives some of it back.
    pub fn shrink(&mut self, bytes: u64) {
        let bytes = bytes.min(self.bytes);
        self.budget.held.fetch_sub(bytes, Ordering::Relaxed);
        self.bytes -= bytes;
    }

    /// Bytes that it has taken.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Counts it as read once more.
    ///
    /// # Errors
    /// More is read than may be.
    pub fn read_again(&self) -> Result<(), OverBudget> {
        self.budget.read(self.bytes)
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.shrink(self.bytes);
    }
}

/// What is asked of a budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// To take memory.
    Memory,
    /// To read.
    Reading,
}

/// What is read needs more memory than it may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub struct OverBudget {
    /// What is needed.
    pub need: Need,
    /// Bytes that would be needed in all.
    pub needed: u64,
    /// Bytes that may be.
    pub limit: u64,
    /// What raises the limit.
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
    budget.read(bytes.len() as u64)?;
    Ok(bytes)
}

/// A stream that is read bit by bit, of which a budget counts each.
pub struct Counted<'a, R> {
    /// The stream.
    pub stream: R,
    /// What counts.
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
