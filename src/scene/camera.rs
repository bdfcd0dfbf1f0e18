//! `Camera`.

use glam::DAffine3;

use super::error::SceneError;
use super::model::{Camera, Projection};
use super::params::ParamList;
use super::registry::{Family, Kind, ParamSpec, full, not_yet, supported};

const FLOAT: &[Kind] = &[Kind::Float];
const SCREEN_WINDOW: ParamSpec = full("screenwindow", FLOAT);
const FRAME_ASPECT_RATIO: ParamSpec = full("frameaspectratio", FLOAT);
const LENS_RADIUS: ParamSpec = full("lensradius", FLOAT);
const FOCAL_DISTANCE: ParamSpec = full("focaldistance", FLOAT);
// Nothing moves, but the time that the shutter is open exposes the film.
const SHUTTER_OPEN: ParamSpec = full("shutteropen", FLOAT);
const SHUTTER_CLOSE: ParamSpec = full("shutterclose", FLOAT);

/// The cameras of pbrt.
pub(super) const FAMILY: Family = Family {
    directive: "Camera",
    types: &[
        supported(
            "perspective",
            &[
                full("fov", FLOAT),
                SCREEN_WINDOW,
                FRAME_ASPECT_RATIO,
                LENS_RADIUS,
                FOCAL_DISTANCE,
                SHUTTER_OPEN,
                SHUTTER_CLOSE,
            ],
        ),
        supported(
            "orthographic",
            &[SCREEN_WINDOW, FRAME_ASPECT_RATIO, LENS_RADIUS, FOCAL_DISTANCE, SHUTTER_OPEN, SHUTTER_CLOSE],
        ),
        supported("spherical", &[full("mapping", &[Kind::String]), SHUTTER_OPEN, SHUTTER_CLOSE]),
        not_yet("realistic"),
    ],
};

/// Makes a camera from parameters that [`FAMILY`] has checked.
pub(super) fn camera(
    name: &str,
    params: &ParamList,
    world_from_camera: DAffine3,
    resolution: [u32; 2],
) -> Result<Camera, SceneError> {
    let aspect = f64::from(resolution[0]) / f64::from(resolution[1]);
    let aspect = params.positive("frameaspectratio", aspect)?;
    let screen_window = match params.get("screenwindow") {
        None if aspect > 1.0 => [-aspect, aspect, -1.0, 1.0],
        None => [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect],
        Some(param) => {
            let window: [f64; 4] = param.one()?;
            if !(window[0] < window[1] && window[2] < window[3]) {
                return Err(param.bad_value("x minimum < x maximum, y minimum < y maximum"));
            }
            window
        }
    };
    Ok(Camera {
        world_from_camera,
        projection: projection(name, params)?,
        screen_window,
        lens_radius: params.not_negative("lensradius", 0.0)?,
        focal_distance: params.positive("focaldistance", 1e6)?,
    })
}

fn projection(name: &str, params: &ParamList) -> Result<Projection, SceneError> {
    match name {
        "orthographic" => Ok(Projection::Orthographic),
        "spherical" => match (params.string("mapping")?, params.get("mapping")) {
            (Some("equirectangular"), _) => Ok(Projection::Equirectangular),
            (Some("equalarea"), _) | (_, None) => Ok(Projection::EqualArea),
            (_, Some(param)) => Err(param.bad_value("\"equalarea\" or \"equirectangular\"")),
        },
        _ => {
            let fov = params.float_in("fov", 90.0, |v| v > 0.0 && v < 180.0, "an angle between 0 and 180°")?;
            Ok(Projection::Perspective { tan_half_fov: (fov / 2.0).to_radians().tan() })
        }
    }
}

/// How long the shutter is open, 1 by default.
pub(super) fn exposure_time(params: &ParamList) -> Result<f64, SceneError> {
    let open = params.float("shutteropen")?.unwrap_or(0.0);
    let close = params.float("shutterclose")?.unwrap_or(1.0);
    match params.get("shutterclose").or(params.get("shutteropen")) {
        Some(param) if close <= open => Err(param.bad_value("a shutter that closes after it opens")),
        _ => Ok(close - open),
    }
}
