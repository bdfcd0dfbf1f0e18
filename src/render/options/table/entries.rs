//! The entries of the table, in the order of the help and under its headings.

use super::{Effect, Fallback, Kind, Needs, RenderOption};
use crate::base::names::{Name, Named, named};
use crate::gpu_scene::pack::{Envelopes, RevolutionSolver};
use crate::render::guide::guidance::Guidance;
use crate::render::options::values::{RADIUS, RESOLUTION, SECONDS, TARGET_ERROR};
use crate::render::options::values::{radius, resolution, seconds, target_error};
use crate::render::options::{
    DEFAULT_ALPHA, DEFAULT_CELL_SCALE, DEFAULT_EYE_PATHS, DEFAULT_ROUND, DEFAULT_WORKGROUP_SIZE, DirectLight,
    Dispersion, Integrator, LookupKind, MAX_PHOTONS, Options, Sampler,
};
use crate::render::radius::{RADIUS_SCHEDULE, RadiusSchedule};

const QUALITY: &str = "Quality";
const ALGORITHM: &str = "Algorithm";
const DEVICE: &str = "Device";
const RESEARCH: &str = "Research";

/// The help of `auto` as a number of photons or of eye paths.
const MORE_OF_PHOTONS: &str = "With auto, a short trial before the first iteration measures the noise and the work of photons and \
                    of eye paths, and chooses the number with the least noise for the work. If --eye-paths is auto too, \
                    an iteration keeps about the work of the default. A checkpoint stores the chosen numbers. \
                    `goblet view` makes no trial: there, auto is the default.";

/// The range from 1 to the largest u32.
const POSITIVE: [u64; 2] = [1, u32::MAX as u64];

named! {
    /// The kinds of [`RevolutionSolver`].
    pub enum SolverKind = Certified {
        /// Isolates the roots by interval bounds and misses none
        Certified: "certified",
        /// The classical method, for comparison: slower, and misses some roots
        Newton: "newton",
    }
}

/// Every option of a render that users set.
pub const OPTIONS: &[RenderOption] = &[
    RenderOption {
        name: "iterations",
        placeholder: "N",
        kind: Kind::Whole { range: POSITIVE, set: |request, count| request.limits.iterations = narrow(count) },
        unit: "iterations",
        fallback: Fallback::Words("the sampler's pixelsamples"),
        group: QUALITY,
        help: "Stop after this many iterations",
        more: "Each iteration traces new photons and improves the image. With --time or --target-error, there is no limit \
               by default.",
        effect: Effect::End,
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "time",
        placeholder: "SECONDS",
        kind: Kind::Form {
            expected: SECONDS,
            set: |request, text| seconds(text).map(|time| request.limits.time = Some(time)),
        },
        unit: "seconds",
        fallback: Fallback::Nothing,
        group: QUALITY,
        help: "Stop after this render time, at the end of an iteration",
        more: "The time starts with the first iteration; it does not include loading the scene and compiling the \
               kernels. With --stats, seconds.render is the time that this option limits, and seconds.total is the whole \
               time. If --iterations is given too, the render stops at the first limit that it reaches.",
        effect: Effect::End,
        needs: Needs::Nothing,
        is_knob: false,
    },
    RenderOption {
        name: "target-error",
        placeholder: "E",
        kind: Kind::Form {
            expected: TARGET_ERROR,
            set: |request, text| target_error(text).map(|error| request.limits.target_error = Some(error)),
        },
        unit: "relative error",
        fallback: Fallback::Nothing,
        group: QUALITY,
        help: "Stop when the estimated relative error of the image is at most E, such as 0.05",
        more: "The relative error is the standard error of a pixel's luminance divided by the luminance, as the root mean \
               square over all pixels. It measures noise. It does not measure the blur that the gather radius causes.",
        effect: Effect::End,
        needs: Needs::Nothing,
        is_knob: false,
    },
    RenderOption {
        name: "photons",
        placeholder: "P",
        kind: Kind::WholeOrAuto {
            range: [1, MAX_PHOTONS],
            set: |request, count| {
                request.options.photons = count;
                request.options.auto.photons = count.is_none();
            },
        },
        unit: "photons",
        fallback: Fallback::Words("the scene's, else one per pixel"),
        group: QUALITY,
        help: "Number of photons that an iteration emits, or auto",
        more: MORE_OF_PHOTONS,
        effect: Effect::Image("photons per iteration", |_, resolved| resolved.photons.to_string()),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "eye-paths",
        placeholder: "N",
        kind: Kind::WholeOrAuto {
            range: [Options::EYE_PATHS[0] as u64, Options::EYE_PATHS[1] as u64],
            set: |request, count| {
                request.options.eye_paths = count.and_then(narrow);
                request.options.auto.eye_paths = count.is_none();
            },
        },
        unit: "paths",
        fallback: Fallback::Number(DEFAULT_EYE_PATHS as f64, ""),
        group: QUALITY,
        help: "Number of eye paths per pixel and iteration, or auto",
        more: "More eye paths give smoother edges and less noise in direct light. Photons are gathered only at the visible \
               point of the last eye path. --photons explains auto.",
        effect: Effect::Image("eye paths per iteration", |_, resolved| resolved.eye_paths.to_string()),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "radius",
        placeholder: "R",
        kind: Kind::Form {
            expected: RADIUS,
            set: |request, text| {
                [request.options.radius, request.options.radius_in_pixels] = radius(text)?;
                Ok(())
            },
        },
        unit: "scene units, or px",
        fallback: Fallback::SceneOrNumber(Options::DEFAULT_RADIUS_IN_PIXELS, "px"),
        group: QUALITY,
        help: "Initial gather radius, in scene units (0.05) or in pixels (2px)",
        more: "A pixel sums the photons within this radius of its visible point. A larger radius gives less noise and more \
               blur. In pixels, the unit is the width of the pixel on the surface that it shows.",
        effect: Effect::Image("radius", |_, resolved| match resolved.radius {
            Some(radius) => radius.to_string(),
            None => format!("{}px", resolved.radius_in_pixels),
        }),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "alpha",
        placeholder: "A",
        kind: Kind::Number {
            range: [f32::MIN_POSITIVE as f64, 1.0],
            set: |request, alpha| request.options.alpha = Some(alpha),
        },
        unit: "",
        fallback: Fallback::Number(DEFAULT_ALPHA, ""),
        group: QUALITY,
        help: "Speed at which the gather radius shrinks; 1 keeps it constant",
        more: "Alpha is the share of an iteration's photons that a pixel keeps when its radius shrinks. A smaller alpha shrinks \
               the radius faster: less blur, more noise. With 2/3, the default, both fall at the same rate.",
        effect: Effect::Image("alpha", |_, resolved| resolved.alpha.to_string()),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "max-depth",
        placeholder: "D",
        kind: Kind::Whole { range: POSITIVE, set: |request, count| request.options.max_depth = narrow(count) },
        unit: "segments",
        fallback: Fallback::Scene,
        group: QUALITY,
        help: "Largest number of segments of an eye path or a photon path",
        more: "A path that crosses or is reflected by n surfaces needs n + 1 segments. If the number is too small, glass is \
               dark; 20 is enough for most scenes with glass.",
        effect: Effect::Image("maximum depth", |_, resolved| resolved.max_depth.to_string()),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "seed",
        placeholder: "S",
        kind: Kind::Whole { range: [0, u32::MAX as u64], set: |request, seed| request.options.seed = narrow(seed) },
        unit: "",
        fallback: Fallback::Scene,
        group: QUALITY,
        help: "Seed of the random numbers",
        more: "Renders with different seeds have different noise and the same expected image.",
        effect: Effect::Image("seed", |_, resolved| resolved.seed.to_string()),
        needs: Needs::Nothing,
        is_knob: false,
    },
    RenderOption {
        name: "resolution",
        placeholder: "WxH",
        kind: Kind::Form {
            expected: RESOLUTION,
            set: |request, text| resolution(text).map(|size| request.options.resolution = Some(size)),
        },
        unit: "pixels",
        fallback: Fallback::Scene,
        group: QUALITY,
        help: "Width and height of the image in pixels, such as 640x480",
        more: "",
        effect: Effect::Image("resolution", |_, resolved| {
            let [width, height] = resolved.resolution;
            format!("{width}x{height}")
        }),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "integrator",
        placeholder: "INTEGRATOR",
        kind: Kind::Named {
            names: Integrator::NAMES,
            set: |request, name| name.parse().map(|value| request.options.integrator = value),
        },
        unit: "",
        fallback: Fallback::Name(|| Integrator::default().name()),
        group: ALGORITHM,
        help: "Algorithm: how often new eye paths are traced",
        more: "",
        effect: Effect::Image("integrator", |options, _| options.integrator.to_string()),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "photons-per-round",
        placeholder: "P",
        kind: Kind::Whole {
            range: [1, u64::MAX],
            set: |request, count| request.options.photons_per_round = Some(count),
        },
        unit: "photons",
        fallback: Fallback::Number(DEFAULT_ROUND as f64, " iterations"),
        group: ALGORITHM,
        help: "With ppm: number of photons after which new eye paths are traced",
        more: "The number is rounded up to whole iterations. The iterations that share their eye paths are a round.",
        effect: Effect::Image("iterations per round", |_, resolved| resolved.sequence.round_length.to_string()),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "rounds",
        placeholder: "N",
        kind: Kind::Whole { range: POSITIVE, set: |request, count| request.limits.rounds = narrow(count) },
        unit: "rounds",
        fallback: Fallback::Nothing,
        group: ALGORITHM,
        help: "With ppm: stop after this many rounds",
        more: "The iterations that share their eye paths are a round. The image is the mean of all rounds.",
        effect: Effect::End,
        needs: Needs::Absence("iterations"),
        is_knob: false,
    },
    RenderOption {
        name: "radius-schedule",
        placeholder: "SCHEDULE",
        kind: Kind::Named {
            names: RadiusSchedule::NAMES,
            set: |request, name| name.parse().map(|value| request.options.radius_schedule = value),
        },
        unit: "",
        fallback: Fallback::Name(|| RadiusSchedule::default().name()),
        group: ALGORITHM,
        help: "How the gather radii shrink from iteration to iteration",
        more: "",
        effect: Effect::Image(RADIUS_SCHEDULE, |options, _| options.radius_schedule.to_string()),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "direct",
        placeholder: "METHOD",
        kind: Kind::Named {
            names: DirectLight::NAMES,
            set: |request, name| name.parse().map(|value| request.options.direct = value),
        },
        unit: "",
        fallback: Fallback::Name(|| DirectLight::default().name()),
        group: ALGORITHM,
        help: "How direct light is estimated: the light that reaches a surface straight from a light source",
        more: "",
        effect: Effect::Image("direct light", |options, _| options.direct.to_string()),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "guide",
        placeholder: "WHETHER",
        kind: Kind::Named {
            names: Guidance::NAMES,
            set: |request, name| name.parse().map(|value| request.options.guidance = value),
        },
        unit: "",
        fallback: Fallback::Name(|| Guidance::default().name()),
        group: ALGORITHM,
        help: "Whether to emit more photons towards the surfaces that are visible",
        more: "Use it where few photons reach the view, such as under a sun above a large ground. A pilot traces a few photons \
               before the first iteration and learns which photons light visible surfaces. The guide changes the noise, not \
               the expected image. In `goblet view`, auto means off, because the pilot would delay each new view.",
        effect: Effect::Image("guide", |options, _| {
            if options.is_guided() { options.guidance.to_string() } else { Guidance::Off.to_string() }
        }),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "dispersion",
        placeholder: "WHETHER",
        kind: Kind::Named {
            names: Dispersion::NAMES,
            set: |request, name| name.parse().map(|value| request.options.dispersion = value),
        },
        unit: "",
        fallback: Fallback::Name(|| Dispersion::default().name()),
        group: ALGORITHM,
        help: "Whether glass splits light by wavelength, where its index of refraction depends on it",
        more: "`goblet info` says whether a scene has such glass. --no-dispersion is short for `--dispersion off`.",
        effect: Effect::Image("dispersion", |options, _| options.dispersion.to_string()),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "sampler",
        placeholder: "SAMPLER",
        kind: Kind::Named {
            names: Sampler::NAMES,
            set: |request, name| name.parse().map(|value| request.options.sampler = value),
        },
        unit: "",
        fallback: Fallback::Name(|| Sampler::default().name()),
        group: ALGORITHM,
        help: "Generator of the random numbers",
        more: "",
        effect: Effect::Image("sampler", |options, _| options.sampler.to_string()),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "lookup",
        placeholder: "LOOKUP",
        kind: Kind::Named {
            names: LookupKind::NAMES,
            set: |request, name| name.parse().map(|value| request.options.lookup = value),
        },
        unit: "",
        fallback: Fallback::Name(|| LookupKind::default().name()),
        group: ALGORITHM,
        help: "Search structure that pairs photons with the visible points near them; does not change the image",
        more: "",
        effect: Effect::Cost,
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "cell-scale",
        placeholder: "X",
        kind: Kind::Number {
            range: Options::CELL_SCALES,
            set: |request, scale| request.options.cell_scale = Some(scale),
        },
        unit: "diameters of the largest disc",
        fallback: Fallback::Number(DEFAULT_CELL_SCALE, ""),
        group: ALGORITHM,
        help: "Width of the hash grid's cells, in diameters of the largest gather disc; does not change the image",
        more: "",
        effect: Effect::Cost,
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "workgroup-size",
        placeholder: "SIZE",
        kind: Kind::Named {
            names: WORKGROUP_SIZES,
            set: |request, text| workgroup_size(text).map(|size| request.options.workgroup_size = Some(size)),
        },
        unit: "invocations",
        fallback: Fallback::Number(DEFAULT_WORKGROUP_SIZE as f64, ""),
        group: DEVICE,
        help: "Invocations (GPU threads) per workgroup; does not change the image",
        more: "",
        effect: Effect::Cost,
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "batch-size",
        placeholder: "PHOTONS",
        kind: Kind::Whole { range: POSITIVE, set: |request, count| request.options.batch_size = Some(count) },
        unit: "photons",
        fallback: Fallback::Words("adapted to the time that a batch takes"),
        group: DEVICE,
        help: "Number of photons that are traced and gathered at once; does not change the image",
        more: "Smaller batches need less memory and keep each dispatch short.",
        effect: Effect::Cost,
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "revolution-solver",
        placeholder: "SOLVER",
        kind: Kind::Named {
            names: SolverKind::NAMES,
            set: |request, name| {
                request.options.revolution_solver = match name.parse()? {
                    SolverKind::Certified => RevolutionSolver::Certified,
                    SolverKind::Newton => RevolutionSolver::NEWTON,
                };
                Ok(())
            },
        },
        unit: "",
        fallback: Fallback::Name(|| SolverKind::default().name()),
        group: RESEARCH,
        help: "Method that intersects rays with bodies of revolution",
        more: "",
        effect: Effect::Image("revolution solver", |options, _| options.revolution_solver.to_string()),
        needs: Needs::Nothing,
        is_knob: true,
    },
    RenderOption {
        name: "newton-segments",
        placeholder: "M",
        kind: Kind::Whole {
            range: [*RevolutionSolver::SEGMENTS.start() as u64, *RevolutionSolver::SEGMENTS.end() as u64],
            set: |request, count| {
                if let RevolutionSolver::Newton { segments, .. } = &mut request.options.revolution_solver {
                    *segments = count as u32;
                }
            },
        },
        unit: "pieces",
        fallback: Fallback::Number(RevolutionSolver::DEFAULT_SEGMENTS as f64, ""),
        group: RESEARCH,
        help: "With newton: line segments that approximate each segment of a profile",
        more: "Newton's method starts where the ray hits this approximation.",
        effect: Effect::PartOf,
        needs: Needs::Value("revolution-solver", "newton"),
        is_knob: true,
    },
    RenderOption {
        name: "newton-envelopes",
        placeholder: "WHICH",
        kind: Kind::Named {
            names: Envelopes::NAMES,
            set: |request, name| {
                let which = name.parse()?;
                if let RevolutionSolver::Newton { envelopes, .. } = &mut request.options.revolution_solver {
                    *envelopes = which;
                }
                Ok(())
            },
        },
        unit: "",
        fallback: Fallback::Name(|| Envelopes::default().name()),
        group: RESEARCH,
        help: "With newton: line segments whose intersections with the ray start Newton's method",
        more: "",
        effect: Effect::PartOf,
        needs: Needs::Value("revolution-solver", "newton"),
        is_knob: true,
    },
];

/// The names of [`Options::WORKGROUP_SIZES`].
const WORKGROUP_SIZES: &[Name] = &[("32", ""), ("64", ""), ("128", "")];

fn workgroup_size(text: &str) -> Result<u32, String> {
    let size = text.parse().ok().filter(|size| Options::WORKGROUP_SIZES.contains(size));
    size.ok_or_else(|| crate::base::names::expected_name(WORKGROUP_SIZES))
}

/// Converts a number from a range within 32 bits.
fn narrow(count: u64) -> Option<u32> {
    u32::try_from(count).ok()
}
