//! Images to files and back; the file's extension chooses the format.
//!
//! EXR keeps the linear floats and the metadata, PNG is for looking at. A file is replaced as a
//! whole, so that a write that fails or is interrupted leaves the previous image as it was. The same
//! image and metadata give the same bytes.

mod attribute;
mod read;

use std::io::{self, Cursor};
use std::path::{Path, PathBuf};

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, IntegerBounds, Layer, LayerAttributes, SmallVec, Vec2,
    WritableImage,
};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

use crate::base::host_memory;
use crate::base::output::{Replacement, replace};
use crate::image::estimate::Sum;
use crate::image::film::{Image, Window, picture};
pub use attribute::Attribute;
pub use read::{Layers, Transfer, Use, read, read_layers};

/// Why an image file could not be read or written; says which file.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The extension is not that of a supported format.
    #[error(
        "{}: the extension names no image format; supported are {supported}",
        .path.display()
    )]
    Extension {
        /// The file.
        path: PathBuf,
        /// The extensions of supported formats.
        supported: &'static str,
    },
    /// The file could not be opened or read.
    #[error("{}: cannot read the image: {reason}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        reason: io::Error,
    },
    /// The file is not an image of its format.
    #[error("{}: expected {expected}: {reason}", .path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// The format, and what it must hold.
        expected: &'static str,
        /// What is wrong with the file.
        reason: String,
    },
    /// The file could not be created or written.
    #[error("{}: cannot write the image: {reason}", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The error of the operating system, or what is at the path.
        reason: io::Error,
    },
    /// The image or its metadata cannot be expressed in the format.
    #[error("{}: cannot encode the image: {reason}", .path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// The part that the format cannot express.
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

/// Returns whether the extension is that of a format for looking at, whose 8 bits a channel depend on the exposure.
#[must_use]
pub fn is_picture(path: &Path) -> bool {
    matches!(WriteFormat::of(path), Ok(WriteFormat::Png))
}

/// Returns the extension in lower case; empty if there is none.
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

/// Checks, before a long render, that [`write`] can write to a path: the extension is known, and the
/// directory exists and takes a new file.
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
    /// Its name, by convention `layer.X`, as in `standardError.Y`.
    pub name: String,
    /// A value for each pixel of the image.
    pub values: Vec<f32>,
}

/// Writes an image, atomically: `path` holds the old file or the whole new one.
///
/// EXR stores 32-bit floats (channels R, G, B), which are negative for colours outside of
/// sRGB's gamut, the chromaticities of sRGB, and each metadata pair as an attribute.
/// PNG stores the image's [`picture`], and no metadata.
///
/// # Errors
/// When the extension is unknown, the image's shape or a metadata key cannot be
/// expressed, or the file cannot be written.
pub fn write(path: &Path, image: &Image, metadata: &[(String, Attribute)]) -> Result<(), ImageError> {
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
    metadata: &[(String, Attribute)],
) -> Result<(), ImageError> {
    let format = WriteFormat::of(path)?;
    let room = encoding_bytes([image.width, image.height]) + 4 * channels.len() as u64 * image.pixels.len() as u64;
    host_memory::check("an image file", room).map_err(|reason| write_error(path, io::Error::other(reason)))?;
    let encoded = image.check_shape().map_err(|shape| shape.to_string()).and_then(|()| match format {
        WriteFormat::Exr => encode_exr(image, window, channels, metadata),
        WriteFormat::Png => encode_png(image),
    });
    let bytes = encoded.map_err(|reason| ImageError::Encode { path: path.to_owned(), reason })?;
    replace(path, &bytes).map_err(|reason| write_error(path, reason))
}

/// Estimates the bytes of host memory that it takes to make a file from an image's sums and those of its layers, in
/// groups of four.
pub(crate) fn host_bytes(resolution: [u32; 2], layer_groups: u64) -> u64 {
    let sums = (size_of::<[Sum; 4]>() + size_of::<[f32; 3]>()) as u64;
    // Of each layer the file has four copies: the plane, its bytes in order, those compressed, and the whole file.
    let layers = layer_groups * (size_of::<[Sum; 4]>() + 4 * size_of::<[f32; 4]>()) as u64;
    pixels(resolution) * (sums + layers) + encoding_bytes(resolution)
}

/// Estimates the part of these bytes for the file: the planes, their bytes in order, those compressed, and
/// the whole file.
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
    metadata: &[(String, Attribute)],
) -> Result<Vec<u8>, String> {
    let [x, y] = window.first;
    let mut attributes = LayerAttributes { layer_position: Vec2(x, y), ..LayerAttributes::default() };
    attribute::add(&mut attributes, metadata)?;
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
    exr.attributes.chromaticities = Some(attribute::chromaticities());
    exr.write().to_buffered(&mut file).map_err(|error| error.to_string())?;
    let mut bytes = file.into_inner();
    attribute::sort(&mut bytes).ok_or("the EXR header is malformed")?;
    Ok(bytes)
}

fn rgb_channels(image: &Image) -> SmallVec<[AnyChannel<FlatSamples>; 4]> {
    let plane = |channel: usize| {
        let samples = image.pixels.iter().map(|pixel| pixel[channel]).collect();
        AnyChannel::new(["R", "G", "B"][channel], FlatSamples::F32(samples))
    };
    (0..3).map(plane).collect()
}

/// Returns the bytes of a PNG file.
///
/// # Errors
/// The error of the encoder.
pub(crate) fn encode_png(image: &Image) -> Result<Vec<u8>, String> {
    let mut file = Vec::new();
    PngEncoder::new(&mut file)
        .write_image(&picture(image), image.width, image.height, ExtendedColorType::Rgb8)
        .map_err(|error| error.to_string())?;
    Ok(file)
}

#[cfg(test)]
mod tests;
