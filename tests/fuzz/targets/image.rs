//! Image files of every format that is read: the first byte says which.
#![no_main]

use std::sync::LazyLock;

use goblet::base::input::Budget;
use goblet::image::file::{Transfer, Use, read_layers};
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));

const EXTENSIONS: [&str; 6] = ["exr", "png", "jpg", "tga", "pfm", "hdr"];
/// So that one input takes little time.
const MEMORY: u64 = 1 << 24;

fuzz_target!(|parts: (u8, &[u8])| {
    let (format, bytes) = parts;
    let extension = EXTENSIONS[usize::from(format) % EXTENSIONS.len()];
    let path = FOLDER.path().join(format!("fuzz.{extension}"));
    std::fs::write(&path, bytes).expect("a file");
    let of = if format < 128 { Use::Light } else { Use::Reflectance };
    if let Ok(layers) = read_layers(&path, Transfer::Srgb, of, &Budget::new(MEMORY)) {
        assert_eq!(layers.image.pixels.len(), layers.image.width as usize * layers.image.height as usize);
    }
});
