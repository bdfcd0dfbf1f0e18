//! Packing of a resolved scene into the arrays that the GPU reads.
//!
//! Render space: the scene's bounding box is moved to the origin and scaled by a power of two to a half
//! diagonal in (1/2, 1], in f64, before any number becomes f32. Thus a scene in millimetres or kilometres,
//! or far from the origin, renders alike. Radiance does not change under scaling; intensities scale with
//! the square of length.

// Circle: pack.rs <-> contact.rs <-> contact/finder.rs <-> contact/layer.rs <-> contact/near.rs <-> instance.rs <-> light.rs <-> light_image.rs <-> light_image/portal.rs <-> material.rs <-> material/dispersion.rs <-> media.rs <-> newton.rs <-> quadric.rs <-> revolution.rs <-> space.rs <-> texture.rs: one file per family of arrays, each with its methods of the Packer that holds the arrays.

mod contact;
mod instance;
mod light;
mod light_image;
mod light_range;
mod light_spectrum;
mod material;
mod media;
mod newton;
mod noise;
mod order;
mod quadric;
mod revolution;
mod space;
mod texture;

use glam::{DAffine3, DVec3, Vec3A};
use obvhs::aabb::Aabb;

pub use contact::Contacts;
use contact::Part;
use instance::Placed;
use light::POWERS;
pub(crate) use light::light_kind;
use light_range::sphere_of_reach;
pub use light_spectrum::LightSpectra;
use material::{has_bumps, mark_facets, specialize};
use media::packed_medium;
pub use newton::{Envelopes, RevolutionSolver};
pub use noise::PERMUTATION;
pub use quadric::longest_row;
use quadric::{quadric, quadric_area, quadric_bounds};
use space::MAX_EXTENT;
pub use space::RenderSpace;
use texture::PackedTextures;
pub use texture::Packing;

use crate::base::input::OverBudget;
use crate::gpu_scene::bvh::{self, Bvh, CompactBox};
use crate::kernels::{
    self, AREA, AliasEntry, DISK, DISTANT, GONIOMETRIC, INFINITE, Instance, KIND_SHIFT, LightTexel, MaterialFeatures,
    NONE, NewtonStart, PORTAL, PROJECTION, Quadric, REVOLUTION, Revolution, RevolutionPiece, RevolutionSegment, SPHERE,
    SPOT, SceneArrays, SceneFeatures, SceneInfo, TEXTURE_DOTS, TEXTURE_IMAGE, TRIANGLE, Triangle, TriangleNormals,
    TriangleUvs,
};
use crate::scene::{ByWavelength, Geometry, Input, Mesh, PACKED_LIGHT, PACKED_TRIANGLE, Rgb, Scene, Shape};

/// The reason why a scene without errors cannot be rendered.
#[derive(Debug, thiserror::Error)]
pub enum PackError {
    /// The scene's radius in scene units is above the limit.
    #[error("the scene has a radius of {0:e}; expected at most {MAX_EXTENT:e}")]
    TooLarge(f64),
    /// The power of all lights is outside of the range in which fp32 computes with it.
    #[error(
        "the power of all lights over the square of the scene's size is {0:e} W/m^2; expected {least:e} to {most:e}",
        least = POWERS.start(),
        most = POWERS.end()
    )]
    Power(f64),
    /// One light's radiance, irradiance or intensity overflows fp32.
    #[error("a light has a radiance, irradiance or intensity of {0:e}; expected at most {max:e}", max = f32::MAX)]
    TooBright(f64),
    /// The scene has more primitives than a reference can address.
    #[error("the scene has {0} primitives; at most {max} fit", max = kernels::MAX_PRIMITIVES)]
    TooManyPrimitives(usize),
    /// A texture has too many nodes or nested textures, or needs more intermediate values than the kernel's
    /// stack holds.
    #[error(
        "{location}: the texture is made of too many others; expected at most {max} values at a time",
        max = kernels::TEXTURE_STACK
    )]
    TextureTooDeep {
        /// `file:line:column` of the texture.
        location: String,
    },
    /// The packed form of a directive takes more memory than the scene's budget allows.
    #[error("{location}: too large: {over}")]
    OverBudget {
        /// `file:line:column` of the directive.
        location: String,
        /// The bytes needed, and the bytes permitted.
        over: OverBudget,
    },
}

// The sizes that the scene's budget is charged must cover the packed structs.
const _: () = {
    assert!(size_of::<Triangle>() as u64 <= PACKED_TRIANGLE && size_of::<TriangleNormals>() as u64 <= PACKED_TRIANGLE);
    let host = size_of::<f64>() + size_of::<Option<ByWavelength>>();
    assert!((size_of::<kernels::Light>() + 2 * size_of::<AliasEntry>() + host) as u64 <= PACKED_LIGHT);
};

/// All data of a scene that cross to the GPU.
pub struct PackedScene {
    /// The transform between world space and render space.
    pub space: RenderSpace,
    /// The arrays that the kernels read.
    pub arrays: SceneArrays,
    /// Number of lights that are skies.
    pub sky_count: u32,
    /// Number of the medium around the camera.
    pub camera_medium: u32,
    /// Constant radiance from infinitely far away, W/(m² sr).
    pub infinite: Rgb,
    /// Colors of lights by wavelength.
    pub light_spectra: LightSpectra,
    /// Power of all lights, mean of channels, in W at render scale; 0 if there is no light.
    pub mean_power: f64,
    /// Features that the scene's shapes and lights require of kernels.
    pub features: SceneFeatures,
    /// Features that its materials require.
    pub material_features: MaterialFeatures,
    /// The places where surfaces of different bodies coincide.
    pub contacts: Contacts,
}

impl PackedScene {
    /// Returns whether a ray can meet anything.
    pub fn has_surfaces(&self) -> bool {
        !self.arrays.bvh_children.is_empty()
    }

    /// Returns the values that kernels read besides the arrays.
    pub fn info(&self, max_depth: u32, seed: u32) -> SceneInfo {
        let (lights_center, lights_reach2) = sphere_of_reach(&self.arrays.lights);
        SceneInfo {
            center: [0.0; 3],
            // The margin is larger than the rounding errors.
            radius: (self.space.radius * 1.0001) as f32,
            infinite: self.infinite.as_vec3().to_array(),
            mean_power: self.mean_power as f32,
            emission_count: self.arrays.emission_table.len() as u32,
            direct_count: self.arrays.direct_table.len() as u32,
            max_depth,
            seed,
            lights_center,
            lights_reach2,
            contact_lower: self.contacts.lower,
            contact_error: self.contacts.error,
            contact_upper: self.contacts.upper,
            half_extent: self.space.half_extent.as_vec3().to_array(),
            sky_count: self.sky_count,
            camera_medium: self.camera_medium,
            colors: self.light_spectra.white,
            infinite_colors: self.light_spectra.infinite,
            light_colors: self.light_spectra.lights,
            pad0: 0,
        }
    }
}

/// Maximum number of triangles and quadrics of a scene that is rendered without a hierarchy: see
/// docs/performance.md.
const MAX_FLAT: usize = 24;
/// Maximum number of bodies of revolution of such a scene: at most the number of bits of a mask.
const MAX_FLAT_REVOLUTIONS: usize = 16;

/// Packs a scene, for a solver of bodies of revolution or for all of a [`Packing`].
///
/// # Errors
/// The scene is too large, has too many primitives, takes too much memory, or its lights are outside of
/// fp32's range.
pub fn pack(scene: &Scene, packing: impl Into<Packing>) -> Result<PackedScene, PackError> {
    let Packing { solver, keeps_uvs, is_guided, has_dispersion } = packing.into();
    let mut placed = Placed::of(scene)?;
    let space = RenderSpace::of(&placed.bounds())?.unwrap_or_else(|| {
        // Only the sky is visible, and it looks the same from everywhere: render space may have any size.
        placed = Placed::default();
        let size = DVec3::splat(scene.integrator.radius.unwrap_or(1.0));
        RenderSpace::around(scene.camera.world_from_camera.translation, size)
    });
    let render_from_world = space.from_world();
    let mut packer = Packer { render_from_world, solver, keeps_uvs, is_guided, ..Packer::default() };
    packer.add_lights(scene, &space);
    packer.textures = PackedTextures::new(scene, &packer.render_from_world, has_dispersion);
    packer.dress(scene, &mut placed)?;
    packer.add_media(scene, &mut placed, space.scale);
    packer.gathers_rough = scene.has_unmet_light_on_rough_surfaces();
    if packer.gathers_rough {
        mark_facets(&mut packer.materials);
    }
    let bvh = packer.add_surfaces(&placed)?;
    let light_spectra = packer.pack_light_spectra();
    let contacts = packer.find_contacts(&placed, &bvh);
    let wide = packer.widen(&bvh)?;
    let mean_power: f64 = packer.powers.iter().sum();
    packer.check_brightness(mean_power)?;
    let (emission_table, direct_table) = packer.choose_lights();
    let features = packer.features(scene, &direct_table, contacts.exist());
    packer.order_triangles(wide.triangles);
    Ok(PackedScene {
        space,
        sky_count: packer.sky_count,
        camera_medium: packed_medium(scene.camera_medium),
        infinite: packer.infinite,
        light_spectra,
        mean_power,
        features: SceneFeatures { has_light_spectra: light_spectra.lights != NONE, ..features },
        material_features: specialize(&packer.materials),
        contacts,
        arrays: SceneArrays {
            bvh_planes: wide.planes,
            bvh_children: wide.children,
            triangles: packer.triangles,
            triangle_normals: packer.triangle_normals,
            triangle_uvs: packer.triangle_uvs,
            quadrics: packer.quadrics,
            revolutions: packer.revolutions,
            revolution_pieces: packer.revolution_pieces,
            instances: packer.instances,
            revolution_segments: packer.revolution_segments,
            newton_starts: packer.newton_starts,
            materials: packer.materials,
            texture_nodes: packer.textures.nodes,
            texture_texels: packer.textures.texels,
            media: packer.media,
            medium_interfaces: packer.medium_interfaces,
            lights: packer.lights,
            light_images: packer.light_images,
            light_texels: packer.light_texels,
            emission_table,
            direct_table,
        },
    })
}

/// The arrays during packing.
#[derive(Default)]
struct Packer {
    render_from_world: DAffine3,
    solver: RevolutionSolver,
    /// Whether images of lights have cumulative tables.
    is_guided: bool,
    /// Ranges of the arrays that each shape was packed to, in the order of the shapes.
    parts: Vec<Part>,
    /// Boxes of the primitives that are in no hierarchy yet: the last ones of `references`.
    boxes: Vec<CompactBox>,
    references: Vec<u32>,
    triangles: Vec<Triangle>,
    triangle_normals: Vec<TriangleNormals>,
    triangle_uvs: Vec<TriangleUvs>,
    textures: PackedTextures,
    materials: Vec<kernels::Material>,
    media: Vec<kernels::Medium>,
    /// Of each material; empty without media.
    medium_interfaces: Vec<kernels::MediumInterface>,
    quadrics: Vec<Quadric>,
    revolutions: Vec<Revolution>,
    revolution_pieces: Vec<RevolutionPiece>,
    revolution_segments: Vec<RevolutionSegment>,
    newton_starts: Vec<NewtonStart>,
    instances: Vec<Instance>,
    lights: Vec<kernels::Light>,
    /// Of each light.
    light_curves: Vec<Option<ByWavelength>>,
    sky_count: u32,
    light_images: Vec<kernels::LightImage>,
    light_texels: Vec<LightTexel>,
    /// Whether triangles keep their texture coordinates.
    keeps_uvs: bool,
    /// Whether the current shape is a light that no ray meets, as pbrt's are whose alpha is 0.
    is_invisible: bool,
    /// Whether photons are gathered on rough surfaces.
    gathers_rough: bool,
    /// Whether any shape so far is such a light.
    has_invisible: bool,
    /// Power of each light, mean of channels, W at render scale.
    powers: Vec<f64>,
    infinite: Rgb,
}

impl Packer {
    fn add_shape(&mut self, shape: &Shape) {
        self.is_invisible = shape.alpha == Input::Constant(0.0);
        self.has_invisible |= self.is_invisible;
        let render_from_object = self.render_from_world * shape.world_from_object;
        let lengths = |packer: &Self| [packer.triangles.len(), packer.quadrics.len(), packer.revolutions.len()];
        let before = lengths(self);
        match &shape.geometry {
            Geometry::Mesh(mesh) => self.add_mesh(shape, mesh, &render_from_object),
            Geometry::Sphere { radius, z_min, z_max, phi_max } => {
                let mut quadric =
                    quadric(shape, render_from_object * DAffine3::from_scale(DVec3::splat(*radius)), SPHERE);
                quadric.z_min = (z_min / radius) as f32;
                quadric.z_max = (z_max / radius) as f32;
                quadric.phi_max = *phi_max as f32;
                self.add_quadric(shape, quadric);
            }
            Geometry::Disk { height, radius, inner_radius, phi_max } => {
                let raise = DAffine3::from_translation(DVec3::new(0.0, 0.0, *height));
                let widen = DAffine3::from_scale(DVec3::splat(*radius));
                let mut quadric = quadric(shape, render_from_object * raise * widen, DISK);
                quadric.inner_radius = (inner_radius / radius) as f32;
                quadric.phi_max = *phi_max as f32;
                self.add_quadric(shape, quadric);
            }
            Geometry::Revolution(profile) => self.add_revolution(shape, profile, &render_from_object),
        }
        let [triangles, quadrics, revolutions] = std::array::from_fn(|kind| before[kind]..lengths(self)[kind]);
        self.parts.push(Part { triangles, quadrics, revolutions, is_invisible: self.is_invisible });
    }

    fn add_mesh(&mut self, shape: &Shape, mesh: &Mesh, render_from_object: &DAffine3) {
        let points: Vec<DVec3> = mesh.positions.iter().map(|p| render_from_object.transform_point3(*p)).collect();
        let normals = mesh_normals(shape, mesh);
        let mirrored = shape.world_from_object.matrix3.determinant() < 0.0;
        for corners in &mesh.triangles {
            let vertices = corners.map(|corner| corner as usize);
            let [a, b, c] = vertices;
            let normal = (points[b] - points[a]).cross(points[c] - points[a]);
            // As in pbrt, shading normals decide which side is outside, if the triangle has them.
            let shading = normals.as_ref().map(|normals| vertices.map(|vertex| normals[vertex])).filter(are_normals);
            let flip = match shading {
                Some([a, b, c]) => normal.dot(a + b + c) < 0.0,
                None => shape.reverse_orientation ^ mirrored,
            };
            let order = corner_order(vertices.map(|vertex| points[vertex]), flip);
            let [a, b, c] = order.map(|corner| vertices[corner]);
            let corners = [a, b, c].map(|corner| points[corner].as_vec3());
            let reference = TRIANGLE << KIND_SHIFT | self.triangles.len() as u32;
            let mut bounds = Aabb::empty();
            for corner in corners {
                bounds.extend(Vec3A::from(corner));
            }
            let light = match &shape.emission {
                Some(emission) => self.add_emitter(emission, reference, 0.5 * normal.length(), &bounds),
                None => NONE,
            };
            let attributes = match shading {
                Some(normals) => {
                    let [n0, n1, n2] = order.map(|corner| normals[corner].as_vec3().extend(0.0).to_array());
                    self.triangle_normals.push(TriangleNormals { n0, n1, n2 });
                    self.triangle_normals.len() as u32 - 1
                }
                None => NONE,
            };
            self.add_uvs(&mesh.uvs, vertices, order);
            let [p0, p1, p2] = corners.map(|corner| corner.to_array());
            let material = shape.material as u32;
            self.triangles.push(Triangle { p0, material, p1, light, p2, normals: attributes });
            self.add_primitive(reference, bounds);
        }
    }

    fn add_quadric(&mut self, shape: &Shape, mut quadric: Quadric) {
        let reference = quadric.kind << KIND_SHIFT | self.quadrics.len() as u32;
        let (area, bounds) = (quadric_area(&quadric), quadric_bounds(&quadric));
        if let Some(emission) = &shape.emission {
            quadric.light = self.add_emitter(emission, reference, area, &bounds);
        }
        self.add_primitive(reference, bounds);
        self.quadrics.push(quadric);
    }

    fn add_primitive(&mut self, reference: u32, bounds: Aabb) {
        self.references.extend((!self.is_invisible).then_some(reference));
        self.boxes.extend((!self.is_invisible).then(|| CompactBox::from(bounds)));
    }

    /// Builds the hierarchy over the primitives added since the last hierarchy, of which there must be at
    /// least one.
    fn build_hierarchy(&mut self, most_depth: usize) -> Result<Bvh, PackError> {
        if self.references.len() > kernels::MAX_PRIMITIVES as usize {
            return Err(PackError::TooManyPrimitives(self.references.len()));
        }
        let boxes = std::mem::take(&mut self.boxes);
        let first = self.references.len() - boxes.len();
        Ok(bvh::build(&boxes, &self.references[first..], most_depth))
    }

    fn features(&self, scene: &Scene, direct_table: &[AliasEntry], has_contacts: bool) -> SceneFeatures {
        let has_light = |kind| self.lights.iter().any(|light| light.kind == kind);
        let shines = |kind| self.lights.iter().any(|light| light.kind == AREA && light.primitive >> KIND_SHIFT == kind);
        let has_kind = |kind| self.references.iter().any(|reference| reference >> KIND_SHIFT == kind);
        let whole = |quadric: &Quadric| {
            quadric.z_min <= -1.0 && quadric.z_max >= 1.0 && quadric.phi_max >= std::f32::consts::TAU
        };
        // An empty scene has no hierarchy.
        let is_empty = self.references.is_empty();
        let is_flat = is_empty
            || self.triangles.len() + self.quadrics.len() <= MAX_FLAT
                && self.revolutions.len() <= MAX_FLAT_REVOLUTIONS
                && self.instances.is_empty()
                && self.solver == RevolutionSolver::Certified
                // Kernels without a hierarchy test every primitive, even those that no ray may meet.
                && !self.has_invisible;
        let has_alpha = self.materials.iter().any(|material| material.alpha_texture != NONE);
        let flat = |count: usize| if is_flat && !is_empty { count as u32 } else { 0 };
        SceneFeatures {
            has_contacts,
            has_triangles: has_kind(TRIANGLE),
            has_spheres: has_kind(SPHERE),
            has_disks: has_kind(DISK),
            has_quadrics: !self.quadrics.is_empty(),
            // Bodies that no ray meets count, too: light comes from them.
            has_revolutions: !self.revolutions.is_empty(),
            has_curved: !self.quadrics.is_empty() || !self.revolutions.is_empty(),
            revolution_pairs: revolution::degree(scene) / 2 + 1,
            revolution_newton: self.solver != RevolutionSolver::Certified,
            has_cut_spheres: self.quadrics.iter().any(|quadric| !whole(quadric)),
            has_instances: !self.instances.is_empty(),
            has_shading_normals: !self.triangle_normals.is_empty() || has_bumps(&self.materials),
            has_spot_lights: has_light(SPOT),
            has_distant_lights: has_light(DISTANT),
            has_infinite_lights: has_light(INFINITE) || self.sky_count > 0,
            has_skies: self.sky_count > 0,
            has_light_spectra: false, // until they are packed
            has_portals: has_light(PORTAL),
            has_goniometric_lights: has_light(GONIOMETRIC),
            has_projection_lights: has_light(PROJECTION),
            has_area_lights: has_light(AREA),
            has_locatable_lights: !direct_table.is_empty(),
            has_hittable_lights: has_light(AREA) || has_light(INFINITE) || self.sky_count > 0,
            has_triangle_lights: shines(TRIANGLE),
            has_sphere_lights: shines(SPHERE),
            has_disk_lights: shines(DISK),
            has_revolution_lights: shines(REVOLUTION),
            is_flat,
            flat_triangles: flat(self.triangles.len()),
            flat_quadrics: flat(self.quadrics.len()),
            flat_revolutions: flat(self.revolutions.len()),
            has_textures: !self.textures.nodes.is_empty(),
            has_image_textures: self.textures.has(TEXTURE_IMAGE),
            has_texture_trees: self.textures.has_trees(),
            has_noise: self.textures.has_noise(),
            has_dots: self.textures.has(TEXTURE_DOTS),
            has_alpha,
            has_media: !self.media.is_empty(),
            has_interfaces: self.has_interfaces(),
            has_passable: has_alpha || self.has_interfaces(),
            has_rough_gather: self.gathers_rough,
            has_image_emitters: self.lights.iter().any(|light| light.image != NONE),
        }
    }
}

/// Returns the order of a triangle's corners, reversed if `flip`. The first corner is the one opposite to
/// the longest edge, from which rays are intersected most accurately (`intersect_triangle`).
fn corner_order(corners: [DVec3; 3], flip: bool) -> [usize; 3] {
    let mut order = if flip { [0, 2, 1] } else { [0, 1, 2] };
    let opposite = |i: usize| corners[order[(i + 1) % 3]].distance_squared(corners[order[(i + 2) % 3]]);
    let first = (1..3).fold(0, |first, i| if opposite(i) > opposite(first) { i } else { first });
    order.rotate_left(first);
    order
}

/// Returns true if a triangle has shading normals that pbrt would not replace by the geometric normal.
fn are_normals(normals: &[DVec3; 3]) -> bool {
    normals.iter().all(|normal| normal.is_finite()) && normals.iter().any(|normal| *normal != DVec3::ZERO)
}

/// Returns a mesh's unit normals in world space, or `None` if it has none. A normal that is not finite
/// becomes NaN.
fn mesh_normals(shape: &Shape, mesh: &Mesh) -> Option<Vec<DVec3>> {
    let cofactors = shape.world_from_object.matrix3.inverse().transpose();
    let sign = if shape.reverse_orientation { -1.0 } else { 1.0 };
    let transform = |normal: &DVec3| {
        // `normalize_or_zero` maps vectors that are not finite to 0.
        if normal.is_finite() { sign * (cofactors * *normal).normalize_or_zero() } else { DVec3::NAN }
    };
    (!mesh.normals.is_empty()).then(|| mesh.normals.iter().map(transform).collect())
}

/// Returns the rows of an affine transform as f32.
pub fn rows(transform: &DAffine3) -> [[f32; 4]; 3] {
    let linear = transform.matrix3.transpose();
    let row = |axis: DVec3, offset: f64| axis.extend(offset).as_vec4().to_array();
    [
        row(linear.x_axis, transform.translation.x),
        row(linear.y_axis, transform.translation.y),
        row(linear.z_axis, transform.translation.z),
    ]
}

fn mean(rgb: Rgb) -> f64 {
    rgb.element_sum() / 3.0
}
