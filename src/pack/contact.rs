//! Which surfaces of different bodies are in contact: they coincide within the error of positions,
//! as the underside of a glass and the table that it stands on. `shaders/include/contact.glsl`
//! has rays meet them in an order that no rounding decides; this gives each of them its layer.
//!
//! Only contacts whose order can be seen count: of dielectrics, lamps, and surfaces that let light
//! pass with anything, and of open sheets with other sheets, such as a decal on a wall.

mod body;
mod layer;
mod near;

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use glam::{DAffine3, DVec3, Vec3A};
use obvhs::aabb::Aabb;

use super::instance::Placed;
use super::space::Bounds;
use super::{Packer, RevolutionSolver};
use crate::bvh::Bvh;
use crate::kernels::{
    DIELECTRIC, DIFFUSE_TRANSMISSION, DISK, INDEX_MASK, INSTANCE, KIND_SHIFT, MATERIAL_MASK, MIX, NONE, REVOLUTION,
    THIN_DIELECTRIC, TRIANGLE,
};
use crate::scene::{Geometry, Shape};
use body::{connected, is_closed};
use near::{Form, contact};

/// Half a unit in the last place of 1, for f32.
const ROUNDING: f64 = 0.5 * f32::EPSILON as f64;
/// A surface reaches this many errors of a position to either side: position_error bounds an
/// axis, a ray leaves along the normal, where up to root 3 of them add up, and the other surface
/// has its own.
const ERRORS: f64 = 3.0;
/// Primitives of dielectric instances that are compared with those of other instances, at most.
const MOST_INSTANCED: usize = 1_000_000;
/// Primitives of a shape up to which sheets are compared with other sheets, and a dielectric mesh
/// with itself.
const MOST_PRIMITIVES: usize = 100_000;
/// Boxes of other shapes that a primitive is compared with before the hierarchy is asked.
const MOST_BOXES: usize = 64;

/// Where surfaces are in contact, render units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contacts {
    /// Lower corner of a box around all such places.
    pub lower: [f32; 3],
    /// Its upper corner.
    pub upper: [f32; 3],
    /// The largest error of a position on surfaces in contact; 0 where there are none.
    pub error: f32,
    /// Pairs of primitives of one dielectric body that are nearer to each other than rays can
    /// tell: a wall too thin.
    pub too_thin: u32,
    /// Bodies that have found no layer of their own.
    pub without_layer: u32,
}

impl Contacts {
    /// Whether there are any.
    pub fn exist(&self) -> bool {
        self.error > 0.0
    }

    /// What rays cannot decide, one line each.
    pub fn warnings(&self) -> Vec<String> {
        let thin = (self.too_thin > 0).then(|| {
            format!(
                "{} pairs of faces of the same glass are too near to each other for rays in single precision: \
                 light may be lost there",
                self.too_thin
            )
        });
        let full = (self.without_layer > 0).then(|| {
            format!("{} bodies lie on too many others: which of them is in front may be wrong", self.without_layer)
        });
        thin.into_iter().chain(full).collect()
    }
}

/// How a shape's surface may hide or pass light, in the order in which coinciding ones are met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Role {
    /// Light passes without an inside: panes, sheets, cut-outs.
    Passing,
    /// It emits.
    Lamp,
    Opaque,
    /// The boundary of a dielectric.
    Boundary,
}

/// A shape as it was packed.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub triangles: Range<usize>,
    pub quadrics: Range<usize>,
    pub revolutions: Range<usize>,
    pub is_invisible: bool,
}

impl Part {
    fn len(&self) -> usize {
        self.triangles.len() + self.quadrics.len() + self.revolutions.len()
    }

    fn references(&self) -> impl Iterator<Item = u32> + use<> {
        let kind = |kind: u32, range: &Range<usize>| range.clone().map(move |index| kind << KIND_SHIFT | index as u32);
        // A sphere's and a disk's references differ; the index of a quadric is enough here.
        kind(TRIANGLE, &self.triangles).chain(kind(DISK, &self.quadrics)).chain(kind(REVOLUTION, &self.revolutions))
    }
}

/// What of a part may be told apart: a body of it.
type Body = (usize, u32);

/// A part with what is asked of it again and again.
struct Known<'a> {
    part: &'a Part,
    shape: &'a Shape,
    role: Role,
    /// For each triangle of a dielectric mesh, the body that it is part of.
    bodies: Vec<u32>,
    /// Whether it has an inside, once that was asked.
    is_closed: OnceCell<bool>,
}

struct Finder<'a> {
    packer: &'a Packer,
    bvh: &'a Bvh,
    parts: Vec<Known<'a>>,
    /// How many of them are of objects: the first ones.
    of_objects: usize,
    /// First triangle, quadric and revolution of each part: what a reference is part of.
    starts: [Vec<usize>; 3],
    pairs: BTreeSet<(Body, Body)>,
    /// Primitives in contact, by kind (a quadric's is DISK) and index.
    members: BTreeMap<u32, Body>,
    region: Bounds,
    error: f64,
    too_thin: u32,
}

/// A primitive where it stands.
#[derive(Clone, Copy)]
struct Standing {
    reference: u32,
    instance: Option<usize>,
}

impl Packer {
    /// Finds what is in contact, and writes layers to the primitives' materials.
    pub(super) fn find_contacts(&mut self, placed: &Placed, bvh: &Bvh) -> Contacts {
        let nothing = Contacts {
            lower: [f32::INFINITY; 3],
            upper: [f32::NEG_INFINITY; 3],
            error: 0.0,
            too_thin: 0,
            without_layer: 0,
        };
        if self.materials.len() > MATERIAL_MASK as usize || self.solver != RevolutionSolver::Certified {
            return nothing;
        }
        let mut finder = Finder::new(self, placed, bvh);
        finder.search(placed);
        let Finder { pairs, members, region, error, too_thin, .. } = &finder;
        if members.is_empty() {
            return Contacts { too_thin: *too_thin, ..nothing };
        }
        let (layers, without_layer) = layer::assign(&finder.bodies(), &pairs.iter().copied().collect::<Vec<_>>());
        let marks: Vec<(u32, u32)> = members
            .iter()
            .filter_map(|(reference, body)| {
                let role = finder.parts[body.0].role;
                let layer = layers.get(body)?;
                Some((*reference, layer::mark(*layer, role == Role::Boundary)))
            })
            .collect();
        let contacts = Contacts {
            lower: region.lower().as_vec3().to_array(),
            upper: region.upper().as_vec3().to_array(),
            error: *error as f32,
            too_thin: *too_thin,
            without_layer,
        };
        for (reference, mark) in marks {
            let index = (reference & INDEX_MASK) as usize;
            match reference >> KIND_SHIFT {
                TRIANGLE => self.triangles[index].material |= mark,
                DISK => self.quadrics[index].material |= mark,
                _ => self.revolutions[index].material |= mark,
            }
        }
        contacts
    }

    fn role(&self, shape: &Shape) -> Role {
        let material = &self.materials[shape.material];
        let is_made_of = |kinds: &[u32]| {
            let mut pending = vec![material];
            let mut found = false;
            while let Some(material) = pending.pop() {
                found |= kinds.contains(&material.kind);
                if material.kind == MIX {
                    pending.extend([material.first, material.second_part].map(|index| &self.materials[index as usize]));
                }
            }
            found
        };
        if is_made_of(&[DIELECTRIC]) {
            Role::Boundary
        } else if shape.emission.is_some() {
            Role::Lamp
        } else if material.alpha_texture != NONE || is_made_of(&[THIN_DIELECTRIC, DIFFUSE_TRANSMISSION]) {
            Role::Passing
        } else {
            Role::Opaque
        }
    }
}

impl Known<'_> {
    fn is_closed(&self) -> bool {
        *self.is_closed.get_or_init(|| is_closed(self.shape))
    }
}

impl<'a> Finder<'a> {
    fn new(packer: &'a Packer, placed: &'a Placed, bvh: &'a Bvh) -> Self {
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
            members: BTreeMap::new(),
            region: Bounds::default(),
            error: 0.0,
            too_thin: 0,
        }
    }

    /// Compares the primitives of each part with those of the parts that have more.
    fn search(&mut self, placed: &Placed) {
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
        // Boxes of the world's other parts: what none of them touches is in contact with nothing.
        let mut near = None;
        if !has_instances && !compares_itself {
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

    /// Whether primitives of a part are compared with those of another: each pair is looked at from
    /// the side that has fewer, or stands in the world itself.
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

    /// Whether it can be seen which of two parts is in front.
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
        let Some(form) = self.form(one) else { return };
        let reach = ERRORS * self.error(one);
        // The other may have the larger error, which is that of coordinates up to 1.
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
        for other in candidates {
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
        // Between instances of one object there is no telling which is which.
        if bodies[0] == bodies[1] && !is_one_body {
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
        // Where a closed body stands on something, nobody sees what is between.
        if are_sheets == [true; 2] && [index, other_index].iter().any(|index| self.parts[*index].is_closed()) {
            return;
        }
        let [first, second] = bodies;
        self.pairs.insert((first.min(second), first.max(second)));
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
        // The last part that starts there has it: those before it have none of this kind.
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

    /// The error of a position on a primitive, as shaders/include/surface.glsl bounds it.
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

    /// The bodies in contact, each with what decides its place among others.
    fn bodies(&self) -> BTreeMap<Body, layer::Rank> {
        let of_part = |body: &Body| {
            let known = &self.parts[body.0];
            let area: f64 = known
                .part
                .references()
                .filter_map(|reference| self.form(Standing { reference, instance: None }))
                .map(|form| form.bounds().half_extent().length_squared())
                .sum();
            let material = bytemuck::bytes_of(&self.packer.materials[known.shape.material]).to_vec();
            (*body, layer::Rank { role: known.role, area, material })
        };
        self.pairs.iter().flat_map(|(a, b)| [a, b]).map(of_part).collect()
    }
}

/// A reference with DISK for both kinds of quadrics.
fn by_kind(reference: u32) -> u32 {
    match reference >> KIND_SHIFT {
        TRIANGLE | REVOLUTION => reference,
        _ => DISK << KIND_SHIFT | reference & INDEX_MASK,
    }
}

/// A transform by its rows.
fn affine(rows: &[[f32; 4]; 3]) -> DAffine3 {
    let column = |i: usize| DVec3::from(rows.map(|row| f64::from(row[i])));
    DAffine3 { matrix3: glam::DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

/// Whether two flat surfaces turn their backs on each other, or their fronts.
fn turn_backs(a: &Form, b: &Form) -> bool {
    match (a, b) {
        (Form::Flat { normal, .. }, Form::Flat { normal: other, .. }) => normal.dot(*other) < 0.0,
        _ => false,
    }
}
