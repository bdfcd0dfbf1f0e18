//! OpenEXR files.

use std::io::Cursor;

use exr::meta::{MetaData, header::Header};
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, Text, Vec2};
use glam::DVec2;

use super::source::{Layers, RGBA_BYTES, Source, convert, opaque, with_alpha};
use crate::base::color::{Primaries, srgb_from_xyz};
use crate::image::film::{Image, Window};

/// The channels that are read.
enum Channels {
    /// Red, green and blue; alpha if there.
    Rgb([Text; 3], Option<Text>),
    /// CIE XYZ; alpha if there.
    Xyz([Text; 3], Option<Text>),
    /// One channel, which becomes grey.
    Grey(Text),
}

/// Decodes the channels that [`super::read_layers`] names, in the data window.
///
/// # Errors
/// The bytes are not an EXR, or have other channels; the message says which.
pub(super) fn decode(source: &Source) -> Result<Layers, String> {
    let bytes = source.bytes;
    let headers = MetaData::read_from_buffered(bytes, false).map_err(|error| error.to_string())?.headers;
    // Before the reader allocates what the header asks for.
    for header in &headers {
        source.check_size(header.layer_size.0 as u64, header.layer_size.1 as u64, RGBA_BYTES)?;
    }
    let flat: Vec<&Header> = headers.iter().filter(|header| !header.deep).collect();
    let (header, channels) = choose(&flat)?;
    if let Some(channel) = header.channels.list.iter().find(|channel| channel.sampling != Vec2(1, 1)) {
        return Err(format!("its channel {} has fewer samples than the image has pixels", channel.name));
    }
    let mut layers = match &channels {
        Channels::Rgb(names, alpha) | Channels::Xyz(names, alpha) => {
            catch_panic(|| decode_three(bytes, names, alpha.as_ref()))?
        }
        Channels::Grey(name) => catch_panic(|| decode_one(bytes, name))?,
    };
    let to_srgb = match channels {
        Channels::Rgb(..) => primaries(header).map_or(Ok(None), |primaries| source.of.to_srgb(&primaries))?,
        Channels::Xyz(..) => Some(srgb_from_xyz()),
        Channels::Grey(_) => None,
    };
    if let Some(matrix) = to_srgb {
        convert(&mut layers.image, matrix);
    }
    layers.window = window(header);
    Ok(layers)
}

/// Returns the first part with channels that make an image, and these channels.
fn choose<'a>(headers: &[&'a Header]) -> Result<(&'a Header, Channels), String> {
    let with = |names: [&str; 3]| {
        headers
            .iter()
            .find_map(|header| Some((*header, three(header, |name| names.iter().position(|it| name == *it))?)))
    };
    if let Some((header, names)) = with(["R", "G", "B"]) {
        return Ok((header, Channels::Rgb(names, find(header, "A"))));
    }
    if let Some((header, names)) = with(["X", "Y", "Z"]) {
        return Ok((header, Channels::Xyz(names, find(header, "A"))));
    }
    if let Some((header, name)) = headers.iter().find_map(|header| Some((*header, find(header, "Y")?))) {
        if find(header, "RY").or(find(header, "BY")).is_some() {
            return Err("its channels are luminance and chroma: Y, RY, BY".to_owned());
        }
        return Ok((header, Channels::Grey(name)));
    }
    let all: Vec<(&Header, String)> =
        headers.iter().flat_map(|h| h.channels.list.iter().map(|channel| (*h, channel.name.to_string()))).collect();
    let layer_of = |(header, name): &(&'a Header, String)| {
        let layer = name.strip_suffix(".R")?.to_owned();
        let names = three(header, |it| ["R", "G", "B"].iter().position(|end| it == format!("{layer}.{end}")))?;
        Some((*header, names, layer))
    };
    let mut layers: Vec<_> = all.iter().filter_map(layer_of).collect();
    if layers.len() > 1 {
        let names: Vec<String> = layers.into_iter().map(|(_, _, layer)| layer).collect();
        return Err(format!("its layers are {}: which of them is the image is not said", names.join(", ")));
    }
    if let Some((header, names, layer)) = layers.pop() {
        return Ok((header, Channels::Rgb(names, find(header, &format!("{layer}.A")))));
    }
    match &all[..] {
        [(header, name)] => find(header, name).map(|name| (*header, Channels::Grey(name))),
        _ => None,
    }
    .ok_or_else(|| {
        let names: Vec<String> = all.into_iter().map(|(_, name)| name).collect();
        format!("its channels are {}", names.join(", "))
    })
}

/// Returns three channels of a part: those to which `place` gives the places 0, 1 and 2.
fn three(header: &Header, place: impl Fn(&str) -> Option<usize>) -> Option<[Text; 3]> {
    let mut found = [None, None, None];
    for channel in &header.channels.list {
        if let Some(place) = place(&channel.name.to_string()) {
            found[place] = Some(channel.name.clone());
        }
    }
    let [first, second, third] = found;
    Some([first?, second?, third?])
}

fn find(header: &Header, name: &str) -> Option<Text> {
    let channel = header.channels.list.iter().find(|channel| channel.name.as_slice() == name.as_bytes())?;
    Some(channel.name.clone())
}

fn primaries(header: &Header) -> Option<Primaries> {
    let file = header.shared_attributes.chromaticities?;
    let [red, green, blue, white] =
        [file.red, file.green, file.blue, file.white].map(|Vec2(x, y)| DVec2::new(x.into(), y.into()));
    Some(Primaries { red, green, blue, white })
}

/// Returns the position of the data window in the display window.
fn window(header: &Header) -> Option<Window> {
    let display = header.shared_attributes.display_window;
    let at = header.own_attributes.layer_position;
    let first = [at.0.checked_sub(display.position.0)?, at.1.checked_sub(display.position.1)?];
    Some(Window { first, full: [u32::try_from(display.size.0).ok()?, u32::try_from(display.size.1).ok()?] })
}

/// Makes a panic an error: the `exr` crate (1.74) panics on some damaged B44 blocks. It must decode on this
/// thread, since a panic on one of its own aborts the process.
fn catch_panic(decode: impl FnOnce() -> Result<Layers, String>) -> Result<Layers, String> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err("its pixel data is damaged".to_owned()))
}

fn decode_three(bytes: &[u8], [first, second, third]: &[Text; 3], alpha: Option<&Text>) -> Result<Layers, String> {
    // Without alpha, a name that the file does not have.
    let alpha = alpha.cloned().unwrap_or_else(|| Text::from("no alpha"));
    exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required(first.clone())
        .required(second.clone())
        .required(third.clone())
        .optional(alpha, 1.0f32)
        .collect_pixels(
            |size, _| (black(size), vec![1.0; size.area()]),
            |(image, alpha): &mut (Image, Vec<f32>), at, (r, g, b, a): (f32, f32, f32, f32)| {
                set(image, at, [r, g, b]);
                if let Some(alpha) = alpha.get_mut(at.1 * image.width as usize + at.0) {
                    *alpha = a;
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map(|file| file.layer_data.channel_data.pixels)
        .map(|(image, alpha)| with_alpha(image, alpha))
        .map_err(|error| error.to_string())
}

fn decode_one(bytes: &[u8], name: &Text) -> Result<Layers, String> {
    exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required(name.clone())
        .collect_pixels(|size, _| black(size), |image: &mut Image, at, (y,): (f32,)| set(image, at, [y; 3]))
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map(|file| opaque(file.layer_data.channel_data.pixels))
        .map_err(|error| error.to_string())
}

fn black(size: Vec2<usize>) -> Image {
    // `decode` has checked that both fit into 32 bits.
    Image::new(size.0 as u32, size.1 as u32)
}

fn set(image: &mut Image, at: Vec2<usize>, value: [f32; 3]) {
    let index = at.1 * image.width as usize + at.0;
    if let Some(pixel) = image.pixels.get_mut(index) {
        *pixel = value;
    }
}
