//! The pictures of a report: each render beside the reference, with a slider between them, and their difference.

use std::error::Error;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::imageops::{FilterType, resize};
use image::{ExtendedColorType, ImageEncoder, RgbImage};
use maud::{Markup, PreEscaped, html};

use crate::image::difference::{Difference, DifferenceMap, Scale};
use crate::image::exposure::exposed;
use crate::image::film::{Image, Window, picture};

/// The page shows the pictures of this many settings.
pub const SHOWN: usize = 32;
/// Pictures with more pixels are JPEGs.
const PNG_PIXELS: u32 = 1 << 16;
/// Longer sides are shrunk to this many pixels: the files beside the page have all pixels.
const LONGEST_SIDE: u32 = 800;
/// Quality of JPEGs in percent.
const QUALITY: u8 = 90;
/// Colours of a scale on the page.
const STOPS: u8 = 20;

/// The last image of a setting.
pub struct LastImage<'a> {
    /// The image.
    pub image: &'a Image,
    /// Its window in the full image.
    pub window: Window,
    /// Its difference from the reference; `None` if it cannot be measured.
    pub difference: Option<DifferenceMap>,
}

/// Returns a scale for all differences, by which they can be compared: that of the setting in the middle.
pub fn common_scale(differences: &[&DifferenceMap]) -> Scale {
    let mut ends: Vec<f64> = differences.iter().map(|difference| difference.scale().most).collect();
    ends.sort_by(f64::total_cmp);
    Scale::new(Difference::Signed, ends.get(ends.len() / 2).copied().unwrap_or(1.0))
}

/// The style by which all sliders share one copy of the reference.
pub fn reference_style(reference: &Image, stops: f32) -> Result<Markup, Box<dyn Error>> {
    let url = data_url(reference.width, reference.height, picture(&exposed(reference, stops)))?;
    let size = format!("{}/{}", reference.width, reference.height);
    Ok(PreEscaped(format!(".reference{{background-image:url({url})}}.picture{{aspect-ratio:{size}}}")))
}

/// The render of a setting and the reference, with a slider between them.
pub fn slider(name: &str, image: &Image, stops: f32) -> Result<Markup, Box<dyn Error>> {
    let source = data_url(image.width, image.height, picture(&exposed(image, stops)))?;
    Ok(html! {
        figure {
            div.slide {
                img.picture.(pixels(image.width)) alt=(format!("render with {name}")) src=(source);
                div.picture.reference.(pixels(image.width)) role="img" aria-label="reference" {}
                span.tag.left { "render" }
                span.tag.right { "reference" }
                input type="range" min="0" max="100" step="0.1" value="50"
                    aria-label=(format!("how much of the render with {name} is shown, in percent"));
            }
            figcaption { "Left of the line: the render. Right of it: the reference." }
        }
    })
}

/// The difference of a setting from the reference, in false colours.
pub fn difference(name: &str, map: &DifferenceMap, scale: &Scale) -> Result<Markup, Box<dyn Error>> {
    let source = data_url(map.width, map.height, map.picture(scale))?;
    Ok(html! {
        figure {
            img.picture.map.(pixels(map.width)) alt=(format!("difference of {name} from the reference")) src=(source);
            (bar(scale))
            figcaption {
                "Relative difference of luminance: blue is too dark, white is equal, red is too bright, green is not finite."
            }
        }
    })
}

/// A scale with its values.
fn bar(scale: &Scale) -> Markup {
    let [least, most] = scale.ends();
    let stop = |i: u8| {
        let at = f64::from(i) / f64::from(STOPS);
        let [r, g, b] = scale.color((least + at * (most - least)) as f32);
        format!("rgb({r},{g},{b})")
    };
    let stops: Vec<String> = (0..=STOPS).map(stop).collect();
    html! {
        div.scale role="img" aria-label=(format!("scale from {least} to {most}")) {
            div.bar style=(format!("background:linear-gradient(to right,{})", stops.join(","))) {}
            @for (value, text) in scale.ticks() {
                span style=(format!("left:{:.2}%", 100.0 * scale.place(value))) { (text) }
            }
        }
    }
}

/// The class of a picture: pixels of small ones are shown as squares.
fn pixels(width: u32) -> &'static str {
    if width < 400 { "squares" } else { "smooth" }
}

/// Returns a picture of three bytes a pixel as a URL that contains it.
fn data_url(width: u32, height: u32, bytes: Vec<u8>) -> Result<String, Box<dyn Error>> {
    let mut encoded = Vec::new();
    if u64::from(width) * u64::from(height) <= u64::from(PNG_PIXELS) {
        PngEncoder::new(&mut encoded).write_image(&bytes, width, height, ExtendedColorType::Rgb8)?;
        return Ok(format!("data:image/png;base64,{}", STANDARD.encode(&encoded)));
    }
    let mut picture = RgbImage::from_raw(width, height, bytes).ok_or("a picture of another size")?;
    let longest = width.max(height);
    if longest > LONGEST_SIDE {
        let side = |side: u32| (u64::from(side) * u64::from(LONGEST_SIDE) / u64::from(longest)).max(1) as u32;
        picture = resize(&picture, side(width), side(height), FilterType::Triangle);
    }
    JpegEncoder::new_with_quality(&mut encoded, QUALITY).encode_image(&picture)?;
    Ok(format!("data:image/jpeg;base64,{}", STANDARD.encode(&encoded)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_pictures_are_small_files() {
        let noise = |pixels: u32| (0..3 * pixels).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        let small = data_url(128, 128, noise(128 * 128)).unwrap();
        assert!(small.starts_with("data:image/png;base64,") && small.len() > 60_000, "{}", small.len());
        let large = data_url(1600, 400, noise(1600 * 400)).unwrap();
        let bytes = STANDARD.decode(large.strip_prefix("data:image/jpeg;base64,").unwrap()).unwrap();
        let decoded = image::load_from_memory(&bytes).unwrap();
        assert_eq!((decoded.width(), decoded.height()), (800, 200));
        assert!(bytes.len() < 300_000, "{}", bytes.len());
    }

    #[test]
    fn one_scale_is_for_all() {
        let map = |most: f32| DifferenceMap { kind: Difference::Signed, width: 1, height: 1, values: vec![most] };
        let maps = [map(0.2), map(-50.0), map(0.01)];
        assert_eq!(common_scale(&maps.iter().collect::<Vec<_>>()), Scale::new(Difference::Signed, 0.2));
        assert_eq!(common_scale(&[]), Scale::new(Difference::Signed, 1.0));
        let bar = bar(&Scale::new(Difference::Signed, 0.2)).into_string();
        assert!(bar.contains("<span style=\"left:50.00%\">0</span>") && bar.contains("rgb(255,255,255)"), "{bar}");
    }
}
