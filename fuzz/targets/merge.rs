//! Two checkpoints that are to be merged, each as what its file expands to.
#![no_main]

use flate2::Compression;
use flate2::read::GzEncoder;
use goblet::checkpoint::Checkpoint;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|parts: (&[u8], &[u8])| {
    let decode = |bytes| Checkpoint::decode(GzEncoder::new(bytes, Compression::none()));
    if let (Ok(mut sum), Ok(other)) = (decode(parts.0), decode(parts.1)) {
        let _ = sum.merge(&other);
        let _ = sum.estimate.image();
        let _ = sum.estimate.relative_error();
    }
});
