//! The subcommand `goblet compare`: compares two image files, prints the result and checks the limits.

mod sheet;

use std::path::Path;

use serde::Serialize;

use super::failure::CompareError;
use super::outputs::{Files, Written};
use super::{CompareArgs, Failure, terminal};
use crate::base::input::Budget;
use crate::base::names::Named;
use crate::image::compare::{Comparison, Gates, SizeMismatch, compare};
use crate::image::difference::{DifferenceMap, Scale};
use crate::image::exposure::exposed;
use crate::image::file::{self, ImageError, Layers, Transfer, Use};
use crate::image::film::{Image, Window, common_part};
#[cfg(feature = "study")]
use crate::study::flip::{Flip, flip};

pub use sheet::{Place, draw};

/// The version of the JSON that `--json` prints, which docs/json.md describes. It is raised when a key vanishes, or
/// changes its type or its meaning.
const SCHEMA_VERSION: u32 = 1;

/// The result that is printed.
#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    image: &'a Path,
    reference: &'a Path,
    #[serde(flatten)]
    comparison: Comparison,
    flip: Option<Flip>,
    diff: Option<Map<'a>>,
    gates: Gates,
    passed: bool,
    failures: Vec<String>,
}

/// The map that is written.
#[derive(Serialize)]
struct Map<'a> {
    file: &'a Path,
    kind: &'static str,
    unit: &'static str,
    /// Values of the first and the last colour; null for the values themselves in an EXR.
    scale: Option<[f64; 2]>,
}

/// goblet without the feature `study` has no FLIP.
#[cfg(not(feature = "study"))]
type Flip = ();

/// Compares two images, prints the result, and returns whether every limit was kept.
///
/// # Errors
/// An image cannot be read, the sizes differ, or the map or standard output cannot be written.
pub fn run(args: &CompareArgs) -> Result<bool, Failure> {
    let inputs = Files::default().reads("the image to compare", &args.image).reads("the reference", &args.reference);
    inputs.writes("the difference", &args.diff).check()?;
    if let Some(diff) = &args.diff {
        file::check_writable(diff)?;
        check_picture(args, diff)?;
    }
    let (image, reference) = read_both(args)?;
    let comparison = compare(&image, &reference).map_err(CompareError::from)?;
    let stops = args.exposure.stops(&reference);
    let (flip, flip_map) = seen(&image, &reference, stops).map_err(CompareError::from)?.unzip();
    let mut written = Written::default();
    let diff = match &args.diff {
        Some(file) => {
            let map = match DifferenceMap::new(args.diff_kind, &image, &reference).map_err(CompareError::from)? {
                Some(map) => map,
                None => flip_map.ok_or(CompareError::NoFlip)?,
            };
            let (map, outcome) = write_map(args, file, &map, [&image, &reference].map(|it| exposed(it, stops)));
            written.note(outcome);
            Some(map)
        }
        None => None,
    };

    let gates = Gates { max_relmse: args.max_relmse, max_energy: args.max_energy };
    let failures = comparison.failures(&gates);
    let report = Report {
        schema_version: SCHEMA_VERSION,
        image: &args.image,
        reference: &args.reference,
        comparison,
        flip,
        diff,
        gates,
        passed: failures.is_empty(),
        failures,
    };
    let text = if args.json { report.json() } else { report.table() };
    written.note(terminal::print(&text));
    written.end().map(|()| report.passed)
}

/// Checks that nothing is asked of an EXR that only a picture has.
fn check_picture(args: &CompareArgs, diff: &Path) -> Result<(), CompareError> {
    let asked = [("--side-by-side", args.side_by_side), ("--diff-max", args.diff_max.is_some())];
    match asked.into_iter().find(|(_, is_asked)| *is_asked && !file::is_picture(diff)) {
        Some((option, _)) => Err(CompareError::NoPicture(option)),
        None => Ok(()),
    }
}

/// Returns the difference that people see, if goblet can measure it.
#[cfg(feature = "study")]
fn seen(image: &Image, reference: &Image, stops: f32) -> Result<Option<(Flip, DifferenceMap)>, SizeMismatch> {
    flip(image, reference, stops).map(Some)
}

#[cfg(not(feature = "study"))]
fn seen(_: &Image, _: &Image, _: f32) -> Result<Option<(Flip, DifferenceMap)>, SizeMismatch> {
    Ok(None)
}

/// Writes a map, and returns what is said of it.
fn write_map<'a>(
    args: &CompareArgs,
    path: &'a Path,
    map: &DifferenceMap,
    sides: [Image; 2],
) -> (Map<'a>, Result<(), Failure>) {
    let said = Map { file: path, kind: map.kind.name(), unit: map.kind.unit(), scale: None };
    if !file::is_picture(path) {
        return (said, file::write(path, &map.image(), &[]).map_err(Failure::from));
    }
    let scale = args.diff_max.map_or_else(|| map.scale(), |most| Scale::new(map.kind, most));
    let (sheet, _) = draw(map, &scale, args.side_by_side.then_some([&sides[0], &sides[1]]));
    (Map { scale: Some(scale.ends()), ..said }, file::write(path, &sheet, &[]).map_err(Failure::from))
}

/// Reads both images. If they are crops of one image, both results are reduced to the pixels that both have.
fn read_both(args: &CompareArgs) -> Result<(Image, Image), CompareError> {
    let read = |path: &Path| {
        let Layers { image, window, .. } = file::read_layers(path, Transfer::Srgb, Use::Light, &Budget::default())?;
        let whole = Window::whole([image.width, image.height]);
        Ok::<_, ImageError>((image, window.unwrap_or(whole)))
    };
    let (image, reference) = (read(&args.image)?, read(&args.reference)?);
    match common_part((&image.0, image.1), (&reference.0, reference.1))? {
        Some([image, reference]) => {
            let Image { width, height, .. } = image;
            terminal::say(format_args!("compared where both have pixels: {width}x{height} of them"));
            Ok((image, reference))
        }
        None => Ok((image.0, reference.0)),
    }
}

impl Report<'_> {
    fn json(&self) -> String {
        // Serialization fails only for a path that is not Unicode.
        serde_json::to_string_pretty(self).map_or_else(|e| e.to_string(), |json| json + "\n")
    }

    fn table(&self) -> String {
        let c = &self.comparison;
        let trimmed = format!("without {} worst", c.left_out);
        let mut text = format!(
            "image      {}\n\
             reference  {}\n\
             size       {}x{}\n\
             \n\
             {:<20}{:>16}{trimmed:>22}\n",
            self.image.display(),
            self.reference.display(),
            c.width,
            c.height,
            "",
            "all pixels",
        );
        for (name, all, trimmed) in [
            ("mean energy ratio", c.energy_ratio, Some(c.energy_ratio_trimmed)),
            ("relMSE", c.relmse, Some(c.relmse_trimmed)),
            ("RMSE", c.rmse, None),
            ("max difference", c.max_difference, None),
        ] {
            let trimmed = trimmed.map_or(String::new(), |value| format!("{:>22}", digits(value)));
            text += &format!("{name:<20}{:>16}{trimmed}\n", digits(all));
        }
        if let Some(flip) = &self.flip {
            text += &flip_line(flip);
        }
        let broken = [c.non_finite_image, c.non_finite_reference];
        if broken != [0, 0] {
            let [image, reference] = broken;
            text += &format!("not finite: {image} pixels of the image, {reference} of the reference\n");
        }
        if let Some(Map { file, kind, scale, .. }) = &self.diff {
            let scale = scale.map_or("the values".to_owned(), |[least, most]| format!("scale {least} to {most}"));
            text += &format!("\nwrote {}: {kind}, {scale}\n", file.display());
        }
        for failure in &self.failures {
            text += &format!("FAILED: {failure}\n");
        }
        if self.passed && self.gates != Gates::default() {
            text += "passed\n";
        }
        text
    }
}

/// Returns the line of FLIP, which says which FLIP it is.
#[cfg(feature = "study")]
fn flip_line(flip: &Flip) -> String {
    let Flip { mean, variant, exposure_stops, pixels_per_degree } = flip;
    let conditions = format!("{variant}, exposure {exposure_stops} stops, {pixels_per_degree} pixels a degree");
    format!("{:<20}{:>16}   {conditions}\n", "FLIP", digits(*mean))
}

#[cfg(not(feature = "study"))]
fn flip_line((): &Flip) -> String {
    String::new()
}

/// Writes a number with six decimals, or with a power of ten if its absolute value is below 1e-3.
fn digits(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 { format!("{value:.5e}") } else { format!("{value:.6}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::difference::Difference;
    use crate::image::exposure::Exposure;

    /// The result of comparing a grey image with a slightly darker one.
    fn compare_files(change: impl Fn(&mut CompareArgs)) -> Result<bool, Failure> {
        let directory = tempfile::tempdir().unwrap();
        let file = |name: &str, value: f32| {
            let path = directory.path().join(name);
            let image = Image::from_pixels(2, 1, vec![[value; 3]; 2]).unwrap();
            file::write(&path, &image, &[]).unwrap();
            path
        };
        let diff = directory.path().join("diff.png");
        let mut args = CompareArgs {
            image: file("image.exr", 1.0),
            reference: file("reference.exr", 0.9),
            diff: Some(diff.clone()),
            diff_kind: Difference::default(),
            diff_max: None,
            exposure: Exposure::default(),
            side_by_side: false,
            json: false,
            max_relmse: None,
            max_energy: None,
        };
        change(&mut args);
        let result = run(&args);
        assert_eq!(diff.exists(), result.is_ok());
        result
    }

    #[test]
    fn the_verdict_is_that_of_the_gates() {
        assert!(compare_files(|_| ()).unwrap());
        assert!(compare_files(|args| args.max_relmse = Some(0.02)).unwrap());
        assert!(!compare_files(|args| args.max_relmse = Some(0.01)).unwrap());
        assert!(!compare_files(|args| args.max_energy = Some(0.1)).unwrap());
    }

    #[test]
    fn an_input_that_cannot_be_read_is_an_error() {
        let result = compare_files(|args| args.reference = "missing.exr".into());
        assert!(result.unwrap_err().to_string().contains("missing.exr"));
    }

    #[test]
    fn json_says_what_was_measured() {
        let image = Image::new(1, 1);
        let report = Report {
            schema_version: SCHEMA_VERSION,
            flip: None,
            diff: None,
            image: Path::new("a.exr"),
            reference: Path::new("b.exr"),
            comparison: compare(&image, &image).unwrap(),
            gates: Gates::default(),
            passed: true,
            failures: vec![],
        };
        let json: serde_json::Value = serde_json::from_str(&report.json()).unwrap();
        assert_eq!((&json["energy_ratio"], &json["passed"]), (&1.0.into(), &true.into()));
        assert!(report.table().contains("mean energy ratio"));
    }
}
