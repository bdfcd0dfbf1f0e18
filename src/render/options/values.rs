//! Parsers of the values of options. They refuse a value that no scene could use.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;
use std::time::Duration;

use super::Options;

/// The largest f64 up to which all whole numbers are exact: 2^53.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// Reads a whole number in a range.
///
/// # Errors
/// The text is not such a value; the message says what is expected.
pub fn whole_number<T>(text: &str, range: RangeInclusive<T>) -> Result<T, String>
where
    T: FromStr + PartialOrd + Display,
{
    text.parse()
        .ok()
        .filter(|value| range.contains(value))
        .ok_or_else(|| format!("expected a whole number from {} to {}", range.start(), range.end()))
}

/// Reads a whole number, which may have an exponent, as in `5e8`. `None` if `text` is not a whole number.
pub fn count(text: &str) -> Option<u64> {
    let exact = |value: &f64| *value >= 0.0 && *value <= MAX_EXACT && value.fract() == 0.0;
    text.parse().ok().or_else(|| text.parse().ok().filter(exact).map(|value| value as u64))
}

/// Reads a number for which `accepted` returns true.
///
/// # Errors
/// The text is not such a value; the message says what is expected.
pub fn number(text: &str, accepted: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    text.parse().ok().filter(|&value| accepted(value)).ok_or_else(|| format!("expected {expected}"))
}

/// The values that [`radius`] accepts, in words.
pub const RADIUS: &str = "a length above 0, from 1e-18 to 1e18, or pixels from 0.0625px to 64px";

/// Reads an initial radius. Of the two results one is `Some`: the radius in scene units, or the radius in
/// widths of a pixel.
///
/// # Errors
/// The text is not such a value; the message says what is expected.
pub fn radius(text: &str) -> Result<[Option<f64>; 2], String> {
    if let Some(pixels) = text.strip_suffix("px") {
        let [least, most] = Options::RADII_IN_PIXELS;
        let pixels = number(pixels, |pixels| (least..=most).contains(&pixels), RADIUS)?;
        return Ok([None, Some(pixels)]);
    }
    // The kernels square the radius in 32-bit floats.
    let length = number(text, |radius| (1e-18..=1e18).contains(&radius), RADIUS)?;
    Ok([Some(length), None])
}

/// The values that [`seconds`] accepts, in words.
pub const SECONDS: &str = "a finite number of seconds above 0";

/// Reads a time in seconds.
///
/// # Errors
/// The text is not such a value; the message says what is expected.
pub fn seconds(text: &str) -> Result<Duration, String> {
    text.parse()
        .ok()
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .filter(|time| !time.is_zero())
        .ok_or_else(|| format!("expected {SECONDS}"))
}

/// The values that [`target_error`] accepts, in words.
pub const TARGET_ERROR: &str = "a finite number above 0";

/// Reads a relative error.
///
/// # Errors
/// The text is not such a value; the message says what is expected.
pub fn target_error(text: &str) -> Result<f64, String> {
    number(text, |error| error > 0.0 && error < f64::INFINITY, TARGET_ERROR)
}

/// The values that [`resolution`] accepts, in words.
pub const RESOLUTION: &str = "WIDTHxHEIGHT, each from 1 to 65536, such as 640x480";

/// Reads the width and height of an image in pixels.
///
/// # Errors
/// The text is not such a value; the message says what is expected.
pub fn resolution(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=65536).contains(side));
    text.split_once('x')
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or_else(|| format!("expected {RESOLUTION}"))
}
