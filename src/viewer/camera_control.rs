//! Camera control: orbit, pan, dolly, flight, focus and lens.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use crate::gpu_scene::camera::ImagePlane;
use crate::scene::{Camera, Film, Projection};

/// The smallest angle between the viewing direction and the up direction (or its opposite), in radians. At
/// smaller angles the camera could turn over.
const LEAST_TILT: f64 = 0.02;

/// The range of the field of view, in degrees.
pub const FIELDS_OF_VIEW: [f64; 2] = [1.0, 170.0];

/// A camera and its distance to the pivot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The camera.
    pub camera: Camera,
    /// The distance from the eye to the pivot in world units; `None` until the first picture.
    pub distance: Option<f64>,
}

/// A camera with the pivot about which it turns.
#[derive(Clone, Debug)]
pub struct CameraControl {
    camera: Camera,
    /// The camera to which `reset` returns.
    home: Camera,
    film: Film,
    /// The up direction, a unit vector in world space.
    up: DVec3,
    /// The distance from the eye to the pivot in world units; `None` until the first picture.
    distance: Option<f64>,
}

impl CameraControl {
    /// Returns the control of a scene's camera.
    pub fn new(camera: Camera, film: Film) -> Self {
        // A `Scene` does not keep the up vector of the file. In most scenes it is a coordinate axis.
        let seen = camera.world_from_camera.matrix3.y_axis;
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * seen.dot(axis).signum());
        let up = axes.into_iter().max_by(|a, b| a.dot(seen).total_cmp(&b.dot(seen))).unwrap_or(DVec3::Y);
        Self { camera, home: camera, film, up, distance: None }
    }

    /// Returns the current camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Returns the camera and its distance to the pivot.
    pub fn place(&self) -> Place {
        Place { camera: self.camera, distance: self.distance }
    }

    /// Returns to a place.
    pub fn go_to(&mut self, place: Place) {
        (self.camera, self.distance) = (place.camera, place.distance);
    }

    /// Returns whether the camera is that of the scene.
    pub fn is_home(&self) -> bool {
        self.camera == self.home
    }

    /// Returns the field of view along the shorter side of the image, in degrees; `None` if lines of sight are parallel
    /// or the camera sees all directions.
    pub fn field_of_view(&self) -> Option<f64> {
        let Projection::Perspective { tan_half_fov } = self.camera.projection else { return None };
        Some(2.0 * tan_half_fov.atan().to_degrees())
    }

    /// Sets the field of view along the shorter side of the image, in degrees, where the camera has one.
    pub fn set_field_of_view(&mut self, degrees: f64) {
        if let Projection::Perspective { tan_half_fov } = &mut self.camera.projection {
            let [least, most] = FIELDS_OF_VIEW;
            *tan_half_fov = (0.5 * degrees.clamp(least, most)).to_radians().tan();
        }
    }

    /// Multiplies the size of what the camera sees by a factor: the width of the image plane, whose field of view stays in
    /// its range.
    pub fn widen(&mut self, factor: f64) {
        match self.camera.projection {
            Projection::Perspective { tan_half_fov } => {
                self.set_field_of_view(2.0 * (factor * tan_half_fov).atan().to_degrees());
            }
            Projection::Orthographic => self.dolly(factor),
            Projection::Equirectangular | Projection::EqualArea => {}
        }
    }

    /// Resets the camera to the one of the scene.
    pub fn reset(&mut self) {
        self.camera = self.home;
        self.distance = None;
    }

    /// Sets the distance to the pivot in world units, unless it is known.
    pub fn set_distance_once(&mut self, distance: f64) {
        self.distance.get_or_insert(distance);
    }

    /// Takes the home camera and the film of another control, and keeps the current camera.
    pub fn set_home(&mut self, other: Self) {
        (self.home, self.film) = (other.home, other.film);
    }

    /// Returns the width of a pixel at the pivot in world units.
    pub fn pixel_width(&self, resolution: [u32; 2]) -> f64 {
        let across = ImagePlane::new(&self.camera, &self.film, resolution).across.abs();
        let matrix = self.camera.world_from_camera.matrix3;
        match self.camera.projection {
            Projection::Orthographic => across * matrix.x_axis.length(),
            _ => across * self.distance(),
        }
    }

    /// Returns the distance from the eye to the pivot in world units; 1 if it is unknown.
    pub fn distance(&self) -> f64 {
        self.distance.unwrap_or(1.0)
    }

    fn forward(&self) -> DVec3 {
        self.camera.world_from_camera.matrix3.z_axis.normalize()
    }

    /// Returns the point about which the camera turns.
    pub fn pivot(&self) -> DVec3 {
        self.camera.world_from_camera.translation + self.forward() * self.distance()
    }

    fn turn_about(&mut self, pivot: DVec3, rotation: DMat3) {
        let DAffine3 { matrix3, translation } = self.camera.world_from_camera;
        self.camera.world_from_camera =
            DAffine3 { matrix3: rotation * matrix3, translation: pivot + rotation * (translation - pivot) };
    }

    /// Turns the camera about the pivot, by angles in radians: to the right about the up direction, and
    /// upward.
    pub fn orbit(&mut self, right: f64, upward: f64) {
        let tilt = self.forward().angle_between(self.up);
        // A camera that moves up looks down.
        let most = std::f64::consts::PI - LEAST_TILT;
        let upward = (tilt + upward).clamp(LEAST_TILT.min(tilt), most.max(tilt)) - tilt;
        let sideways = self.up.cross(self.forward()).normalize_or(self.camera.world_from_camera.matrix3.x_axis);
        // In a mirrored world, right on the image may be left.
        let right = right * sideways.dot(self.camera.world_from_camera.matrix3.x_axis).signum();
        let rotation = DMat3::from_axis_angle(self.up, right) * DMat3::from_axis_angle(sideways.normalize(), upward);
        self.turn_about(self.pivot(), rotation);
    }

    /// Moves the camera sideways, so that a point at `depth` (or at the depth of the pivot) moves on the
    /// image from one place to another. The corners of the image are (0, 0) and (1, 1).
    pub fn pan(&mut self, from: DVec2, to: DVec2, depth: Option<f64>, resolution: [u32; 2]) {
        let Some([from, to]) = self.on_plane(from, resolution).zip(self.on_plane(to, resolution)).map(<[_; 2]>::from)
        else {
            return;
        };
        let matrix = self.camera.world_from_camera.matrix3;
        let scale = match self.camera.projection {
            Projection::Orthographic => 1.0,
            _ => depth.unwrap_or(self.distance() / matrix.z_axis.length()),
        };
        self.camera.world_from_camera.translation -= matrix * ((to - from) * scale).extend(0.0);
    }

    /// Multiplies the distance to the pivot by a factor: below 1, the camera moves nearer.
    pub fn dolly(&mut self, factor: f64) {
        if self.camera.projection == Projection::Orthographic {
            // A distance has no effect on parallel rays, so the image plane is scaled.
            let zoom = DMat3::from_diagonal(DVec3::new(factor, factor, 1.0));
            self.camera.world_from_camera.matrix3 *= zoom;
            return;
        }
        let pivot = self.pivot();
        self.distance = Some(self.distance() * factor);
        self.camera.world_from_camera.translation = pivot - self.forward() * self.distance();
    }

    /// Moves the camera and its pivot along its axes (right, up, forward), in distances to the pivot.
    pub fn fly(&mut self, by: DVec3) {
        let matrix = self.camera.world_from_camera.matrix3;
        let axes = DMat3::from_cols(matrix.x_axis.normalize(), self.up, matrix.z_axis.normalize());
        self.camera.world_from_camera.translation += axes * by * self.distance();
    }

    /// Focuses on a point, and moves the pivot to the depth of this point.
    pub fn focus(&mut self, point: DVec3) {
        let depth = self.depth_of(point);
        if depth > 0.0 {
            self.camera.focal_distance = depth;
            self.distance = Some(depth * self.camera.world_from_camera.matrix3.z_axis.length());
        }
    }

    /// Sets the radius and the focal distance of the lens. If the camera was a pinhole, which has everything
    /// in focus, it focuses on the pivot instead.
    pub fn set_lens(&mut self, radius: f64, focal_distance: f64) {
        let was_pinhole = self.camera.lens_radius == 0.0 && radius > 0.0;
        let focal_distance = if was_pinhole { self.depth_of(self.pivot()) } else { focal_distance };
        (self.camera.lens_radius, self.camera.focal_distance) = (radius, focal_distance);
    }

    /// Returns the depth of a point, which is its z in camera space.
    pub fn depth_of(&self, point: DVec3) -> f64 {
        self.camera.world_from_camera.inverse().transform_point3(point).z
    }

    /// Returns the end point of a straight path of this length from a place on the image; `None` for
    /// spherical cameras.
    pub fn seen(&self, at: DVec2, length: f64, resolution: [u32; 2]) -> Option<DVec3> {
        let place = self.on_plane(at, resolution)?;
        let (origin, direction) = match self.camera.projection {
            Projection::Orthographic => (place.extend(0.0), DVec3::Z),
            _ => (DVec3::ZERO, place.extend(1.0)),
        };
        let camera = self.camera.world_from_camera;
        let direction = camera.transform_vector3(direction).normalize();
        Some(camera.transform_point3(origin) + direction * length)
    }

    /// Converts a place on the image to a place on the image plane; `None` for spherical cameras.
    fn on_plane(&self, at: DVec2, resolution: [u32; 2]) -> Option<DVec2> {
        let has_plane = matches!(self.camera.projection, Projection::Perspective { .. } | Projection::Orthographic);
        let ImagePlane { lower, upper, .. } = ImagePlane::new(&self.camera, &self.film, resolution);
        let (lower, upper) = (DVec2::from(lower), DVec2::from(upper));
        has_plane.then(|| lower + (upper - lower) * at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    const RESOLUTION: [u32; 2] = [300, 200];

    fn control(text: &str) -> CameraControl {
        let film = "Film \"rgb\" \"integer xresolution\" 300 \"integer yresolution\" 200\n";
        let world = "WorldBegin\nLightSource \"point\"\nShape \"sphere\"\n";
        let scene = Scene::parse(&format!("{film}{text}{world}"), "test.pbrt", ".").unwrap();
        let mut control = CameraControl::new(scene.camera, scene.film);
        control.set_distance_once(5.0);
        control
    }

    const CAMERAS: [&str; 4] = [
        "LookAt 1 2 5  0 .5 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\n",
        "LookAt 3 -4 2  0 0 1  0 0 1\nCamera \"perspective\"\n",
        "Scale -1 1 1\nLookAt 1 2 5  0 .5 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\n",
        "LookAt 1 2 5  0 .5 0  0 1 0\nScale 2 2 2\nCamera \"orthographic\"\n",
    ];

    fn project(control: &CameraControl, point: DVec3) -> DVec2 {
        let at = control.camera().world_from_camera.inverse().transform_point3(point);
        let place = match control.camera().projection {
            Projection::Orthographic => at.truncate(),
            _ => at.truncate() / at.z,
        };
        let ImagePlane { lower, upper, .. } = ImagePlane::new(control.camera(), &control.film, RESOLUTION);
        let (lower, upper) = (DVec2::from(lower), DVec2::from(upper));
        (place - lower) / (upper - lower)
    }

    #[test]
    fn orbiting_keeps_the_pivot_the_distance_and_up() {
        for text in CAMERAS {
            let mut control = control(text);
            let (pivot, up) = (control.pivot(), control.up);
            for i in 0..100 {
                control.orbit(0.1, if i % 40 < 20 { 0.07 } else { -0.07 });
                let DAffine3 { matrix3, translation } = control.camera().world_from_camera;
                assert!(control.pivot().distance(pivot) < 1e-9, "{text}");
                assert!((translation.distance(pivot) - 5.0).abs() < 1e-9, "{text}");
                assert!(matrix3.x_axis.dot(up).abs() < 1e-9, "level: {text}");
                assert!(matrix3.y_axis.dot(up) > 0.0, "upright: {text}");
            }
            assert!(control.camera().world_from_camera.translation != control.home.world_from_camera.translation);
        }
    }

    #[test]
    fn no_orbit_goes_over_the_pole() {
        for upward in [10.0, -10.0] {
            let mut control = control(CAMERAS[0]);
            control.orbit(0.0, upward);
            control.orbit(0.0, upward);
            let tilt = control.forward().angle_between(control.up);
            assert!((tilt.min(std::f64::consts::PI - tilt) - LEAST_TILT).abs() < 1e-6, "{tilt}");
        }
    }

    #[test]
    fn panning_moves_a_point_with_the_cursor() {
        for text in CAMERAS {
            let mut control = control(text);
            let from = DVec2::new(0.25, 0.7);
            let point = control.seen(from, 4.0, RESOLUTION).unwrap();
            assert!(project(&control, point).distance(from) < 1e-9, "{text}");
            let to = DVec2::new(0.7, 0.2);
            control.pan(from, to, Some(control.depth_of(point)), RESOLUTION);
            assert!(project(&control, point).distance(to) < 1e-9, "{text}");
        }
    }

    #[test]
    fn dollying_keeps_the_pivot_in_the_middle() {
        for text in CAMERAS {
            let mut control = control(text);
            let pivot = control.pivot();
            control.dolly(0.5);
            control.dolly(1.5);
            let away = control.camera().world_from_camera.translation.distance(pivot);
            let is_flat = control.camera().projection == Projection::Orthographic;
            assert!((away - if is_flat { 5.0 } else { 3.75 }).abs() < 1e-9, "{text}");
            assert!(project(&control, pivot).distance(DVec2::splat(0.5)) < 1e-9, "{text}");
        }
    }

    #[test]
    fn what_is_clicked_is_in_focus() {
        for text in CAMERAS {
            let mut control = control(text);
            let point = control.seen(DVec2::new(0.1, 0.3), 3.0, RESOLUTION).unwrap();
            control.focus(point);
            assert!((control.camera().focal_distance - control.depth_of(point)).abs() < 1e-12);
            assert!((control.depth_of(control.pivot()) - control.depth_of(point)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_lens_that_opens_is_in_focus() {
        for text in CAMERAS {
            let mut control = control(text);
            let depth = control.depth_of(control.pivot());
            control.set_lens(0.1, 1e6);
            assert_eq!((control.camera().lens_radius, control.camera().focal_distance), (0.1, depth));
            control.set_lens(0.2, 3.0);
            assert_eq!((control.camera().lens_radius, control.camera().focal_distance), (0.2, 3.0));
        }
    }

    #[test]
    fn flying_goes_along_the_axes_and_reset_comes_back() {
        let mut control = control(CAMERAS[0]);
        let start = control.camera().world_from_camera.translation;
        control.fly(DVec3::new(0.0, 0.0, 0.2));
        let gone = control.camera().world_from_camera.translation - start;
        assert!((gone - control.forward()).length() < 1e-9);
        control.reset();
        assert_eq!(control.camera().world_from_camera, control.home.world_from_camera);
    }

    #[test]
    fn a_wider_field_of_view_sees_more_and_stays_in_its_range() {
        let mut control = control(CAMERAS[0]);
        assert!((control.field_of_view().unwrap() - 40.0).abs() < 1e-9);
        control.set_field_of_view(60.0);
        assert!((control.field_of_view().unwrap() - 60.0).abs() < 1e-9);
        let width = ImagePlane::new(control.camera(), &control.film, RESOLUTION).across;
        control.widen(1.25);
        let wider = ImagePlane::new(control.camera(), &control.film, RESOLUTION).across;
        assert!((wider / width - 1.25).abs() < 1e-9);
        for (factor, end) in [(1e9, 1), (1e-9, 0)] {
            control.widen(factor);
            assert!((control.field_of_view().unwrap() - FIELDS_OF_VIEW[end]).abs() < 1e-6);
        }
    }

    #[test]
    fn parallel_lines_of_sight_have_no_angle_but_can_be_widened() {
        let mut control = control(CAMERAS[3]);
        assert_eq!(control.field_of_view(), None);
        let pivot = control.pivot();
        control.widen(1.25);
        assert!(project(&control, pivot).distance(DVec2::splat(0.5)) < 1e-9);
        assert!(!control.is_home());
        let place = control.place();
        control.reset();
        assert!(control.is_home());
        control.go_to(place);
        assert_eq!(control.place(), place);
    }
}
