//! The `Camera` directive.

use glam::{DAffine3, DMat4, DVec3};

use crate::scene::directives::transform;
use crate::scene::format::error::SceneError;
use crate::scene::format::kind::Kind;
use crate::scene::format::params::ParamList;
use crate::scene::format::registry::{Family, ParamSpec, full, ignored, not_yet, supported};
use crate::scene::model::{Camera, Projection};

const FLOAT: &[Kind] = &[Kind::Float];
const SCREEN_WINDOW: ParamSpec = full("screenwindow", FLOAT);
const FRAME_ASPECT_RATIO: ParamSpec = full("frameaspectratio", FLOAT);
const LENS_RADIUS: ParamSpec = full("lensradius", FLOAT);
const FOCAL_DISTANCE: ParamSpec = full("focaldistance", FLOAT);
// Motion is ignored, but the time that the shutter is open is a factor of the exposure.
const SHUTTER_OPEN: ParamSpec = full("shutteropen", FLOAT);
const SHUTTER_CLOSE: ParamSpec = full("shutterclose", FLOAT);

/// pbrt's default focal distance, in scene units.
const FAR: f64 = 1e6;

/// The cameras of pbrt.
pub(in crate::scene) const FAMILY: Family = Family {
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
        supported(
            "spherical",
            &[
                full("mapping", &[Kind::String]),
                ignored("screenwindow", FLOAT),
                ignored("frameaspectratio", FLOAT),
                ignored("lensradius", FLOAT),
                ignored("focaldistance", FLOAT),
                SHUTTER_OPEN,
                SHUTTER_CLOSE,
            ],
        ),
        not_yet("realistic"),
    ],
};

/// Returns a camera from parameters that [`FAMILY`] has checked. `resolution` gives the default aspect
/// ratio.
pub(in crate::scene) fn camera(
    name: &str,
    params: &ParamList,
    world_from_camera: DAffine3,
    resolution: [u32; 2],
) -> Result<Camera, SceneError> {
    let aspect = f64::from(resolution[0]) / f64::from(resolution[1]);
    let aspect = params.positive("frameaspectratio", aspect)?;
    let screen_window = match params.get("screenwindow") {
        None => default_window(aspect),
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
        focal_distance: params.positive("focaldistance", FAR)?,
    })
}

impl Camera {
    /// Returns a pinhole camera at `eye` that looks at the point `target`, with the direction `up` upwards
    /// in the image; all in world space, in scene units. `fov` is the field of view along the shorter side
    /// of the image, in radians, between 0 and π. `resolution` is the image's width and height in pixels.
    ///
    /// Returns `None` if `target` is `eye`, `up` is parallel to the line of sight, a number is not finite,
    /// or `fov` or `resolution` is out of range.
    pub fn looking_at(eye: DVec3, target: DVec3, up: DVec3, fov: f64, resolution: [u32; 2]) -> Option<Self> {
        let [width, height] = resolution.map(f64::from);
        let is_seen = fov > 0.0 && fov < std::f64::consts::PI && width > 0.0 && height > 0.0;
        let camera_from_world = transform::look_at(eye, target, up).filter(|look| is_seen && look.is_finite())?;
        Some(Self {
            world_from_camera: camera_from_world.inverse(),
            projection: Projection::Perspective { tan_half_fov: (0.5 * fov).tan() },
            screen_window: default_window(width / height),
            lens_radius: 0.0,
            focal_distance: FAR,
        })
    }

    /// Returns the directives that give this camera, for a film of `width` x `height` pixels.
    pub fn to_text(&self, [width, height]: [u32; 2]) -> String {
        let mut text = self.transform_text();
        let (name, fov) = match self.projection {
            Projection::Perspective { tan_half_fov } => {
                let fov = 2.0 * tan_half_fov.atan().to_degrees();
                ("perspective", format!(" \"float fov\" [ {fov} ]"))
            }
            Projection::Orthographic => ("orthographic", String::new()),
            Projection::Equirectangular => ("spherical", " \"string mapping\" \"equirectangular\"".to_owned()),
            Projection::EqualArea => ("spherical", " \"string mapping\" \"equalarea\"".to_owned()),
        };
        text += &format!("Camera \"{name}\"{fov}");
        if name == "spherical" {
            return text + "\n";
        }
        if self.screen_window != default_window(f64::from(width) / f64::from(height)) {
            let [left, right, bottom, top] = self.screen_window;
            text += &format!("\n  \"float screenwindow\" [ {left} {right} {bottom} {top} ]");
        }
        if self.lens_radius > 0.0 {
            let Self { lens_radius, focal_distance, .. } = self;
            text += &format!("\n  \"float lensradius\" [ {lens_radius} ] \"float focaldistance\" [ {focal_distance} ]");
        }
        text + "\n"
    }

    /// Returns a `LookAt` if that gives the camera's transform, and a `Transform` otherwise.
    fn transform_text(&self) -> String {
        let DAffine3 { matrix3, translation: eye } = self.world_from_camera;
        let (look, up) = (eye + matrix3.z_axis, matrix3.y_axis);
        let looks = transform::look_at(eye, look, up);
        if looks.is_some_and(|looks| looks.inverse().abs_diff_eq(self.world_from_camera, 1e-9)) {
            return format!(
                "LookAt {} {} {}  {} {} {}  {} {} {}\n",
                eye.x, eye.y, eye.z, look.x, look.y, look.z, up.x, up.y, up.z
            );
        }
        let numbers = DMat4::from(self.world_from_camera.inverse()).to_cols_array();
        format!("Transform [ {} ]\n", numbers.map(|number| number.to_string()).join(" "))
    }
}

/// Returns the default screen window for an aspect ratio: ±1 along the shorter axis.
pub(crate) fn default_window(aspect: f64) -> [f64; 4] {
    if aspect > 1.0 { [-aspect, aspect, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect] }
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

/// Returns the time that the shutter is open, 1 by default.
pub(in crate::scene) fn exposure_time(params: &ParamList) -> Result<f64, SceneError> {
    let open = params.float("shutteropen")?.unwrap_or(0.0);
    let close = params.float("shutterclose")?.unwrap_or(1.0);
    match params.get("shutterclose").or(params.get("shutteropen")) {
        Some(param) if close <= open => Err(param.bad_value("a shutter that closes after it opens")),
        _ => Ok(close - open),
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use crate::scene::Scene;

    fn camera(text: &str) -> super::Camera {
        let film = "Film \"rgb\" \"integer xresolution\" 300 \"integer yresolution\" 200\n";
        let world = "WorldBegin\nLightSource \"point\"\nShape \"sphere\"\n";
        Scene::parse(&format!("{film}{text}{world}"), "test.pbrt", ".").unwrap().camera
    }

    #[test]
    fn a_camera_made_by_numbers_is_that_of_the_directives() {
        let read = camera("LookAt 1 2 3  4 -5 6  .1 1 .2\nCamera \"perspective\" \"float fov\" 37\n");
        let [eye, target, up] = [[1.0, 2.0, 3.0], [4.0, -5.0, 6.0], [0.1, 1.0, 0.2]].map(DVec3::from);
        let fov = 37f64.to_radians();
        assert_eq!(super::Camera::looking_at(eye, target, up, fov, [300, 200]), Some(read));
        for (target, up, fov, resolution) in [
            (eye, up, fov, [300, 200]),
            (target, target - eye, fov, [300, 200]),
            (target, up, std::f64::consts::PI, [300, 200]),
            (target, up, f64::NAN, [300, 200]),
            (DVec3::NAN, up, fov, [300, 200]),
            (target, up, fov, [300, 0]),
        ] {
            assert_eq!(super::Camera::looking_at(eye, target, up, fov, resolution), None);
        }
    }

    #[test]
    fn a_camera_written_as_text_is_the_same_when_read() {
        for (text, is_plain) in [
            ("LookAt 1 2 3  4 -5 6  .1 1 .2\nCamera \"perspective\" \"float fov\" 37\n", true),
            (
                "LookAt 0 9 0  0 0 0  0 0 1\nCamera \"perspective\" \"float lensradius\" .2 \"float focaldistance\" 7\n",
                true,
            ),
            ("LookAt 0 0 5  0 0 0  0 1 0\nCamera \"orthographic\" \"float screenwindow\" [-2 3 -1 4]\n", true),
            ("Camera \"spherical\" \"string mapping\" \"equirectangular\"\n", true),
            ("Scale -1 1 1\nLookAt 1 2 3  4 5 6  0 1 0\nCamera \"perspective\"\n", false),
            ("LookAt 1 2 3  4 5 6  0 1 0\nScale 2 2 2\nCamera \"spherical\"\n", false),
        ] {
            let before = camera(text);
            let written = before.to_text([300, 200]);
            assert_eq!(written.starts_with("LookAt"), is_plain, "{written}");
            let after = camera(&written);
            assert!(after.world_from_camera.abs_diff_eq(before.world_from_camera, 1e-12), "{written}");
            let numbers = |camera: &super::Camera| {
                let [a, b, c, d] = camera.screen_window;
                let fov = match camera.projection {
                    super::Projection::Perspective { tan_half_fov } => tan_half_fov,
                    _ => 0.0,
                };
                // The focal distance does not matter without a lens.
                let focus = if camera.lens_radius > 0.0 { camera.focal_distance } else { 0.0 };
                [a, b, c, d, fov, camera.lens_radius, focus]
            };
            for (after, before) in numbers(&after).iter().zip(numbers(&before)) {
                assert!((after - before).abs() < 1e-12, "{written}");
            }
        }
    }
}
