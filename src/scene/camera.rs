//! `Camera`.

use glam::DAffine3;

use super::error::SceneError;
use super::model::Camera;
use super::params::ParamList;
use super::registry::{Family, Kind, full, ignored, not_yet, supported};

/// The cameras of pbrt.
pub(super) const FAMILY: Family = Family {
    directive: "Camera",
    types: &[
        supported(
            "perspective",
            &[
                full("fov", &[Kind::Float]),
                full("screenwindow", &[Kind::Float]),
                full("frameaspectratio", &[Kind::Float]),
                full("lensradius", &[Kind::Float]),
                full("focaldistance", &[Kind::Float]),
                // Nothing moves yet, so the shutter has nothing to show.
                ignored("shutteropen", &[Kind::Float]),
                ignored("shutterclose", &[Kind::Float]),
            ],
        ),
        not_yet("orthographic"),
        not_yet("realistic"),
        not_yet("spherical"),
    ],
};

/// Makes a camera from parameters that [`FAMILY`] has checked.
pub(super) fn camera(
    params: &ParamList,
    world_from_camera: DAffine3,
    resolution: [u32; 2],
) -> Result<Camera, SceneError> {
    let fov = params.float_in("fov", 90.0, |v| v > 0.0 && v < 180.0, "an angle between 0 and 180°")?;
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
        tan_half_fov: (fov / 2.0).to_radians().tan(),
        screen_window,
        lens_radius: params.not_negative("lensradius", 0.0)?,
        focal_distance: params.positive("focaldistance", 1e6)?,
    })
}
