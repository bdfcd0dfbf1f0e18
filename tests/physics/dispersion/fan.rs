//! A prism spreads white light into a fan. Where in it a color is, Snell's law says, and Sellmeier's formula.
//!
//! The prism's axis is z, and light goes along x. Photons: a narrow beam crosses the prism and ends on a screen. Eye paths:
//! the camera looks through the prism at a narrow lamp in the plane of the screen. Both are followed in f64 for each
//! wavelength, and compared by where shares of X, Y and Z end: these are never negative, so that such places are well
//! defined, and each is near one wavelength.

use std::f64::consts::PI;

use goblet::image::film::Image;

use super::super::{Shot, solid};
use crate::support::spectral::{FLINT, LINES, reflectance, xyz_of};

/// Where light begins, and where the screen is, from the middle of the prism.
const BEGIN: f64 = 2.0;
const SCREEN: f64 = 10.0;
/// Half of a side of the prism.
const HALF: f64 = 0.5;
/// The wavelength in nm that is deviated least.
const LEAST_DEVIATED: f64 = 560.0;

/// Half of the least deviation, radians.
fn half_deviation() -> f64 {
    (FLINT.eta(LEAST_DEVIATED) * 0.5).asin() - PI / 6.0
}

type Point = [f64; 2];

fn along(from: Point, direction: Point, t: f64) -> Point {
    [from[0] + t * direction[0], from[1] + t * direction[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn at_angle(angle: f64) -> Point {
    [angle.cos(), angle.sin()]
}

/// Refracts by Snell's law at a face whose normal is along the light, from one index to another.
fn refract(direction: Point, normal: Point, from: f64, to: f64) -> (Point, f64) {
    let cos_i = dot(direction, normal);
    let kept = 1.0 - reflectance(cos_i, to / from);
    let ratio = from / to;
    let cos_t = (1.0 - ratio * ratio * (1.0 - cos_i * cos_i)).sqrt();
    (along([ratio * direction[0], ratio * direction[1]], normal, cos_t - ratio * cos_i), kept)
}

/// Where light of a wavelength in nm meets the screen that begins at an angle to the beam, in radians, positive upward: the
/// height on the screen over its distance, in degrees. And the share that the prism lets through.
fn follow(angle: f64, nm: f64) -> (f64, f64) {
    let eta = FLINT.eta(nm);
    let half_deviation = half_deviation();
    // Light rises to the prism, goes level inside, and falls behind it.
    let axis = at_angle(half_deviation);
    let start = [-BEGIN * axis[0], -BEGIN * axis[1]];
    let mut at = start;
    let mut direction = at_angle(half_deviation + angle);
    let mut kept = 1.0;
    for (x, normal, from, to) in [(-1.0, -PI / 6.0, 1.0, eta), (1.0, PI / 6.0, eta, 1.0)] {
        // The middle of the face is half a quarter of the base away from the middle plane.
        let normal = at_angle(normal);
        let face = [x * HALF / 2.0, 0.0];
        at = along(at, direction, dot([face[0] - at[0], face[1] - at[1]], normal) / dot(direction, normal));
        let (next, share) = refract(direction, normal, from, to);
        direction = next;
        kept *= share;
    }
    let normal = at_angle(-half_deviation);
    at = along(at, direction, (SCREEN - dot(at, normal)) / dot(direction, normal));
    let up = at_angle(PI / 2.0 - half_deviation);
    ((dot(at, up) / SCREEN).to_degrees(), kept)
}

fn prism() -> String {
    let height = HALF * 0.75_f64.sqrt();
    let end = |z: f64| format!("{} {} {z} {HALF} {} {z} 0 {height} {z} ", -HALF, -height, -height);
    format!(
        "Material \"dielectric\" \"spectrum eta\" \"glass-F11\"\nShape \"trianglemesh\" \"point3 P\" [{}{}] \
         \"integer indices\" [0 2 1  3 4 5  0 1 4  0 4 3  1 2 5  1 5 4  2 0 3  2 3 5]\n",
        end(-1.0),
        end(1.0)
    )
}

/// A strip of the screen between two heights over its distance, in degrees.
fn on_screen(heights: [f64; 2]) -> String {
    let (out, up) = (at_angle(-half_deviation()), at_angle(PI / 2.0 - half_deviation()));
    let corner = |degrees: f64, z: f64| {
        let [x, y] = along([SCREEN * out[0], SCREEN * out[1]], up, SCREEN * degrees.to_radians());
        format!("{x} {y} {z} ")
    };
    let [low, high] = heights;
    let corners = [corner(low, -1.0), corner(high, -1.0), corner(high, 1.0), corner(low, 1.0)].concat();
    format!("Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [{corners}]\n")
}

/// A camera at a place that looks along a direction. Its columns rise; they and the rows span these widths.
fn camera(kind: &str, at: Point, direction: Point, columns: [f64; 2], rows: f64) -> String {
    let [x, y] = along(at, direction, 1.0);
    let [low, high] = columns;
    format!(
        "LookAt {} {} 0  {x} {y} 0  0 0 1\nCamera \"{kind}\" \"float screenwindow\" [{low} {high} {} {rows}]",
        at[0], at[1], -rows
    )
}

const COLUMNS: u32 = 160;
const ROWS: u32 = 4;

/// Linear RGB by place in degrees: violet comes first.
struct Profile {
    first: f64,
    step: f64,
    rgb: Vec<[f64; 3]>,
}

impl Profile {
    fn new([first, last]: [f64; 2]) -> Self {
        let step = (last - first) / f64::from(COLUMNS);
        Self { first, step, rgb: vec![[0.0; 3]; COLUMNS as usize] }
    }

    /// The sums of columns.
    fn of(image: &Image, range: [f64; 2], is_reversed: bool) -> Self {
        let mut profile = Self::new(range);
        for (i, pixel) in image.pixels.iter().enumerate() {
            let column = i % COLUMNS as usize;
            let at = if is_reversed { COLUMNS as usize - 1 - column } else { column };
            profile.rgb[at] = [0, 1, 2].map(|channel| profile.rgb[at][channel] + f64::from(pixel[channel]));
        }
        profile
    }

    /// Adds light at a place, if that is in range.
    fn add(&mut self, place: f64, rgb: [f64; 3], share: f64) {
        let column = (place - self.first) / self.step;
        if column >= 0.0 && column < f64::from(COLUMNS) {
            let sum = &mut self.rgb[column as usize];
            *sum = [0, 1, 2].map(|channel| sum[channel] + share * rgb[channel]);
        }
    }

    /// How much light there is within some degrees of a place, as the sum of all channels' sizes, and where its middle is.
    fn around(&self, place: f64, degrees: f64) -> (f64, f64) {
        let (mut sum, mut moment) = (0.0, 0.0);
        for (column, rgb) in self.rgb.iter().enumerate() {
            let at = self.first + self.step * (column as f64 + 0.5);
            if (at - place).abs() < degrees {
                let size: f64 = rgb.iter().map(|value| value.abs()).sum();
                (sum, moment) = (sum + size, moment + size * at);
            }
        }
        (sum, moment / sum)
    }

    /// Where a share of X, Y or Z is reached.
    fn place_of(&self, share: f64, of: usize) -> f64 {
        let values = self.rgb.iter().map(|rgb| xyz_of(*rgb)[of]);
        let wanted = share * values.clone().sum::<f64>();
        let mut sum = 0.0;
        for (column, value) in values.enumerate() {
            if sum + value >= wanted {
                return self.first + self.step * (column as f64 + (wanted - sum) / value);
            }
            sum += value;
        }
        unreachable!("a share below 1")
    }

    /// The hues of groups of columns where there is much light, from -60 to 300 degrees: 0 is red, 120 green, 240 blue.
    fn hues(&self) -> Vec<Option<f64>> {
        let groups: Vec<[f64; 3]> = self
            .rgb
            .chunks(4)
            .map(|group| [0, 1, 2].map(|channel| group.iter().map(|rgb| rgb[channel]).sum()))
            .collect();
        let size = |rgb: &[f64; 3]| rgb.iter().map(|value| value.abs()).sum::<f64>();
        let most = groups.iter().map(size).fold(0.0, f64::max);
        let hue = |rgb: &[f64; 3]| {
            let [r, g, b] = *rgb;
            (3_f64.sqrt() * (g - b)).atan2(2.0 * r - g - b).to_degrees()
        };
        groups.iter().map(|rgb| (size(rgb) > 0.1 * most).then(|| (hue(rgb) + 60.0).rem_euclid(360.0) - 60.0)).collect()
    }
}

/// Shares of X, Y and Z from the violet end, and the wavelengths in nm that are there.
const SHARES: [(f64, usize, f64); 5] =
    [(0.3, 2, 440.0), (0.1, 1, 510.0), (0.5, 1, 557.0), (0.9, 1, 608.0), (0.9, 0, 627.0)];

/// Places are within 0.05 degrees. A column has about as much; both ends of what is compared are sharp to a tenth of that. The
/// approximate observer shifts places by a nm or less, which is 0.01 to 0.03 degrees; the noise of 200,000 paths in a fan of
/// 5 degrees is about 0.01.
///
/// Hues are within 15 degrees, since they change by up to 40 degrees from one group of columns to the next, a fifth of a
/// degree on, and colours are means over some columns; and none goes back.
fn assert_fan(what: &str, profile: &Profile, expected: &Profile) {
    for (share, of, nm) in SHARES {
        let [place, expected] = [profile, expected].map(|profile| profile.place_of(share, of));
        println!("{what}, about {nm} nm: {place:.4} degrees, expected {expected:.4}");
        assert!((place - expected).abs() < 0.05, "{what}, about {nm} nm: at {place}, expected at {expected}");
    }
    let hues: Vec<[f64; 2]> =
        profile.hues().iter().zip(expected.hues()).filter_map(|(hue, expected)| Some([(*hue)?, expected?])).collect();
    println!("{what}: {hues:.0?}");
    assert!(hues.len() > 25, "{what}: {} groups of columns", hues.len());
    for [hue, expected] in &hues {
        assert!((hue - expected).abs() < 15.0, "{what}: a hue of {hue}, expected {expected}");
    }
    for pair in hues.windows(2) {
        assert!(pair[1][0] < pair[0][0] + 2.0, "{what}: {pair:?}");
    }
    assert!(hues[0][0] > 240.0 && hues[hues.len() - 1][0] < 10.0, "{what}: {hues:?}");
}

/// Places of the fan on the screen, degrees.
const FAN: [f64; 2] = [-6.0, 2.5];

/// Half of the beam's angle in degrees, and the gather radius.
const BEAM: f64 = 0.05;
const RADIUS: f64 = 0.01;

/// The fan on the screen of a beam of a small angle. `light`: the parameter of the lamp's intensity; `before`: what else
/// is there.
fn fan_of_beam(light: &str, before: &str) -> Profile {
    let (axis, out) = (at_angle(half_deviation()), at_angle(-half_deviation()));
    let world = format!(
        "LightSource \"spot\" \"point3 from\" [{} {} 0] \"point3 to\" [0 0 0] \"float coneangle\" {BEAM} \
         \"float conedeltaangle\" {} {light}\n{}{before}Material \"diffuse\"\n{}",
        -BEGIN * axis[0],
        -BEGIN * axis[1],
        BEAM / 100.0,
        prism(),
        on_screen([FAN[0] - 1.0, FAN[1] + 1.0])
    );
    let columns = FAN.map(|degrees| SCREEN * degrees.to_radians());
    let look = camera("orthographic", along([0.0; 2], out, SCREEN - 0.5), out, columns, 0.025);
    let shot = Shot {
        resolution: [COLUMNS, ROWS],
        photons: 16384,
        iterations: 16,
        radius: RADIUS,
        alpha: 1.0,
        depth: 3,
        eye_paths: 1,
    };
    Profile::of(&shot.take(&look, &world).image, FAN, false)
}

const WHITE_BEAM: &str = "\"rgb I\" [1e6 1e6 1e6]";

/// Photons: a beam of a small angle.
#[test]
fn a_beam_through_a_prism_lights_a_fan_of_colors() {
    let mut expected = Profile::new(FAN);
    // Beam and disc are round: a chord of each by the distance from its middle.
    let chords = (-10..=10).map(|i| f64::from(i) / 10.5).map(|x| (x, (1.0 - x * x).sqrt()));
    LINES.with(|lines| {
        for line in lines {
            for (x, chord) in chords.clone() {
                let (place, kept) = follow(x * BEAM.to_radians(), line.nm);
                for (y, other) in chords.clone() {
                    let blurred = place + y * (RADIUS / SCREEN).to_degrees();
                    expected.add(blurred, line.rgb, kept * chord * other);
                }
            }
        }
    });
    assert_fan("photons", &fan_of_beam(WHITE_BEAM, ""), &expected);
}

/// Eye paths: a narrow lamp on the screen, in the middle of the fan.
#[test]
fn a_lamp_behind_a_prism_looks_like_a_fan_of_colors() {
    const LAMP: f64 = 0.1;
    /// Angles at which the camera sees, degrees downward.
    const SEEN: [f64; 2] = [-6.5, 3.0];
    let axis = at_angle(half_deviation());
    let world = format!(
        "{}AreaLightSource \"diffuse\" \"rgb L\" [100 100 100] \"bool twosided\" true\n\
         Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n{}",
        prism(),
        on_screen([-LAMP / 2.0, LAMP / 2.0])
    );
    let columns = SEEN.map(|degrees| -degrees.to_radians());
    let look = camera("perspective", [-BEGIN * axis[0], -BEGIN * axis[1]], axis, [columns[1], columns[0]], 0.005)
        + " \"float fov\" 90";
    let shot = Shot {
        resolution: [COLUMNS, ROWS],
        photons: 1,
        iterations: 8,
        radius: 0.1,
        alpha: 1.0,
        depth: 3,
        eye_paths: 64,
    };
    let rendered = shot.take(&look, &world);
    let mut expected = Profile::new(SEEN);
    for column in 0..8 * COLUMNS {
        let place = expected.first + expected.step * (f64::from(column) + 0.5) / 8.0;
        let angle = -place.to_radians().atan();
        LINES.with(|lines| {
            for line in lines {
                let [(low, kept), (high, _)] = [-0.5, 0.5].map(|half| follow(angle, line.nm + half));
                let inside = high.min(LAMP / 2.0) - low.max(-LAMP / 2.0);
                expected.add(place, line.rgb, kept * (inside / (high - low)).max(0.0));
            }
        });
    }
    assert_fan("eye paths", &Profile::of(&rendered.image, SEEN, true), &expected);
}

/// A lamp of three narrow lines keeps them: light lands within 0.05 degrees of where each of them belongs, and nowhere else.
/// A line of 4 nm is up to 0.15 degrees wide, and symmetric to a tenth of that; beam and disc are 0.05 and 0.06 wide.
#[test]
fn a_lamp_of_lines_lights_lines() {
    let lines = [450.0, 546.0, 610.0];
    let spectrum = lines.map(|nm: f64| format!("{} 0 {nm} 1 {} 0", nm - 2.0, nm + 2.0)).join(" ");
    let fan = fan_of_beam(&format!("\"spectrum I\" [{spectrum}] \"float scale\" 1e6"), "");
    let (all, _) = fan.around(0.0, f64::INFINITY);
    let mut near = 0.0;
    for place in lines.map(|nm| follow(0.0, nm).0) {
        let (size, middle) = fan.around(place, 0.3);
        println!("{size} of {all} at {middle:.4} degrees, expected {place:.4}");
        assert!((middle - place).abs() < 0.05, "{middle}, expected {place}");
        // The lamp has as much light in each line, which the eye weights differently.
        assert!(size > 0.02 * all, "{size} of {all} at {place}");
        near += size;
    }
    assert!(near > 0.98 * all, "{near} of {all}");
}

/// A medium behind the prism absorbs what is longer than 580 nm, and nothing else: not a part of each channel.
#[test]
fn a_medium_absorbs_wavelengths_of_a_fan() {
    let medium = "AttributeBegin\nMakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"spectrum sigma_a\" [380 0 575 0 585 20 780 20] \
                  \"rgb sigma_s\" [0 0 0]\nMediumInterface \"m\" \"\"\nMaterial \"interface\"\n";
    let slab = format!("{medium}{}\nAttributeEnd\n", solid([6.5, -8.0, -2.0], [7.3, -1.0, 2.0]));
    let [clear, dyed] = ["", slab.as_str()].map(|before| fan_of_beam(WHITE_BEAM, before));
    for (nm, share, tolerance) in
        [(450.0, 1.0, 0.1), (510.0, 1.0, 0.1), (550.0, 1.0, 0.1), (610.0, 0.0, 0.02), (640.0, 0.0, 0.02)]
    {
        let [clear, dyed] = [&clear, &dyed].map(|fan| fan.around(follow(0.0, nm).0, 0.1).0);
        println!("{nm} nm: {dyed} of {clear}");
        assert!((dyed / clear - share).abs() < tolerance, "{nm} nm: {dyed} of {clear}");
    }
}
