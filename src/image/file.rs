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

use crate::base::room;
use crate::image::estimate::Sum;
use crate::image::film::{Image, Window, picture};
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

/// The extensions that [`write()`] accepts.
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

/// Checks, before a long render, that [`write()`] will be able to: the extension is
/// known, and the directory exists and takes a new file.
///
/// # Errors
/// The error that [`write()`] would return.
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

/// As [`write()`], of an image that may be a part of a larger one, and with further channels. EXR
/// has both: the part is its data window, the larger image its display window, as pbrt writes
/// them. PNG leaves them out.
///
/// # Errors
/// As [`write()`].
pub fn write_part(
    path: &Path,
    image: &Image,
    window: &Window,
    channels: &[Channel],
    metadata: &[(String, String)],
) -> Result<(), ImageError> {
    let format = WriteFormat::of(path)?;
    let room = encoding_bytes([image.width, image.height]) + 4 * channels.len() as u64 * image.pixels.len() as u64;
    room::check("an image file", room).map_err(|reason| write_error(path, io::Error::other(reason)))?;
    let encoded = image.check_shape().map_err(|shape| shape.to_string()).and_then(|()| match format {
        WriteFormat::Exr => encode_exr(image, window, channels, metadata),
        WriteFormat::Png => encode_png(image),
    });
    let bytes = encoded.map_err(|reason| ImageError::Encode { path: path.to_owned(), reason })?;
    replace(path, &bytes).map_err(|reason| write_error(path, reason))
}

/// Bytes of host memory, about, from an image's sums to its file.
pub(crate) fn host_bytes(resolution: [u32; 2]) -> u64 {
    let sums = size_of::<[Sum; 4]>() + size_of::<[f32; 3]>();
    pixels(resolution) * sums as u64 + encoding_bytes(resolution)
}

/// Of these, those for making a file: the planes, their bytes in order, compressed, and the whole.
fn encoding_bytes(resolution: [u32; 2]) -> u64 {
    pixels(resolution) * 4 * size_of::<[f32; 3]>() as u64
}

fn pixels(resolution: [u32; 2]) -> u64 {
    resolution.map(u64::from).iter().product()
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

/// Writes a file, atomically: `path` holds the old file or the whole new one.
pub(crate) fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut replacement = Replacement::create(path)?;
    replacement.file.write_all(bytes)?;
    replacement.commit()
}

/// A new file beside its final place; removed again unless it is committed. It has the mode of the
/// file that it replaces, and where possible its owner and group.
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
        let existing = fs::metadata(&target).ok();
        if let Some(existing) = &existing {
            if existing.is_dir() {
                return Err(io::Error::other("it exists and is a directory, not a file"));
            }
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
        let (file, temporary) = create_temporary(directory, &target, existing.is_some()).map_err(|reason| {
            let directory = directory.display();
            io::Error::new(reason.kind(), format!("directory {directory}: {reason}"))
        })?;
        let replacement = Self { file, temporary, target };
        if let Some(existing) = existing {
            replacement.be_like(&existing)?;
        }
        Ok(replacement)
    }

    /// Takes over who may do what with a file.
    fn be_like(&self, existing: &fs::Metadata) -> io::Result<()> {
        #[cfg(unix)]
        {
            use std::os::unix::fs::{MetadataExt, fchown};
            // Only the superuser gives files away; a group may be any of one's own.
            let _ = fchown(&self.file, Some(existing.uid()), Some(existing.gid()))
                .or_else(|_| fchown(&self.file, None, Some(existing.gid())));
        }
        // Some file systems have no modes.
        match self.file.set_permissions(existing.permissions()) {
            Err(reason) if reason.kind() != io::ErrorKind::Unsupported => Err(reason),
            _ => Ok(()),
        }
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
/// process it is of, so that nobody else writes to it, however many share the directory. A
/// private one is of its owner alone until it is given another mode.
fn create_temporary(directory: &Path, target: &Path, is_private: bool) -> io::Result<(File, PathBuf)> {
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
    let mut options = OpenOptions::new();
    #[cfg(unix)]
    if is_private {
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    }
    let file = options.write(true).create_new(true).open(&path)?;
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
mod tests;
