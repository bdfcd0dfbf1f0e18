//! What is known of a scene, for people: JSON has every digit.

use std::fmt::Write;

use super::{Camera, Contents, Film, Info, Integrator};

/// How wide the names before values are.
const NAMES: usize = 12;

/// The whole text.
pub(super) fn describe(info: &Info) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: &str| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{name:NAMES$}{value}");
    };
    if let Some(contents) = &info.contents {
        for (name, value) in lines(contents) {
            line(name, &value);
        }
    }
    for (name, list) in [("warning: ", &info.warnings), ("unsupported: ", &info.unsupported), ("error: ", &info.errors)]
    {
        list.iter().for_each(|item| line(name, item));
    }
    text
}

fn lines(contents: &Contents) -> Vec<(&'static str, String)> {
    let Contents { scene, bounds, light_power, film, camera, integrator, specialization, memory } = contents;
    let of = |ending: &'static str| scene.iter().filter_map(move |(name, n)| Some((name.strip_suffix(ending)?, *n)));
    let materials = of("_shapes").map(|(name, n)| format!("{} ({})", words(name), counted("shapes", n)));
    let shapes = scene.iter().filter(|(name, _)| !name.ends_with("_shapes") && !name.ends_with("_lights"));
    let powers = light_power.iter().map(|(kind, power)| format!("{kind} {} W", number(*power)));
    let powers = powers.collect::<Vec<_>>().join(", ");
    let lights = match list(of("_lights")) {
        none if none.is_empty() => "none".to_owned(),
        counts => format!("{counts}; power (mean of red, green and blue): {powers}"),
    };
    let bounds = bounds.as_ref().map_or_else(
        || "no surface".to_owned(),
        |bounds| format!("a sphere of radius {} about {}", number(bounds.radius), point(&bounds.center)),
    );
    let features = specialization.iter().filter(|(_, value)| value.is_boolean()).map(|(name, _)| words(name));
    vec![
        ("shapes", or_none(list(shapes.map(|(name, n)| (*name, *n))))),
        ("materials", or_none(materials.collect::<Vec<_>>().join(", "))),
        ("lights", lights),
        ("bounds", bounds),
        ("camera", describe_camera(camera)),
        ("film", describe_film(film)),
        ("integrator", describe_integrator(integrator)),
        (
            "memory",
            format!(
                "of the device: {} for images and photons, {} for the scene",
                bytes(memory.buffers),
                bytes(memory.scene)
            ),
        ),
        ("kernels", or_none(features.collect::<Vec<_>>().join(", "))),
    ]
}

fn describe_camera(camera: &Camera) -> String {
    let Camera { projection, fov, position, screen_window, lens_radius, focal_distance } = camera;
    let mut text = (*projection).to_owned();
    if let Some(fov) = fov {
        let _ = write!(text, ", {}° of the shorter side", number(*fov));
    }
    let _ = write!(text, ", at {}", point(position));
    // Of a camera that sees all directions, neither means anything.
    if matches!(*projection, "perspective" | "orthographic") {
        let [left, right, bottom, top] = screen_window.map(number);
        let _ = write!(text, ", screen window {left} to {right} by {bottom} to {top}");
        if *lens_radius > 0.0 {
            let _ = write!(text, ", lens of radius {} focused at {}", number(*lens_radius), number(*focal_distance));
        }
    }
    text
}

fn describe_film(film: &Film) -> String {
    let Film { resolution: [width, height], rendered: [[left, top], [right, bottom]], exposure, .. } = film;
    let mut text = format!("{width} x {height} pixels");
    if [left, top] != [&0, &0] || [right, bottom] != [width, height] {
        let _ = write!(text, ", of which {} x {} from ({left}, {top}) on are rendered", right - left, bottom - top);
    }
    let [x, y] = film.filter_radius.map(number);
    let _ = write!(text, ", {} filter of {x} by {y} pixels either way", film.filter);
    let parameters = film.filter_parameters.iter().map(|(name, value)| format!("{name} {}", number(*value)));
    let parameters: Vec<_> = parameters.collect();
    if !parameters.is_empty() {
        let _ = write!(text, " ({})", parameters.join(", "));
    }
    if *exposure != 1.0 {
        let _ = write!(text, ", radiance times {}", number(*exposure));
    }
    text
}

fn describe_integrator(integrator: &Integrator) -> String {
    let Integrator { iterations, photons_per_iteration, max_depth, radius, radius_in_pixels, seed } = integrator;
    let radius = match (radius, radius_in_pixels) {
        (Some(radius), _) => number(*radius),
        (None, Some(pixels)) => format!("{} pixels", number(*pixels)),
        (None, None) => "none".to_owned(),
    };
    format!(
        "{} iterations of {} photons, maximum depth {max_depth}, first radius {radius}, seed {seed}",
        thousands((*iterations).into()),
        thousands(*photons_per_iteration),
    )
}

fn or_none(text: String) -> String {
    if text.is_empty() { "none".to_owned() } else { text }
}

/// Counts with their names.
fn list<'a>(counts: impl Iterator<Item = (&'a str, u64)>) -> String {
    counts.map(|(name, n)| counted(&words(name), n)).collect::<Vec<_>>().join(", ")
}

/// A number of things, whose name is that of more than one.
fn counted(names: &str, number: u64) -> String {
    let one = || names.strip_suffix("es").filter(|stem| stem.ends_with("sh")).or(names.strip_suffix('s'));
    let name = if number == 1 { one().unwrap_or(names) } else { names };
    format!("{} {name}", thousands(number))
}

/// A name of JSON as words; of a feature, without the verb.
fn words(name: &str) -> String {
    let name = name.strip_prefix("has_").or(name.strip_prefix("is_")).unwrap_or(name);
    name.replace('_', " ")
}

fn point(point: &[f64; 3]) -> String {
    format!("({})", point.map(number).join(", "))
}

/// Four digits are enough to recognise a number.
fn number(value: f64) -> String {
    const DIGITS: i32 = 4;
    let magnitude = value.abs();
    if magnitude < 1e-12 {
        return "0".to_owned();
    }
    if !(1e-4..1e7).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    let places = (DIGITS - 1 - magnitude.log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.places$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().map(|group| std::str::from_utf8(group).unwrap_or_default()).collect();
    groups.join(",")
}

fn bytes(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["bytes", "KiB", "MiB", "GiB", "TiB"];
    let (mut value, mut unit) = (bytes as f64, 0);
    while value >= 1024.0 && unit + 1 < UNITS.len() {
        (value, unit) = (value / 1024.0, unit + 1);
    }
    let value = if unit == 0 || value >= 100.0 { format!("{value:.0}") } else { format!("{value:.1}") };
    format!("{value} {}", UNITS[unit])
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.732_050_807_568_877_2, "1.732"),
            (-6.4, "-6.4"),
            (1e6, "1000000"),
            (12_345.678, "12346"),
            (0.026_666, "0.02667"),
            (1e-5, "1.000e-5"),
            (1e30, "1.000e30"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(number(value), text);
        }
        assert_eq!([0, 999, 1_000, 1_234_567].map(thousands), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([0, 1023, 2168, 119_537_664].map(bytes), ["0 bytes", "1023 bytes", "2.1 KiB", "114 MiB"]);
    }

    #[test]
    fn counts_have_their_number() {
        let counts = BTreeMap::from([("meshes", 1), ("spheres", 2), ("triangles", 12_000)]);
        assert_eq!(list(counts.into_iter()), "1 mesh, 2 spheres, 12,000 triangles");
        assert_eq!(list([("spheres", 1), ("disks", 1), ("area", 1)].into_iter()), "1 sphere, 1 disk, 1 area");
    }
}
