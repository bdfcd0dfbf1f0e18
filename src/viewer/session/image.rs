//! How the picture is shown: its place in the window, its colours, and the values of its pixels.

use std::sync::Arc;

use glam::DVec2;

use super::Session;
use crate::image::exposure::{Exposure, auto_stops};
use crate::viewer::compared::{Shown, show};
use crate::viewer::histogram::Histogram;
use crate::viewer::layout::Placement;
use crate::viewer::paint::Colors;
use crate::viewer::quantity::{Picture, Quantity};

/// The steps of the exposure by keys, in stops, and the range.
const EXPOSURE_STEP: f32 = 0.5;
/// The range of the exposure, in stops.
pub const EXPOSURES: [f32; 2] = [-20.0, 20.0];

/// The values of the pixel under the cursor.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Column and row in the whole film, from the upper left corner.
    pub pixel: [u32; 2],
    /// What the values are of.
    pub quantity: Quantity,
    /// The values of the current picture.
    pub values: [f32; 3],
    /// The values of the other picture, if there is one of the same size.
    pub other: Option<[f32; 3]>,
}

impl Session {
    /// Returns the place of the image in the window.
    pub fn placement(&self) -> Placement {
        Placement::new(self.area, self.image(), self.zoom)
    }

    /// Converts a pixel of the window to a place on the image, whose corners are (0, 0) and (1, 1).
    pub fn on_image(&self, pixel: [f32; 2]) -> DVec2 {
        let Placement { origin, size, .. } = self.placement();
        let place = |axis: usize| f64::from((pixel[axis] - origin[axis]) / size[axis]);
        DVec2::new(place(0), place(1))
    }

    /// Returns the pixel of the window about which keys zoom: that under the cursor, else the middle.
    pub(super) fn hand(&self) -> [f32; 2] {
        self.cursor.unwrap_or_else(|| self.area.middle())
    }

    /// Moves the image in the window by eighths of the area.
    pub(super) fn shift(&mut self, eighths: [i8; 2]) {
        let by = [0, 1].map(|axis| f32::from(eighths[axis]) * self.area.size[axis] as f32 / 8.0);
        self.zoom = self.zoom.dragged(by, self.area, self.image());
    }

    /// Shows the picture in other colours.
    pub fn color(&mut self, colors: Colors) {
        self.is_changed |= self.colors != colors;
        self.colors = colors;
    }

    /// Changes the exposure by steps.
    pub(super) fn expose(&mut self, steps: i8) {
        let stops = self.look.stops + f32::from(steps) * EXPOSURE_STEP;
        self.set_exposure(Exposure::Stops(stops.clamp(EXPOSURES[0], EXPOSURES[1])));
    }

    /// Sets the exposure of the window and of PNGs that are saved.
    pub fn set_exposure(&mut self, exposure: Exposure) {
        self.has_auto_exposure = exposure == Exposure::Auto;
        if let Exposure::Stops(stops) = exposure {
            self.look.stops = stops;
        }
        self.follow_exposure();
    }

    /// Lets the exposure follow from the image, or keeps it as it is.
    pub fn auto_expose(&mut self, is_auto: bool) {
        self.set_exposure(if is_auto { Exposure::Auto } else { Exposure::Stops(self.look.stops) });
    }

    /// Returns the exposure of the window and of PNGs that are saved.
    pub(super) fn exposure(&self) -> Exposure {
        if self.has_auto_exposure { Exposure::Auto } else { Exposure::Stops(self.look.stops) }
    }

    /// Sets the automatic exposure of the picture, if it is light and not coarse, and the user wants it.
    pub(super) fn follow_exposure(&mut self) {
        let image = self.image();
        let is_light = |picture: &&Arc<Picture>| picture.quantity.is_radiance() && picture.size == image;
        if let Some(picture) = self.picture.as_ref().filter(|_| self.has_auto_exposure).filter(is_light) {
            self.look.stops = auto_stops(&picture.to_image());
        }
    }

    /// Hands the colours that the window shows to `take`, if they have changed.
    ///
    /// # Errors
    /// The error of `take`.
    pub fn repaint<E>(&mut self, take: impl FnOnce(&Shown<'_>) -> Result<(), E>) -> Result<(), E> {
        let Some(picture) = self.picture.as_ref().filter(|_| self.is_changed).map(Arc::clone) else { return Ok(()) };
        self.is_changed = false;
        // Another quantity is wished, and its picture is still to come.
        let colors = if picture.quantity == self.quantity { self.colors } else { Colors::first(picture.quantity) };
        let other = self.other_picture();
        let shown = show(&picture, other.as_deref(), colors, self.compared.beside);
        self.scale = shown.scale;
        take(&shown)
    }

    /// Returns the histogram of the picture.
    pub fn histogram(&mut self) -> Option<&Histogram> {
        let picture = self.picture.as_ref()?;
        if self.histogram.as_ref().is_none_or(|(number, _)| *number != self.pictures) {
            self.histogram = Some((self.pictures, Histogram::of(picture)));
        }
        self.histogram.as_ref().map(|(_, histogram)| histogram)
    }

    /// Returns the values of the pixel under the cursor.
    pub fn probe(&self) -> Option<Probe> {
        let at = self.on_image(self.cursor?);
        let picture = self.picture.as_ref()?;
        let values = picture.at(at.into())?;
        let other = self.other_picture().and_then(|other| other.at(at.into()));
        let [first, _] = self.film.bounds(self.resolution());
        let image = self.image();
        let pixel = [0, 1].map(|axis| first[axis] + (at[axis] * f64::from(image[axis])) as u32);
        Some(Probe { pixel, quantity: picture.quantity, values, other })
    }

    /// Returns the unit of the picture's values; empty for numbers without a unit.
    pub fn unit(&self) -> String {
        let quantity = self.picture.as_ref().map_or(self.quantity, |picture| picture.quantity);
        let is_light_of_film = matches!(quantity, Quantity::Image | Quantity::Direct | Quantity::Photons);
        if is_light_of_film && self.film.exposure != 1.0 {
            return format!("{} times the film's exposure, {:.4}", quantity.unit(), self.film.exposure);
        }
        quantity.unit().to_owned()
    }
}
