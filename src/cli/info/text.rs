//! The description of a scene as text: lines of a name and a value with its unit.

use std::fmt::Write;

use super::{AutomaticRadius, Camera, Contents, Film, Info, Integrator};

/// The number of significant digits of a number that is not a count.
const DIGITS: i32 = 4;

/// Returns the whole description.
pub fn describe(info: &Info) -> String {
    let mut text = String::new();
    if let Some(contents) = &info.contents {
        for (title, lines) in sections(contents) {
            text += &format!("{title}\n");
            for (name, value) in lines {
                text += &format!("  {name}: {value}\n");
            }
        }
    }
    for parameter in &info.ignored {
        text += &format!("ignored: {parameter}\n");
    }
    text
}

type Lines = Vec<(String, String)>;

fn sections(contents: &Contents) -> Vec<(&'static str, Lines)> {
    let Contents { scene, bounds, light_power, dispersion, film, camera, integrator, specialization, memory } =
        contents;
    let counts = scene.iter().map(|(name, number)| (words(name), count(*number))).collect();
    let bounds = bounds.iter().flat_map(|bounds| {
        let radius = format!("{} scene units", number(bounds.radius));
        [("center".to_owned(), numbers(&bounds.center)), ("radius".to_owned(), radius)]
    });
    let power = light_power.iter().map(|(kind, power)| (words(kind), format!("{} W", number(*power)))).collect();
    let splits_light = if *dispersion { lines([("dispersion", "by wavelength".to_owned())]) } else { Vec::new() };
    let used: Vec<String> = specialization
        .iter()
        .filter(|(_, value)| value.is_boolean())
        .map(|(name, _)| words(name.strip_prefix("has_").unwrap_or(name)))
        .collect();
    let all: Vec<(&str, Lines)> = vec![
        ("scene", counts),
        ("bounds", bounds.collect()),
        ("light power", power),
        ("glass", splits_light),
        ("camera", camera_lines(camera)),
        ("film", film_lines(film)),
        ("integrator", integrator_lines(integrator)),
        ("kernels", vec![("compiled for".to_owned(), used.join(", "))]),
        (
            "device memory",
            vec![("scene".to_owned(), bytes(memory.scene)), ("buffers".to_owned(), bytes(memory.buffers))],
        ),
    ];
    all.into_iter().filter(|(_, lines)| !lines.is_empty()).collect()
}

fn lines<const N: usize>(lines: [(&str, String); N]) -> Lines {
    lines.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn camera_lines(camera: &Camera) -> Lines {
    let mut all = lines([("projection", words(camera.projection))]);
    if let Some(angle) = camera.field_of_view {
        all.extend(lines([("field of view", format!("{} degrees", number(angle)))]));
    }
    all.extend(lines([("position", numbers(&camera.position)), ("screen window", numbers(&camera.screen_window))]));
    if camera.lens_radius > 0.0 {
        let [radius, distance] = [camera.lens_radius, camera.focal_distance].map(number);
        let lens = format!("radius {radius} scene units, in focus at a distance of {distance}");
        all.extend(lines([("lens", lens)]));
    }
    all
}

fn film_lines(film: &Film) -> Lines {
    let [width, height] = film.resolution;
    let [first, end] = film.rendered;
    let mut all = lines([("resolution", format!("{width} x {height} pixels"))]);
    if (first, end) != ([0, 0], film.resolution) {
        let [width, height] = [end[0] - first[0], end[1] - first[1]];
        let part = format!("{width} x {height} pixels from column {} and row {}", first[0], first[1]);
        all.extend(lines([("rendered", part)]));
    }
    let mut filter = film.filter.to_owned();
    for (name, value) in &film.filter_parameters {
        // Writing to a string cannot fail.
        let _ = write!(filter, ", {name} {}", number(*value));
    }
    let [x, y] = film.filter_radius.map(number);
    filter += &format!(", radius {x} x {y} pixels");
    all.extend(lines([("exposure", number(film.exposure))]));
    if let Some(kelvin) = film.whitebalance {
        all.extend(lines([("white balance", format!("{} K", number(kelvin)))]));
    }
    all.extend(lines([("filter", filter)]));
    all
}

fn integrator_lines(integrator: &Integrator) -> Lines {
    let AutomaticRadius { pixels, distance, at_distance } = integrator.automatic_radius;
    let radius = integrator.radius.map_or_else(
        || {
            let [pixels, distance, at_distance] = [pixels, distance, at_distance].map(number);
            format!("{pixels} pixels: {at_distance} scene units at a distance of {distance}, the centre of the bounds")
        },
        |radius| format!("{} scene units", number(radius)),
    );
    lines([
        ("iterations", count(integrator.iterations.into())),
        ("photons per iteration", count(integrator.photons_per_iteration)),
        ("longest path", format!("{} segments", count(integrator.max_depth.into()))),
        ("first radius", radius),
        ("seed", integrator.seed.to_string()),
    ])
}

/// Returns the words of a key of the JSON.
fn words(key: &str) -> String {
    key.replace('_', " ")
}

/// Writes a count with a comma between groups of three digits.
fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Writes a number with [`DIGITS`] digits, and with a power of ten if it would have many zeros.
fn number(value: f64) -> String {
    // Adding 0 removes the sign of a negative zero.
    let rounded = format!("{:.*e}", (DIGITS - 1) as usize, value + 0.0);
    let Some((digits, exponent)) = rounded.split_once('e') else { return rounded };
    let exponent: i32 = exponent.parse().unwrap_or_default();
    if !(-DIGITS..=6).contains(&exponent) {
        return format!("{}e{exponent}", without_zeros(digits));
    }
    let decimals = (DIGITS - 1 - exponent).max(0) as usize;
    // The rounded number is formatted, so that it is not rounded twice.
    rounded.parse().map_or(rounded, |value: f64| without_zeros(&format!("{value:.decimals$}")).to_owned())
}

/// Removes the zeros at the end of a decimal fraction.
fn without_zeros(decimal: &str) -> &str {
    if decimal.contains('.') { decimal.trim_end_matches('0').trim_end_matches('.') } else { decimal }
}

fn numbers(values: &[f64]) -> String {
    values.iter().map(|value| number(*value)).collect::<Vec<_>>().join(" ")
}

/// Writes a number of bytes in the largest unit in which it is at least 1.
fn bytes(bytes: u64) -> String {
    let mut value = bytes as f64;
    for unit in ["bytes", "KiB", "MiB"] {
        if value < 1024.0 {
            return format!("{} {unit}", number(value));
        }
        value /= 1024.0;
    }
    format!("{} GiB", number(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, expected) in [
            (0.0, "0"),
            (-0.0, "0"),
            (-0.5, "-0.5"),
            (1.0, "1"),
            (7.681_145_747_868_608, "7.681"),
            (210.219_111_025_148_98, "210.2"),
            (0.253_967, "0.254"),
            (999.96, "1000"),
            (123_456.0, "123500"),
            (1e6, "1000000"),
            (1.234_56e9, "1.235e9"),
            (0.000_123_46, "0.0001235"),
            (1e-9, "1e-9"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(value), expected);
        }
    }

    #[test]
    fn counts_and_bytes_have_units() {
        for (value, expected) in [(0, "0"), (999, "999"), (1000, "1,000"), (12_345_678, "12,345,678")] {
            assert_eq!(count(value), expected);
        }
        for (value, expected) in
            [(43_340, "42.32 KiB"), (144_310_272, "137.6 MiB"), (1 << 40, "1024 GiB"), (7, "7 bytes")]
        {
            assert_eq!(bytes(value), expected);
        }
    }
}
