//! Checkpoints: the bytes as a file, and as what a file expands to.
#![no_main]

use std::io::BufReader;

use flate2::Compression;
use flate2::bufread::GzEncoder;
use goblet::render::checkpoint::Checkpoint;
use goblet::base::input::Budget;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let budget = Budget::new(1 << 24);
    let _ = Checkpoint::decode(bytes, &budget);
    let _ = Checkpoint::decode(BufReader::new(GzEncoder::new(bytes, Compression::none())), &budget);
});
