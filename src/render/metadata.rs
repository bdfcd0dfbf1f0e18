//! What a file says of the render that made its image. Names and matrices that pbrt writes have pbrt's names;
//! the others begin with `goblet.`.

use crate::image::estimate::Estimate;
use crate::image::file::Attribute;
use crate::render::checkpoint::difference::{EYE_PATHS, ROUND};
use crate::render::checkpoint::{Checkpoint, MadeBy};
use crate::render::frame::Frame;
use crate::render::identity::Identity;
use crate::render::options::table::{Effect, OPTIONS};
use crate::render::radius::FirstRadius;
use crate::render::renderer::Renderer;

/// The facts of a render that its files name.
struct Facts<'a> {
    scene: &'a str,
    made_by: &'a MadeBy,
    identity: &'a Identity,
    first_radius: Option<FirstRadius>,
    frame: Option<Frame>,
    photons: u64,
}

impl Facts<'_> {
    fn attributes(&self, estimate: &Estimate) -> Vec<(String, Attribute)> {
        let MadeBy { version, device, driver } = self.made_by;
        let text = |text: &str| Attribute::Text(text.to_owned());
        let mut all = vec![
            ("goblet.version", text(version)),
            ("goblet.scene", text(self.scene)),
            ("goblet.device", text(device)),
            ("goblet.driver", text(driver)),
            ("goblet.iterations", integer(estimate.iterations())),
            ("goblet.photons", integer(self.photons)),
        ];
        if let Some(error) = estimate.relative_error().filter(|error| error.is_finite()) {
            all.push(("goblet.relativeError", Attribute::Number(error)));
        }
        if let Some(samples) = self.samples_per_pixel(estimate) {
            all.push(("samplesPerPixel", integer(samples)));
        }
        if let Some(Frame { world_to_camera, world_to_ndc, length }) = self.frame {
            all.push(("worldToCamera", Attribute::Matrix(world_to_camera)));
            all.extend(world_to_ndc.map(|matrix| ("worldToNDC", Attribute::Matrix(matrix))));
            all.extend(self.first_radius.map(|radius| ("goblet.radius", Attribute::Number(radius.middle() * length))));
        }
        let mut all: Vec<_> = all.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        all.extend(self.options().map(|(name, value)| (format!("goblet.option.{name}"), Attribute::of_text(value))));
        all
    }

    /// Returns the options that determine the image: the name that `goblet render` has for each, and its value.
    fn options(&self) -> impl Iterator<Item = (&'static str, &str)> {
        OPTIONS.iter().filter_map(|option| match option.effect {
            Effect::Image(name, _) => Some((option.name, self.identity.value(name)?)),
            Effect::PartOf | Effect::End | Effect::Cost => None,
        })
    }

    /// Returns the number of eye paths of each pixel; `None` if the identity does not tell.
    fn samples_per_pixel(&self, estimate: &Estimate) -> Option<u64> {
        let number = |name| self.identity.value(name)?.parse::<u64>().ok();
        let rounds = estimate.iterations().div_ceil(number(ROUND)?.max(1));
        rounds.checked_mul(number(EYE_PATHS)?)
    }
}

fn integer(number: u64) -> Attribute {
    i64::try_from(number).map_or(Attribute::Number(number as f64), Attribute::Integer)
}

impl Renderer {
    /// Returns the attributes of files with this estimate of the render. They name neither a time nor a host, so
    /// that the same render gives the same file. `scene` is the name of the scene.
    #[must_use]
    pub fn metadata(&self, scene: &str, estimate: &Estimate) -> Vec<(String, Attribute)> {
        let (identity, first_radius, frame) = self.facts();
        let made_by = MadeBy::new(self.device());
        let photons = self.photons();
        Facts { scene, made_by: &made_by, identity, first_radius, frame, photons }.attributes(estimate)
    }
}

impl Checkpoint {
    /// Returns the attributes of files with the image of the checkpoint, as [`Renderer::metadata`] does.
    #[must_use]
    pub fn metadata(&self) -> Vec<(String, Attribute)> {
        let Self { scene, made_by, identity, first_radius, frame, tally, estimate, .. } = self;
        let facts =
            Facts { scene, made_by, identity, first_radius: *first_radius, frame: *frame, photons: tally.emitted };
        facts.attributes(estimate)
    }
}
