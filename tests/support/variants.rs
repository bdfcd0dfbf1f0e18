//! Every way to render the same image, and the scenes on which the ways are compared: shared
//! by the test and the example of this name.
#![allow(dead_code, reason = "each user uses a part of this")]

use std::path::Path;

use glam::DVec2;
use goblet::image::file;
use goblet::image::film::Image;
use goblet::scene::{FilterKind, PixelFilter, Scene};
use goblet::{DirectLight, Integrator, Options, RadiusSchedule, Sampler};

/// One value of each option that may change the noise of an image, and must not change what
/// it converges to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    pub integrator: Integrator,
    pub radius_schedule: RadiusSchedule,
    pub direct: DirectLight,
    pub sampler: Sampler,
}

impl Variant {
    /// All 16; the defaults come first.
    pub fn all() -> Vec<Self> {
        (0..16).map(Self::number).collect()
    }

    /// Half of them, in which any three options meet in every combination of their values:
    /// those with an even number of options that are not the default.
    pub fn covering() -> Vec<Self> {
        (0..16_u32).filter(|number| number.count_ones() % 2 == 0).map(Self::number).collect()
    }

    /// Five of them, in which any two options meet in every combination of their values: the defaults, and
    /// those with one option that is the default.
    pub fn pairs() -> Vec<Self> {
        (0..16_u32).filter(|number| [0, 3].contains(&number.count_ones())).map(Self::number).collect()
    }

    /// A bit per option, 0 where it is the default.
    fn number(number: u32) -> Self {
        let bit = |i: u32| number >> i & 1 == 1;
        Self {
            integrator: if bit(3) { Integrator::Ppm } else { Integrator::Sppm },
            radius_schedule: if bit(2) { RadiusSchedule::Global } else { RadiusSchedule::Adaptive },
            direct: if bit(1) { DirectLight::Photons } else { DirectLight::Nee },
            sampler: if bit(0) { Sampler::Pcg } else { Sampler::Sobol },
        }
    }

    /// The words of the command line: "sppm adaptive nee sobol".
    pub fn name(self) -> String {
        let Self { integrator, radius_schedule, direct, sampler } = self;
        format!("{integrator:?} {radius_schedule:?} {direct:?} {sampler:?}").to_lowercase()
    }

    /// The options; progressive photon mapping has rounds of `round` iterations.
    pub fn options(self, base: &Options, round: u64) -> Options {
        let Self { integrator, radius_schedule, direct, sampler } = self;
        let per_round = base.photons.map(|photons| photons * round);
        let photons_per_round = if integrator == Integrator::Ppm { per_round } else { None };
        Options { integrator, photons_per_round, radius_schedule, direct, sampler, ..base.clone() }
    }
}

/// A scene whose pixels are boxes, so that the mean of a reference's pixels is the reference
/// of a smaller image.
pub fn boxed_scene(path: &Path) -> Scene {
    let mut scene = Scene::load(path).expect("a scene");
    scene.film.filter = PixelFilter { kind: FilterKind::Box, radius: DVec2::splat(0.5) };
    scene
}

/// Reads an image, and makes its width and height smaller by a whole factor.
pub fn reference(path: &Path, factor: u32) -> Image {
    boxed(&file::read(path).expect("a reference"), factor)
}

/// The image of means over squares of `factor` pixels a side.
pub fn boxed(image: &Image, factor: u32) -> Image {
    let [width, height] = [image.width / factor, image.height / factor];
    assert_eq!([width * factor, height * factor], [image.width, image.height], "whole boxes");
    let mut small = Image::new(width, height);
    let weight = 1.0 / (factor * factor) as f32;
    for (i, pixel) in image.pixels.iter().enumerate() {
        let [x, y] = [i as u32 % image.width / factor, i as u32 / image.width / factor];
        let sum = &mut small.pixels[(y * width + x) as usize];
        for (sum, value) in sum.iter_mut().zip(pixel) {
            *sum += value * weight;
        }
    }
    small
}
