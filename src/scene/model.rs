//! What a scene file says, fully resolved: the input of [`crate::gpu_scene::pack`].
//!
//! Nothing here refers to the text any more: includes are read, transforms are
//! composed (in f64), named materials are looked up, spectra are linear RGB in
//! the sRGB primaries. Lengths are in scene units, in the scene's world space.

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
    /// The image to make.
    pub film: Film,
    /// Where it is seen from.
    pub camera: Camera,
    /// What the scene file says about how to render it.
    pub integrator: Integrator,
    /// Materials; [`Shape::material`] indexes them.
    pub materials: Vec<Material>,
    /// Every texture, whether something uses it or not, in the order of the file.
    pub textures: Vec<Texture>,
    /// Every surface, in the order of the file.
    pub shapes: Vec<Shape>,
    /// Where objects stand, in the order of the file.
    pub instances: Vec<Instance>,
    /// Every light that is not a surface, in the order of the file.
    pub lights: Vec<Light>,
    /// Files that it includes or imports.
    pub included: Vec<PathBuf>,
    /// Files that it reads besides its own: those that it includes or imports, and those that
    /// parameters name.
    pub inputs: Vec<PathBuf>,
    /// One line each: what was ignored or rendered differently than asked for.
    pub warnings: Vec<String>,
    /// What the scene may take, and what of it is taken.
    pub budget: Arc<Budget>,
}

/// Image size and file.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Width and height in pixels of what the camera sees, each at least 1.
    pub resolution: [u32; 2],
    /// The part of it that is rendered: x minimum, x maximum, y minimum, y maximum, as
    /// fractions of the resolution from the upper left corner.
    pub window: [f64; 4],
    /// What pixels are, over the radiance that they see.
    pub exposure: f64,
    /// The output file that the scene names, relative to the working directory.
    pub filename: Option<PathBuf>,
    /// How camera samples spread around a pixel.
    pub filter: PixelFilter,
}

impl Film {
    /// The first pixel that is rendered, and the one after the last, where the camera sees
    /// so many pixels. There is always one.
    pub fn bounds(&self, resolution: [u32; 2]) -> [[u32; 2]; 2] {
        // Rounded up, as pbrt does. Bounds that were whole stay so: fractions have rounding
        // errors, far smaller than this.
        const SLACK: f64 = 1e-6;
        let [width, height] = resolution;
        let [x0, x1, y0, y1] = self.window;
        let pixel = |fraction: f64, side: u32| (fraction * f64::from(side) - SLACK).ceil() as u32;
        let first = [pixel(x0, width).min(width - 1), pixel(y0, height).min(height - 1)];
        [first, [pixel(x1, width).max(first[0] + 1), pixel(y1, height).max(first[1] + 1)]]
    }

    /// Where what is rendered lies in what the camera sees, in so many pixels.
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
    /// Half width along x and y, in pixels; 0 looks through the pixel's centre only.
    pub radius: DVec2,
}

/// The profile of a [`PixelFilter`] along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilterKind {
    /// Constant.
    Box,
    /// Linear to zero at the radius.
    Triangle,
    /// exp(-x²/2σ²) less its value at the radius; `sigma` in pixels.
    Gaussian {
        /// Standard deviation, in pixels.
        sigma: f64,
    },
    /// A cubic spline in |x| over half the radius, with negative lobes (Mitchell and
    /// Netravali 1988).
    Mitchell {
        /// Weight of the blurring part.
        b: f64,
        /// Weight of the ringing part.
        c: f64,
    },
    /// sin(πx) / πx, windowed by the main lobe of the same, `tau` times as wide (Lanczos);
    /// it has negative lobes.
    Sinc {
        /// Width of the window in cycles, positive.
        tau: f64,
    },
}

/// How a [`Camera`] lays the world out on the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Through a point or a thin lens.
    Perspective {
        /// tan(fov / 2) of the shorter image axis.
        tan_half_fov: f64,
    },
    /// Along parallel lines; the screen window is in scene units.
    Orthographic,
    /// All directions, by angles: y is up, the left edge looks along +x.
    Equirectangular,
    /// All directions on a square, of equal solid angles (Clarberg 2008).
    EqualArea,
}

/// A camera, perhaps with a thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// From camera space (x right, y up, z forward, as in pbrt) to world space.
    pub world_from_camera: DAffine3,
    /// How directions become places on the image.
    pub projection: Projection,
    /// Screen window: x minimum, x maximum, y minimum, y maximum; ±1 spans the fov.
    /// Of no matter where all directions are seen, nor is the lens.
    pub screen_window: [f64; 4],
    /// Radius of the lens in scene units; 0 is a pinhole.
    pub lens_radius: f64,
    /// Distance along z at which the lens is in focus, scene units.
    pub focal_distance: f64,
}

/// The scene's own rendering options; the command line may override each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrator {
    /// The most segments of a path.
    pub max_depth: u32,
    /// Photons per iteration; `None` means one per pixel, as in pbrt.
    pub photons_per_iteration: Option<u64>,
    /// Initial radius, scene units.
    pub radius: Option<f64>,
    /// Seed of every random number.
    pub seed: u32,
    /// Iterations: the sampler's `pixelsamples`.
    pub iterations: u32,
}

/// Roughness of a surface of microfacets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughness {
    /// Along the direction in which the first texture coordinate grows; 0 or more.
    pub u: Input<f64>,
    /// Along the other.
    pub v: Input<f64>,
    /// The values are perceptual: their square roots are the slopes of the microfacets (GGX's
    /// alpha), as in pbrt.
    pub remap: bool,
}

impl Roughness {
    /// None at all.
    pub const SMOOTH: Self = Self { u: Input::Constant(0.0), v: Input::Constant(0.0), remap: false };
    /// Surfaces with a smaller alpha along both directions are smooth: pbrt's bound.
    pub const LEAST_ALPHA: f64 = 1e-3;

    /// GGX's alpha for a value.
    pub fn alpha(&self, value: f64) -> f64 {
        if self.remap { value.sqrt() } else { value }
    }

    /// Whether it is none; never that of a texture.
    pub fn is_smooth(&self) -> bool {
        let is_small = |input| matches!(input, Input::Constant(value) if self.alpha(value) < Self::LEAST_ALPHA);
        is_small(self.u) && is_small(self.v)
    }
}

/// What a metal reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Metal {
    /// By optical constants, per channel.
    Index {
        /// Real part of the index of refraction.
        eta: Rgb,
        /// Absorption coefficient.
        k: Rgb,
    },
    /// By reflectance at normal incidence, 0 to 1; a constant one has become an index.
    Reflectance(Input<Rgb>),
}

/// A clear coat of varnish.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Its index of refraction over that outside.
    pub eta: f64,
    /// Optical thickness: light that crosses it straight keeps exp(-thickness).
    pub thickness: f64,
    /// Of its surface.
    pub roughness: Roughness,
}

/// How a surface scatters light.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Lambertian.
    Diffuse {
        /// Albedo per channel, 0 to 1; what a texture has outside is clamped.
        reflectance: Input<Rgb>,
    },
    /// Lambertian on both sides of a thin sheet.
    DiffuseTransmission {
        /// Albedo on the side that the light comes from, 0 to 1.
        reflectance: Input<Rgb>,
        /// Albedo on the other side, 0 to 1.
        transmittance: Input<Rgb>,
        /// Factor of both.
        scale: f64,
    },
    /// A metal.
    Conductor {
        /// Its reflectance.
        metal: Metal,
        /// Its roughness.
        roughness: Roughness,
    },
    /// Glass or water.
    Dielectric {
        /// Index of refraction inside over outside, positive.
        eta: f64,
        /// What part of the light passes at each crossing, per channel, 0 to 1.
        /// An extension of the pbrt format: pbrt's dielectrics are untinted.
        transmittance: Rgb,
        /// Its roughness.
        roughness: Roughness,
    },
    /// A thin pane of glass, with both of its surfaces.
    ThinDielectric {
        /// Index of refraction inside over outside, positive.
        eta: f64,
    },
    /// A Lambertian surface under a coat.
    CoatedDiffuse {
        /// Albedo of what is under the coat, 0 to 1.
        reflectance: Input<Rgb>,
        /// The coat.
        coat: Coat,
    },
    /// A metal under a coat.
    CoatedConductor {
        /// The metal's reflectance: of a constant index relative to the coat.
        metal: Metal,
        /// The metal's roughness.
        roughness: Roughness,
        /// The coat.
        coat: Coat,
    },
    /// At each point one of two others, by chance.
    Mix {
        /// Indices into [`Scene::materials`].
        materials: [usize; 2],
        /// Chance of the second, 0 to 1.
        amount: Input<f64>,
    },
    /// None: light passes. Shapes of it are left out.
    Interface,
}

/// One surface of the scene.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its form, in object space.
    pub geometry: Geometry,
    /// From its object space to world space, or that of its instances; invertible, but for meshes
    /// without normals.
    pub world_from_object: DAffine3,
    /// Set where it is part of an object, of which there are [`Scene::instances`] or none.
    /// Such a shape does not emit.
    pub object: Option<usize>,
    /// `ReverseOrientation` was in force.
    pub reverse_orientation: bool,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// How much of it is there, 0 to 1: rays go through the rest.
    pub alpha: Input<f64>,
    /// Set where an `AreaLightSource` was in force.
    pub emission: Option<AreaLight>,
    /// Of `Shape "revolution"`: how many such directives stand before its own.
    pub revolution: Option<usize>,
    /// `file:line:column` of the directive, for messages.
    pub location: String,
}

/// A place where an object stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// All shapes with this [`Shape::object`]; there is at least one.
    pub object: usize,
    /// From what is world space to those shapes; invertible.
    pub world_from_instance: DAffine3,
}

/// The form of a [`Shape`].
#[derive(Clone, Debug)]
pub enum Geometry {
    /// Triangles.
    Mesh(Arc<Mesh>),
    /// A sphere about the origin, perhaps cut.
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
    /// A body of revolution about z: goblet's own.
    Revolution(Arc<Profile>),
}

/// The profile of a body of revolution, in the half plane of radius and height. Its outside
/// is to the right of travel: one that runs upward faces away from the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Bezier curves of degree 1 to 8, all of one degree; each begins where the last one
    /// ends. Radii are 0 or more, and at least one is not.
    pub segments: Vec<Curve>,
}

/// Triangles with shared vertices. All numbers but those of normals are finite, all indices in
/// range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions in object space.
    pub positions: Vec<DVec3>,
    /// Vertex normals in object space: one per position, or none at all. Those of a triangle
    /// count unless one of them is not finite, or all are 0.
    pub normals: Vec<DVec3>,
    /// Texture coordinates: one per position, or none at all.
    pub uvs: Vec<DVec2>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// A diffusely emitting surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// Emitted radiance, W/(m² sr), `scale` included; where `power` is set, the
    /// radiance before it is scaled to that power.
    pub radiance: Rgb,
    /// pbrt's `power`: each emitter (a quadric, or one triangle of a mesh) of
    /// area A emits `radiance · power / (k π A)`, k = 2 if two-sided, else 1.
    pub power: Option<f64>,
    /// Emits on both sides.
    pub two_sided: bool,
    /// What the radiance is times.
    pub image: Option<EmissionImage>,
}

/// An image that an area light shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionImage {
    /// Index into [`Scene::textures`].
    pub texture: usize,
    /// Of its pixels.
    pub mean: Rgb,
}

/// What a light shows in each direction: a texel is of one colour, as in pbrt.
#[derive(Clone, Debug, PartialEq)]
pub struct LightImage {
    /// Not negative, finite, and not all black. The top row is first: v = 0.
    pub pixels: Arc<Image>,
    /// Directions of the image's space in world space; orthogonal, of unit length.
    pub world_from_image: DMat3,
}

/// A light that is not a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// Emits the same intensity in all directions from a point.
    Point {
        /// World space.
        position: DVec3,
        /// Radiant intensity, W/sr; scale and power included.
        intensity: Rgb,
    },
    /// A point that emits within a cone.
    Spot {
        /// World space.
        position: DVec3,
        /// Axis of the cone, unit length, world space.
        direction: DVec3,
        /// Radiant intensity on the axis, W/sr; scale and power included.
        intensity: Rgb,
        /// One less the cosine of the angle where the smooth falloff starts.
        falloff_start: f64,
        /// One less the cosine of the angle beyond which nothing is emitted.
        falloff_end: f64,
    },
    /// Parallel light from infinitely far away.
    Distant {
        /// The way the light travels, unit length, world space.
        direction: DVec3,
        /// Irradiance on a surface that faces the light, W/m².
        irradiance: Rgb,
    },
    /// A point whose intensity depends on the direction, by the equal-area map of `octahedral`.
    Goniometric {
        /// World space.
        position: DVec3,
        /// Factors of the intensity, grey.
        image: LightImage,
        /// What they multiply, W/sr; scale and power included.
        intensity: Rgb,
    },
    /// A point that projects an image, which fills a window on the plane z = 1 of its space;
    /// u grows with x, v with y.
    Projection {
        /// World space.
        position: DVec3,
        /// Factors of the intensity.
        image: LightImage,
        /// What they multiply, W/sr; scale and power included.
        intensity: Rgb,
        /// Half the width and height of the window.
        half_extent: DVec2,
    },
    /// Radiance from infinitely far away that depends on the direction, by the equal-area
    /// map of `octahedral`.
    Sky {
        /// Factors of the radiance, by the direction to the sky.
        image: LightImage,
        /// What they multiply, W/(m² sr); scale and illuminance included.
        radiance: Rgb,
    },
    /// The same radiance from every direction.
    Infinite {
        /// Radiance, W/(m² sr).
        radiance: Rgb,
    },
}
