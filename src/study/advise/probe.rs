//! Short renders to which a model is fitted.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use goblet_host::Device;

use super::goal::Length;
use super::model::{Choice, Model, Seconds, Size};
use crate::image::estimate::dark_square;
use crate::image::smooth::{blurred, trimmed_mean};
use crate::render::activity::{Activity, Observer};
use crate::render::counts;
use crate::render::error::RenderError;
use crate::render::options::Options;
use crate::render::renderer::{Prepared, Renderer};
use crate::scene::Scene;

/// So many renders of equal length give a model; one that is longer by a factor corrects it.
const SHORT: u32 = 4;
const LONGER: u32 = 3;
/// Sum of the lengths of all of them, in lengths of a short one.
const SHARES: u32 = SHORT + LONGER;
/// The least share of the whole time that is left for the renders of a probe, however long kernels were compiled.
const LEAST_SHARE: u32 = 4;
/// Least number of iterations of each: one in each half.
const LEAST: u32 = 2;
const MOST: u32 = 64;
/// The iterations that a short render has time for, if need be with fewer pixels and photons.
const ENOUGH: f64 = 5.0;
/// The least share of the photons that a short render has: with fewer, most discs have no photon, and noise is no longer
/// in proportion to 1 / photons.
const FEW_PHOTONS: f64 = 0.25;
/// The number of pixels of the first render, which tells how many the others have time for.
const FEW_PIXELS: f64 = 4096.0;
/// Nearly all pixels: all of them are taken.
const NEARLY_ALL: f64 = 0.6;
/// Kernels whose time is in proportion to photons. The time to gather follows from its radii instead.
const OF_PHOTONS: [&str; 5] = ["photon", "grid_size", "grid_count", "grid_reserve", "grid_fill"];

/// The power of blur where a probe cannot measure it: between edges (1/2) and smooth light (2).
const USUAL_BLUR_POWER: f64 = 1.0;

/// A probe of a scene on a device.
pub struct Probe<'a> {
    device: &'a Arc<Device>,
    scene: &'a Scene,
    base: &'a Options,
    length: Length,
    observer: Observer,
    start: Instant,
    /// What is built and compiled for all renders; `None` before the first.
    renderer: Option<Renderer>,
    /// How many times fewer pixels the renders have along each side, and their size over that of the full image.
    fewer: f64,
    size: Size,
    /// Luminance of each pixel, summed over the iterations of all shots.
    luminances: Vec<f64>,
    iterations: u32,
    /// Divisors of the squared errors: squared luminances, as far as they are known.
    weights: Vec<f64>,
}

/// A short render.
struct Shot {
    iterations: u32,
    /// Luminance of each pixel in each half of the iterations.
    halves: Vec<[f64; 2]>,
    /// Seconds of an iteration: of all of it, and of the kernels of [`OF_PHOTONS`].
    seconds: f64,
    photon_seconds: f64,
    /// Seconds of the guide's pilot, which are not in those of the iterations.
    start_seconds: f64,
}

/// An estimate of a square, which noise may make negative.
struct Estimated {
    square: f64,
    /// Standard deviation of `square`.
    deviation: f64,
}

impl Estimated {
    /// Returns an upper bound of the square, two deviations above it: wide discs must not look good
    /// because noise hides their blur.
    fn at_most(&self) -> f64 {
        self.square.max(0.0) + 2.0 * self.deviation
    }

    /// Returns the root, if the square is three deviations above 0.
    fn root(&self) -> Option<f64> {
        (self.square > 3.0 * self.deviation).then(|| self.square.sqrt())
    }
}

impl<'a> Probe<'a> {
    pub fn new(
        device: &'a Arc<Device>,
        scene: &'a Scene,
        base: &'a Options,
        length: Length,
        observer: Observer,
    ) -> Self {
        let (luminances, weights) = Default::default();
        Self {
            device,
            scene,
            base,
            length,
            observer,
            start: Instant::now(),
            renderer: None,
            fewer: 1.0,
            size: Size::FULL,
            luminances,
            iterations: 0,
            weights,
        }
    }

    /// Returns the seconds since the probe was begun.
    pub fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Returns the options of `goblet render` for a choice. Those that have their defaults stay unset.
    pub fn options(&self, choice: Choice) -> Options {
        let mut options = self.base.clone();
        if choice.eye_paths != Choice::DEFAULT.eye_paths {
            options.eye_paths = Some(choice.eye_paths);
        }
        if choice.radius != 1.0 {
            match self.scene.integrator.radius {
                Some(radius) => options.radius = Some(three_figures(choice.radius * radius)),
                None => {
                    options.radius_in_pixels = Some(three_figures(choice.radius * Options::DEFAULT_RADIUS_IN_PIXELS));
                }
            }
        }
        if choice.photons != 1.0 {
            options.photons = Some((choice.photons * self.default_photons() as f64).round().max(1.0) as u64);
        }
        options
    }

    /// Finds the numbers of photons and eye paths that a render with `auto` takes.
    pub fn auto(&mut self) -> Result<counts::Choice, RenderError> {
        let auto = counts::Auto { photons: true, eye_paths: true };
        let renderer = self.build(&Options { auto, ..self.base.clone() })?;
        let choice = *renderer.choice().expect("options that ask for a trial");
        self.renderer = Some(renderer);
        Ok(choice)
    }

    /// Builds and compiles what all renders need.
    fn build(&self, options: &Options) -> Result<Renderer, RenderError> {
        let prepared = Prepared::new(self.scene, options, self.observer.clone())?;
        let mut renderer = prepared.build(Arc::clone(self.device))?;
        // From now on, what is told is the number of the render.
        renderer.set_observer(Observer::default());
        Ok(renderer)
    }

    /// Chooses the numbers of pixels and photons, so that a short render has time for enough iterations.
    fn choose_size(&mut self, time: Duration) -> Result<(), RenderError> {
        let pixels = self.pixels() as f64;
        self.fewer = (pixels / FEW_PIXELS).sqrt().max(1.0);
        let shot = self.shoot(Choice::DEFAULT, LEAST..=LEAST, Duration::MAX)?;
        self.forget();
        let of_photons = shot.photon_seconds;
        let of_pixels = (shot.seconds - of_photons).max(1e-9) / self.size.pixels;
        let seconds = time.as_secs_f64() / ENOUGH;
        // Photons have half of the time at most, unless they become too few.
        let photons = if 2.0 * of_photons > seconds { (0.5 * seconds / of_photons).max(FEW_PHOTONS) } else { 1.0 };
        let pixels = ((seconds - photons * of_photons) / of_pixels).clamp(self.size.pixels, 1.0);
        self.size.photons = photons;
        self.fewer = if pixels > NEARLY_ALL { 1.0 } else { pixels.sqrt().recip() };
        Ok(())
    }

    /// Starts a render of a choice.
    fn begin(&mut self, choice: Choice) -> Result<Renderer, RenderError> {
        let mut renderer = match self.renderer.take() {
            Some(renderer) => renderer,
            None => self.build(&self.options(choice))?,
        };
        let photons = (self.size.photons * choice.photons * self.default_photons() as f64).round().max(1.0) as u64;
        let options = Options { photons: Some(photons), ..self.options(choice) };
        self.size.pixels = renderer.restart_with_fewer_pixels(self.scene, &options, self.fewer)?;
        Ok(renderer)
    }

    fn default_photons(&self) -> u64 {
        self.scene.integrator.photons_per_iteration.unwrap_or_else(|| self.pixels())
    }

    fn pixels(&self) -> u64 {
        let film = &self.scene.film;
        let [first, end] = film.bounds(self.base.resolution.unwrap_or(film.resolution));
        u64::from(end[0] - first[0]) * u64::from(end[1] - first[1])
    }

    /// Returns the time that is left of the whole.
    fn left(&self, time: Duration) -> Duration {
        time.saturating_sub(self.start.elapsed()).max(time / LEAST_SHARE)
    }

    /// Renders four short images, and fits a model to them.
    pub fn model(&mut self) -> Result<Model, RenderError> {
        let at = |radius| Choice { radius, ..Choice::DEFAULT };
        let (iterations, share) = match self.length {
            Length::Time(time) => {
                self.tell(0);
                self.choose_size(self.left(time) / SHARES)?;
                (LEAST..=MOST, self.left(time) / SHARES)
            }
            Length::Iterations(count) => (count..=count, Duration::MAX),
        };
        // All have the same random numbers, so that images differ by the settings only.
        self.tell(1);
        let wide = self.shoot(at(2.0), iterations, share)?;
        let same = wide.iterations..=wide.iterations;
        self.tell(2);
        let usual = self.shoot(at(1.0), same.clone(), share)?;
        self.tell(3);
        let narrow = self.shoot(at(0.5), same.clone(), share)?;
        self.tell(SHORT);
        let few = self.shoot(Choice { eye_paths: 1, ..Choice::DEFAULT }, same, share)?;
        Ok(self.fit([&wide, &usual, &narrow], &few))
    }

    /// Tells which render of the probe begins; 0 is the one that chooses their size.
    fn tell(&self, number: u32) {
        self.observer.tell(Activity::Probing { number: number.max(1), all: SHORT + 1 });
    }

    fn fit(&self, [wide, usual, narrow]: [&Shot; 3], few: &Shot) -> Model {
        let n = f64::from(wide.iterations);
        let alpha = self.base.alpha.unwrap_or(crate::render::options::DEFAULT_ALPHA);
        // Noise is a + v / r². Eye paths are the same at all radii, so that differences are noise of photons.
        let [noise_wide, noise, noise_narrow] = [wide, usual, narrow].map(|shot| self.noise(shot));
        let photons = ((noise_narrow - noise_wide) / (4.0 - 0.25)).clamp(0.0, noise_narrow / 4.0);
        let rest = ((noise_wide + noise + noise_narrow - 5.25 * photons) / 3.0).max(0.0);
        let eye_paths = f64::from(Choice::DEFAULT.eye_paths);
        let eye = ((self.noise(few) - noise) / (eye_paths - 1.0)).clamp(0.0, rest);

        // Blur is b r^k. Its differences between radii follow from the halves.
        let [outer, inner] = [self.blur(wide, usual), self.blur(usual, narrow)];
        let blur_power = match (outer.root(), inner.root()) {
            (Some(outer), Some(inner)) => (outer / inner).log2().clamp(0.5, 2.0),
            _ => USUAL_BLUR_POWER,
        };
        let blur = outer.at_most().sqrt() / (blur_power.exp2() - 1.0);

        let gather = ((wide.seconds - narrow.seconds) / (4.0 - 0.25)).max(0.0);
        let eye_path = ((usual.seconds - few.seconds) / (eye_paths - 1.0)).max(0.0);
        let of_photons = usual.photon_seconds;
        let seconds = Seconds {
            eye_path,
            photons: of_photons,
            gather,
            rest: (usual.seconds - eye_paths * eye_path - of_photons - gather).max(0.0),
        };
        // From the image of n iterations to that of one, and from the photons of the probe to those of the render.
        let (seconds, start) = (seconds.scaled(self.size.inverse()), usual.start_seconds);
        let unit = Model { alpha, eye: 1.0, iteration: 0.0, photons: 1.0, blur: 1.0, blur_power, seconds, start };
        let of_unit = unit.parts(Choice::DEFAULT, wide.iterations);
        Model {
            eye: eye * n,
            iteration: (rest - eye) * n,
            photons: self.size.photons * photons / of_unit.photons,
            blur: blur / of_unit.blur.sqrt(),
            ..unit
        }
    }

    /// Renders a choice for a short time, and returns the model with the noise and the time of an iteration
    /// that were measured.
    pub fn correct(&mut self, model: &Model, choice: Choice) -> Result<Model, RenderError> {
        let (iterations, left) = match self.length {
            Length::Time(time) => {
                (LEAST..=u32::MAX, time.saturating_sub(self.start.elapsed()).max(self.left(time) * LONGER / SHARES))
            }
            Length::Iterations(count) => (LONGER * count..=LONGER * count, Duration::MAX),
        };
        self.tell(SHORT + 1);
        let shot = self.shoot(choice, iterations, left)?;
        let parts = model.parts(Choice { photons: self.size.photons * choice.photons, ..choice }, shot.iterations);
        let predicted = parts.eye + parts.photons;
        let noise = self.noise(&shot);
        let factor = if predicted > 0.0 && noise > 0.0 { noise / predicted } else { 1.0 };
        let slower = shot.seconds / model.seconds.scaled(self.size).of(choice);
        let Seconds { eye_path, photons, gather, rest } = model.seconds;
        Ok(Model {
            eye: model.eye * factor,
            iteration: model.iteration * factor,
            photons: model.photons * factor,
            seconds: Seconds {
                eye_path: eye_path * slower,
                photons: photons * slower,
                gather: gather * slower,
                rest: rest * slower,
            },
            start: shot.start_seconds,
            ..*model
        })
    }

    /// Updates the weights. Errors are divided by luminances; the noise of few iterations would make some
    /// too dark, so each luminance is the mean over all shots and over the pixels around.
    fn learn(&mut self, halves: &[[f64; 2]], iterations: u32, width: usize) {
        self.luminances.resize(halves.len(), 0.0);
        for (sum, [a, b]) in self.luminances.iter_mut().zip(halves) {
            *sum += f64::from(iterations) * 0.5 * (a + b);
        }
        self.iterations += iterations;
        let mean = |sum: f64| sum / f64::from(self.iterations);
        let floor = dark_square(self.luminances.iter().map(|sum| mean(*sum))).unwrap_or(1.0);
        let blurred = blurred(&self.luminances, width);
        self.weights = blurred.into_iter().map(|sum| mean(sum).powi(2) + floor).collect();
    }

    /// Forgets the weights: other renders have other pixels.
    fn forget(&mut self) {
        (self.luminances, self.weights, self.iterations) = Default::default();
    }

    /// Returns the squared noise of an image: that of the mean of its two halves.
    fn noise(&self, shot: &Shot) -> f64 {
        let squares = shot.halves.iter().zip(&self.weights).map(|([a, b], weight)| (a - b).powi(2) / (4.0 * weight));
        trimmed_mean(squares.collect())
    }

    /// Estimates the squared difference of two images without their noise. The halves of an image are
    /// independent, so that noise does not contribute to the mean of a product.
    fn blur(&self, a: &Shot, b: &Shot) -> Estimated {
        let products = a.halves.iter().zip(&b.halves).map(|(a, b)| (a[0] - b[0]) * (a[1] - b[1]));
        let products: Vec<f64> = products.zip(&self.weights).map(|(product, weight)| product / weight).collect();
        let variance = trimmed_mean(products.iter().map(|product| product * product).collect());
        Estimated { deviation: (variance / products.len() as f64).sqrt(), square: trimmed_mean(products) }
    }

    /// Renders for a time, with a number of iterations in a range, made even.
    fn shoot(
        &mut self,
        choice: Choice,
        iterations: std::ops::RangeInclusive<u32>,
        time: Duration,
    ) -> Result<Shot, RenderError> {
        let mut renderer = self.begin(choice)?;
        let passes = || -> BTreeMap<_, _> { self.device.pass_times().into_iter().collect() };
        let of_photons = |passes: &BTreeMap<&str, Duration>| -> f64 {
            OF_PHOTONS.iter().filter_map(|name| passes.get(name)).map(Duration::as_secs_f64).sum()
        };
        let start = Instant::now();
        // Photons of the pilot are in the first iteration.
        renderer.step()?;
        let before = of_photons(&passes());
        while renderer.iterations() < *iterations.start()
            || !renderer.iterations().is_multiple_of(2)
            || (renderer.iterations() < *iterations.end() && start.elapsed() < time)
        {
            renderer.step()?;
        }
        let start_seconds = renderer.guide().map_or(0.0, |guide| guide.time.as_secs_f64());
        let seconds = start.elapsed().as_secs_f64() - start_seconds;
        let estimate = renderer.estimate()?;
        let count = renderer.iterations();
        let halves: Vec<[f64; 2]> = estimate.half_luminances().map(Iterator::collect).unwrap_or_default();
        self.learn(&halves, count, estimate.resolution[0] as usize);
        self.renderer = Some(renderer);
        Ok(Shot {
            iterations: count,
            halves,
            seconds: seconds / f64::from(count),
            photon_seconds: (of_photons(&passes()) - before) / f64::from(count - 1),
            start_seconds,
        })
    }
}

/// Rounds to three significant figures, so that commands are short.
fn three_figures(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
