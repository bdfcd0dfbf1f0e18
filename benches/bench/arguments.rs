//! The command line.

use std::ffi::OsString;
use std::path::PathBuf;

use super::error::References;

pub const USAGE: &str = "bench [--quick] [--references A.exr B.exr] OUT_DIR";

pub struct Arguments {
    pub quick: bool,
    pub references: Option<References>,
    pub folder: PathBuf,
}

impl Arguments {
    /// Reads the references, too: a mistake in them should not be found out minutes later.
    pub fn parse(mut words: impl Iterator<Item = OsString>) -> Result<Self, String> {
        let mut quick = false;
        let mut references = None;
        let mut folder = None;
        while let Some(word) = words.next() {
            match word.to_str() {
                Some("--quick") => quick = true,
                Some("--references") => {
                    let (Some(a), Some(b)) = (words.next(), words.next()) else {
                        return Err("--references: expected two images".into());
                    };
                    references = Some(References::read([a.into(), b.into()])?);
                }
                Some(option) if option.starts_with('-') => return Err(format!("unknown option `{option}`")),
                _ if folder.is_some() => return Err(format!("one folder too many: {}", word.display())),
                _ => folder = Some(PathBuf::from(word)),
            }
        }
        let folder = folder.ok_or("expected a folder to write to")?;
        Ok(Self { quick, references, folder })
    }
}
