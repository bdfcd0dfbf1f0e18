//! Moves a camera as a hand does.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use crate::gpu_scene::camera::ImagePlane;
use crate::scene::{Camera, Film, Projection};

/// How near to the up direction a camera looks, radians: nearer, it would turn over.
const LEAST_TILT: f64 = 0.02;

/// A camera, and what it turns about.
#[derive(Clone, Debug)]
pub struct CameraControl {
    camera: Camera,
    /// Where it was at first.
    home: Camera,
    film: Film,
    /// A unit vector that stays upright.
    up: DVec3,
    /// From the eye to the point that it turns about, world units; unknown until something is seen.
    distance: Option<f64>,
}

impl CameraControl {
    /// Of a camera that the scene has.
    pub fn new(camera: Camera, film: Film) -> Self {
        // What the scene called up is forgotten; most have an axis there.
        let seen = camera.world_from_camera.matrix3.y_axis;
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * seen.dot(axis).signum());
        let up = axes.into_iter().max_by(|a, b| a.dot(seen).total_cmp(&b.dot(seen))).unwrap_or(DVec3::Y);
        Self { camera, home: camera, film, up, distance: None }
    }

    /// The camera as it is now.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Back to where it was at first.
    pub fn reset(&mut self) {
        self.camera = self.home;
        self.distance = None;
    }

    /// The middle of the image is so far away.
    pub fn set_distance_once(&mut self, distance: f64) {
        self.distance.get_or_insert(distance);
    }

    /// Comes back to where another one is at first, and has its film.
    pub fn set_home(&mut self, other: Self) {
        (self.home, self.film) = (other.home, other.film);
    }

    /// Width of a pixel at the pivot, world units.
    pub fn pixel_width(&self, resolution: [u32; 2]) -> f64 {
        let across = ImagePlane::new(&self.camera, &self.film, resolution).across.abs();
        let matrix = self.camera.world_from_camera.matrix3;
        match self.camera.projection {
            Projection::Orthographic => across * matrix.x_axis.length(),
            _ => across * self.distance(),
        }
    }

    /// From the eye to the pivot, world units.
    pub fn distance(&self) -> f64 {
        self.distance.unwrap_or(1.0)
    }

    fn forward(&self) -> DVec3 {
        self.camera.world_from_camera.matrix3.z_axis.normalize()
    }

    /// The point that it turns about.
    pub fn pivot(&self) -> DVec3 {
        self.camera.world_from_camera.translation + self.forward() * self.distance()
    }

    fn turn_about(&mut self, pivot: DVec3, rotation: DMat3) {
        let DAffine3 { matrix3, translation } = self.camera.world_from_camera;
        self.camera.world_from_camera =
            DAffine3 { matrix3: rotation * matrix3, translation: pivot + rotation * (translation - pivot) };
    }

    /// Turns about the pivot, radians: to the right about what is up, and then upward.
    pub fn orbit(&mut self, right: f64, upward: f64) {
        let tilt = self.forward().angle_between(self.up);
        // Who goes up looks down.
        let most = std::f64::consts::PI - LEAST_TILT;
        let upward = (tilt + upward).clamp(LEAST_TILT.min(tilt), most.max(tilt)) - tilt;
        let sideways = self.up.cross(self.forward()).normalize_or(self.camera.world_from_camera.matrix3.x_axis);
        // What is right on the image may be left in a mirrored world.
        let right = right * sideways.dot(self.camera.world_from_camera.matrix3.x_axis).signum();
        let rotation = DMat3::from_axis_angle(self.up, right) * DMat3::from_axis_angle(sideways.normalize(), upward);
        self.turn_about(self.pivot(), rotation);
    }

    /// Moves sideways, so that what is so deep in the image (or at the pivot) goes from one place
    /// on it to another; the corners are (0, 0) and (1, 1).
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

    /// Goes nearer to the pivot, or further away from it where the factor is above 1.
    pub fn dolly(&mut self, factor: f64) {
        if self.camera.projection == Projection::Orthographic {
            // Going nowhere would change nothing.
            let zoom = DMat3::from_diagonal(DVec3::new(factor, factor, 1.0));
            self.camera.world_from_camera.matrix3 *= zoom;
            return;
        }
        let pivot = self.pivot();
        self.distance = Some(self.distance() * factor);
        self.camera.world_from_camera.translation = pivot - self.forward() * self.distance();
    }

    /// Flies along its own axes (right, up, forward), in distances to the pivot, which goes along.
    pub fn fly(&mut self, by: DVec3) {
        let matrix = self.camera.world_from_camera.matrix3;
        let axes = DMat3::from_cols(matrix.x_axis.normalize(), self.up, matrix.z_axis.normalize());
        self.camera.world_from_camera.translation += axes * by * self.distance();
    }

    /// Focuses there, and turns about a point as far away.
    pub fn focus(&mut self, point: DVec3) {
        let depth = self.depth_of(point);
        if depth > 0.0 {
            self.camera.focal_distance = depth;
            self.distance = Some(depth * self.camera.world_from_camera.matrix3.z_axis.length());
        }
    }

    /// Sets the lens. One that was a pinhole, to which all is sharp, comes to focus on the pivot.
    pub fn set_lens(&mut self, radius: f64, focal_distance: f64) {
        let was_pinhole = self.camera.lens_radius == 0.0 && radius > 0.0;
        let focal_distance = if was_pinhole { self.depth_of(self.pivot()) } else { focal_distance };
        (self.camera.lens_radius, self.camera.focal_distance) = (radius, focal_distance);
    }

    /// How deep a point is in the image, in units of camera space.
    pub fn depth_of(&self, point: DVec3) -> f64 {
        self.camera.world_from_camera.inverse().transform_point3(point).z
    }

    /// What a path of this length from a place on the image has come to, as far as it is straight.
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

    /// From a place on the image to one on the image plane; spherical cameras have none.
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
}
