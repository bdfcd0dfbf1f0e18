//! Search for primitives of different bodies that coincide.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use glam::{DAffine3, DVec3, Vec3A};
use obvhs::aabb::Aabb;

use super::super::instance::Placed;
use super::super::space::Bounds;
use super::body::{connected, is_closed};
use super::near::{Form, contact};
use super::{Body, Packer, Part, Role, layer};
use crate::gpu_scene::bvh::Bvh;
use crate::kernels::{DISK, INDEX_MASK, INSTANCE, KIND_SHIFT, REVOLUTION, TRIANGLE};
use crate::scene::{Geometry, Shape};

/// Half a unit in the last place of 1, for f32.
const ROUNDING: f64 = 0.5 * f32::EPSILON as f64;
/// Number of errors by which a surface is widened to either side. `position_error` bounds the error along
/// one axis; a ray leaves along the normal, where up to root 3 errors add up, and the other surface has its
/// own error.
const ERRORS: f64 = 3.0;
/// Maximum number of primitives of dielectric instances that are compared with those of other instances.
const MOST_INSTANCED: usize = 1_000_000;
/// Maximum number of primitives of a shape for comparisons of sheets with other sheets, and of a dielectric
/// mesh with itself.
const MOST_PRIMITIVES: usize = 100_000;
/// Maximum number of comparisons of primitives, besides [`COMPARISONS_EACH`] per primitive. Scenes of
/// bodies that stand on others need fewer, but a scene may have any number of bodies in one place.
const MOST_COMPARISONS: usize = 1 << 21;
/// Additional comparisons per primitive.
const COMPARISONS_EACH: usize = 4;
/// Number of contacts from which on a body is not compared with other such bodies. There are fewer layers
/// than that.
const MOST_PARTNERS: u32 = 64;
/// Maximum number of parts whose boxes are all compared with each other.
const MOST_PARTS: usize = 4096;
/// Maximum number of boxes of other shapes that a primitive is compared with before a query of the
/// hierarchy.
const MOST_BOXES: usize = 64;

/// A part with values that are needed repeatedly.
struct Known<'a> {
    part: &'a Part,
    shape: &'a Shape,
    role: Role,
    /// For each triangle of a dielectric mesh, the number of its body.
    bodies: Vec<u32>,
    /// Whether the shape is closed; computed on demand.
    is_closed: OnceCell<bool>,
}

pub(super) struct Finder<'a> {
    packer: &'a Packer,
    bvh: &'a Bvh,
    parts: Vec<Known<'a>>,
    /// Number of parts that belong to objects; they are the first ones.
    of_objects: usize,
    /// First triangle, quadric and revolution of each part, to find the part of a reference.
    starts: [Vec<usize>; 3],
    /// Bodies that are in contact with each other.
    pub pairs: BTreeSet<(Body, Body)>,
    /// Number of pairs that each body is in.
    partners: BTreeMap<Body, u32>,
    /// Primitives in contact, by kind (DISK for all quadrics) and index, with their bodies.
    pub members: BTreeMap<u32, Body>,
    /// Bounds of all contacts.
    pub region: Bounds,
    /// Largest error of a position in contact.
    pub error: f64,
    /// Number of pairs of primitives of one dielectric body that are too near to each other.
    pub too_thin: u32,
    /// Number of comparisons left.
    left: usize,
}

/// A primitive in the world, or in an instance.
#[derive(Clone, Copy)]
struct Standing {
    reference: u32,
    instance: Option<usize>,
}

impl Known<'_> {
    fn is_closed(&self) -> bool {
        *self.is_closed.get_or_init(|| is_closed(self.shape))
    }
}

impl<'a> Finder<'a> {
    pub fn new(packer: &'a Packer, placed: &'a Placed, bvh: &'a Bvh) -> Self {
        let known = |(part, shape): (&'a Part, &'a Shape)| {
            let role = packer.role(shape);
            let bodies = match &shape.geometry {
                Geometry::Mesh(mesh) if role == Role::Boundary => connected(mesh),
                _ => Vec::new(),
            };
            Known { part, shape, role, bodies, is_closed: OnceCell::new() }
        };
        let parts: Vec<Known> = packer.parts.iter().zip(placed.shapes_as_packed()).map(known).collect();
        let starts = |range: fn(&Part) -> &Range<usize>| parts.iter().map(|known| range(known.part).start).collect();
        Self {
            starts: [starts(|part| &part.triangles), starts(|part| &part.quadrics), starts(|part| &part.revolutions)],
            packer,
            bvh,
            parts,
            of_objects: placed.parts_of_objects().0,
            pairs: BTreeSet::new(),
            partners: BTreeMap::new(),
            members: BTreeMap::new(),
            region: Bounds::default(),
            error: 0.0,
            too_thin: 0,
            left: MOST_COMPARISONS + COMPARISONS_EACH * packer.parts.iter().map(Part::len).sum::<usize>(),
        }
    }

    /// Returns true if the number of comparisons reached its maximum.
    pub fn gave_up(&self) -> bool {
        self.left == 0
    }

    /// Returns the role of a body's surface.
    pub fn role_of(&self, body: Body) -> Role {
        self.parts[body.0].role
    }

    /// Compares the primitives of each part with those of the parts that have more.
    pub fn search(&mut self, placed: &Placed) {
        let boxes: Vec<Bounds> = self.parts.iter().map(|known| self.bounds_of(known.part)).collect();
        let (first, objects) = placed.parts_of_objects();
        for index in first..self.parts.len() {
            self.search_part(index, None, &boxes, first);
        }
        let mut left = MOST_INSTANCED;
        for (instance, parts) in objects.into_iter().enumerate() {
            for index in parts.filter(|index| self.parts[*index].role == Role::Boundary).collect::<Vec<_>>() {
                let count = self.parts[index].part.len();
                if count > left {
                    return;
                }
                left -= count;
                self.search_part(index, Some(instance), &boxes, first);
            }
        }
    }

    fn search_part(&mut self, index: usize, instance: Option<usize>, boxes: &[Bounds], first: usize) {
        let part = self.parts[index].part;
        if part.is_invisible {
            return;
        }
        let has_instances = !self.packer.instances.is_empty();
        let compares_itself = self.may_matter(index, index);
        // Boxes of the other parts in the world: a primitive that touches none of them has no contact.
        let mut near = None;
        if !has_instances && !compares_itself && self.parts.len() <= MOST_PARTS {
            let others = (first..self.parts.len())
                .filter(|other| self.is_compared(index, *other) && boxes[index].common(&boxes[*other]).is_some());
            let others: Vec<Bounds> = others.map(|other| boxes[other]).take(MOST_BOXES + 1).collect();
            if others.is_empty() {
                return;
            }
            near = (others.len() <= MOST_BOXES).then_some(others);
        }
        for reference in part.references() {
            self.search_primitive(index, Standing { reference, instance }, near.as_deref());
        }
    }

    /// Returns true if primitives of `part` are compared with those of `other`: each pair is examined from
    /// the part with fewer primitives, or from the part that is in the world itself.
    fn is_compared(&self, part: usize, other: usize) -> bool {
        let size = |index: usize| (self.parts[index].part.len(), index);
        let is_chosen = match [part, other].map(|index| index < self.of_objects) {
            [false, false] => size(part) <= size(other),
            [false, true] => true,
            [true, false] => false,
            [true, true] => self.parts[other].role != Role::Boundary || size(part) <= size(other),
        };
        is_chosen && self.may_matter(part, other)
    }

    /// Returns true if the order of two parts in contact is visible.
    fn may_matter(&self, a: usize, b: usize) -> bool {
        let [known_a, known_b] = [&self.parts[a], &self.parts[b]];
        if known_b.part.is_invisible {
            return false;
        }
        if a == b {
            return known_a.role == Role::Boundary && (2..=MOST_PRIMITIVES).contains(&known_a.part.len());
        }
        let are_sheets = [known_a, known_b].iter().all(|known| matches!(known.role, Role::Passing | Role::Opaque));
        if are_sheets && known_a.part.len().min(known_b.part.len()) > MOST_PRIMITIVES {
            return false;
        }
        let is_plain = known_a.role == Role::Opaque && known_b.role == Role::Opaque;
        !is_plain || known_a.shape.material != known_b.shape.material
    }

    fn search_primitive(&mut self, index: usize, one: Standing, near: Option<&[Bounds]>) {
        if self.gave_up() {
            return;
        }
        let Some(form) = self.form(one) else { return };
        let reach = ERRORS * self.error(one);
        // The other primitive may have the larger error: that of coordinates up to 1.
        let bounds = form.bounds().widened(reach.max(ERRORS * 32.0 * ROUNDING));
        if near.is_some_and(|near| near.iter().all(|other| other.common(&bounds).is_none())) {
            return;
        }
        let mut candidates = Vec::new();
        let world = Aabb::new(Vec3A::from(bounds.lower().as_vec3()), Vec3A::from(bounds.upper().as_vec3()));
        self.bvh.visit(0, &world, &mut |reference| {
            if reference >> KIND_SHIFT != INSTANCE {
                candidates.push(Standing { reference: by_kind(reference), instance: None });
                return;
            }
            let instance = (reference & INDEX_MASK) as usize;
            let placed = &self.packer.instances[instance];
            let mut local = Bounds::default();
            local.add_bounds(&affine(&placed.object_from_render), &bounds);
            let local = Aabb::new(Vec3A::from(local.lower().as_vec3()), Vec3A::from(local.upper().as_vec3()));
            self.bvh.visit(placed.root, &local, &mut |reference| {
                candidates.push(Standing { reference: by_kind(reference), instance: Some(instance) });
            });
        });
        let count = candidates.len().min(self.left);
        self.left -= count;
        for other in candidates.into_iter().take(count) {
            self.compare(index, one, &form, other);
        }
    }

    fn compare(&mut self, index: usize, one: Standing, form: &Form, other: Standing) {
        let other_index = self.part_of(other.reference);
        let is_self = one.reference == other.reference && one.instance == other.instance;
        let is_asked = self.is_compared(index, other_index) || (index == other_index && one.instance != other.instance);
        if is_self || !is_asked {
            return;
        }
        let bodies = [self.body(index, one.reference), self.body(other_index, other.reference)];
        let is_one_body = bodies[0] == bodies[1] && one.instance == other.instance;
        // Two instances of one body have the same marks and cannot be distinguished.
        if bodies[0] == bodies[1] && !is_one_body {
            return;
        }
        // Neither body would find a layer of its own.
        if bodies.iter().all(|body| self.partners.get(body).is_some_and(|count| *count >= MOST_PARTNERS)) {
            return;
        }
        let Some(other_form) = self.form(other) else { return };
        let error = self.error(one).max(self.error(other));
        if is_one_body {
            let is_asked = one.reference < other.reference && turn_backs(form, &other_form);
            self.too_thin += u32::from(is_asked && contact(form, &other_form, error).is_some());
            return;
        }
        let Some(region) = contact(form, &other_form, ERRORS * error) else { return };
        let are_sheets = [index, other_index].map(|index| self.parts[index].role == Role::Opaque);
        // The surfaces between a closed body and the sheet below it are invisible.
        if are_sheets == [true; 2] && [index, other_index].iter().any(|index| self.parts[*index].is_closed()) {
            return;
        }
        let [first, second] = bodies;
        if self.pairs.insert((first.min(second), first.max(second))) {
            bodies.iter().for_each(|body| *self.partners.entry(*body).or_insert(0) += 1);
        }
        self.members.insert(one.reference, first);
        self.members.insert(other.reference, second);
        self.region.unite(&region);
        self.error = self.error.max(error);
    }

    fn bounds_of(&self, part: &Part) -> Bounds {
        let mut bounds = Bounds::default();
        for reference in part.references() {
            if let Some(form) = self.form(Standing { reference, instance: None }) {
                bounds.unite(&form.bounds());
            }
        }
        bounds.widened(2.0 * ERRORS * 32.0 * ROUNDING)
    }

    fn part_of(&self, reference: u32) -> usize {
        let index = (reference & INDEX_MASK) as usize;
        let starts = match reference >> KIND_SHIFT {
            TRIANGLE => &self.starts[0],
            DISK => &self.starts[1],
            _ => &self.starts[2],
        };
        // The primitive belongs to the last part that starts there; the parts before that have none of this
        // kind.
        starts.partition_point(|start| *start <= index) - 1
    }

    fn body(&self, part: usize, reference: u32) -> Body {
        let known = &self.parts[part];
        let first = known.part.triangles.start;
        let triangle = ((reference & INDEX_MASK) as usize).wrapping_sub(first);
        (part, known.bodies.get(triangle).copied().unwrap_or(0))
    }

    fn form(&self, standing: Standing) -> Option<Form<'a>> {
        let index = (standing.reference & INDEX_MASK) as usize;
        let place = standing.instance.map(|instance| affine(&self.packer.instances[instance].render_from_object));
        let place = place.unwrap_or(DAffine3::IDENTITY);
        match standing.reference >> KIND_SHIFT {
            TRIANGLE => {
                let triangle = &self.packer.triangles[index];
                let corner = |p: [f32; 3]| place.transform_point3(DVec3::from(p.map(f64::from)));
                Form::triangle([triangle.p0, triangle.p1, triangle.p2].map(corner))
            }
            DISK => {
                let quadric = &self.packer.quadrics[index];
                let transform = place * affine(&quadric.render_from_object);
                if quadric.kind == DISK { Form::disk(&transform) } else { Some(Form::Ellipsoid(transform)) }
            }
            _ => {
                let body = &self.packer.revolutions[index];
                let first = body.first_piece as usize;
                let pieces = &self.packer.revolution_pieces[first..first + body.piece_count as usize];
                Some(Form::Turned { render_from_unit: place * affine(&body.render_from_unit), pieces })
            }
        }
    }

    /// Returns the error of a position on a primitive, by the bound in
    /// shaders/include/geometry/surface.glsl.
    fn error(&self, standing: Standing) -> f64 {
        let index = (standing.reference & INDEX_MASK) as usize;
        let largest = |point: DVec3| point.abs().max_element();
        let of_transform = |rows: &[[f32; 4]; 3]| {
            let transform = affine(rows);
            let linear = transform.matrix3.transpose();
            let size = linear.x_axis.length().max(linear.y_axis.length()).max(linear.z_axis.length());
            largest(transform.translation) + 2.0 * size
        };
        let size = match standing.reference >> KIND_SHIFT {
            TRIANGLE => {
                let triangle = &self.packer.triangles[index];
                let corners = [triangle.p0, triangle.p1, triangle.p2];
                corners.into_iter().flatten().fold(0.0_f64, |most, x| most.max(f64::from(x).abs()))
            }
            DISK => of_transform(&self.packer.quadrics[index].render_from_object),
            _ => of_transform(&self.packer.revolutions[index].render_from_unit),
        };
        let error = 16.0 * ROUNDING * size;
        standing.instance.map_or(error, |instance| {
            let instance = &self.packer.instances[instance];
            f64::from(instance.growth) * error + f64::from(instance.error)
        })
    }

    /// Returns the bodies in contact with their ranks.
    pub fn bodies(&self) -> BTreeMap<Body, layer::Rank> {
        let mut ranks = BTreeMap::new();
        let mut rank_of = |part: usize| ranks.entry(part).or_insert_with(|| self.rank(&self.parts[part])).clone();
        self.partners.keys().map(|body| (*body, rank_of(body.0))).collect()
    }

    fn rank(&self, known: &Known) -> layer::Rank {
        let forms = known.part.references().filter_map(|reference| self.form(Standing { reference, instance: None }));
        let area = forms.map(|form| form.bounds().half_extent().length_squared()).sum();
        let material = bytemuck::bytes_of(&self.packer.materials[known.shape.material]).to_vec();
        layer::Rank { role: known.role, area, material }
    }
}

/// Returns a reference with the kind DISK for both kinds of quadrics.
fn by_kind(reference: u32) -> u32 {
    match reference >> KIND_SHIFT {
        TRIANGLE | REVOLUTION => reference,
        _ => DISK << KIND_SHIFT | reference & INDEX_MASK,
    }
}

/// Returns the transform with these rows.
fn affine(rows: &[[f32; 4]; 3]) -> DAffine3 {
    let column = |i: usize| DVec3::from(rows.map(|row| f64::from(row[i])));
    DAffine3 { matrix3: glam::DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

/// Returns true if two flat surfaces face in opposite directions.
fn turn_backs(a: &Form, b: &Form) -> bool {
    match (a, b) {
        (Form::Flat { normal, .. }, Form::Flat { normal: other, .. }) => normal.dot(*other) < 0.0,
        _ => false,
    }
}
