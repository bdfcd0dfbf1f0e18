//! What was measured, on what and when: every report of a measurement names it.

use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

use goblet_host::DeviceInfo;
use serde::Serialize;

/// What was measured, on what and when.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// Version of goblet.
    pub goblet: &'static str,
    /// What the sources are at; null where git does not say.
    pub commit: Option<String>,
    /// Day and time, UTC.
    pub date: String,
    /// Name of the device.
    pub device: String,
    /// Its driver, with version.
    pub driver: String,
    /// Threads that the system says can run at once.
    pub cpus: Option<usize>,
}

impl Machine {
    /// This one, with a device of its.
    pub fn new(device: &DeviceInfo) -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self {
            goblet: env!("CARGO_PKG_VERSION"),
            commit: commit(),
            date: date(now.as_secs()),
            device: device.name.clone(),
            driver: device.driver.clone(),
            cpus: std::thread::available_parallelism().ok().map(usize::from),
        }
    }
}

fn commit() -> Option<String> {
    let git = Command::new("git").args(["-C", env!("CARGO_MANIFEST_DIR"), "rev-parse", "HEAD"]).output().ok()?;
    let text = String::from_utf8(git.stdout).ok()?.trim().to_owned();
    (git.status.success() && !text.is_empty()).then_some(text)
}

/// Year, month, day and time of day (UTC) of a Unix time.
fn date(seconds: u64) -> String {
    // Days of years that begin in March, so that a leap day is the last of its year.
    let days = seconds / 86_400 + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    let [hour, minute] = [seconds / 3_600 % 24, seconds / 60 % 60];
    format!("{:04}-{month:02}-{day:02} {hour:02}:{minute:02} UTC", 400 * era + year + next)
}
