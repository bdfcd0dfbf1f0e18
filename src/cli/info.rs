//! The subcommand `goblet info`: describes the contents of a scene without a device. docs/json.md lists the
//! keys of the JSON.

// Circle: info.rs <-> text.rs: the text describes the structs of the JSON.

mod text;

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

use super::stats::count;
use super::{Failure, InfoArgs, terminal};
use crate::gpu_scene::camera::{View, pack_camera};
use crate::gpu_scene::pack::{PackedScene, light_kind, pack};
use crate::kernels::{Constant, Specialization};
use crate::render::buffers::{LEAST_ROOM, Sizes};
use crate::render::error::RenderError;
use crate::render::memory::MemoryNeed;
use crate::render::options::{Options, Resolved};
use crate::render::specialize::specialization;
use crate::scene::{self, FilterKind, Projection, Scene, Survey};
use text::describe;

/// The version of the keys of the JSON and of their meaning. It is raised when one vanishes, or changes its type or
/// its meaning; keys are added without.
const SCHEMA_VERSION: u32 = 1;

/// The description of a scene. Parts that are unknown because of faults are left out.
#[derive(Serialize)]
struct Info {
    schema_version: u32,
    #[serde(flatten)]
    contents: Option<Contents>,
    /// Parts of the scene that are ignored, or rendered differently than the file asks for.
    warnings: Vec<String>,
    /// Parameters that cannot change the image.
    ignored: Vec<String>,
    unsupported: Vec<String>,
    /// All other faults.
    errors: Vec<String>,
    /// The number of faults that are not listed.
    further_faults: u64,
}

#[derive(Serialize)]
struct Contents {
    /// Counts of shapes, materials and lights by type.
    scene: BTreeMap<String, u64>,
    /// The bounding sphere; `None` if there is no surface.
    bounds: Option<Bounds>,
    /// Power in W by kind of light, as the mean of red, green and blue.
    light_power: BTreeMap<&'static str, f64>,
    /// Whether glass or a pane has an index of refraction that depends on the wavelength.
    dispersion: bool,
    film: Film,
    camera: Camera,
    integrator: Integrator,
    /// The features of the kernels that the scene uses.
    specialization: BTreeMap<String, Value>,
    memory: Memory,
}

/// The bounding sphere of the scene, in scene units.
#[derive(Serialize)]
struct Bounds {
    center: [f64; 3],
    radius: f64,
}

#[derive(Serialize)]
struct Film {
    resolution: [u32; 2],
    /// The first pixel that is rendered, and the one after the last.
    rendered: [[u32; 2]; 2],
    exposure: f64,
    /// Colour temperature in K; `None` without a white balance.
    whitebalance: Option<f64>,
    filter: &'static str,
    /// Parameters of the filter by their names in scene files.
    filter_parameters: BTreeMap<&'static str, f64>,
    /// Radius of the filter in pixels.
    filter_radius: [f64; 2],
}

#[derive(Serialize)]
struct Camera {
    projection: &'static str,
    /// The angle along the shorter image axis in degrees; `None` for spherical and orthographic cameras.
    field_of_view: Option<f64>,
    position: [f64; 3],
    screen_window: [f64; 4],
    lens_radius: f64,
    focal_distance: f64,
}

#[derive(Serialize)]
struct Integrator {
    iterations: u32,
    photons_per_iteration: u64,
    max_depth: u32,
    /// The initial radius in scene units; `None` if it follows the footprints of pixels.
    radius: Option<f64>,
    /// The initial radius without one of the scene's own.
    automatic_radius: AutomaticRadius,
    seed: u32,
}

/// An initial radius that follows the footprints of pixels. The length of the eye path decides; without a device it is
/// known for one distance.
#[derive(Serialize)]
struct AutomaticRadius {
    /// In widths of a pixel.
    pixels: f64,
    /// From the camera to the centre of the bounds, in scene units.
    distance: f64,
    /// At that distance, in scene units.
    at_distance: f64,
}

/// The estimated device memory in bytes.
#[derive(Serialize)]
struct Memory {
    scene: u64,
    buffers: u64,
}

/// Prints the description of a scene on standard output, and its faults on standard error; JSON has both.
///
/// # Errors
/// The scene cannot be rendered; the known parts of its description are printed nevertheless. Or standard
/// output cannot be written to.
pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let Survey { scene, unsupported, errors, more } = Scene::survey(&args.scene, args.scene_memory.budget());
    let mut errors: Vec<Failure> = errors.into_iter().map(Failure::from).collect();
    let contents = scene.as_ref().map(Contents::new).transpose().unwrap_or_else(|error| {
        errors.push(error.into());
        None
    });
    let (warnings, ignored) = scene.map(|scene| (scene.warnings, scene.ignored)).unwrap_or_default();
    let info = Info {
        schema_version: SCHEMA_VERSION,
        contents,
        warnings,
        ignored,
        unsupported: unsupported.iter().map(ToString::to_string).collect(),
        errors: errors.iter().map(ToString::to_string).collect(),
        further_faults: more,
    };
    let failure = match errors.pop() {
        None if unsupported.is_empty() => None,
        Some(error) if unsupported.is_empty() && errors.is_empty() => Some(error),
        _ => Some(Failure::Unrenderable(args.scene.display().to_string())),
    };
    if args.json {
        let json = serde_json::to_value(&info).map_err(|error| Failure::Info(error.to_string()))?;
        terminal::print(&format!("{json:#}\n"))?;
    } else {
        terminal::print(&describe(&info))?;
        say_faults(&info, matches!(failure, Some(Failure::Unrenderable(_))));
    }
    failure.map_or(Ok(()), Err)
}

/// Prints warnings and faults on standard error. A single error is the failure of the command, which is printed at
/// the end; `has_all` says that the errors are to be printed here.
fn say_faults(info: &Info, has_all: bool) {
    info.warnings.iter().for_each(terminal::warn);
    let errors = info.errors.iter().filter(|_| has_all);
    let faults =
        info.unsupported.iter().map(|fault| ("unsupported", fault)).chain(errors.map(|fault| ("error", fault)));
    for (kind, fault) in faults {
        terminal::say(format_args!("{kind}: {fault}"));
    }
    if info.further_faults > 0 {
        terminal::say(format_args!("further faults: {}", info.further_faults));
    }
}

impl Contents {
    fn new(scene: &Scene) -> Result<Self, RenderError> {
        let options = Options::default();
        let packed = pack(scene, options.packing(scene))?;
        let size = packed.space.radius / packed.space.scale;
        let resolved = options.resolve(scene, size)?;
        let view = pack_camera(&scene.camera, &scene.film, resolved.window.full, &packed.space.from_world());
        let Resolved { photons, max_depth, .. } = resolved;
        let sizes = Sizes::of_render(&packed, &options, &resolved, LEAST_ROOM);
        let memory = MemoryNeed::new(&packed, &sizes, options.lookup, resolved.layers);
        Ok(Self {
            scene: count(scene),
            bounds: packed.has_surfaces().then(|| Bounds { center: packed.space.center.to_array(), radius: size }),
            light_power: light_power(&packed),
            dispersion: packed.material_features.has_dispersion,
            film: Film::new(&scene.film),
            camera: Camera::new(&scene.camera),
            integrator: Integrator {
                iterations: scene.integrator.iterations,
                photons_per_iteration: photons,
                max_depth,
                radius: resolved.radius,
                automatic_radius: AutomaticRadius::new(scene, &packed, &resolved, &view),
                seed: resolved.seed,
            },
            specialization: features(&specialization(
                packed.features,
                packed.material_features,
                &view,
                &options,
                &resolved,
                Specialization::DECLARED.device,
            )),
            memory: Memory { scene: memory.scene, buffers: memory.buffers },
        })
    }
}

impl AutomaticRadius {
    fn new(scene: &Scene, packed: &PackedScene, resolved: &Resolved, view: &View) -> Self {
        let distance = scene.camera.world_from_camera.translation.distance(packed.space.center);
        let pixel =
            if view.is_parallel() { view.pixel_width / packed.space.scale } else { view.pixel_width * distance };
        let pixels = resolved.radius_in_pixels;
        Self { pixels, distance, at_distance: pixels * pixel }
    }
}

impl Film {
    fn new(film: &scene::Film) -> Self {
        let (filter, parameters) = match film.filter.kind {
            FilterKind::Box => ("box", vec![]),
            FilterKind::Triangle => ("triangle", vec![]),
            FilterKind::Gaussian { sigma } => ("gaussian", vec![("sigma", sigma)]),
            FilterKind::Mitchell { b, c } => ("mitchell", vec![("B", b), ("C", c)]),
            FilterKind::Sinc { tau } => ("sinc", vec![("tau", tau)]),
        };
        Self {
            resolution: film.resolution,
            rendered: film.bounds(film.resolution),
            exposure: film.exposure,
            whitebalance: film.white_balance.map(|balance| balance.kelvin),
            filter,
            filter_parameters: parameters.into_iter().collect(),
            filter_radius: film.filter.radius.to_array(),
        }
    }
}

impl Camera {
    fn new(camera: &scene::Camera) -> Self {
        let (projection, field_of_view) = match camera.projection {
            Projection::Perspective { tan_half_fov } => ("perspective", Some(2.0 * tan_half_fov.atan().to_degrees())),
            Projection::Orthographic => ("orthographic", None),
            Projection::Equirectangular => ("equirectangular", None),
            Projection::EqualArea => ("equal_area", None),
        };
        Self {
            projection,
            field_of_view,
            position: camera.world_from_camera.translation.to_array(),
            screen_window: camera.screen_window,
            lens_radius: camera.lens_radius,
            focal_distance: camera.focal_distance,
        }
    }
}

fn light_power(packed: &PackedScene) -> BTreeMap<&'static str, f64> {
    let scene_unit = 1.0 / packed.space.scale;
    let mut powers = BTreeMap::new();
    for light in &packed.arrays.lights {
        let power = f64::from(light.emission_pmf) * packed.mean_power * scene_unit * scene_unit;
        *powers.entry(light_kind(light.kind)).or_insert(0.0) += power;
    }
    powers
}

/// Returns the specialization constants that are neither false nor 0, by their names.
fn features(specialization: &Specialization) -> BTreeMap<String, Value> {
    let used = specialization.values().into_iter().filter_map(|(name, constant)| {
        let value = match constant {
            Constant::Flag(value) => value.then_some(Value::Bool(true)),
            Constant::Number(value) if value.fract() == 0.0 => (value != 0.0).then(|| Value::from(value as u64)),
            Constant::Number(value) => Some(Value::from(value)),
        };
        Some((name.to_owned(), value?))
    });
    used.collect()
}
