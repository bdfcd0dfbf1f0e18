//! The statistics of `--stats`.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::time::Duration;

use serde::Serialize;

use super::Failure;
use crate::base::output::{Replacement, replace};
use crate::render::counters::Tally;
use crate::render::counts::Choice;
use crate::render::error::RenderError;
use crate::render::guide::guidance::Guide;
use crate::render::renderer::Renderer;
use crate::render::unsampled::Noise;
use crate::scene::{Geometry, Scene};

/// The version of the keys of the JSON and of their meaning (docs/json.md). It is raised when one vanishes, or changes
/// its type or its meaning; keys are added without.
const SCHEMA_VERSION: u32 = 1;

/// The largest share of photon paths that may be lost in glass without a warning.
const MOST_LOST: f64 = 1e-4;

/// Times, counts and memory of a render.
#[derive(Serialize)]
pub struct Stats {
    schema_version: u32,
    device: String,
    driver: String,
    /// Counts of shapes, materials and lights by type.
    scene: BTreeMap<String, u64>,
    iterations: u32,
    photons: u64,
    photons_per_second: f64,
    seconds: Seconds,
    /// Device time in seconds by kernel. It includes compilation if the driver defers it.
    passes: BTreeMap<&'static str, f64>,
    radius: Range,
    /// The estimated relative error from noise; null before both halves of the rounds have begun, and if
    /// nothing is known about the error.
    relative_error: Option<f64>,
    /// The light that one photon would add to the image, relative to the image: a smaller error is not known.
    /// Null if the image is black and photons could contribute to it.
    error_of_one_photon: Option<f64>,
    /// Photons recorded on diffuse surfaces divided by emitted photons; null if none is emitted.
    recorded_share: Option<f64>,
    /// Whether glass splits light by wavelength: the scene has such glass, and the option is on.
    dispersion: bool,
    /// What the pilot of a guided render has found; null if there was none.
    guide: Option<GuideStats>,
    /// What a trial has found and chosen; null if there was none.
    trial: Option<TrialStats>,
    device_memory_bytes: u64,
    eye_paths: u64,
    #[serde(flatten)]
    tally: Tally,
    #[serde(skip)]
    noise: Noise,
}

#[derive(Serialize)]
struct GuideStats {
    /// The share of photons that bring light to what is seen, as far as the pilot tells: without the guide.
    reached_share_without: f64,
    /// The share with the guide.
    reached_share: f64,
    /// The factor by which the guide lowers the product of variance and time of photons, as far as the pilot tells; 1 if
    /// photons begin by the power of the lights alone.
    gain: f64,
    /// The time of the pilot; it is part of `seconds.render`.
    seconds: f64,
}

impl From<&Guide> for GuideStats {
    fn from(guide: &Guide) -> Self {
        let [reached_share_without, reached_share] = guide.reached;
        Self { reached_share_without, reached_share, gain: guide.gain, seconds: guide.time.as_secs_f64() }
    }
}

#[derive(Serialize)]
struct TrialStats {
    /// Photons of an iteration, and eye paths of a pixel: chosen, and by default.
    photons: u64,
    eye_paths: u32,
    usual_photons: u64,
    usual_eye_paths: u32,
    /// The squared relative noise of an iteration with the default numbers: of eye paths, and of photons.
    eye_noise: f64,
    photon_noise: f64,
    /// Its noise that falls with iterations alone.
    other_noise: f64,
    /// The work of such an iteration, in eye paths.
    eye_work: f64,
    photon_work: f64,
    /// The squared noise after the same work, over that with the default numbers.
    noise_share: f64,
    /// The time of the trial; it is part of `seconds.total`.
    seconds: f64,
}

impl From<&Choice> for TrialStats {
    fn from(Choice { trial, usual, taken, time }: &Choice) -> Self {
        let [[eye_noise, photon_noise], [eye_work, photon_work]] = [trial.noise(*usual), trial.work(*usual)];
        Self {
            photons: taken.photons,
            eye_paths: taken.eye_paths,
            usual_photons: usual.photons,
            usual_eye_paths: usual.eye_paths,
            eye_noise,
            photon_noise,
            other_noise: trial.other_noise,
            eye_work,
            photon_work,
            noise_share: trial.gain(*usual, *taken),
            seconds: time.as_secs_f64(),
        }
    }
}

#[derive(Serialize)]
struct Seconds {
    load: f64,
    build: f64,
    compile: f64,
    /// The time of the host for kd-trees over visible points; it is part of `render`.
    kd_build: f64,
    /// From the first iteration on; `--time` limits it.
    render: f64,
    /// With all that comes before the first iteration.
    total: f64,
}

/// A range of radii in scene units.
#[derive(Serialize)]
struct Range {
    min: f64,
    max: f64,
}

impl Stats {
    /// Collects the statistics at the end of a render. `photons` is the number of photons since the render
    /// began or was resumed. The times are of loading the scene, of rendering, and of the whole process.
    ///
    /// # Errors
    /// The device fails.
    pub fn new(
        scene: &Scene,
        renderer: &Renderer,
        noise: Noise,
        photons: u64,
        [load, render, total]: [Duration; 3],
    ) -> Result<Self, RenderError> {
        let device = renderer.device();
        let [min, max] = renderer.radius_range()?;
        let tally = *renderer.tally();
        let finite = |value: f64| value.is_finite().then_some(value);
        Ok(Self {
            schema_version: SCHEMA_VERSION,
            device: device.info().name.clone(),
            driver: device.info().driver.clone(),
            scene: count(scene),
            iterations: renderer.iterations(),
            photons: renderer.photons(),
            photons_per_second: photons as f64 / render.as_secs_f64(),
            seconds: Seconds {
                load: load.as_secs_f64(),
                build: renderer.build_time().as_secs_f64(),
                compile: renderer.compile_time().as_secs_f64(),
                kd_build: renderer.kd_build_time().as_secs_f64(),
                render: render.as_secs_f64(),
                total: total.as_secs_f64(),
            },
            passes: device.pass_times().into_iter().map(|(name, time)| (name, time.as_secs_f64())).collect(),
            radius: Range { min, max },
            relative_error: noise.relative_error(),
            error_of_one_photon: finite(noise.of_one_photon),
            recorded_share: finite(tally.recorded as f64 / tally.emitted as f64),
            dispersion: renderer.splits_light(),
            guide: renderer.guide().map(GuideStats::from),
            trial: renderer.choice().map(TrialStats::from),
            device_memory_bytes: device.allocated_bytes(),
            eye_paths: renderer.eye_paths(),
            tally,
            noise,
        })
    }

    /// Returns the warnings that a user should get even without `--stats`.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        for (pass, count) in self.tally.non_finite.found() {
            warnings.push(format!(
                "{pass}: {count} paths or pixels were dropped because they had values that are not finite"
            ));
        }
        for (pass, count) in self.tally.saturated.found() {
            warnings.push(format!("{pass}: {count} sums saturated: the image is too dark there"));
        }
        let cut = self.tally.cut;
        if cut.photon + cut.eye > 0 {
            let share = |count: u64, all: u64| 100.0 * count as f64 / all.max(1) as f64;
            warnings.push(format!(
                "{:.2} % of photon paths and {:.2} % of eye paths were cut, because this driver limits the loops of a \
                 kernel and a segment of these paths needs more; the image is too dark there",
                share(cut.photon, self.tally.emitted),
                share(cut.eye, self.eye_paths),
            ));
        }
        let lost = (self.tally.lost_in_glass - self.tally.eye_lost_in_glass) as f64 / self.tally.emitted.max(1) as f64;
        if lost > MOST_LOST {
            warnings.push(format!(
                "{:.2} % of photon paths were lost inside a dielectric such as glass: its surface is not closed, or faces \
                 the wrong way, or two surfaces are too close to each other",
                100.0 * lost
            ));
        }
        warnings.extend(self.missing_light());
        warnings
    }

    /// Returns a warning if nearly all photons land far from the surfaces that are seen.
    fn missing_light(&self) -> Option<String> {
        let Tally { emitted, recorded, .. } = self.tally;
        if !self.noise.misses_light(emitted, recorded) {
            return None;
        }
        let one = match self.noise.of_one_photon {
            infinite if infinite.is_infinite() => "but the image is black".to_owned(),
            one if one > 1.0 => format!("and one more photon would add {one:.1} times the light of the image"),
            one => format!("and one more photon would add {} of the light of the image", percent(one)),
        };
        Some(format!(
            "light of photons may be missing, such as caustics: {recorded} of {emitted} photons were recorded ({}), {one}. The \
             error may be larger than estimated. Render more iterations, or use more --photons, or remove surroundings \
             outside the view: most of the light of a sun, a sky or a far lamp falls on them",
            percent(recorded as f64 / emitted as f64)
        ))
    }

    /// Checks that a file can be written to `path`. Callers use it before a long render that ends with
    /// [`write`](Self::write).
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn check_writable(path: &Path) -> Result<(), Failure> {
        Replacement::create(path).map(drop).map_err(|reason| failed(path, reason))
    }

    /// Writes the statistics as JSON, atomically: `path` has either the old file or the whole new one.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        write_json(path, self)
    }
}

/// Writes a share as a percentage with two significant digits.
pub(crate) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    let digits = if percent > 0.0 { (1.0 - percent.log10().floor()).clamp(0.0, 12.0) as usize } else { 0 };
    format!("{percent:.digits$} %")
}

/// Writes statistics as JSON.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write_json(path: &Path, stats: &impl Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(stats).map_err(|error| failed(path, error.into()))?;
    text.push('\n');
    replace(path, text.as_bytes()).map_err(|reason| failed(path, reason))
}

fn failed(path: &Path, reason: io::Error) -> Failure {
    Failure::Stats { path: path.display().to_string(), reason }
}

/// Counts the shapes, the materials of shapes, and the lights by type.
pub(crate) fn count(scene: &Scene) -> BTreeMap<String, u64> {
    let mut counts = BTreeMap::new();
    let mut add = |name: String, number| *counts.entry(name).or_insert(0) += number;
    for shape in &scene.shapes {
        match &shape.geometry {
            Geometry::Mesh(mesh) => {
                add("meshes".into(), 1);
                add("triangles".into(), mesh.triangles.len() as u64);
            }
            Geometry::Sphere { .. } => add("spheres".into(), 1),
            Geometry::Disk { .. } => add("disks".into(), 1),
            Geometry::Revolution(_) => add("revolutions".into(), 1),
        }
        if shape.emission.is_some() {
            add("area_lights".into(), 1);
        }
        add(format!("{}_shapes", scene.materials[shape.material].kind()), 1);
    }
    if !scene.instances.is_empty() {
        add("instances".into(), scene.instances.len() as u64);
    }
    for light in &scene.lights {
        add(format!("{}_lights", light.kind()), 1);
    }
    counts
}
