//! Layers of bodies in contact: numbers from 1 on that differ between bodies in contact and, of
//! those that are no boundary of a dielectric, say which is in front.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::{Body, Role};
use crate::kernels::{IS_BOUNDARY, LAYER_SHIFT, MAX_LAYER};

/// What decides which of two bodies is in front. It does not depend on the order in which a scene
/// declares them.
#[derive(Clone, Debug)]
pub(super) struct Rank {
    pub role: Role,
    /// A measure of the size of the whole shape: the smaller one is in front.
    pub area: f64,
    /// Contents of the material: two bodies of the same may change places.
    pub material: Vec<u8>,
}

impl Rank {
    fn compare(&self, other: &Self) -> Ordering {
        let by_role = self.role.cmp(&other.role);
        by_role.then(self.area.total_cmp(&other.area)).then_with(|| self.material.cmp(&other.material))
    }
}

/// The bits that a primitive's material has above its index.
pub(super) fn mark(layer: u32, is_boundary: bool) -> u32 {
    layer << LAYER_SHIFT | if is_boundary { IS_BOUNDARY } else { 0 }
}

/// The layer of each body, and how many found none of their own. Boundaries come last: their layer
/// is just a number that no body in contact with them has.
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
        let taken: Vec<u32> = neighbours[body].iter().filter_map(|other| layers.get(other).copied()).collect();
        let free = if rank.role == Role::Boundary {
            (1..).find(|layer| !taken.contains(layer))
        } else {
            taken.iter().max().map(|layer| layer + 1)
        };
        let layer = free.unwrap_or(1);
        without += u32::from(layer > MAX_LAYER);
        layers.insert(*body, layer.min(MAX_LAYER));
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
        assert!(layers[&(3, 0)] < layers[&(2, 0)] && layers[&(2, 0)] < layers[&(1, 0)], "{layers:?}");
        assert!(pairs.iter().all(|(a, b)| layers[a] != layers[b]), "{layers:?}");
    }

    #[test]
    fn more_bodies_than_layers_are_counted() {
        let bodies: BTreeMap<Body, Rank> = (0..200).map(|i| ((i, 0), rank(Role::Opaque, i as f64))).collect();
        let pairs: Vec<(Body, Body)> = (0..200).flat_map(|i| (0..i).map(move |j| ((j, 0), (i, 0)))).collect();
        let (layers, without) = assign(&bodies, &pairs);
        assert_eq!(without, 200 - MAX_LAYER);
        assert!(layers.values().all(|layer| (1..=MAX_LAYER).contains(layer)));
    }
}
