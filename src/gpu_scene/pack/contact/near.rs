//! Test whether two primitives are in contact: their distance is below the error of positions over an area,
//! or at a point where a curved one is tangent. Primitives that cross each other are not in contact. All
//! lengths are in render units.

use glam::{DAffine3, DVec2, DVec3};

use crate::gpu_scene::pack::revolution;
use crate::gpu_scene::pack::space::Bounds;
use crate::kernels::RevolutionPiece;

/// Sine of the largest angle between flat surfaces in contact.
const PARALLEL: f64 = 0.05;
/// Number of corners of the polygon around a disk.
const DISK_CORNERS: u32 = 32;
/// Number of steps in which a piece of a profile is sampled to find its extremes.
const PIECE_SAMPLES: u32 = 256;
/// Maximum error of these extremes, as a fraction of their range.
const PIECE_SLACK: f64 = 1e-5;
/// Maximum number of steps of the comparison of two profiles; undecided profiles count as in contact.
const PROFILE_STEPS: u32 = 1 << 16;
/// Minimum fraction of a sphere's cross-section over which the gap at a tangent point must be below the
/// tolerance. The light that a smaller contact loses is not worth the time that contacts take.
const LEAST_PART: f64 = 1e-4;
/// Relative tolerance of tests of a transform's kind.
const SAME: f64 = 1e-6;

/// A primitive in render space.
#[derive(Debug)]
pub(super) enum Form<'a> {
    /// A convex polygon and its unit normal.
    Flat { corners: Vec<DVec3>, normal: DVec3 },
    /// The transform of a unit sphere.
    Ellipsoid(DAffine3),
    /// A body of revolution, from its unit space.
    Turned { render_from_unit: DAffine3, pieces: &'a [RevolutionPiece] },
}

impl Form<'_> {
    /// Returns a triangle, or `None` if it has no area.
    pub fn triangle(corners: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).try_normalize()?;
        Some(Self::Flat { corners: corners.to_vec(), normal })
    }

    /// Returns the form of a transformed unit disk in the plane z = 0, or `None` if it has no area; a hole
    /// counts as surface.
    pub fn disk(render_from_object: &DAffine3) -> Option<Self> {
        let step = std::f64::consts::TAU / f64::from(DISK_CORNERS);
        let radius = 1.0 / (0.5 * step).cos();
        let corner = |i| (radius * DVec2::from_angle(step * f64::from(i))).extend(0.0);
        let corners = (0..DISK_CORNERS).map(|i| render_from_object.transform_point3(corner(i))).collect();
        let linear = render_from_object.matrix3;
        Some(Self::Flat { corners, normal: linear.x_axis.cross(linear.y_axis).try_normalize()? })
    }

    pub fn bounds(&self) -> Bounds {
        let mut bounds = Bounds::default();
        match self {
            Self::Flat { corners, .. } => corners.iter().for_each(|corner| bounds.add(*corner)),
            Self::Ellipsoid(transform) => bounds.add_bounds(transform, &Bounds::of(DVec3::NEG_ONE, DVec3::ONE)),
            Self::Turned { render_from_unit, pieces } => {
                pieces.iter().for_each(|piece| bounds.unite(&piece_bounds(piece, render_from_unit)));
            }
        }
        bounds
    }
}

/// Returns the bounds of the contact of two primitives, whose surfaces are at most `tolerance` apart there;
/// `None` if they are not in contact.
pub(super) fn contact(a: &Form, b: &Form, tolerance: f64) -> Option<Bounds> {
    use Form::{Ellipsoid, Flat, Turned};
    let region = match (a, b) {
        (Flat { corners: a, normal }, Flat { corners: b, normal: other }) => {
            flat_on_flat((a, *normal), (b, *other), tolerance)
        }
        (Flat { corners, normal }, Ellipsoid(sphere)) | (Ellipsoid(sphere), Flat { corners, normal }) => {
            flat_on_ellipsoid((corners, *normal), sphere, tolerance)
        }
        (Flat { corners, normal }, Turned { render_from_unit, pieces })
        | (Turned { render_from_unit, pieces }, Flat { corners, normal }) => {
            flat_on_turned((corners, *normal), render_from_unit, pieces, tolerance)
        }
        (Ellipsoid(a), Ellipsoid(b)) => ellipsoids(a, b, tolerance),
        (Turned { render_from_unit: a, pieces: of_a }, Turned { render_from_unit: b, pieces: of_b }) => {
            turned((a, of_a), (b, of_b), tolerance)
        }
        // An exact test would save only the time of a false contact.
        (Ellipsoid(_), Turned { .. }) | (Turned { .. }, Ellipsoid(_)) => a.bounds().common(&b.bounds()),
    };
    region.map(|region| region.widened(4.0 * tolerance))
}

fn flat_on_flat((a, normal): (&[DVec3], DVec3), (b, other): (&[DVec3], DVec3), tolerance: f64) -> Option<Bounds> {
    if normal.cross(other).length() > PARALLEL {
        return None;
    }
    // The part of b that is over a and near its plane.
    let mut part = b.to_vec();
    part = clipped(part, a[0] + tolerance * normal, normal);
    part = clipped(part, a[0] - tolerance * normal, -normal);
    for (corner, next) in edges(a) {
        part = clipped(part, corner, outwards(corner, next, normal, a));
    }
    // Neighbours with a common edge have no common area.
    let perimeter: f64 = edges(&part).map(|(corner, next)| corner.distance(next)).sum();
    (area(&part) > tolerance * perimeter).then(|| Bounds::around(&part))
}

fn edges(polygon: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> {
    polygon.iter().copied().zip(polygon.iter().copied().cycle().skip(1))
}

/// Returns the direction out of a convex polygon at an edge, in its plane.
fn outwards(corner: DVec3, next: DVec3, normal: DVec3, polygon: &[DVec3]) -> DVec3 {
    let side = (next - corner).cross(normal).normalize_or_zero();
    let middle = polygon.iter().copied().sum::<DVec3>() / polygon.len() as f64;
    if side.dot(middle - corner) > 0.0 { -side } else { side }
}

/// Returns the part of a polygon that is not beyond a plane (Sutherland and Hodgman 1974).
fn clipped(polygon: Vec<DVec3>, origin: DVec3, beyond: DVec3) -> Vec<DVec3> {
    let height = |point: DVec3| (point - origin).dot(beyond);
    let mut kept = Vec::new();
    for (corner, next) in edges(&polygon) {
        let (from, to) = (height(corner), height(next));
        if from <= 0.0 {
            kept.push(corner);
        }
        if (from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0) {
            kept.push(corner.lerp(next, from / (from - to)));
        }
    }
    kept
}

fn area(polygon: &[DVec3]) -> f64 {
    let origin = polygon.first().copied().unwrap_or_default();
    let twice: DVec3 = edges(polygon).map(|(corner, next)| (corner - origin).cross(next - origin)).sum();
    0.5 * twice.length()
}

/// Returns the radius around a tangent point within which the gap below a curved surface is less than the
/// tolerance.
fn reach(radius: f64, tolerance: f64) -> f64 {
    2.0 * (2.0 * radius * tolerance).sqrt() + tolerance
}

/// Returns true if the contact of a sphere and a flatter surface at a point covers too small a part of the
/// sphere: the gap is below the tolerance up to a squared distance of twice radius times tolerance.
fn is_small(radius: f64, tolerance: f64) -> bool {
    2.0 * tolerance < LEAST_PART * radius
}

fn around(point: DVec3, radius: f64) -> Bounds {
    Bounds::of(point - radius, point + radius)
}

fn longest_axis(transform: &DAffine3) -> f64 {
    let linear = transform.matrix3;
    linear.x_axis.length().max(linear.y_axis.length()).max(linear.z_axis.length())
}

fn flat_on_ellipsoid((corners, normal): (&[DVec3], DVec3), sphere: &DAffine3, tolerance: f64) -> Option<Bounds> {
    let support = sphere.matrix3.transpose() * normal;
    let height = (sphere.translation - corners[0]).dot(normal);
    if (height.abs() - support.length()).abs() > tolerance {
        return None;
    }
    let tangent = sphere.translation - height.signum() * (sphere.matrix3 * support.normalize_or_zero());
    if is_small(longest_axis(sphere), tolerance) {
        return None;
    }
    let reach = reach(longest_axis(sphere), tolerance);
    let is_beside =
        |(corner, next): (DVec3, DVec3)| (tangent - corner).dot(outwards(corner, next, normal, corners)) > reach;
    (!edges(corners).any(is_beside)).then(|| around(tangent, reach))
}

/// Returns the radius of a transformed unit sphere; `None` if it is stretched.
fn radius(transform: &DAffine3) -> Option<f64> {
    let squares = transform.matrix3.transpose() * transform.matrix3;
    let radius2 = squares.x_axis.x;
    let is_even = (0..3)
        .all(|i| (0..3).all(|j| (squares.col(i)[j] - if i == j { radius2 } else { 0.0 }).abs() <= SAME * radius2));
    is_even.then(|| radius2.sqrt())
}

fn ellipsoids(a: &DAffine3, b: &DAffine3, tolerance: f64) -> Option<Bounds> {
    let bounds = || Form::Ellipsoid(*a).bounds().common(&Form::Ellipsoid(*b).bounds());
    let (Some(radius_a), Some(radius_b)) = (radius(a), radius(b)) else { return bounds() };
    let between = b.translation - a.translation;
    let distance = between.length();
    if (distance - (radius_a - radius_b).abs()).abs() <= tolerance && distance <= 10.0 * tolerance {
        return bounds(); // one in the other, of one size
    }
    let touches = |gap: f64| (distance - gap).abs() <= tolerance;
    let way = between.normalize_or_zero();
    let smaller = radius_a.min(radius_b);
    if touches(radius_a + radius_b) && !is_small(smaller, tolerance) {
        return Some(around(a.translation + radius_a * way, reach(smaller, tolerance)));
    }
    // If one sphere is in the other and their radii are similar, their curvatures nearly cancel.
    let curvature = (1.0 / smaller - 1.0 / radius_a.max(radius_b)).max(tolerance);
    let side = if radius_a >= radius_b { way } else { -way };
    touches((radius_a - radius_b).abs())
        .then(|| around(a.translation + radius_a * side, reach(curvature.recip(), tolerance)))
}

fn piece_bounds(piece: &RevolutionPiece, render_from_unit: &DAffine3) -> Bounds {
    let bounds = revolution::bounds(piece, render_from_unit);
    Bounds::of(bounds.min.as_dvec3(), bounds.max.as_dvec3())
}

/// Returns radius and height at x in [-1, 1].
fn point_of(piece: &RevolutionPiece, x: f64) -> DVec2 {
    let pairs = piece.coefficients.iter().rev();
    pairs.fold(DVec2::ZERO, |point, [u0, v0, u1, v1]| {
        let [u0, v0, u1, v1] = [u0, v0, u1, v1].map(|c| f64::from(*c));
        (point * x + DVec2::new(u1, v1)) * x + DVec2::new(u0, v0)
    })
}

/// Returns the bounds of the contact of a polygon and a body of revolution. A plane touches a body at an
/// extreme of a piece along the plane's normal, on either side of the axis.
fn flat_on_turned(
    (corners, normal): (&[DVec3], DVec3),
    render_from_unit: &DAffine3,
    pieces: &[RevolutionPiece],
    tolerance: f64,
) -> Option<Bounds> {
    let along = render_from_unit.matrix3.transpose() * normal;
    let (sideways, height) = (along.truncate().length(), (corners[0] - render_from_unit.translation).dot(normal));
    let polygon = Bounds::around(corners);
    let mut region = Bounds::default();
    for piece in pieces {
        let points = (0..=PIECE_SAMPLES).map(|i| point_of(piece, f64::from(i) * 2.0 / f64::from(PIECE_SAMPLES) - 1.0));
        let mut extremes = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
        for point in points {
            for (side, pair) in [1.0, -1.0].into_iter().zip(extremes.chunks_exact_mut(2)) {
                let value = along.z * point.y + side * sideways * point.x;
                (pair[0], pair[1]) = (pair[0].min(value), pair[1].max(value));
            }
        }
        let range = extremes[1].max(extremes[3]) - extremes[0].min(extremes[2]);
        let slack = tolerance + PIECE_SLACK * range;
        if extremes.iter().any(|extreme| (height - extreme).abs() <= slack) {
            let near = piece_bounds(piece, render_from_unit).widened(slack).common(&polygon.widened(slack));
            near.iter().for_each(|near| region.unite(near));
        }
    }
    (!region.is_empty()).then_some(region)
}

fn turned(
    (a, of_a): (&DAffine3, &[RevolutionPiece]),
    (b, of_b): (&DAffine3, &[RevolutionPiece]),
    tolerance: f64,
) -> Option<Bounds> {
    let mut region = Bounds::default();
    let same_axis = axis_map(a, b);
    for (piece, other) in of_a.iter().flat_map(|piece| of_b.iter().map(move |other| (piece, other))) {
        let near = piece_bounds(piece, a).widened(tolerance).common(&piece_bounds(other, b));
        let Some(near) = near else { continue };
        let touch = same_axis.is_none_or(|map| {
            let size = longest_axis(a);
            let mut steps = 0;
            let of_b = |x| map * point_of(other, x).extend(1.0);
            touch(
                &|x| point_of(piece, x),
                &|x| of_b(x).truncate(),
                [-1.0, 1.0, -1.0, 1.0],
                tolerance / size,
                &mut steps,
            )
        });
        if touch {
            region.unite(&near);
        }
    }
    (!region.is_empty()).then_some(region)
}

/// Returns the map of radius and height from the unit space of `b` to that of `a`; `None` if the bodies do
/// not share an axis.
fn axis_map(a: &DAffine3, b: &DAffine3) -> Option<glam::DMat3> {
    let map = a.inverse() * *b;
    let linear = map.matrix3;
    let (radial, axial) = (linear.x_axis.length(), linear.z_axis.z);
    let size = radial.max(axial.abs());
    let strays =
        [map.translation.x, map.translation.y, linear.z_axis.x, linear.z_axis.y, linear.x_axis.z, linear.y_axis.z];
    let is_round = (linear.y_axis.length() - radial).abs() <= SAME * size
        && linear.x_axis.dot(linear.y_axis).abs() <= SAME * size * size;
    (is_round && strays.iter().all(|stray| stray.abs() <= SAME * size)).then(|| {
        glam::DMat3::from_cols(
            DVec3::new(radial, 0.0, 0.0),
            DVec3::new(0.0, axial, 0.0),
            DVec3::new(0.0, map.translation.z, 1.0),
        )
    })
}

/// Returns true if two monotone curves come nearer to each other than the tolerance. The test bisects the
/// stretches `[x0, x1, y0, y1]` of both curves and compares their boxes, which the ends of a stretch
/// determine.
fn touch(
    a: &impl Fn(f64) -> DVec2,
    b: &impl Fn(f64) -> DVec2,
    [x0, x1, y0, y1]: [f64; 4],
    tolerance: f64,
    steps: &mut u32,
) -> bool {
    *steps += 1;
    let [[a0, a1], [b0, b1]] = [[a(x0), a(x1)], [b(y0), b(y1)]];
    let apart = (a0.min(a1) - b0.max(b1)).max(b0.min(b1) - a0.max(a1));
    if apart.max_element() > tolerance {
        return false;
    }
    let (size_a, size_b) = (a0.distance(a1), b0.distance(b1));
    if size_a.max(size_b) <= tolerance || *steps > PROFILE_STEPS {
        return true;
    }
    let (x, y) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
    let halves = if size_a >= size_b { [[x0, x, y0, y1], [x, x1, y0, y1]] } else { [[x0, x1, y0, y], [x0, x1, y, y1]] };
    halves.into_iter().any(|half| touch(a, b, half, tolerance, steps))
}
