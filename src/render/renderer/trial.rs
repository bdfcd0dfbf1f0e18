//! A trial before the first iteration, which chooses the numbers of photons and of eye paths: [`crate::render::counts`].
//!
//! The trial renders a sparse sample of the pixels, with the hierarchy and the kernels of the render, and with pixels and
//! discs as wide as those of the full image. Iterations come in pairs that share their eye paths. The difference within a
//! pair is the noise of photons. The difference between pairs in the light of eye paths is the noise of eye paths. The
//! rest of the difference between pairs is noise that depends on the number of iterations only.
//!
//! The result depends on the scene, the options and the seed only, and not on a clock. Every shard, and a resumed render,
//! gets the same result.

use std::sync::Arc;
use std::time::Instant;

use goblet_host::Device;

use super::{Prepared, Renderer};
use crate::image::estimate::dark_square;
use crate::image::smooth::{blurred, trimmed_mean};
use crate::render::activity::{Activity, Observer};
use crate::render::counts::{Auto, Choice, Counts, Trial};
use crate::render::error::RenderError;
use crate::render::options::{Integrator, MAX_PHOTONS, Options, Resolved};
use crate::render::radius::{GlobalShrink, RadiusSchedule};
use crate::render::sequence::Shard;
use crate::scene::Scene;

/// The approximate number of pixels of a trial.
const PIXELS: f64 = 4096.0;
/// The number of pairs of iterations.
const PAIRS: usize = 4;
/// The least and the largest number of photons in an iteration of a trial, unless the render has fewer.
const PHOTONS: [u64; 2] = [1 << 12, 1 << 15];
/// The number of iterations of a typical render. The discs shrink during these iterations, so that the noise of photons
/// is larger than in the first iteration.
const USUAL_ITERATIONS: u64 = 64;

/// Work in eye paths: of a photon's path, of each record on it, from which most paths go on, and of a record on the disc of
/// a visible point. Fitted to llvmpipe's times for the scenes of `tests/reference`, from which single scenes differ by up
/// to a factor of 1.5. With numbers for twice the work of a photon, the squared noise after the same work is 1.03 times as
/// large, where photons and eye paths have equal shares: (1 + sqrt 2)² / (4 sqrt 2).
const WORK_OF_PATH: f64 = 0.55;
const WORK_OF_RECORD: f64 = 1.5;
const WORK_OF_GATHERED: f64 = 0.08;

impl Renderer {
    /// Prepares a scene for rendering: builds the hierarchy, uploads the scene and compiles the kernels. Renders a trial
    /// if [`Options::auto`] asks for one.
    ///
    /// # Errors
    /// The scene cannot be rendered, an option is out of range, or the host or the device does not have
    /// enough memory.
    pub fn new(device: Arc<Device>, scene: &Scene, options: &Options) -> Result<Self, RenderError> {
        Prepared::new(scene, options, Observer::default())?.build(device)
    }

    /// Returns what a trial has chosen; `None` if there was none.
    pub fn choice(&self) -> Option<&Choice> {
        self.choice.as_ref()
    }

    /// Chooses the numbers of photons and eye paths, and starts again with them.
    pub(super) fn choose_counts(&mut self, scene: &Scene, options: &Options) -> Result<(), RenderError> {
        let start = Instant::now();
        // The iterations of a trial, and their pilot, are parts of the trial.
        let observer = std::mem::take(&mut self.observer);
        observer.tell(Activity::Trial);
        let (resolved, view) = self.base.resolve(scene, options)?;
        let usual = Counts { photons: resolved.photons, eye_paths: resolved.eye_paths };
        let trial = self.try_out(scene, options, &resolved, view.pixel_width)?;
        let most = Counts { photons: MAX_PHOTONS, eye_paths: Options::EYE_PATHS[1] };
        let taken = trial.choose(usual, options.auto, most);
        let Counts { photons, eye_paths } = taken;
        let chosen =
            Options { photons: Some(photons), eye_paths: Some(eye_paths), auto: Auto::default(), ..options.clone() };
        let (resolved, view) = self.base.resolve(scene, &chosen)?;
        self.begin_again(scene, &chosen, &resolved, &view)?;
        self.choice = Some(Choice { trial, usual, taken, time: start.elapsed() });
        self.observer = observer;
        Ok(())
    }

    /// Renders the trial. `pixel_width` is that of the full image.
    fn try_out(
        &mut self,
        scene: &Scene,
        options: &Options,
        full: &Resolved,
        pixel_width: f64,
    ) -> Result<Trial, RenderError> {
        let pixels = |resolution: [u32; 2]| resolution.map(f64::from).iter().product::<f64>();
        let fewer = (pixels(full.resolution) / PIXELS).sqrt().max(1.0);
        let size = (full, pixel_width, fewer);
        let photons = (full.photons / 8).clamp(PHOTONS[0], PHOTONS[1]).min(full.photons);
        let small = Options {
            photons: Some(photons),
            integrator: Integrator::Ppm,
            photons_per_round: Some(2 * photons),
            // Discs keep their size.
            alpha: Some(1.0),
            shard: Shard::WHOLE,
            ..options.clone()
        };
        let resolved = self.begin_with_fewer_pixels(scene, small, size)?;
        let shots = self.shoot()?;

        let [width, _] = resolved.resolution;
        let [eye, photon, other] = shots.noise(width as usize);
        let [length, pixels] = [f64::from(full.sequence.round_length), pixels(full.resolution)];
        let (emitted, recorded) = (self.progress.tally.emitted as f64, self.progress.tally.recorded as f64);
        let [larger_noise, smaller_area] = shrinkage(full.alpha, full.sequence.round_length);
        let gathered = shots.gathered * smaller_area * pixels / self.settings.pixels() as f64;
        let works = WORK_OF_PATH * emitted + WORK_OF_RECORD * recorded + WORK_OF_GATHERED * gathered;
        Ok(Trial {
            eye_noise: eye * f64::from(full.eye_paths) * length,
            photon_noise: photon * photons as f64 * larger_noise,
            other_noise: other * length,
            eye_work: pixels / length,
            photon_work: if emitted > 0.0 { works / emitted } else { 0.0 },
            photons_matter: self.settings.photons_matter,
        })
    }

    /// Starts again with fewer pixels, by a factor along each side, each as wide as one of the full image and with a
    /// disc of the same size: its noise is that of the full image with the same numbers of photons and eye paths.
    /// Returns the share of pixels that it has.
    ///
    /// # Errors
    /// An option is out of range, or the device fails.
    #[cfg(feature = "study")]
    pub(crate) fn restart_with_fewer_pixels(
        &mut self,
        scene: &Scene,
        options: &Options,
        fewer: f64,
    ) -> Result<f64, RenderError> {
        let pixels = |resolution: [u32; 2]| resolution.map(f64::from).iter().product::<f64>();
        let (full, view) = self.base.resolve(scene, options)?;
        let small = self.begin_with_fewer_pixels(scene, options.clone(), (&full, view.pixel_width, fewer))?;
        Ok(pixels(small.resolution) / pixels(full.resolution))
    }

    /// Does so, with the values of the full image, the width of its pixels, and the factor.
    fn begin_with_fewer_pixels(
        &mut self,
        scene: &Scene,
        options: Options,
        (full, pixel_width, fewer): (&Resolved, f64, f64),
    ) -> Result<Resolved, RenderError> {
        let resolution = full.window.full.map(|side| (f64::from(side) / fewer).floor().max(1.0) as u32);
        let small = Options { resolution: Some(resolution), ..options };
        let (mut resolved, view) = self.base.resolve(scene, &small)?;
        let narrower = pixel_width / view.pixel_width;
        resolved.radius_in_pixels = full.radius_in_pixels * narrower;
        let view = view.with_narrow_filter(narrower);
        self.begin_again(scene, &small, &resolved, &view)?;
        Ok(resolved)
    }

    /// Renders the iterations of a trial.
    fn shoot(&mut self) -> Result<Shots, RenderError> {
        let pixels = self.settings.pixels();
        let [red, green, blue] = self.settings.luminance();
        let mut shots = Shots { pairs: Vec::new(), of_eye_paths: Vec::new(), gathered: 0.0 };
        let mut before = vec![0.0; pixels as usize];
        let mut next = |renderer: &mut Self| -> Result<Vec<f64>, RenderError> {
            renderer.step()?;
            let sums: Vec<f64> = renderer.estimate()?.luminance_sums().collect();
            let terms = sums.iter().zip(&before).map(|(sum, before)| sum - before).collect();
            before = sums;
            Ok(terms)
        };
        for _ in 0..PAIRS {
            shots.pairs.push([next(self)?, next(self)?]);
            shots.gathered += self.gathered()?;
            let radiances = self.device.read_first_texels(&self.buffers.visible_radiances, pixels)?;
            let luminance = |[r, g, b, _]: [f32; 4]| red * f64::from(r) + green * f64::from(g) + blue * f64::from(b);
            let unit = self.settings.unit;
            shots.of_eye_paths.push(radiances.into_iter().map(|radiance| luminance(radiance) / unit).collect());
        }
        Ok(shots)
    }

    /// Returns the number of records that visible points have gathered in this pair.
    fn gathered(&self) -> Result<f64, RenderError> {
        let states = self.device.read_first_texels(&self.buffers.pixel_states, self.settings.pixels())?;
        let has_sums = self.settings.radius_schedule == RadiusSchedule::Data;
        let found = |low: u32, high: u32| {
            if has_sums {
                f64::from(f32::from_bits(low))
            } else {
                f64::from(high).mul_add(4_294_967_296.0, f64::from(low))
            }
        };
        Ok(states.iter().map(|state| found(state.found_low, state.found_high)).sum())
    }
}

/// Returns two ratios of a typical render to its first iteration: of the noise of photons, and of the area of discs.
fn shrinkage(alpha: f64, round_length: u32) -> [f64; 2] {
    let count = if round_length > 1 { u64::from(round_length).min(USUAL_ITERATIONS) } else { USUAL_ITERATIONS };
    let mut shrink = GlobalShrink::new(alpha);
    let areas: Vec<f64> = (0..count).map(|step| shrink.at(step)).collect();
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / count as f64;
    [mean(&mut areas.iter().map(|area| 1.0 / area)), mean(&mut areas.iter().copied())]
}

/// Luminances of the pixels of a trial, in multiples of the unit.
struct Shots {
    /// The luminances of the two iterations of each pair.
    pairs: Vec<[Vec<f64>; 2]>,
    /// The luminances of the light that eye paths find, for each pair.
    of_eye_paths: Vec<Vec<f64>>,
    /// The number of records that visible points have gathered.
    gathered: f64,
}

impl Shots {
    /// Returns three parts of the squared relative noise of an iteration: of eye paths, of photons, and the rest.
    fn noise(&self, width: usize) -> [f64; 3] {
        let pairs = self.pairs.len() as f64;
        let images = || self.pairs.iter().flatten();
        let pixels = 0..self.of_eye_paths[0].len();
        let mean = |pixel: usize| images().map(|image| image[pixel]).sum::<f64>() / (2.0 * pairs);
        let means = blurred(&pixels.clone().map(mean).collect::<Vec<_>>(), width);
        let Some(dark) = dark_square(means.iter().copied()) else { return [0.0; 3] };
        let variance = |value: &dyn Fn(usize) -> f64| {
            let all = || (0..self.pairs.len()).map(value);
            let mean = all().sum::<f64>() / pairs;
            all().map(|value| (value - mean).powi(2)).sum::<f64>() / (pairs - 1.0)
        };
        let eye = |pixel: usize| variance(&|pair| self.of_eye_paths[pair][pixel]);
        // The mean of a pair has the noise of eye paths, half of the noise of photons, and the rest.
        let of_means = |pixel: usize| variance(&|pair| 0.5 * (self.pairs[pair][0][pixel] + self.pairs[pair][1][pixel]));
        let photons =
            |pixel: usize| self.pairs.iter().map(|[a, b]| (a[pixel] - b[pixel]).powi(2) / 2.0).sum::<f64>() / pairs;
        let relative = |square: &dyn Fn(usize) -> f64| {
            trimmed_mean(pixels.clone().map(|pixel| square(pixel) / (means[pixel].powi(2) + dark)).collect())
        };
        let [eye, photons, of_means] = [relative(&eye), relative(&photons), relative(&of_means)];
        [eye, photons, (of_means - eye - 0.5 * photons).max(0.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two pixels, the first has a luminance of 1 and photons with a variance of 2; eye paths bring nothing or 2 to the
    /// second, and photons nothing.
    #[test]
    fn noise_within_pairs_is_of_photons_and_between_them_of_eye_paths() {
        let lights = [0.0, 2.0, 0.0, 2.0];
        let pair = |light: f64| [vec![0.0, light], vec![2.0, light]];
        let shots = Shots {
            pairs: lights.iter().map(|light| pair(*light)).collect(),
            of_eye_paths: lights.iter().map(|light| vec![0.0, *light]).collect(),
            gathered: 0.0,
        };
        // Both pixels have the mean 1, and the tenth of it as the least that counts.
        let [eye, photons, _] = shots.noise(2);
        assert!((eye - 0.5 * (4.0 / 3.0) / 1.01).abs() < 1e-12 && (photons - 0.5 * 2.0 / 1.01).abs() < 1e-12);
        let black = Shots { pairs: vec![[vec![0.0], vec![0.0]]; 2], of_eye_paths: vec![vec![0.0]; 2], gathered: 0.0 };
        assert_eq!(black.noise(1), [0.0; 3]);
    }

    #[test]
    fn discs_that_shrink_leave_more_noise() {
        assert_eq!(shrinkage(1.0, 1), [1.0; 2]);
        let [noise, area] = shrinkage(2.0 / 3.0, 2);
        assert!((noise - 0.5 * (1.0 + 1.5)).abs() < 1e-12 && (area - 0.5 * (1.0 + 2.0 / 3.0)).abs() < 1e-12);
        let [noise, area] = shrinkage(2.0 / 3.0, 1);
        assert!((3.0..5.0).contains(&noise) && (0.25..0.4).contains(&area), "{noise} {area}");
    }
}
