//! The content of a scene file, fully resolved: the input of [`crate::gpu_scene::pack`].
//!
//! No value refers to the text any more: included files are read, transforms are composed (in f64), named
//! materials are looked up, spectra are linear RGB in the sRGB primaries. Lengths are in scene units, in
//! the scene's world space.

pub(in crate::scene) mod extent;
mod input;
pub(in crate::scene) mod missing_light;
mod plane;
pub(in crate::scene) mod texture;

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};

pub use input::{Input, Rgb};

use crate::base::input::Budget;
use crate::geometry::bezier::Curve;
use crate::image::film::{Image, Window};
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
    /// Paths of the files that the scene includes or imports.
    pub included: Vec<PathBuf>,
    /// Paths of the files that the scene reads besides its own: included and imported files, and files that
    /// parameters name.
    pub inputs: Vec<PathBuf>,
    /// Warnings, one line each: directives and parameters that are ignored, or rendered differently than
    /// the scene asks for.
    pub warnings: Vec<String>,
    /// The scene's budget of memory, with the bytes taken so far.
    pub budget: Arc<Budget>,
}

/// Image size, file, exposure and pixel filter.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Width and height in pixels of what the camera sees, each at least 1.
    pub resolution: [u32; 2],
    /// The part of the image that is rendered: x minimum, x maximum, y minimum, y maximum, as fractions of
    /// the resolution from the upper left corner.
    pub window: [f64; 4],
    /// Factor from the radiance that a pixel sees to the pixel's value.
    pub exposure: f64,
    /// The output file that the scene names, relative to the working directory.
    pub filename: Option<PathBuf>,
    /// Filter by which camera samples spread around a pixel.
    pub filter: PixelFilter,
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

/// Roughness of a surface of microfacets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughness {
    /// Roughness along the direction in which the first texture coordinate grows; 0 or more.
    pub u: Input<f64>,
    /// Roughness along the direction in which the second texture coordinate grows; 0 or more.
    pub v: Input<f64>,
    /// Whether the values are perceptual: then their square roots are the slopes of the microfacets (GGX's
    /// alpha), as in pbrt.
    pub remap: bool,
}

impl Roughness {
    /// The roughness of a smooth surface.
    pub const SMOOTH: Self = Self { u: Input::Constant(0.0), v: Input::Constant(0.0), remap: false };
    /// Smallest alpha of a rough surface: a surface with a smaller alpha along both directions is smooth,
    /// as in pbrt.
    pub const LEAST_ALPHA: f64 = 1e-3;

    /// Returns GGX's alpha for a value of the roughness.
    pub fn alpha(&self, value: f64) -> f64 {
        if self.remap { value.sqrt() } else { value }
    }

    /// Returns true if the surface is smooth: both values are constants with an alpha below
    /// [`Self::LEAST_ALPHA`]. A roughness from a texture is never smooth.
    pub fn is_smooth(&self) -> bool {
        let is_small = |input| matches!(input, Input::Constant(value) if self.alpha(value) < Self::LEAST_ALPHA);
        is_small(self.u) && is_small(self.v)
    }
}

/// The reflectance of a metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Metal {
    /// Optical constants per channel.
    Index {
        /// Real part of the index of refraction.
        eta: Rgb,
        /// Absorption coefficient.
        k: Rgb,
    },
    /// Reflectance at normal incidence, 0 to 1. A constant reflectance is converted to [`Metal::Index`].
    Reflectance(Input<Rgb>),
}

/// A clear coat of varnish.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Index of refraction of the coat over the index outside.
    pub eta: f64,
    /// Optical thickness: light that crosses the coat perpendicularly is multiplied by exp(-thickness).
    pub thickness: f64,
    /// Roughness of the coat's outer surface.
    pub roughness: Roughness,
}

/// How a surface scatters light.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Lambertian reflection.
    Diffuse {
        /// Albedo per channel, 0 to 1; values of a texture outside that range are clamped.
        reflectance: Input<Rgb>,
    },
    /// Lambertian reflection and transmission of a thin sheet.
    DiffuseTransmission {
        /// Albedo of reflection, to the side that the light comes from, 0 to 1.
        reflectance: Input<Rgb>,
        /// Albedo of transmission, to the other side, 0 to 1.
        transmittance: Input<Rgb>,
        /// Factor of both albedos.
        scale: f64,
    },
    /// A metal.
    Conductor {
        /// Reflectance of the metal.
        metal: Metal,
        /// Roughness of the metal.
        roughness: Roughness,
    },
    /// Glass or water.
    Dielectric {
        /// Index of refraction inside over outside, positive.
        eta: f64,
        /// Fraction of the light that passes at each crossing, per channel, 0 to 1. An extension of the
        /// pbrt format: pbrt's dielectrics are untinted.
        transmittance: Rgb,
        /// Roughness of the surface.
        roughness: Roughness,
    },
    /// A thin pane of glass, with both of its surfaces.
    ThinDielectric {
        /// Index of refraction inside over outside, positive.
        eta: f64,
    },
    /// A Lambertian surface under a coat.
    CoatedDiffuse {
        /// Albedo of the surface under the coat, 0 to 1.
        reflectance: Input<Rgb>,
        /// The coat.
        coat: Coat,
    },
    /// A metal under a coat.
    CoatedConductor {
        /// Reflectance of the metal; optical constants are relative to the coat's index.
        metal: Metal,
        /// Roughness of the metal.
        roughness: Roughness,
        /// The coat.
        coat: Coat,
    },
    /// A random choice between two other materials at each point.
    Mix {
        /// Indices into [`Scene::materials`].
        materials: [usize; 2],
        /// Probability of the second material, 0 to 1.
        amount: Input<f64>,
    },
    /// No surface: light passes unchanged. The scene leaves out shapes of this material.
    Interface,
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
#[derive(Clone, Copy, Debug, PartialEq)]
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
}

/// An image that an area light shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionImage {
    /// Index into [`Scene::textures`].
    pub texture: usize,
    /// Mean of the image's pixels.
    pub mean: Rgb,
}

/// An image that gives the light in each direction: a texel has one colour, as in pbrt.
#[derive(Clone, Debug, PartialEq)]
pub struct LightImage {
    /// Pixels: finite, 0 or more, and not all black. The first row is the top one, v = 0.
    pub pixels: Arc<Image>,
    /// Transform of directions from the image's space to world space; its columns are orthogonal and of
    /// unit length.
    pub world_from_image: DMat3,
}

/// A light that is not a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// Emits the same intensity in all directions from a point.
    Point {
        /// Position in world space.
        position: DVec3,
        /// Radiant intensity, W/sr; scale and power included.
        intensity: Rgb,
    },
    /// A point that emits within a cone.
    Spot {
        /// Position in world space.
        position: DVec3,
        /// Axis of the cone, unit length, world space.
        direction: DVec3,
        /// Radiant intensity on the axis, W/sr; scale and power included.
        intensity: Rgb,
        /// 1 minus the cosine of the angle at which the smooth falloff starts.
        falloff_start: f64,
        /// 1 minus the cosine of the angle beyond which the light emits nothing.
        falloff_end: f64,
    },
    /// Parallel light from infinitely far away.
    Distant {
        /// Direction in which the light travels, unit length, world space.
        direction: DVec3,
        /// Irradiance on a surface that faces the light, W/m².
        irradiance: Rgb,
    },
    /// A point whose intensity depends on the direction, by the equal-area map of
    /// [`crate::geometry::equal_area`].
    Goniometric {
        /// Position in world space.
        position: DVec3,
        /// Grey image whose pixels multiply the intensity.
        image: LightImage,
        /// Radiant intensity before the image's factor, W/sr; scale and power included.
        intensity: Rgb,
    },
    /// A point that projects an image, which fills a window on the plane z = 1 of the image's space; u
    /// grows with x, v with y.
    Projection {
        /// Position in world space.
        position: DVec3,
        /// Image whose pixels multiply the intensity.
        image: LightImage,
        /// Radiant intensity before the image's factor, W/sr; scale and power included.
        intensity: Rgb,
        /// Half the width and height of the window.
        half_extent: DVec2,
    },
    /// Radiance from infinitely far away that depends on the direction, by the equal-area map of
    /// [`crate::geometry::equal_area`].
    Sky {
        /// Image whose pixels multiply the radiance, by the direction to the sky.
        image: LightImage,
        /// Radiance before the image's factor, W/(m² sr); scale and illuminance included.
        radiance: Rgb,
    },
    /// The same radiance from every direction.
    Infinite {
        /// Radiance, W/(m² sr).
        radiance: Rgb,
    },
}
