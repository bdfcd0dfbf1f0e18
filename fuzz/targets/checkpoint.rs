//! Checkpoints: the bytes as a file, and as what a file expands to.
#![no_main]

use flate2::Compression;
use flate2::read::GzEncoder;
use goblet::checkpoint::Checkpoint;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = Checkpoint::decode(bytes);
    let _ = Checkpoint::decode(GzEncoder::new(bytes, Compression::none()));
});
