//! The subcommand `goblet compare`: compares two image files, prints the result and checks the limits.

use std::path::Path;

use serde::Serialize;

use super::failure::CompareError;
use super::outputs::{Files, Written};
use super::{CompareArgs, Failure, terminal};
use crate::base::input::Budget;
use crate::image::compare::{Comparison, Gates, compare, difference_image};
use crate::image::file::{self, ImageError, Layers, Transfer, Use};
use crate::image::film::{Image, Window, common_part};

/// The result that is printed.
#[derive(Serialize)]
struct Report<'a> {
    image: &'a Path,
    reference: &'a Path,
    #[serde(flatten)]
    comparison: Comparison,
    gates: Gates,
    passed: bool,
    failures: Vec<String>,
}

/// Compares two images, prints the result, and returns whether every limit was kept.
///
/// # Errors
/// An image cannot be read, the sizes differ, or the difference image or standard output cannot be written.
pub fn run(args: &CompareArgs) -> Result<bool, Failure> {
    let inputs = Files::default().reads("the image to compare", &args.image).reads("the reference", &args.reference);
    inputs.writes("the difference", &args.diff).check()?;
    if let Some(diff) = &args.diff {
        file::check_writable(diff)?;
    }
    let (image, reference) = read_both(args)?;
    let comparison = compare(&image, &reference).map_err(CompareError::from)?;
    let difference = args.diff.as_ref().map_or(Ok(()), |diff| {
        let difference = difference_image(&image, &reference).map_err(CompareError::from)?;
        Ok(file::write(diff, &difference, &[])?)
    });

    let gates = Gates { max_relmse: args.max_relmse, max_energy: args.max_energy };
    let failures = comparison.failures(&gates);
    let report = Report {
        image: &args.image,
        reference: &args.reference,
        comparison,
        gates,
        passed: failures.is_empty(),
        failures,
    };
    let text = if args.json { report.json() } else { report.table() };
    let mut written = Written::default();
    written.note(terminal::print(&text));
    written.note(difference);
    written.end().map(|()| report.passed)
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
        let broken = [c.non_finite_image, c.non_finite_reference];
        if broken != [0, 0] {
            let [image, reference] = broken;
            text += &format!("not finite: {image} pixels of the image, {reference} of the reference\n");
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

/// Writes a number with six decimals, or with a power of ten if its absolute value is below 1e-3.
fn digits(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 { format!("{value:.5e}") } else { format!("{value:.6}") }
}

#[cfg(test)]
mod tests {
    use super::*;

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
