//! Detection of surfaces of different bodies that are in contact: they coincide within the error of
//! positions, such as the underside of a glass and the table below it.
//! `shaders/include/geometry/contact.glsl` makes rays meet such surfaces in an order that does not depend
//! on rounding; this module assigns a layer to each of them.
//!
//! Only contacts with a visible order count: contacts of dielectrics, lamps and surfaces that let light
//! pass with any surface, and of open sheets with other sheets, such as a decal on a wall.

mod body;
mod finder;
mod layer;
mod near;

use std::ops::Range;

use super::instance::Placed;
use super::{Packer, RevolutionSolver};
use crate::gpu_scene::bvh::Bvh;
use crate::kernels::{
    DIELECTRIC, DIFFUSE_TRANSMISSION, DISK, INDEX_MASK, INTERFACE, KIND_SHIFT, MATERIAL_MASK, MIX, NONE, REVOLUTION,
    THIN_DIELECTRIC, TRIANGLE,
};
use crate::scene::Shape;
use finder::Finder;

/// Contacts of surfaces; lengths are in render units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contacts {
    /// Lower corner of a box around all contacts.
    pub lower: [f32; 3],
    /// Upper corner of the box.
    pub upper: [f32; 3],
    /// Largest error of a position on surfaces in contact; 0 if there are no contacts.
    pub error: f32,
    /// Number of pairs of primitives of one dielectric body that are nearer to each other than rays can
    /// distinguish: walls that are too thin.
    pub too_thin: u32,
    /// Number of bodies without a layer of their own.
    pub without_layer: u32,
    /// Whether some surfaces were not compared, because too many are near to each other.
    pub gave_up: bool,
}

impl Contacts {
    /// Returns true if there are contacts.
    pub fn exist(&self) -> bool {
        self.error > 0.0
    }

    /// Returns warnings about contacts that rays may meet in the wrong order, one line each.
    pub fn warnings(&self) -> Vec<String> {
        let thin = (self.too_thin > 0).then(|| {
            format!(
                "{} pairs of faces of the same glass are too close to each other for rays in single precision: \
                 light may be lost there",
                self.too_thin
            )
        });
        let full = (self.without_layer > 0).then(|| {
            format!("{} bodies touch too many others: rays may meet them in the wrong order", self.without_layer)
        });
        let many = self.gave_up.then(|| {
            "too many surfaces touch each other to compare them all: rays may meet them in the wrong order".to_owned()
        });
        thin.into_iter().chain(full).chain(many).collect()
    }
}

/// Role of a shape's surface in hiding or passing light, in the order in which rays meet coinciding
/// surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Role {
    /// A surface that light passes without an inside: a pane, a sheet, a cut-out.
    Passing,
    /// An emitting surface.
    Lamp,
    Opaque,
    /// The boundary of a dielectric or of a medium.
    Boundary,
}

/// The ranges of the arrays that a shape was packed to.
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
        // References of spheres and disks differ in kind; here DISK stands for both, with the quadric's
        // index.
        kind(TRIANGLE, &self.triangles).chain(kind(DISK, &self.quadrics)).chain(kind(REVOLUTION, &self.revolutions))
    }
}

/// A body: the index of a part, and a number that distinguishes the connected meshes in it.
type Body = (usize, u32);

impl Packer {
    /// Finds the surfaces in contact, and adds their layers to the primitives' materials.
    pub(super) fn find_contacts(&mut self, placed: &Placed, bvh: &Bvh) -> Contacts {
        let nothing = Contacts {
            lower: [f32::INFINITY; 3],
            upper: [f32::NEG_INFINITY; 3],
            error: 0.0,
            too_thin: 0,
            without_layer: 0,
            gave_up: false,
        };
        if self.materials.len() > MATERIAL_MASK as usize || self.solver != RevolutionSolver::Certified {
            return nothing;
        }
        let mut finder = Finder::new(self, placed, bvh);
        finder.search(placed);
        let Finder { pairs, members, region, error, too_thin, .. } = &finder;
        if members.is_empty() {
            return Contacts { too_thin: *too_thin, gave_up: finder.gave_up(), ..nothing };
        }
        let (layers, without_layer) = layer::assign(&finder.bodies(), &pairs.iter().copied().collect::<Vec<_>>());
        let marks: Vec<(u32, u32)> = members
            .iter()
            .filter_map(|(reference, body)| {
                let role = finder.role_of(*body);
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
            gave_up: finder.gave_up(),
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
        if is_made_of(&[DIELECTRIC, INTERFACE]) {
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
