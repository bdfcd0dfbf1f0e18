//! The portal of an infinite light: pbrt-v4 takes its corners in world space, whatever the transform.

use glam::DVec3;

use crate::scene::format::error::SceneError;
use crate::scene::format::params::ParamList;
use crate::scene::model::Portal;

/// Largest cosine between edges that are to be perpendicular, and difference from 1 between those that are to be
/// parallel, as in pbrt.
const TOLERANCE: f64 = 1e-3;

/// Returns the portal, if there is one. In the order of its corners p0 to p3, light comes from the side to which
/// (p3 - p0) x (p1 - p0) points.
pub(super) fn portal(params: &ParamList) -> Result<Option<Portal>, SceneError> {
    let Some(param) = params.get("portal") else {
        return Ok(None);
    };
    let bad = || param.bad_value("the four corners of a rectangle, one after the other");
    let Ok([a, b, c, d]) = <[DVec3; 4]>::try_from(params.triples("portal")) else {
        return Err(bad());
    };
    let edge = |from: DVec3, to: DVec3| (to - from).try_normalize().ok_or_else(bad);
    let (ab, bc, dc, ad) = (edge(a, b)?, edge(b, c)?, edge(d, c)?, edge(a, d)?);
    let are_parallel = |v: DVec3, w: DVec3| (v.dot(w) - 1.0).abs() <= TOLERANCE;
    let is_square = [(ab, bc), (bc, dc), (dc, ad), (ad, ab)].iter().all(|(v, w)| v.dot(*w).abs() <= TOLERANCE);
    if !(are_parallel(ab, dc) && are_parallel(bc, ad) && is_square) {
        return Err(bad());
    }
    Ok(Some(Portal { corner: a, edges: [b - a, d - a] }))
}
