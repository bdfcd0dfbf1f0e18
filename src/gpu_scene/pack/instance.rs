//! Objects and their instances.
//!
//! An object has a hierarchy in a space of its own, which is constructed like render space, and each of its
//! instances is one primitive of the scene. If that saves little memory, the object's shapes are copied
//! instead: kernels without instances are faster.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

use glam::{DAffine3, DVec3, Vec3A};
use obvhs::aabb::Aabb;

use super::space::Bounds;
use super::{PackError, Packer, RenderSpace, rows};
use crate::gpu_scene::bvh::{Bvh, OBJECT_DEPTH};
use crate::gpu_scene::collapse::Collapse;
use crate::gpu_scene::wide::Wide;
use crate::kernels::{INSTANCE, Instance, KIND_SHIFT, MAX_BVH_DEPTH, TRIANGLE};
use crate::scene::{Geometry, Scene, Shape};

/// Maximum number of primitives of all copies of an object that is copied. An object with one instance is
/// always copied.
const MAX_COPIED: usize = 4096;
/// Number of levels below the root of an object's hierarchy at which the boxes are that bound an instance.
const COVER_LEVELS: u32 = 5;
/// Half a unit in the last place of 1, for f32.
const ROUNDING: f64 = 0.5 * f32::EPSILON as f64;

/// The surfaces of a scene, and their transforms.
#[derive(Default)]
pub(super) struct Placed<'a> {
    /// Shapes in the world itself, copies included.
    shapes: Vec<Cow<'a, Shape>>,
    objects: Vec<Object<'a>>,
}

/// An object that is not copied.
struct Object<'a> {
    shapes: Vec<Cow<'a, Shape>>,
    world_from_instance: Vec<DAffine3>,
    bounds: Bounds,
    space: RenderSpace,
}

impl<'a> Placed<'a> {
    /// Returns the placed shapes of a scene, after the decision which objects to copy.
    pub fn of(scene: &'a Scene) -> Result<Self, PackError> {
        let mut placed = Self { shapes: Vec::new(), objects: Vec::new() };
        let mut places = BTreeMap::<usize, Vec<DAffine3>>::new();
        for instance in &scene.instances {
            places.entry(instance.object).or_default().push(instance.world_from_instance);
        }
        let mut parts = BTreeMap::<usize, Vec<&Shape>>::new();
        for shape in &scene.shapes {
            match shape.object {
                Some(object) => parts.entry(object).or_default().push(shape),
                None => placed.shapes.push(Cow::Borrowed(shape)),
            }
        }
        for (object, world_from_instance) in places {
            placed.place(parts.remove(&object).unwrap_or_default(), world_from_instance)?;
        }
        Ok(placed)
    }

    fn place(&mut self, shapes: Vec<&'a Shape>, world_from_instance: Vec<DAffine3>) -> Result<(), PackError> {
        let primitives: usize = shapes.iter().map(|shape| primitives(shape)).sum();
        let copies = world_from_instance.len();
        if copies == 1 || copies.saturating_mul(primitives) <= MAX_COPIED {
            for transform in &world_from_instance {
                self.shapes.extend(shapes.iter().map(|shape| Cow::Owned(copy(shape, transform))));
            }
            return Ok(());
        }
        let mut bounds = Bounds::default();
        shapes.iter().for_each(|shape| bounds.add_shape(shape));
        // An object without an extent is invisible.
        let Some(space) = RenderSpace::of(&bounds)? else { return Ok(()) };
        let shapes = shapes.into_iter().map(Cow::Borrowed).collect();
        self.objects.push(Object { shapes, world_from_instance, bounds, space });
        Ok(())
    }

    /// Returns all shapes; shapes of objects once, not per instance.
    pub fn shapes_mut(&mut self) -> impl Iterator<Item = &mut Cow<'a, Shape>> {
        self.shapes.iter_mut().chain(self.objects.iter_mut().flat_map(|object| &mut object.shapes))
    }

    /// Returns all shapes in the order in which they are packed: shapes of objects first.
    pub fn shapes_as_packed(&self) -> impl Iterator<Item = &Shape> {
        let of_objects = self.objects.iter().flat_map(|object| &object.shapes);
        of_objects.chain(&self.shapes).map(|shape| &**shape)
    }

    /// Returns the number of shapes of objects, and for each instance the range of its object's shapes in
    /// the order of packing.
    pub fn parts_of_objects(&self) -> (usize, Vec<Range<usize>>) {
        let (mut first, mut parts) = (0, Vec::new());
        for object in &self.objects {
            let own = first..first + object.shapes.len();
            first = own.end;
            parts.extend(object.world_from_instance.iter().map(|_| own.clone()));
        }
        (first, parts)
    }

    /// Returns the bounds of all surfaces in world space.
    pub fn bounds(&self) -> Bounds {
        let mut bounds = Bounds::default();
        self.shapes.iter().for_each(|shape| bounds.add_shape(shape));
        for object in &self.objects {
            object.world_from_instance.iter().for_each(|place| bounds.add_bounds(place, &object.bounds));
        }
        bounds
    }
}

fn primitives(shape: &Shape) -> usize {
    match &shape.geometry {
        Geometry::Mesh(mesh) => mesh.triangles.len(),
        _ => 1,
    }
}

/// Returns a copy of an object's shape as a shape of the world.
fn copy(shape: &Shape, world_from_instance: &DAffine3) -> Shape {
    // As in pbrt, a mirroring transform of a quadric or a body reverses its normal; a mirroring transform
    // of an instance does not.
    let is_mesh = matches!(shape.geometry, Geometry::Mesh(_));
    let turns = !is_mesh && world_from_instance.matrix3.determinant() < 0.0;
    Shape {
        world_from_object: *world_from_instance * shape.world_from_object,
        reverse_orientation: shape.reverse_orientation ^ turns,
        object: None,
        ..shape.clone()
    }
}

impl Packer {
    /// Adds all surfaces, and returns their hierarchies as one array, the scene's hierarchy first.
    pub(super) fn add_surfaces(&mut self, placed: &Placed) -> Result<Bvh, PackError> {
        let mut hierarchies = Vec::new();
        let mut places = Vec::new();
        for object in &placed.objects {
            let hierarchy = self.add_object(object)?;
            let cover = hierarchy.cover(COVER_LEVELS);
            for world_from_instance in &object.world_from_instance {
                let (instance, bounds) = self.instance(object, world_from_instance, &cover);
                self.instances.push(instance);
                places.push((hierarchies.len(), bounds));
            }
            hierarchies.push(hierarchy);
        }
        for shape in &placed.shapes {
            self.add_shape(shape);
        }
        for (index, (_, bounds)) in places.iter().enumerate() {
            self.add_primitive(INSTANCE << KIND_SHIFT | index as u32, *bounds);
        }
        if self.boxes.is_empty() {
            return Ok(Bvh { pairs: Vec::new(), primitives: Vec::new(), depth: 0 });
        }
        // The stack of a ray in an object lies above its stack in the scene, so the depths add up.
        let deepest = hierarchies.iter().map(|hierarchy| hierarchy.depth).max().unwrap_or(0);
        let mut all = self.build_hierarchy(MAX_BVH_DEPTH as usize - deepest)?;
        let roots: Vec<u32> = hierarchies.into_iter().map(|hierarchy| all.append(hierarchy)).collect();
        for (instance, (hierarchy, _)) in self.instances.iter_mut().zip(places) {
            instance.root = roots[hierarchy];
        }
        Ok(all)
    }

    /// Turns the hierarchies into those of the device, the scene's first, and the roots of instances with
    /// them.
    pub(super) fn widen(&mut self, bvh: &Bvh) -> Result<Wide, PackError> {
        let mut wide = Wide::default();
        let collapse = Collapse::of(bvh, |primitive| primitive >> KIND_SHIFT == TRIANGLE);
        if !bvh.pairs.is_empty() {
            wide.append(&collapse, 0);
        }
        let mut roots = BTreeMap::new();
        for instance in &mut self.instances {
            let root = instance.root;
            instance.root = *roots.entry(root).or_insert_with(|| wide.append(&collapse, root));
        }
        if wide.fits() { Ok(wide) } else { Err(PackError::TooManyPrimitives(self.references.len())) }
    }

    /// Adds an object's shapes in its own space, and returns their hierarchy.
    fn add_object(&mut self, object: &Object) -> Result<Bvh, PackError> {
        let render_from_world = std::mem::replace(&mut self.render_from_world, object.space.from_world());
        for shape in &object.shapes {
            self.add_shape(shape);
        }
        self.render_from_world = render_from_world;
        self.build_hierarchy(OBJECT_DEPTH)
    }

    /// Returns an instance and its box, which contains the boxes `cover` of the object.
    fn instance(&self, object: &Object, world_from_instance: &DAffine3, cover: &[Aabb]) -> (Instance, Aabb) {
        let render_from_object = self.render_from_world * *world_from_instance * object.space.from_world().inverse();
        let object_from_render = render_from_object.inverse();
        let half = object.bounds.half_extent() * object.space.scale;
        let error = transform_error(&render_from_object, &object_from_render, half);
        let mut bounds = Aabb::empty();
        for part in cover {
            let [lower, upper] = [part.min, part.max].map(|corner| corner.as_dvec3());
            let center = render_from_object.transform_point3(0.5 * (lower + upper));
            let reach = times_sizes(&render_from_object, 0.5 * (upper - lower)) + 2.0 * error;
            bounds = bounds
                .union(&Aabb::new(Vec3A::from((center - reach).as_vec3()), Vec3A::from((center + reach).as_vec3())));
        }
        let instance = Instance {
            object_from_render: rows(&object_from_render),
            render_from_object: rows(&render_from_object),
            root: 0,
            error: error as f32,
            growth: times_sizes(&render_from_object, DVec3::ONE).max_element() as f32,
            pad: 0,
        };
        (instance, bounds)
    }
}

/// Returns a bound of the error, in render units, that transforms cause in a hit point on an object. The
/// object's box about the origin of its space has the half extent `half`.
fn transform_error(render_from_object: &DAffine3, object_from_render: &DAffine3, half: DVec3) -> f64 {
    let place = render_from_object.translation.abs();
    let extent = times_sizes(render_from_object, half);
    // A point takes seven roundings, of which at most four follow each other, and one of the matrix. A
    // direction, of a length across the box, takes one less.
    let origin = times_sizes(object_from_render, place + extent) + object_from_render.translation.abs();
    let way = times_sizes(object_from_render, 2.0 * extent);
    let inward = times_sizes(render_from_object, 5.0 * origin + 4.0 * way);
    // Roundings of the transform back, and of the offset that is added.
    let outward = 5.0 * (extent + place) + 2.0 * (extent + place);
    ROUNDING * (inward + outward).max_element()
}

/// Returns the product of a vector and the absolute values of a transform's linear part.
fn times_sizes(transform: &DAffine3, v: DVec3) -> DVec3 {
    let linear = transform.matrix3;
    linear.x_axis.abs() * v.x + linear.y_axis.abs() * v.y + linear.z_axis.abs() * v.z
}

#[cfg(test)]
mod tests {
    use crate::gpu_scene::pack::{PackedScene, RevolutionSolver, pack};
    use crate::scene::Scene;

    fn packed(world: &str) -> PackedScene {
        let text = format!("WorldBegin\nLightSource \"infinite\"\n{world}");
        pack(&Scene::parse(&text, "t.pbrt", "").unwrap(), RevolutionSolver::default()).unwrap()
    }

    const SHAPES: &str =
        "Shape \"sphere\" Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 3 0] ReverseOrientation\n";
    const PLACES: [&str; 3] = ["Translate 1 2 3", "Scale 1 -2 1", "Rotate 20 1 0 3 Scale -1 1 4 "];

    fn instances(shapes: &str, places: &[&str]) -> String {
        let mut text = format!("ObjectBegin \"o\"\n{shapes}\nObjectEnd\n");
        for place in places {
            text += &format!("AttributeBegin\n{place}\nObjectInstance \"o\"\nAttributeEnd\n");
        }
        text
    }

    #[test]
    fn few_small_instances_are_copies() {
        let a = packed(&instances(SHAPES, &PLACES));
        let copies: String =
            PLACES.iter().map(|place| format!("AttributeBegin\n{place}\n{SHAPES}AttributeEnd\n")).collect();
        let b = packed(&copies);
        assert_eq!((a.arrays.instances.len(), a.arrays.triangles.len(), a.arrays.quadrics.len()), (0, 3, 3));
        assert_eq!(
            bytemuck::cast_slice::<_, u8>(&a.arrays.triangles),
            bytemuck::cast_slice::<_, u8>(&b.arrays.triangles)
        );
        // A mirroring transform of the instance keeps a sphere's normal; one of the sphere itself reverses
        // it.
        let flipped = |packed: &PackedScene| packed.arrays.quadrics.iter().map(|q| q.flipped).collect::<Vec<_>>();
        assert_eq!((flipped(&a), flipped(&b)), (vec![0, 0, 0], vec![0, 1, 1]));
        assert!(a.features.is_flat && !a.features.has_instances);
    }

    #[test]
    fn many_instances_share_what_they_are_of() {
        let a = packed(&(instances(SHAPES, &PLACES.repeat(1000)) + "Shape \"disk\""));
        assert_eq!((a.arrays.instances.len(), a.arrays.triangles.len(), a.arrays.quadrics.len()), (3000, 1, 2));
        assert!(a.features.has_instances && !a.features.is_flat);
        let object = a.arrays.instances[0].root as usize;
        assert_eq!(a.arrays.bvh_children.len(), object + 1, "the object's node comes last");
        assert!(a.arrays.instances.iter().all(|instance| instance.root as usize == object));
    }

    #[test]
    fn what_stands_nowhere_is_not_packed() {
        let a = packed("ObjectBegin \"o\"\nShape \"sphere\" \"float radius\" 9\nObjectEnd\nShape \"disk\"");
        assert_eq!((a.arrays.quadrics.len(), a.space.scale), (1, 0.5));
    }
}
