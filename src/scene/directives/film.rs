//! The `Film`, `PixelFilter`, `Sampler` and `Integrator` directives.

use glam::DVec2;

use crate::image::film::CoordinateSystem;
use crate::scene::format::error::SceneError;
use crate::scene::format::kind::Kind;
use crate::scene::format::params::ParamList;
use crate::scene::format::registry::{Family, ParamSpec, full, ignored, not_yet, supported};
use crate::scene::model::{Film, FilterKind, Integrator, PixelFilter, WhiteBalance};
use crate::scene::spectrum::white_balance;

const SIZE: &[Kind] = &[Kind::Integer];

/// The parameters of a film. `coordinatesystem` has an effect for a `gbuffer` film only.
const fn film_with(coordinate_system: ParamSpec) -> [ParamSpec; 16] {
    [
        full("xresolution", SIZE),
        full("yresolution", SIZE),
        full("filename", &[Kind::String]),
        // "cie1931" is exact; other sensors are rendered as "cie1931", with a warning.
        full("sensor", &[Kind::String]),
        full("iso", &[Kind::Float]),
        full("exposuretime", &[Kind::Float]),
        full("cropwindow", &[Kind::Float]),
        full("pixelbounds", SIZE),
        full("whitebalance", &[Kind::Float]),
        // Bounds single samples; pbrt's photon mapper ignores it, too.
        ignored("maxcomponentvalue", &[Kind::Float]),
        ignored("diagonal", &[Kind::Float]),
        ignored("savefp16", &[Kind::Bool]),
        coordinate_system,
        ignored("nbuckets", SIZE),
        ignored("lambdamin", &[Kind::Float]),
        ignored("lambdamax", &[Kind::Float]),
    ]
}

const FILM: &[ParamSpec] = &film_with(ignored("coordinatesystem", &[Kind::String]));
const GBUFFER: &[ParamSpec] = &film_with(full("coordinatesystem", &[Kind::String]));

/// The films of pbrt. A `spectral` film has the pixels of an `rgb` film, a `gbuffer` film has layers besides.
pub(in crate::scene) const FILM_FAMILY: Family = Family {
    directive: "Film",
    types: &[supported("rgb", FILM), supported("gbuffer", GBUFFER), supported("spectral", FILM)],
};

const X_RADIUS: ParamSpec = full("xradius", &[Kind::Float]);
const Y_RADIUS: ParamSpec = full("yradius", &[Kind::Float]);

/// The pixel filters of pbrt.
pub(in crate::scene) const FILTER_FAMILY: Family = Family {
    directive: "PixelFilter",
    types: &[
        supported("box", &[X_RADIUS, Y_RADIUS]),
        supported("triangle", &[X_RADIUS, Y_RADIUS]),
        supported("gaussian", &[X_RADIUS, Y_RADIUS, full("sigma", &[Kind::Float])]),
        supported("mitchell", &[X_RADIUS, Y_RADIUS, full("B", &[Kind::Float]), full("C", &[Kind::Float])]),
        supported("sinc", &[X_RADIUS, Y_RADIUS, full("tau", &[Kind::Float])]),
    ],
};

const SAMPLER: &[ParamSpec] =
    &[full("pixelsamples", SIZE), ignored("randomization", &[Kind::String]), ignored("seed", SIZE)];

/// The samplers of pbrt. Goblet uses its own sampler, and takes only the number of samples.
pub(in crate::scene) const SAMPLER_FAMILY: Family = Family {
    directive: "Sampler",
    types: &[
        supported("halton", SAMPLER),
        supported("independent", SAMPLER),
        supported("paddedsobol", SAMPLER),
        supported("pmj02bn", SAMPLER),
        supported("sobol", SAMPLER),
        supported(
            "stratified",
            &[full("xsamples", SIZE), full("ysamples", SIZE), ignored("jitter", &[Kind::Bool]), ignored("seed", SIZE)],
        ),
        supported("zsobol", SAMPLER),
    ],
};

const OTHER: &[ParamSpec] = &[
    full("maxdepth", SIZE),
    ignored("bootstrapsamples", SIZE),
    ignored("chains", SIZE),
    ignored("cossample", &[Kind::Bool]),
    ignored("largestepprobability", &[Kind::Float]),
    ignored("lightsampler", &[Kind::String]),
    ignored("maxdistance", &[Kind::Float]),
    ignored("mutationsperpixel", SIZE),
    ignored("regularize", &[Kind::Bool]),
    ignored("rrthreshold", &[Kind::Float]),
    ignored("samplebsdf", &[Kind::Bool]),
    ignored("samplelights", &[Kind::Bool]),
    ignored("sigma", &[Kind::Float]),
    ignored("visualizestrategies", &[Kind::Bool]),
    ignored("visualizeweights", &[Kind::Bool]),
];

/// The integrators of pbrt, all of which are rendered as `sppm`.
pub(in crate::scene) const INTEGRATOR_FAMILY: Family = Family {
    directive: "Integrator",
    types: &[
        supported(
            "sppm",
            &[
                full("maxdepth", SIZE),
                full("photonsperiteration", SIZE),
                full("radius", &[Kind::Float]),
                full("seed", SIZE),
                ignored("lightsampler", &[Kind::String]),
                ignored("regularize", &[Kind::Bool]),
                ignored("rrthreshold", &[Kind::Float]),
            ],
        ),
        supported("bdpt", OTHER),
        supported("lightpath", OTHER),
        supported("mlt", OTHER),
        supported("path", OTHER),
        supported("randomwalk", OTHER),
        supported("simplepath", OTHER),
        supported("simplevolpath", OTHER),
        supported("volpath", OTHER),
        supported("ambientocclusion", OTHER),
        not_yet("function"),
    ],
};

/// Maximum number of pixels along one side; a device's memory is checked later.
const MAX_RESOLUTION: u32 = 65_536;

/// Returns the film of a type from parameters that [`FILM_FAMILY`] has checked. Its exposure is relative to ISO 100 for
/// 1 s; `exposure_time` is the camera's.
pub(in crate::scene) fn film(
    name: &str,
    params: &ParamList,
    filter: PixelFilter,
    exposure_time: f64,
) -> Result<Film, SceneError> {
    let resolution = [
        params.integer("xresolution", 1, MAX_RESOLUTION)?.unwrap_or(1280),
        params.integer("yresolution", 1, MAX_RESOLUTION)?.unwrap_or(720),
    ];
    let exposure = exposure_time * params.positive("exposuretime", 1.0)? * params.positive("iso", 100.0)? / 100.0;
    if let Some(param) = params.get("iso").or(params.get("exposuretime")).filter(|_| !EXPOSURES.contains(&exposure)) {
        return Err(param.bad_value("an exposure from 1e-12 to 1e12 times that of ISO 100 for 1 s"));
    }
    Ok(Film {
        resolution,
        window: window(params, resolution)?,
        exposure,
        white_balance: balance(params)?,
        filename: params.string("filename")?.filter(|name| !name.is_empty()).map(Into::into),
        filter,
        gbuffer: if name == "gbuffer" { Some(coordinate_system(params)?) } else { None },
    })
}

/// Returns the coordinate system of the layers of a `gbuffer` film.
fn coordinate_system(params: &ParamList) -> Result<CoordinateSystem, SceneError> {
    let Some(param) = params.get("coordinatesystem") else {
        return Ok(CoordinateSystem::default());
    };
    match params.string("coordinatesystem")? {
        Some("camera") => Ok(CoordinateSystem::Camera),
        Some("world") => Ok(CoordinateSystem::World),
        _ => Err(param.bad_value("\"camera\" or \"world\"")),
    }
}

/// Permitted exposures: pixels with others may not fit in an f32.
const EXPOSURES: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

/// Permitted colour temperatures in K. Light of a lower one is so deep a red that Bradford's matrix gives it
/// hardly any response of the other cones, or a negative one.
const KELVINS: std::ops::RangeInclusive<f64> = 1e3..=1e6;

/// Returns the white balance; as in pbrt, a temperature of 0 stands for none.
fn balance(params: &ParamList) -> Result<Option<WhiteBalance>, SceneError> {
    let accept = |kelvin: f64| kelvin == 0.0 || KELVINS.contains(&kelvin);
    let expected = "0 for none, or a temperature from 1000 to 1000000 K";
    let kelvin = params.float_in("whitebalance", 0.0, accept, expected)?;
    Ok((kelvin != 0.0).then(|| white_balance::of_temperature(kelvin)))
}

/// Returns the part of the image that is rendered, as fractions of the resolution. As in pbrt, the crop
/// window takes precedence over the pixel bounds, and both may extend beyond the image.
fn window(params: &ParamList, resolution: [u32; 2]) -> Result<[f64; 4], SceneError> {
    let (param, window) = match (params.get("cropwindow"), params.get("pixelbounds")) {
        (Some(param), _) => (param, param.one::<4>()?),
        (None, Some(param)) => {
            let [width, height] = resolution.map(f64::from);
            let [x0, x1, y0, y1] = param.one()?;
            (param, [x0 / width, x1 / width, y0 / height, y1 / height])
        }
        (None, None) => return Ok([0.0, 1.0, 0.0, 1.0]),
    };
    let [x0, x1, y0, y1] = window.map(|edge| edge.clamp(0.0, 1.0));
    let window = [x0.min(x1), x0.max(x1), y0.min(y1), y0.max(y1)];
    if window[0] == window[1] || window[2] == window[3] {
        return Err(
            param.bad_value("x minimum, x maximum, y minimum and y maximum with some of the image between them")
        );
    }
    Ok(window)
}

/// Returns a filter from parameters that [`FILTER_FAMILY`] has checked.
pub(in crate::scene) fn filter(name: &str, params: &ParamList) -> Result<PixelFilter, SceneError> {
    let (kind, radius) = match name {
        "box" => (FilterKind::Box, 0.5),
        "triangle" => (FilterKind::Triangle, 2.0),
        "mitchell" => {
            let weight = |name| params.float_in(name, 1.0 / 3.0, |v| (0.0..=1.0).contains(&v), "a number from 0 to 1");
            (FilterKind::Mitchell { b: weight("B")?, c: weight("C")? }, 2.0)
        }
        "sinc" => (FilterKind::Sinc { tau: params.positive("tau", 3.0)? }, 4.0),
        _ => {
            let sigma = params.positive("sigma", 0.5)?;
            (FilterKind::Gaussian { sigma }, 1.5)
        }
    };
    let accept = |v: f64| v > 0.0 && v <= 64.0;
    let side = |name| params.float_in(name, radius, accept, "above 0, at most 64 pixels");
    Ok(PixelFilter { kind, radius: DVec2::new(side("xradius")?, side("yradius")?) })
}

/// Returns the number of iterations that a sampler asks for.
pub(in crate::scene) fn iterations(name: &str, params: &ParamList) -> Result<u32, SceneError> {
    if name == "stratified" {
        let x = params.integer("xsamples", 1, 65_535)?.unwrap_or(4);
        let y = params.integer("ysamples", 1, 65_535)?.unwrap_or(4);
        return Ok(x * y);
    }
    let samples = params.integer("pixelsamples", 1, i32::MAX as u32)?;
    Ok(samples.unwrap_or(DEFAULT_ITERATIONS))
}

/// pbrt's default number of samples per pixel.
const DEFAULT_ITERATIONS: u32 = 16;

/// The values for a scene without `Integrator` and `Sampler`.
pub(in crate::scene) const DEFAULT_INTEGRATOR: Integrator =
    Integrator { max_depth: 5, photons_per_iteration: None, radius: None, seed: 0, iterations: DEFAULT_ITERATIONS };

/// Returns an integrator from parameters that [`INTEGRATOR_FAMILY`] has checked. Values that the scene does
/// not give are those of `default`.
pub(in crate::scene) fn integrator(
    name: &str,
    params: &ParamList,
    default: Integrator,
) -> Result<Integrator, SceneError> {
    let max_depth = params.integer("maxdepth", 1, 65_535)?.unwrap_or(default.max_depth);
    let mut integrator = Integrator { max_depth, ..default };
    if name == "sppm" {
        integrator.photons_per_iteration = photons(params)?;
        integrator.seed = params.integer("seed", 0, u32::MAX)?.unwrap_or(default.seed);
        if params.get("radius").is_some() {
            // The square of the radius must fit in the device's numbers.
            let expected = "a length from 1e-15 to 1e15";
            let accept = |v: f64| (1e-15..=1e15).contains(&v);
            integrator.radius = Some(params.float_in("radius", 1.0, accept, expected)?);
        }
    }
    Ok(integrator)
}

fn photons(params: &ParamList) -> Result<Option<u64>, SceneError> {
    let Some(param) = params.get("photonsperiteration") else {
        return Ok(None);
    };
    match param.one()? {
        // In pbrt, -1 stands for one photon per pixel.
        [-1.0] => Ok(None),
        [count] if count >= 1.0 => Ok(Some(count as u64)),
        _ => Err(param.bad_value("at least 1, or -1 for one per pixel")),
    }
}
