//! Comparison of the picture with a kept one or with an image file.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::Session;
use crate::image::compare::Comparison;
use crate::viewer::compared::{Beside, Compared, Measurement, Other, error};
use crate::viewer::quantity::Picture;

/// The least time between two measurements of the error.
const BETWEEN: Duration = Duration::from_secs(1);
/// How far a key moves the line, in widths of the image.
const STEP: f32 = 0.05;

impl Session {
    /// Keeps the current picture for a comparison.
    pub fn keep(&mut self) {
        let image = self.image();
        let Some(picture) = self.picture.as_ref().filter(|picture| picture.size == image) else {
            self.message = Some(Err("there is no image to keep yet: expected one that is not coarse".to_owned()));
            return;
        };
        let iterations = self.status.iterations;
        let unit = if iterations == 1 { "iteration" } else { "iterations" };
        let name = format!("{} after {iterations} {unit}", picture.quantity.name());
        self.message = Some(Ok(format!("kept {name}: B shows it, V shows both")));
        let picture = Arc::clone(picture);
        self.take_other(Other { name, picture });
    }

    /// Compares with an image from now on.
    pub(super) fn take_other(&mut self, other: Other) {
        self.compared = Compared { other: Some(other), beside: self.compared.beside, ..Compared::default() };
        self.is_changed = true;
    }

    /// Ends the comparison.
    pub fn forget_other(&mut self) {
        self.compared = Compared::default();
        self.is_changed = true;
    }

    /// Reads an image file to compare with, on a thread of its own, because large files take seconds.
    pub fn compare_with(&mut self, path: &Path) {
        self.reference_text = path.display().to_string();
        self.message = Some(Ok(format!("reading {}", path.display())));
        let (shared, path) = (Arc::clone(&self.shared), path.to_owned());
        std::thread::spawn(move || {
            let other = Other::read(&path);
            shared.tell(|news| news.other = Some(other));
        });
    }

    /// Returns the other picture, if it can be compared with the current one.
    pub(super) fn other_picture(&self) -> Option<Arc<Picture>> {
        let other = self.compared.other.as_ref()?;
        other.refusal(self.image(), self.quantity).is_none().then(|| Arc::clone(&other.picture))
    }

    /// Returns why the other picture cannot be compared with the current one.
    pub fn refusal(&self) -> Option<String> {
        self.compared.other.as_ref()?.refusal(self.image(), self.quantity)
    }

    /// Returns whether another picture is shown now.
    pub fn shows_other(&self) -> bool {
        self.compared.beside != Beside::Current && self.other_picture().is_some()
    }

    /// Shows the other picture, or the current one again.
    pub(super) fn flip(&mut self) {
        self.set_beside(if self.compared.beside == Beside::Other { Beside::Current } else { Beside::Other });
    }

    /// Shows both, or the current one again.
    pub(super) fn split(&mut self) {
        let is_split = matches!(self.compared.beside, Beside::Split(_));
        self.set_beside(if is_split { Beside::Current } else { Beside::Split(0.5) });
    }

    /// Moves the line between both.
    pub(super) fn move_split(&mut self, is_right: bool) {
        let Beside::Split(line) = self.compared.beside else {
            self.message = Some(Ok("there is no line to move: V shows both images".to_owned()));
            return;
        };
        self.set_beside(Beside::Split(line + if is_right { STEP } else { -STEP }));
    }

    /// Shows one of the pictures or both.
    pub fn set_beside(&mut self, beside: Beside) {
        if self.compared.other.is_none() {
            self.message = Some(Ok("there is nothing to compare with: K keeps this image".to_owned()));
            return;
        }
        let beside = if let Beside::Split(line) = beside { Beside::Split(line.clamp(0.0, 1.0)) } else { beside };
        self.is_changed |= self.compared.beside != beside;
        self.compared.beside = beside;
    }

    /// Renders at the size of the other picture from now on, until the window gets another size.
    pub fn take_size_of_other(&mut self) {
        if let Some(other) = &self.compared.other {
            self.options.resolution = Some(other.picture.size);
            self.look_again(false);
        }
    }

    /// Takes the result of a measurement. Measurements against another picture than the present one are too late.
    pub(super) fn take_error(&mut self, number: u64, error: Comparison) {
        if let Some(measured) = self.compared.measured.as_mut().filter(|measured| measured.number == number) {
            measured.is_done = true;
            self.compared.error = Some(error);
        }
    }

    /// Measures the error of the current picture, unless that was done, or another measurement is in progress or has
    /// begun just now. It takes a thread of its own, because it takes longer than a frame may.
    pub(super) fn measure(&mut self) {
        let (Some(other), Some(picture)) = (self.other_picture(), &self.picture) else { return };
        if picture.size != other.size || !picture.quantity.is_radiance() || !other.quantity.is_radiance() {
            self.compared.error = None;
            return;
        }
        let is_due = self.compared.measured.as_ref().is_none_or(|last| {
            let is_soon = last.start.elapsed() < BETWEEN && !self.status.doing.is_rest();
            last.is_done && last.picture != self.pictures && !is_soon
        });
        if !is_due {
            return;
        }
        self.measurements += 1;
        let (number, start) = (self.measurements, Instant::now());
        self.compared.measured = Some(Measurement { number, picture: self.pictures, start, is_done: false });
        let (picture, shared) = (Arc::clone(picture), Arc::clone(&self.shared));
        std::thread::spawn(move || {
            if let Ok(error) = error(&picture, &other) {
                shared.tell(|news| news.comparison = Some((number, error)));
            }
        });
    }
}
