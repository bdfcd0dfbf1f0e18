//! The machine and the time of a measurement. Every report contains them.

use goblet_host::DeviceInfo;
use jiff::Timestamp;
use serde::Serialize;

/// On what and when a measurement was made.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// Version of goblet.
    pub goblet: &'static str,
    /// The commit from which goblet was built; null for a debug build, and for sources that are not in
    /// a git repository.
    pub commit: Option<&'static str>,
    /// Day and time, UTC.
    pub date: String,
    /// Name of the device.
    pub device: String,
    /// Name and version of its driver.
    pub driver: String,
    /// Threads that can run at once; null where the system does not tell.
    pub cpus: Option<usize>,
}

impl Machine {
    /// Describes this machine and a device of it, now.
    pub fn new(device: &DeviceInfo) -> Self {
        Self {
            goblet: env!("CARGO_PKG_VERSION"),
            commit: option_env!("GOBLET_COMMIT"),
            date: Timestamp::now().strftime("%Y-%m-%d %H:%M UTC").to_string(),
            device: device.name.clone(),
            driver: device.driver.clone(),
            cpus: std::thread::available_parallelism().ok().map(usize::from),
        }
    }
}

#[cfg(test)]
mod tests {
    use jiff::civil;

    use super::*;

    #[test]
    fn a_machine_says_when_and_with_which_build_it_measured() {
        let device = goblet_host::DeviceInfo {
            index: 0,
            name: "d".to_owned(),
            driver: "v".to_owned(),
            kind: goblet_host::DeviceKind::Cpu,
            memory: goblet_host::DeviceMemory { total_bytes: 1, free_bytes: 1 },
            max_buffer_bytes: 1,
            max_image_rows: 1,
            arrays: goblet_host::ArrayKind::Images,
            arrays_reason: String::new(),
            keeps_infinities: false,
            subgroups: goblet_host::Subgroups::default(),
            unfit: None,
        };
        let machine = Machine::new(&device);
        let date = civil::DateTime::strptime("%Y-%m-%d %H:%M UTC", &machine.date).unwrap();
        assert!(date.year() >= 2024, "{machine:?}");
        assert!(machine.commit.is_none_or(|commit| commit.len() >= 40 && commit.is_ascii()), "{machine:?}");
    }
}
