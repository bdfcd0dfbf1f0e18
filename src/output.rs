//! Images to files and back; the file's extension chooses the format.
//!
//! EXR keeps the linear floats and the metadata, PNG is for looking at. A file is
//! written beside its final place and renamed into it, so that an interrupted or
//! failed write never destroys the previous image. The same image and metadata
//! give the same bytes.

mod read;

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use exr::meta::attribute::AttributeValue;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, IntegerBounds, Layer, LayerAttributes, SmallVec, Text, Vec2,
    WritableImage,
};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

use crate::film::{Image, Window, picture};
pub use read::{Layers, Transfer, Use, read, read_layers};

/// Why an image file could not be read or written; says which file.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The extension names no format that is supported.
    #[error(
        "{}: the extension names no image format; supported are {supported}",
        .path.display()
    )]
    Extension {
        /// The file.
        path: PathBuf,
        /// The extensions that would do.
        supported: &'static str,
    },
    /// The file could not be opened or read.
    #[error("{}: cannot read the image: {reason}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        reason: io::Error,
    },
    /// The file was read, and is not an image of its format.
    #[error("{}: expected {expected}: {reason}", .path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// The format, and what it must hold.
        expected: &'static str,
        /// What was found instead.
        reason: String,
    },
    /// The file could not be created or written.
    #[error("{}: cannot write the image: {reason}", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system says, or what is in the way.
        reason: io::Error,
    },
    /// The image or its metadata cannot be expressed in the format.
    #[error("{}: cannot encode the image: {reason}", .path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What cannot be expressed.
        reason: String,
    },
}

/// The extensions that [`write`] accepts.
pub const WRITABLE_EXTENSIONS: &str = ".exr and .png";

#[derive(Clone, Copy)]
enum WriteFormat {
    Exr,
    Png,
}

impl WriteFormat {
    fn of(path: &Path) -> Result<Self, ImageError> {
        match extension(path).as_str() {
            "exr" => Ok(Self::Exr),
            "png" => Ok(Self::Png),
            _ => Err(ImageError::Extension { path: path.to_owned(), supported: WRITABLE_EXTENSIONS }),
        }
    }
}

/// The extension in lower case; empty when there is none.
fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Checks that the extension of an output names a format that can be written.
///
/// # Errors
/// [`ImageError::Extension`], with the extensions that can be.
pub fn check_extension(path: &Path) -> Result<(), ImageError> {
    WriteFormat::of(path).map(|_| ())
}

/// Checks, before a long render, that [`write`] will be able to: the extension is
/// known, and the directory exists and takes a new file.
///
/// # Errors
/// The error that [`write`] would return.
pub fn check_writable(path: &Path) -> Result<(), ImageError> {
    check_extension(path)?;
    Replacement::create(path).map(drop).map_err(|reason| write_error(path, reason))
}

/// A channel of an EXR besides the image.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// By convention `layer.X`, as in `standardError.Y`.
    pub name: String,
    /// As many as the image has pixels.
    pub values: Vec<f32>,
}

/// Writes an image, atomically: `path` holds the old file or the whole new one.
///
/// EXR stores 32-bit floats (channels R, G, B) and each metadata pair as an
/// attribute: a `double` if the value reads as a finite number, else a `string`.
/// PNG stores 8 bits in the sRGB transfer function, clamped to 0 to 1, with NaN as
/// black, and no metadata.
///
/// # Errors
/// When the extension is unknown, the image's shape or a metadata key cannot be
/// expressed, or the file cannot be written.
pub fn write(path: &Path, image: &Image, metadata: &[(String, String)]) -> Result<(), ImageError> {
    write_part(path, image, &Window::whole([image.width, image.height]), &[], metadata)
}

/// As [`write`], of an image that may be a part of a larger one, and with further channels. EXR
/// has both: the part is its data window, the larger image its display window, as pbrt writes
/// them. PNG leaves them out.
///
/// # Errors
/// As [`write`].
pub fn write_part(
    path: &Path,
    image: &Image,
    window: &Window,
    channels: &[Channel],
    metadata: &[(String, String)],
) -> Result<(), ImageError> {
    let format = WriteFormat::of(path)?;
    let encoded = image.check_shape().map_err(|shape| shape.to_string()).and_then(|()| match format {
        WriteFormat::Exr => encode_exr(image, window, channels, metadata),
        WriteFormat::Png => encode_png(image),
    });
    let bytes = encoded.map_err(|reason| ImageError::Encode { path: path.to_owned(), reason })?;
    Replacement::create(path)
        .and_then(|mut replacement| replacement.file.write_all(&bytes).and_then(|()| replacement.commit()))
        .map_err(|reason| write_error(path, reason))
}

fn write_error(path: &Path, reason: io::Error) -> ImageError {
    let path = path.to_owned();
    ImageError::Write { path, reason }
}

fn encode_exr(
    image: &Image,
    window: &Window,
    extra: &[Channel],
    metadata: &[(String, String)],
) -> Result<Vec<u8>, String> {
    let [x, y] = window.first;
    let mut attributes = LayerAttributes { layer_position: Vec2(x, y), ..LayerAttributes::default() };
    attributes.other.extend(exr_attributes(metadata)?);
    let size = (image.width as usize, image.height as usize);
    if extra.iter().any(|channel| channel.values.len() != image.pixels.len()) {
        return Err("a channel has not as many values as the image has pixels".to_owned());
    }
    let further =
        extra.iter().map(|Channel { name, values }| AnyChannel::new(name.as_str(), FlatSamples::F32(values.clone())));
    let channels = AnyChannels::sort(rgb_channels(image).into_iter().chain(further).collect());
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, channels);

    let mut file = Cursor::new(Vec::new());
    let mut exr = exr::prelude::Image::from_layer(layer);
    exr.attributes.display_window = IntegerBounds::new((0, 0), (window.full[0] as usize, window.full[1] as usize));
    exr.write().to_buffered(&mut file).map_err(|error| error.to_string())?;
    let mut bytes = file.into_inner();
    sort_exr_attributes(&mut bytes).ok_or("the EXR header is malformed")?;
    Ok(bytes)
}

fn rgb_channels(image: &Image) -> SmallVec<[AnyChannel<FlatSamples>; 4]> {
    let plane = |channel: usize| {
        let samples = image.pixels.iter().map(|pixel| pixel[channel]).collect();
        AnyChannel::new(["R", "G", "B"][channel], FlatSamples::F32(samples))
    };
    (0..3).map(plane).collect()
}

fn exr_attributes(metadata: &[(String, String)]) -> Result<BTreeMap<Text, AttributeValue>, String> {
    // The format allows UTF-8 in both, which the crate's own constructor does not.
    let text = |text: &str| Text::from_slice_unchecked(text.as_bytes());
    let mut attributes = BTreeMap::new();
    for (key, value) in metadata {
        if key.is_empty() || key.len() > 255 || key.contains('\0') {
            return Err(format!("the metadata key {key:?} must have 1 to 255 bytes, none of them zero"));
        }
        let attribute = match value.parse::<f64>() {
            Ok(number) if number.is_finite() => AttributeValue::F64(number),
            _ => AttributeValue::Text(text(value)),
        };
        if attributes.insert(text(key), attribute).is_some() {
            return Err(format!("the metadata key {key:?} occurs twice"));
        }
    }
    Ok(attributes)
}

/// Sorts the attributes of the header by name. The format leaves their order free,
/// and the `exr` crate writes that of a randomly seeded hash map, so that the same
/// image would give other bytes in every run. No offset changes.
///
/// `None` if the header does not have the form of a single-part file's.
fn sort_exr_attributes(file: &mut [u8]) -> Option<()> {
    const MAGIC_AND_VERSION: usize = 8;
    let text_end = |from: usize| Some(from + file.get(from..)?.iter().position(|&b| b == 0)?);

    let mut attributes = Vec::new();
    let mut start = MAGIC_AND_VERSION;
    while *file.get(start)? != 0 {
        let name_end = text_end(start)?;
        let type_end = text_end(name_end + 1)?;
        let size_bytes = file.get(type_end + 1..type_end + 5)?;
        let size = u32::from_le_bytes(size_bytes.try_into().ok()?) as usize;
        let end = type_end + 5 + size;
        attributes.push((file.get(start..name_end)?, file.get(start..end)?));
        start = end;
    }
    attributes.sort();
    let sorted: Vec<u8> = attributes.iter().flat_map(|(_, bytes)| bytes.iter().copied()).collect();
    file.get_mut(MAGIC_AND_VERSION..start)?.copy_from_slice(&sorted);
    Some(())
}

/// The bytes of a PNG file.
///
/// # Errors
/// What the encoder says.
pub(crate) fn encode_png(image: &Image) -> Result<Vec<u8>, String> {
    let mut file = Vec::new();
    PngEncoder::new(&mut file)
        .write_image(&picture(image), image.width, image.height, ExtendedColorType::Rgb8)
        .map_err(|error| error.to_string())?;
    Ok(file)
}

/// A new file beside its final place; removed again unless it is committed.
pub(crate) struct Replacement {
    /// What is to take the place, still empty.
    pub file: File,
    temporary: PathBuf,
    target: PathBuf,
}

impl Replacement {
    /// The directory of `path` must exist, and `path` not be a folder or read-only.
    pub fn create(path: &Path) -> io::Result<Self> {
        // Through a link, so that the file behind it is replaced and not the link.
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if let Ok(existing) = fs::metadata(&target) {
            if !existing.is_file() {
                return Err(io::Error::other("it exists and is not a file"));
            }
            // A rename would replace it all the same.
            if existing.permissions().readonly() {
                return Err(io::Error::other("it exists and is read-only"));
            }
        }
        let directory = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let (file, temporary) = create_temporary(directory, &target).map_err(|reason| {
            let directory = directory.display();
            io::Error::new(reason.kind(), format!("directory {directory}: {reason}"))
        })?;
        Ok(Self { file, temporary, target })
    }

    /// Puts the file, once written, in its place.
    pub fn commit(self) -> io::Result<()> {
        // Without this, a power cut after the rename could leave an empty file.
        self.file.sync_all()?;
        fs::rename(&self.temporary, &self.target)
    }
}

impl Drop for Replacement {
    fn drop(&mut self) {
        // After a commit there is nothing left to remove, and that is no error.
        let _ = fs::remove_file(&self.temporary);
    }
}

/// Creates a file to be renamed to `target`. Its name has a hash of the target and says which
/// process it is of, so that nobody else writes to it, however many share the directory.
fn create_temporary(directory: &Path, target: &Path) -> io::Result<(File, PathBuf)> {
    /// Tells this process from others with its number: containers begin at 1 again.
    static BEGUN: LazyLock<u128> =
        LazyLock::new(|| SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos()));
    static CREATED: AtomicU64 = AtomicU64::new(0);

    let mut hash = DefaultHasher::new();
    target.file_name().hash(&mut hash);
    let prefix = format!(".goblet-{:016x}-", hash.finish());
    let own = format!("{}-{:x}-", std::process::id(), *BEGUN);
    remove_leftovers(directory, &prefix, &own);
    let number = CREATED.fetch_add(1, Ordering::Relaxed);
    let path = directory.join(format!("{prefix}{own}{number}.tmp"));
    let file = OpenOptions::new().write(true).create_new(true).open(&path)?;
    Ok((file, path))
}

/// Removes what killed processes have left of the same target: a job that is preempted again
/// and again would fill the directory. Who still runs is known on Linux; elsewhere files stay.
///
/// A process of another machine looks dead as well. It then fails to put its file in the
/// place that two contend for, and nothing else is harmed.
fn remove_leftovers(directory: &Path, prefix: &str, own: &str) {
    let processes = Path::new("/proc");
    let known = processes.join("self").exists();
    let is_dead = |process: &str| {
        let (id, own_id) = (process.split('-').next(), own.split('-').next());
        !process.starts_with(own) && (id == own_id || (known && id.is_some_and(|id| !processes.join(id).exists())))
    };
    let Ok(entries) = fs::read_dir(directory) else { return };
    for entry in entries.flatten() {
        if entry.file_name().to_str().and_then(|name| name.strip_prefix(prefix)).is_some_and(is_dead) {
            // Another process may have been faster.
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::srgb_encode;
    use crate::input::Budget;

    fn extreme_image() -> Image {
        let pixels = vec![
            [0.0, -0.0, f32::MIN_POSITIVE],
            [1e-40, f32::MAX, -3.5],
            [f32::INFINITY, f32::NEG_INFINITY, f32::from_bits(0x7fc0_1234)],
            [0.25, 0.5, 0.75],
            [1.0, 2.0, 3.0],
            [0.1, 0.2, 0.3],
        ];
        Image::from_pixels(3, 2, pixels).unwrap()
    }

    fn bits(image: &Image) -> Vec<[u32; 3]> {
        image.pixels.iter().map(|p| p.map(f32::to_bits)).collect()
    }

    fn pairs(list: &[(&str, &str)]) -> Vec<(String, String)> {
        list.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect()
    }

    #[test]
    fn exr_keeps_every_bit_and_the_metadata() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("x.EXR");
        let image = extreme_image();
        let metadata = pairs(&[("scene", "Kelch ü 杯"), ("seed", "4294967295")]);
        write(&path, &image, &metadata).unwrap();
        let back = read(&path).unwrap();
        assert_eq!((back.width, back.height), (3, 2));
        assert_eq!(bits(&back), bits(&image));

        let headers = exr::meta::MetaData::read_from_file(&path, true).unwrap().headers;
        let stored = |key: &str| headers[0].own_attributes.other[&Text::from(key)].clone();
        assert_eq!(stored("seed"), AttributeValue::F64(4_294_967_295.0));
        let scene = Text::from_slice_unchecked("Kelch ü 杯".as_bytes());
        assert_eq!(stored("scene"), AttributeValue::Text(scene));
    }

    #[test]
    fn the_same_image_gives_the_same_bytes() {
        let keys: Vec<_> = (0..12).map(|i| (format!("key{i}"), i.to_string())).collect();
        let first = encode_exr(&extreme_image(), &Window::whole([3, 2]), &[], &keys).unwrap();
        for _ in 0..8 {
            assert!(encode_exr(&extreme_image(), &Window::whole([3, 2]), &[], &keys).unwrap() == first);
        }
    }

    #[test]
    fn an_exr_of_a_part_says_which_part() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("x.exr");
        let window = Window { first: [5, 7], full: [64, 48] };
        write_part(&path, &extreme_image(), &window, &[], &[]).unwrap();
        let header = exr::meta::MetaData::read_from_file(&path, true).unwrap().headers.remove(0);
        assert_eq!(header.own_attributes.layer_position, Vec2(5, 7));
        assert_eq!(header.layer_size, Vec2(3, 2));
        assert_eq!(header.shared_attributes.display_window, IntegerBounds::new((0, 0), (64, 48)));
        let back = read_layers(&path, Transfer::Srgb, Use::Light, &Budget::default()).unwrap();
        assert_eq!((bits(&back.image), back.window), (bits(&extreme_image()), Some(window)));
    }

    #[test]
    fn metadata_that_would_break_the_header_is_refused() {
        let long = "k".repeat(256);
        for keys in [&[""][..], &["a\0b"], &[&long], &["a", "a"], &["compression"]] {
            let metadata: Vec<_> = keys.iter().map(|&key| (key, "v")).collect();
            assert!(encode_exr(&extreme_image(), &Window::whole([3, 2]), &[], &pairs(&metadata)).is_err(), "{keys:?}");
        }
    }

    #[test]
    fn png_keeps_what_eight_bits_of_srgb_can() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("x.png");
        let ramp = (0..=500u16).map(|i| [f32::from(i) / 500.0; 3]).collect();
        let image = Image::from_pixels(501, 1, ramp).unwrap();
        write(&path, &image, &[]).unwrap();
        for (back, original) in read(&path).unwrap().pixels.iter().zip(&image.pixels) {
            let error = srgb_encode(back[1]) - srgb_encode(original[1]);
            assert!(error.abs() <= 0.5 / 255.0 + 1e-6, "{back:?} {original:?}");
        }
    }

    #[test]
    fn png_clamps_and_shows_nan_as_black() {
        let pixels = vec![[f32::NAN, f32::INFINITY, -1.0], [7.0, 1.0, 0.0]];
        let image = Image::from_pixels(2, 1, pixels).unwrap();
        let file = encode_png(&image).unwrap();
        let back = image::load_from_memory(&file).unwrap().into_rgb8();
        assert_eq!(back.as_raw(), &[0, 255, 0, 255, 255, 0]);
    }

    #[test]
    fn an_image_of_the_wrong_shape_is_an_error() {
        let mut image = extreme_image();
        image.pixels.pop();
        let directory = tempfile::tempdir().unwrap();
        for name in ["x.exr", "x.png"] {
            let result = write(&directory.path().join(name), &image, &[]);
            assert!(matches!(result, Err(ImageError::Encode { .. })), "{result:?}");
        }
    }

    #[test]
    fn writing_replaces_a_file_and_leaves_nothing_else() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("x.exr");
        write(&path, &Image::new(1, 1), &[]).unwrap();
        check_writable(&path).unwrap();
        write(&path, &extreme_image(), &[]).unwrap();
        assert_eq!(read(&path).unwrap().width, 3);
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
    }

    #[test]
    fn an_output_that_cannot_be_written_is_refused_before_the_render() {
        let directory = tempfile::tempdir().unwrap();
        let blocked = directory.path().join("blocked.exr");
        fs::create_dir(&blocked).unwrap();
        let read_only = directory.path().join("kept.png");
        write(&read_only, &Image::new(1, 1), &[]).unwrap();
        let mut permissions = fs::metadata(&read_only).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&read_only, permissions).unwrap();

        let missing = directory.path().join("missing/x.exr");
        for path in [missing, blocked, read_only] {
            let error = check_writable(&path).unwrap_err();
            assert!(matches!(error, ImageError::Write { .. }), "{error}");
        }
        let error = check_writable(&directory.path().join("x.tiff")).unwrap_err();
        assert!(error.to_string().ends_with("supported are .exr and .png"));
        check_writable(&directory.path().join("new.png")).unwrap();
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 2);
    }
}
