//! The options of a render, and the check of their values for a scene. [`table`] lists the options of the command
//! line.

pub mod request;
pub mod table;
pub(crate) mod values;
pub mod written;

use crate::base::names::named;
use crate::gpu_scene::pack::{Packing, RevolutionSolver};
use crate::image::film::Window;
use crate::image::layers::{Group, Groups};
use crate::kernels::RenderFeatures;
use crate::render::counts::Auto;
use crate::render::error::RenderError;
use crate::render::guide::guidance::Guidance;
use crate::render::radius::RadiusSchedule;
use crate::render::sequence::{Sequence, Shard};
use crate::scene::{self, Scene};

/// The largest number of photons in one iteration: photons are numbered in 32 bits.
pub(crate) const MAX_PHOTONS: u64 = 1 << 31;
/// The largest number of pixels in an image.
const MAX_PIXELS: u64 = 1 << 28;
/// The largest number of pixels along a side of the uncropped image: the limit of the EXR format.
pub(crate) const MAX_SIDE: u32 = 1 << 29;
/// The range of initial radii, in radii of the scene's bounding sphere. Positions are rounded to 6e-8 of
/// that radius.
const RADIUS_RANGE: [f64; 2] = [1e-7, 1e4];
/// The default number of iterations in a round of progressive photon mapping.
pub(crate) const DEFAULT_ROUND: u32 = 16;
/// The default share of photons that a pixel keeps. With 2/3, noise and blur fall at the same rate (Knaus
/// and Zwicker 2011, section 4.2).
pub(crate) const DEFAULT_ALPHA: f64 = 2.0 / 3.0;
/// The default number of eye paths per pixel and iteration. It is above 1 because direct light and edges are
/// noisier than the light of photons: see docs/performance.md.
pub const DEFAULT_EYE_PATHS: u32 = 4;
/// The default width of the hash grid's cells, in diameters of the largest disc.
pub(crate) const DEFAULT_CELL_SCALE: f64 = 1.0;
/// The default number of invocations per workgroup.
pub(crate) const DEFAULT_WORKGROUP_SIZE: u32 = 64;

named! {
    /// How often new eye paths are traced.
    pub enum Integrator = Sppm {
        /// Stochastic progressive photon mapping (Hachisuka and Jensen 2009): in every iteration
        Sppm: "sppm",
        /// Progressive photon mapping (Hachisuka and others 2008): once per round of several iterations
        Ppm: "ppm",
    }
}

named! {
    /// How direct light is estimated: light that reaches a visible point from a source without a bounce.
    pub enum DirectLight = Nee {
        /// Next-event estimation: a ray from the visible point to a point on a light source
        Nee: "nee",
        /// Photons carry it, like all other light; usually noisier
        Photons: "photons",
    }
}

named! {
    /// Which part of the light the image shows.
    pub enum Contribution = All {
        /// All light
        All: "all",
        /// Light sources that are seen, and direct light
        Direct: "direct",
        /// Light that photons carry
        Photons: "photons",
    }
}

named! {
    /// Whether glass splits light by wavelength, where its index of refraction depends on it.
    pub enum Dispersion = On {
        /// Where the scene gives an index by wavelength, each path that it refracts takes one wavelength
        On: "on",
        /// The mean index for all wavelengths: less noise of colour, and no colours by refraction
        Off: "off",
    }
}

named! {
    /// Where random numbers come from.
    pub enum Sampler = Sobol {
        /// Independent numbers: a hash of path and dimension
        Pcg: "pcg",
        /// Scrambled Sobol points for the first 16 dimensions of a path, hashed numbers for the others: less noise
        Sobol: "sobol",
    }
}

impl Sampler {
    /// Returns the number of pairs of dimensions that take low-discrepancy points.
    pub(crate) fn low_discrepancy_pairs(self) -> u32 {
        match self {
            Self::Pcg => 0,
            Self::Sobol => 8,
        }
    }
}

named! {
    /// The search structure that pairs photons with the visible points near them. The choice does not change the image.
    pub enum LookupKind = HashGrid {
        /// A hash grid over the photons
        HashGrid: "hash-grid",
        /// A left-balanced kd-tree over the visible points
        KdTree: "kd-tree",
    }
}

/// How an iteration is given to the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Submission {
    /// In one submission if the iteration is short. On a CPU driver always in pieces: a CPU driver loses nothing by
    /// waiting for the host, and is faster with large batches.
    #[default]
    Auto,
    /// In pieces: each dispatch has a submission of its own. The host measures its time and chooses the size of the
    /// next dispatch.
    Pieces,
    /// In one submission, however long it takes.
    Whole,
}

/// The options of a render. A field that is `None` takes the scene's value, or, if the scene has none, the
/// default that the field's documentation names.
///
/// [`table::OPTIONS`] has an entry for each field that users set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Width and height of the image in pixels, before the film's crop window is applied.
    pub resolution: Option<[u32; 2]>,
    /// Photons per iteration.
    pub photons: Option<u64>,
    /// Eye paths per pixel and iteration, 1 to 64; 4 by default. Each eye path contributes direct light;
    /// photons are gathered only at the visible point of the last one.
    pub eye_paths: Option<u32>,
    /// Whether a trial chooses the numbers of photons and of eye paths: [`crate::render::counts`]. If `photons` or
    /// `eye_paths` is given as well, the trial starts from this number. With `responsive`, there is no trial.
    pub auto: Auto,
    /// Initial radius in scene units. If neither this field nor the scene has a radius, the initial radius
    /// follows the footprints of pixels.
    pub radius: Option<f64>,
    /// Initial radius in widths of a pixel at the visible point, 1/16 to 64; it replaces the scene's radius.
    /// 3 if there is no radius at all. It cannot be combined with `radius`.
    pub radius_in_pixels: Option<f64>,
    /// Share of an iteration's photons that a pixel keeps, in (0, 1]; 2/3 by default.
    pub alpha: Option<f64>,
    /// The largest number of segments of a path.
    pub max_depth: Option<u32>,
    /// Seed of all random numbers.
    pub seed: Option<u32>,
    /// How often new eye paths are traced.
    pub integrator: Integrator,
    /// Number of photons for which [`Integrator::Ppm`] keeps its eye paths, rounded up to whole iterations.
    pub photons_per_round: Option<u64>,
    /// How radii shrink.
    pub radius_schedule: RadiusSchedule,
    /// How direct light is estimated.
    pub direct: DirectLight,
    /// Whether more photons are emitted towards the surfaces that are visible.
    pub guidance: Guidance,
    /// Whether glass splits light by wavelength.
    pub dispersion: Dispersion,
    /// Which part of the light the image shows.
    pub contribution: Contribution,
    /// The layers that are summed besides the image, and besides those that a film asks for.
    pub layers: Groups,
    /// Where random numbers come from.
    pub sampler: Sampler,
    /// The part of the iterations that is rendered.
    pub shard: Shard,
    /// The search structure that pairs photons with the visible points near them. It does not change the image.
    pub lookup: LookupKind,
    /// Width of the hash grid's cells in diameters of the largest disc, 1/4 to 8; 1 by default. It does not
    /// change the image.
    pub cell_scale: Option<f64>,
    /// Invocations per workgroup: 32, 64 (default) or 128. It does not change the image.
    pub workgroup_size: Option<u32>,
    /// Photons per batch. It does not change the image.
    pub batch_size: Option<u64>,
    /// Whether dispatches are kept short, so that [`crate::Renderer::step_unless`] can give up an iteration
    /// soon. It does not change the image.
    pub responsive: bool,
    /// How an iteration is given to the device. It does not change the image.
    pub submission: Submission,
    /// How rays are intersected with bodies of revolution.
    pub revolution_solver: RevolutionSolver,
}

/// Checked options: every `None` is replaced by the scene's value or by the default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Resolved {
    pub resolution: [u32; 2],
    /// The position of the pixels in the full image of the camera.
    pub window: Window,
    pub photons: u64,
    pub eye_paths: u32,
    /// Initial radius in scene units; `None` if it follows the footprints of pixels.
    pub radius: Option<f64>,
    /// Initial radius in widths of a pixel, used if `radius` is `None`.
    pub radius_in_pixels: f64,
    pub alpha: f64,
    pub max_depth: u32,
    pub seed: u32,
    pub sequence: Sequence,
    pub cell_scale: f64,
    pub workgroup_size: u32,
    /// The layers, with those that the film asks for.
    pub layers: Groups,
}

impl Options {
    /// Returns how a scene is packed for a render with these options.
    pub(crate) fn packing(&self, scene: &Scene) -> Packing {
        Packing {
            solver: self.revolution_solver,
            keeps_uvs: self.all_layers(scene).has(Group::Slope),
            is_guided: self.is_guided(),
            has_dispersion: self.dispersion == Dispersion::On,
        }
    }

    /// Returns the layers with those that the film of a scene asks for.
    pub(crate) fn all_layers(&self, scene: &Scene) -> Groups {
        let of_film = if scene.film.gbuffer.is_some() { Groups::OF_GBUFFER } else { Groups::default() };
        self.layers.with(of_film)
    }

    /// Returns whether a pilot runs, which may find a guide for the emission of photons. With `responsive`, `auto` runs
    /// none: the pilot would delay the first picture after each move of the camera.
    pub(crate) fn is_guided(&self) -> bool {
        match self.guidance {
            Guidance::Auto => !self.responsive,
            Guidance::On => true,
            Guidance::Off => false,
        }
    }

    /// The workgroup sizes that kernels are built for.
    pub const WORKGROUP_SIZES: [u32; 3] = [32, 64, 128];

    /// Returns the features of the kernels that the options require.
    pub(crate) fn features(&self, resolved: &Resolved) -> RenderFeatures {
        RenderFeatures {
            direct_nee: self.direct == DirectLight::Nee,
            low_discrepancy_pairs: self.sampler.low_discrepancy_pairs(),
            cell_scale: resolved.cell_scale as f32,
            has_guide: self.is_guided(),
            has_caustic_layer: resolved.layers.has(Group::Caustic),
            has_data_radii: self.radius_schedule == RadiusSchedule::Data,
        }
    }

    /// The range of widths of the hash grid's cells, in diameters of the largest disc.
    pub const CELL_SCALES: [f64; 2] = [0.25, 8.0];

    /// The initial radius in widths of a pixel, used if neither the caller nor the scene gives a radius.
    pub const DEFAULT_RADIUS_IN_PIXELS: f64 = 3.0;

    /// The range of initial radii in widths of a pixel.
    pub const RADII_IN_PIXELS: [f64; 2] = [1.0 / 16.0, 64.0];

    /// The range of eye paths per pixel and iteration.
    pub const EYE_PATHS: [u32; 2] = [1, 64];

    /// Returns the options with the values that are missing taken from a scene. `size` is the radius of the
    /// scene's bounding sphere in scene units.
    ///
    /// # Errors
    /// A value is out of range for this scene, or two options contradict each other.
    pub(crate) fn resolve(&self, scene: &Scene, size: f64) -> Result<Resolved, RenderError> {
        let full_resolution = self.resolution.unwrap_or(scene.film.resolution);
        check(full_resolution.iter().all(|side| *side > 0), || "an image without pixels: expected 1 or more".into())?;
        check(full_resolution.iter().all(|side| *side <= MAX_SIDE), || {
            format!("an image of more than {MAX_SIDE} pixels along a side: expected fewer")
        })?;
        let [first, end] = scene.film.bounds(full_resolution);
        let resolution = [end[0] - first[0], end[1] - first[1]];
        let pixels: u64 = resolution.map(u64::from).iter().product();
        let photons = self.photons.unwrap_or_else(|| photons_of(&scene.integrator, resolution));
        let eye_paths = self.eye_paths.unwrap_or(DEFAULT_EYE_PATHS);
        let max_depth = self.max_depth.unwrap_or(scene.integrator.max_depth);
        let of_scene = scene.integrator.radius.filter(|_| self.radius_in_pixels.is_none());
        let radius = self.radius.or(of_scene);
        let radius_in_pixels = self.radius_in_pixels.unwrap_or(Self::DEFAULT_RADIUS_IN_PIXELS);
        let alpha = self.alpha.unwrap_or(DEFAULT_ALPHA);
        let cell_scale = self.cell_scale.unwrap_or(DEFAULT_CELL_SCALE);
        check(pixels <= MAX_PIXELS, || format!("an image of {pixels} pixels: expected 1 to {MAX_PIXELS}"))?;
        check(photons > 0 && photons <= MAX_PHOTONS, || {
            format!("{photons} photons per iteration: expected 1 to {MAX_PHOTONS}")
        })?;
        let [least, most] = Self::EYE_PATHS;
        check((least..=most).contains(&eye_paths), || {
            format!("{eye_paths} eye paths per iteration: expected {least} to {most}")
        })?;
        check(max_depth > 0, || "a maximum depth of 0: expected 1 or more".into())?;
        let [least, most] = RADIUS_RANGE.map(|bound| bound * size);
        check(radius.is_none_or(|radius| radius >= least && radius <= most), || {
            let radius = radius.unwrap_or_default();
            format!("a radius of {radius}: expected {least:e} to {most:e} for a scene of this size")
        })?;
        let [least, most] = Self::RADII_IN_PIXELS;
        check(radius_in_pixels >= least && radius_in_pixels <= most, || {
            format!("a radius of {radius_in_pixels} pixels: expected {least} to {most}")
        })?;
        check(self.radius.is_none() || self.radius_in_pixels.is_none(), || {
            "a radius in scene units and one in pixels: expected one of them".into()
        })?;
        check(alpha > 0.0 && alpha <= 1.0, || format!("an alpha of {alpha}: expected above 0, up to 1"))?;
        let [least, most] = Self::CELL_SCALES;
        check(cell_scale >= least && cell_scale <= most, || {
            format!("a cell scale of {cell_scale}: expected {least} to {most}")
        })?;
        let solver = self.revolution_solver;
        check(solver.is_valid(), || {
            format!("a revolution solver of {solver:?}: expected {:?} segments", RevolutionSolver::SEGMENTS)
        })?;
        Ok(Resolved {
            resolution,
            window: scene.film.part(full_resolution),
            photons,
            eye_paths,
            radius,
            radius_in_pixels,
            alpha,
            max_depth,
            seed: self.seed.unwrap_or(scene.integrator.seed),
            sequence: Sequence { round_length: self.round_length(photons)?, shard: self.checked_shard()? },
            cell_scale,
            layers: self.all_layers(scene),
            workgroup_size: self.workgroup_size.unwrap_or(DEFAULT_WORKGROUP_SIZE),
        })
    }

    fn round_length(&self, photons: u64) -> Result<u32, RenderError> {
        match (self.integrator, self.photons_per_round) {
            (Integrator::Sppm, None) => Ok(1),
            (Integrator::Ppm, None) => Ok(DEFAULT_ROUND),
            (Integrator::Sppm, Some(_)) => {
                Err(RenderError::Option("photons per round: expected the integrator ppm".into()))
            }
            (Integrator::Ppm, Some(0)) => Err(RenderError::Option("0 photons per round: expected 1 or more".into())),
            (Integrator::Ppm, Some(per_round)) => u32::try_from(per_round.div_ceil(photons)).map_err(|_| {
                RenderError::Option(format!("{per_round} photons per round of {photons} each: too many iterations"))
            }),
        }
    }

    fn checked_shard(&self) -> Result<Shard, RenderError> {
        let Shard { index, count } = self.shard;
        check(index < count, || format!("shard {index} of {count}: expected an index from 0, below the count"))?;
        check(count <= Shard::MAX_COUNT, || format!("{count} shards: expected at most {}", Shard::MAX_COUNT))?;
        let independent = self.radius_schedule == RadiusSchedule::Global || self.integrator == Integrator::Ppm;
        check(count == 1 || independent, || {
            "shards: expected the global radius schedule or the integrator ppm, since other radii depend on all \
             iterations before"
                .into()
        })?;
        Ok(self.shard)
    }
}

/// Returns the number of photons per iteration for an image of this size, if the caller gives none: the
/// scene's number, or one photon per pixel.
pub(crate) fn photons_of(integrator: &scene::Integrator, resolution: [u32; 2]) -> u64 {
    integrator.photons_per_iteration.unwrap_or_else(|| resolution.map(u64::from).iter().product())
}

fn check(holds: bool, message: impl FnOnce() -> String) -> Result<(), RenderError> {
    if holds { Ok(()) } else { Err(RenderError::Option(message())) }
}
