//! Layers of bodies in contact. Bodies in contact have different layers; the layers of sheets (bodies that
//! are not boundaries of dielectrics) give their order, the front one first.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::{Body, Role};
use crate::kernels::{BOUNDARY_LAYERS, SHEET_LAYERS};

/// Criteria that decide which of two bodies is in front. They do not depend on the order in which a scene
/// declares the bodies.
#[derive(Clone, Debug)]
pub(super) struct Rank {
    pub role: Role,
    /// Measure of the size of the whole shape: the smaller shape is in front.
    pub area: f64,
    /// Bytes of the material: two bodies with the same material are interchangeable.
    pub material: Vec<u8>,
}

impl Rank {
    fn compare(&self, other: &Self) -> Ordering {
        let by_role = self.role.cmp(&other.role);
        by_role.then(self.area.total_cmp(&other.area)).then_with(|| self.material.cmp(&other.material))
    }
}

/// Returns the mask of layers of a kind. The layers of sheets are ordered, those of boundaries of
/// dielectrics are not.
fn layers_of(is_boundary: bool) -> u32 {
    if is_boundary { BOUNDARY_LAYERS } else { SHEET_LAYERS }
}

/// Returns the bit for a layer, counted from 0, which a primitive's material has above its index.
pub(super) fn mark(layer: u32, is_boundary: bool) -> u32 {
    1 << (layers_of(is_boundary).trailing_zeros() + layer)
}

/// Returns the layer of each body among those of its kind, and the number of bodies without a layer of
/// their own.
pub(super) fn assign(bodies: &BTreeMap<Body, Rank>, pairs: &[(Body, Body)]) -> (BTreeMap<Body, u32>, u32) {
    let mut neighbours = BTreeMap::<Body, Vec<Body>>::new();
    for (a, b) in pairs {
        neighbours.entry(*a).or_default().push(*b);
        neighbours.entry(*b).or_default().push(*a);
    }
    let mut order: Vec<(&Body, &Rank)> = bodies.iter().collect();
    order.sort_by(|(_, a), (_, b)| a.compare(b));
    let mut layers = BTreeMap::new();
    let mut without = 0;
    for (body, rank) in order {
        let is_boundary = rank.role == Role::Boundary;
        let of_kind = neighbours[body].iter().filter(|other| (bodies[other].role == Role::Boundary) == is_boundary);
        let taken: Vec<u32> = of_kind.filter_map(|other| layers.get(other).copied()).collect();
        let free = if is_boundary {
            (0..).find(|layer| !taken.contains(layer)).unwrap_or(0)
        } else {
            taken.iter().max().map_or(0, |layer| layer + 1)
        };
        let last = layers_of(is_boundary).count_ones() - 1;
        without += u32::from(free > last);
        layers.insert(*body, free.min(last));
    }
    (layers, without)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rank(role: Role, area: f64) -> Rank {
        Rank { role, area, material: Vec::new() }
    }

    #[test]
    fn bodies_in_contact_have_layers_in_order() {
        let bodies = BTreeMap::from([
            ((0, 0), rank(Role::Boundary, 1.0)),
            ((1, 0), rank(Role::Opaque, 9.0)),
            ((2, 0), rank(Role::Opaque, 2.0)),
            ((3, 0), rank(Role::Lamp, 5.0)),
            ((4, 0), rank(Role::Boundary, 1.0)),
        ]);
        let pairs = [((0, 0), (1, 0)), ((1, 0), (2, 0)), ((1, 0), (3, 0)), ((2, 0), (3, 0)), ((0, 0), (4, 0))];
        let (layers, without) = assign(&bodies, &pairs);
        assert_eq!(without, 0);
        let marks: BTreeMap<Body, u32> =
            layers.iter().map(|(body, layer)| (*body, mark(*layer, bodies[body].role == Role::Boundary))).collect();
        assert!(marks[&(3, 0)] < marks[&(2, 0)] && marks[&(2, 0)] < marks[&(1, 0)], "{marks:x?}");
        assert!(pairs.iter().all(|(a, b)| marks[a] != marks[b]), "{marks:x?}");
        assert!(marks.iter().all(|(body, mark)| (mark & BOUNDARY_LAYERS != 0) == (body.0 % 4 == 0)), "{marks:x?}");
    }

    #[test]
    fn more_bodies_than_layers_are_counted() {
        let bodies: BTreeMap<Body, Rank> = (0..200).map(|i| ((i, 0), rank(Role::Opaque, i as f64))).collect();
        let pairs: Vec<(Body, Body)> = (0..200).flat_map(|i| (0..i).map(move |j| ((j, 0), (i, 0)))).collect();
        let (layers, without) = assign(&bodies, &pairs);
        let most = SHEET_LAYERS.count_ones();
        assert_eq!(without, 200 - most);
        assert!(layers.values().all(|layer| *layer < most));
    }
}
