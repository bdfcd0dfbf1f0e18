//! The content of a scene file, fully resolved: the input of [`crate::gpu_scene::pack`].
//!
//! No value refers to the text any more: included files are read, transforms are composed (in f64), named
//! materials are looked up, spectra are linear RGB in the sRGB primaries; indices of refraction, lights and media have
//! their curves by wavelength besides. Lengths are in scene units, in the scene's world space.

pub(in crate::scene) mod extent;
mod index;
mod input;
mod light;
mod material;
mod measured;
mod medium;
mod plane;
pub(in crate::scene) mod texture;
mod unmet_light;

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};

pub use index::{ByWavelength, Index};
pub use input::{Input, Rgb};
pub use light::{Light, LightImage, Portal};
pub use material::{Bump, Coat, Material, Metal, Roughness, Scattering};
pub use measured::{Grid, Measured};
pub use medium::{Medium, MediumInterface};

use crate::base::input::Budget;
use crate::geometry::bezier::Curve;
use crate::image::film::{CoordinateSystem, Window};
use crate::scene::model::texture::Texture;

/// A scene that is ready to upload.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The image: its size, file and pixel filter.
    pub film: Film,
    /// The camera.
    pub camera: Camera,
    /// Rendering options that the scene file gives.
    pub integrator: Integrator,
    /// Materials; [`Shape::material`] indexes them.
    pub materials: Vec<Material>,
    /// Every texture, used or not, in the order of the file.
    pub textures: Vec<Texture>,
    /// Every surface, in the order of the file.
    pub shapes: Vec<Shape>,
    /// Instances of objects, in the order of the file.
    pub instances: Vec<Instance>,
    /// Every light that is not a surface, in the order of the file.
    pub lights: Vec<Light>,
    /// Every medium that surrounds something; indices to it are `None` for a vacuum.
    pub media: Vec<Medium>,
    /// For each of the lights, the index of the medium around it.
    pub light_media: Vec<Option<usize>>,
    /// For each of the lights, its curve over that of daylight, in any unit; `None` if it has the curve of daylight or is
    /// known as RGB only.
    pub light_curves: Vec<Option<ByWavelength>>,
    /// Index of the medium around the camera.
    pub camera_medium: Option<usize>,
    /// Paths of the files that the scene includes or imports.
    pub included: Vec<PathBuf>,
    /// Paths of the files that the scene reads besides its own: included and imported files, and files that
    /// parameters name.
    pub inputs: Vec<PathBuf>,
    /// Warnings, one line each: directives and parameters that are ignored, or rendered differently than
    /// the scene asks for.
    pub warnings: Vec<String>,
    /// Parameters that cannot change the image, one line for each type that has it, with its first place.
    pub ignored: Vec<String>,
    /// The scene's budget of memory, with the bytes taken so far.
    pub budget: Arc<Budget>,
}

/// Image size, file, exposure, white balance and pixel filter.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Width and height in pixels of what the camera sees, each at least 1.
    pub resolution: [u32; 2],
    /// The part of the image that is rendered: x minimum, x maximum, y minimum, y maximum, as fractions of
    /// the resolution from the upper left corner.
    pub window: [f64; 4],
    /// Factor from the radiance that a pixel sees to the pixel's value.
    pub exposure: f64,
    /// The light that looks white in the image; `None` leaves colours as they are.
    pub white_balance: Option<WhiteBalance>,
    /// The output file that the scene names, relative to the working directory.
    pub filename: Option<PathBuf>,
    /// Filter by which camera samples spread around a pixel.
    pub filter: PixelFilter,
    /// The coordinate system of the layers that a `gbuffer` film asks for; `None` for other films.
    pub gbuffer: Option<CoordinateSystem>,
}

/// The adaptation of an image to a light, which looks white in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WhiteBalance {
    /// Colour temperature of the light as the scene gives it, K.
    pub kelvin: f64,
    /// Matrix from the linear sRGB that a pixel sees to that of the image.
    pub matrix: DMat3,
}

impl Film {
    /// Returns the first rendered pixel and the pixel after the last one, as (x, y), for an image of
    /// `resolution` pixels. The range contains at least one pixel.
    pub fn bounds(&self, resolution: [u32; 2]) -> [[u32; 2]; 2] {
        // Edges are rounded up, as in pbrt. Fractions have rounding errors far below this slack, so edges
        // on whole pixels stay whole.
        const SLACK: f64 = 1e-6;
        let [width, height] = resolution;
        let [x0, x1, y0, y1] = self.window;
        let pixel = |fraction: f64, side: u32| (fraction * f64::from(side) - SLACK).ceil() as u32;
        let first = [pixel(x0, width).min(width - 1), pixel(y0, height).min(height - 1)];
        [first, [pixel(x1, width).max(first[0] + 1), pixel(y1, height).max(first[1] + 1)]]
    }

    /// Returns the position of the rendered pixels in an image of `resolution` pixels.
    pub fn part(&self, resolution: [u32; 2]) -> Window {
        let [first, _] = self.bounds(resolution);
        Window { first: first.map(|side| side as i32), full: resolution }
    }
}

/// A separable pixel filter; radii in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelFilter {
    /// The filter's profile along each axis.
    pub kind: FilterKind,
    /// Half width along x and y, in pixels; 0 samples the pixel's centre only.
    pub radius: DVec2,
}

/// The profile of a [`PixelFilter`] along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilterKind {
    /// Constant.
    Box,
    /// Linear to zero at the radius.
    Triangle,
    /// exp(-x²/2σ²) minus its value at the radius; `sigma` in pixels.
    Gaussian {
        /// Standard deviation, in pixels.
        sigma: f64,
    },
    /// A cubic spline in |x| over half the radius, with negative lobes (Mitchell and
    /// Netravali 1988).
    Mitchell {
        /// Weight of the blurring part, B in the paper.
        b: f64,
        /// Weight of the ringing part, C in the paper.
        c: f64,
    },
    /// sin(πx) / πx, windowed by the main lobe of a sinc that is `tau` times as wide (Lanczos). The filter
    /// has negative lobes.
    Sinc {
        /// Width of the window in cycles, positive.
        tau: f64,
    },
}

/// Map from directions to places on the image of a [`Camera`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Central projection through a pinhole or a thin lens.
    Perspective {
        /// tan(fov / 2) of the shorter image axis.
        tan_half_fov: f64,
    },
    /// Projection along parallel lines; the screen window is in scene units.
    Orthographic,
    /// All directions by longitude and latitude: y is up, the left edge looks along +x.
    Equirectangular,
    /// All directions on a square by an equal-area map (Clarberg 2008).
    EqualArea,
}

/// A camera with a pinhole or a thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Transform from camera space (x right, y up, z forward, as in pbrt) to world space.
    pub world_from_camera: DAffine3,
    /// Map from directions to places on the image.
    pub projection: Projection,
    /// Screen window: x minimum, x maximum, y minimum, y maximum; ±1 spans the field of view. Projections
    /// that see all directions use neither the window nor the lens.
    pub screen_window: [f64; 4],
    /// Radius of the lens in scene units; 0 is a pinhole.
    pub lens_radius: f64,
    /// Distance along z of the plane in focus, in scene units.
    pub focal_distance: f64,
}

/// Rendering options of the scene; the command line may override each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrator {
    /// Maximum number of segments of a path.
    pub max_depth: u32,
    /// Photons per iteration; `None` means one per pixel, as in pbrt.
    pub photons_per_iteration: Option<u64>,
    /// Initial radius in scene units; `None` if the scene gives none.
    pub radius: Option<f64>,
    /// Seed of every random number.
    pub seed: u32,
    /// Number of iterations: the sampler's `pixelsamples`.
    pub iterations: u32,
}

/// One surface of the scene.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Geometry in object space.
    pub geometry: Geometry,
    /// Transform from object space to world space, or to the space of the object's instances if `object` is
    /// set. Invertible, except that of a mesh without normals.
    pub world_from_object: DAffine3,
    /// Index of the object that the shape is part of, which may have no instance among
    /// [`Scene::instances`]; `None` for a shape that stands in the scene itself. A shape of an object does
    /// not emit.
    pub object: Option<usize>,
    /// Whether `ReverseOrientation` was in force.
    pub reverse_orientation: bool,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Media on both sides.
    pub media: MediumInterface,
    /// Opacity, 0 to 1: the probability that a ray hits the surface and does not pass through.
    pub alpha: Input<f64>,
    /// Emission; set if an `AreaLightSource` was in force.
    pub emission: Option<AreaLight>,
    /// For a `Shape "revolution"`: the number of such directives before its own; `None` for other shapes.
    pub revolution: Option<usize>,
    /// `file:line:column` of the directive, for messages.
    pub location: String,
}

/// A placed copy of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index of the object: the copy consists of all shapes with this [`Shape::object`], of which there is
    /// at least one.
    pub object: usize,
    /// Transform to world space from the space that [`Shape::world_from_object`] of the object's shapes
    /// leads to; invertible.
    pub world_from_instance: DAffine3,
}

/// The geometry of a [`Shape`].
#[derive(Clone, Debug)]
pub enum Geometry {
    /// Triangles.
    Mesh(Arc<Mesh>),
    /// A sphere or part of a sphere about the origin.
    Sphere {
        /// Radius, positive.
        radius: f64,
        /// Lower cut, in [-radius, z_max).
        z_min: f64,
        /// Upper cut, in (z_min, radius].
        z_max: f64,
        /// Sweep about z from the x axis, radians, in (0, 2π].
        phi_max: f64,
    },
    /// A disk in the plane z = height, facing +z.
    Disk {
        /// Height along z.
        height: f64,
        /// Outer radius, positive.
        radius: f64,
        /// Inner radius, in [0, radius).
        inner_radius: f64,
        /// Sweep about z from the x axis, radians, in (0, 2π].
        phi_max: f64,
    },
    /// A body of revolution about z, an extension of the pbrt format.
    Revolution(Arc<Profile>),
}

/// The profile of a body of revolution, in the half plane of radius and height. The outside is to the right
/// of the direction of travel: a profile that runs upward faces away from the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Bezier curves of one common degree from 1 to 8; each curve begins where the previous one ends. Radii
    /// are 0 or more, and at least one is above 0.
    pub segments: Vec<Curve>,
}

/// Triangles with shared vertices. All numbers except those of normals are finite, and all indices are in
/// range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions in object space.
    pub positions: Vec<DVec3>,
    /// Vertex normals in object space: one per position, or none. A triangle uses the normals of its
    /// corners unless one of them is not finite or all are 0.
    pub normals: Vec<DVec3>,
    /// Texture coordinates: one per position, or none.
    pub uvs: Vec<DVec2>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Diffuse emission of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaLight {
    /// Emitted radiance in W/(m² sr), `scale` included; if `power` is set, the radiance before it is scaled
    /// to that power.
    pub radiance: Rgb,
    /// pbrt's `power`: each emitter (a quadric, or one triangle of a mesh) of area A emits `radiance ·
    /// power / (k π A)`, with k = 2 if two-sided, and 1 otherwise.
    pub power: Option<f64>,
    /// Whether the surface emits on both sides.
    pub two_sided: bool,
    /// Image whose pixels multiply the radiance.
    pub image: Option<EmissionImage>,
    /// The curve of the radiance over that of daylight, in any unit; `None` if it has the curve of daylight or is known as
    /// RGB only.
    pub curve: Option<ByWavelength>,
}

/// An image that an area light shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionImage {
    /// Index into [`Scene::textures`].
    pub texture: usize,
    /// Mean of the image's pixels.
    pub mean: Rgb,
}
