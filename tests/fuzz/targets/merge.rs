//! Two checkpoints that are to be merged, each as what its file expands to.
#![no_main]

use std::io::BufReader;

use flate2::Compression;
use flate2::bufread::GzEncoder;
use goblet::render::checkpoint::Checkpoint;
use goblet::base::input::Budget;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|parts: (&[u8], &[u8])| {
    let budget = Budget::new(1 << 24);
    let decode = |bytes| Checkpoint::decode(BufReader::new(GzEncoder::new(bytes, Compression::none())), &budget);
    if let (Ok(mut sum), Ok(other)) = (decode(parts.0), decode(parts.1)) {
        let _ = sum.merge(&other);
        let _ = sum.estimate.image();
        let _ = sum.estimate.relative_error();
    }
});
