//! Values of options as people write them. A value that no scene could use is refused here.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;
use std::time::Duration;

use super::Options;

/// Whole numbers up to this are exact in f64.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// A whole number in a range.
///
/// # Errors
/// What was expected.
pub fn whole_number<T>(text: &str, range: RangeInclusive<T>) -> Result<T, String>
where
    T: FromStr + PartialOrd + Display,
{
    text.parse()
        .ok()
        .filter(|value| range.contains(value))
        .ok_or_else(|| format!("expected a whole number from {} to {}", range.start(), range.end()))
}

/// A whole number, also written as in `5e8`; `None` if `text` is none.
pub fn count(text: &str) -> Option<u64> {
    let exact = |value: &f64| *value >= 0.0 && *value <= MAX_EXACT && value.fract() == 0.0;
    text.parse().ok().or_else(|| text.parse().ok().filter(exact).map(|value| value as u64))
}

/// A number for which `accepted` holds.
///
/// # Errors
/// What was expected.
pub fn number(text: &str, accepted: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    text.parse().ok().filter(|&value| accepted(value)).ok_or_else(|| format!("expected {expected}"))
}

/// What [`radius`] expects.
pub const RADIUS: &str = "a length above 0, from 1e-18 to 1e18, or pixels from 0.0625px to 64px";

/// An initial radius: in scene units, or else in widths of a pixel.
///
/// # Errors
/// What was expected.
pub fn radius(text: &str) -> Result<[Option<f64>; 2], String> {
    if let Some(pixels) = text.strip_suffix("px") {
        let [least, most] = Options::RADII_IN_PIXELS;
        let pixels = number(pixels, |pixels| (least..=most).contains(&pixels), RADIUS)?;
        return Ok([None, Some(pixels)]);
    }
    // The kernels square it in 32-bit floats.
    let length = number(text, |radius| (1e-18..=1e18).contains(&radius), RADIUS)?;
    Ok([Some(length), None])
}

/// What [`seconds`] expects.
pub const SECONDS: &str = "a finite number of seconds above 0";

/// A time.
///
/// # Errors
/// What was expected.
pub fn seconds(text: &str) -> Result<Duration, String> {
    text.parse()
        .ok()
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .filter(|time| !time.is_zero())
        .ok_or_else(|| format!("expected {SECONDS}"))
}

/// What [`target_error`] expects.
pub const TARGET_ERROR: &str = "a finite number above 0";

/// A relative error.
///
/// # Errors
/// What was expected.
pub fn target_error(text: &str) -> Result<f64, String> {
    number(text, |error| error > 0.0 && error < f64::INFINITY, TARGET_ERROR)
}

/// What [`resolution`] expects.
pub const RESOLUTION: &str = "WIDTHxHEIGHT, each from 1 to 65536, such as 640x480";

/// Width and height of an image.
///
/// # Errors
/// What was expected.
pub fn resolution(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=65536).contains(side));
    text.split_once('x')
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or_else(|| format!("expected {RESOLUTION}"))
}
