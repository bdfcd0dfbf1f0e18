//! Packing of bodies of revolution: profiles in unit space, cut into the pieces that rays are intersected
//! with. `shaders/include/revolution/revolution.glsl` describes the use of each number.

use bytemuck::Zeroable;
use glam::{DAffine3, DVec2, DVec3, Vec3A};
use obvhs::aabb::Aabb;

use super::{Packer, RevolutionSolver, rows};
use crate::geometry::bezier::{Curve, Stretch};
use crate::gpu_scene::bvh::PADDING;
use crate::kernels::{GROUP, KIND_SHIFT, MAX_PIECES, NONE, REVOLUTION, Revolution, RevolutionPiece};
use crate::scene::{AreaLight, Geometry, Profile, Scene, Shape};

/// Number of pieces per unit of a segment's parameter. With more pieces there are more rings to test, with
/// fewer there are more intervals to examine.
const PIECES_PER_UNIT: f64 = 8.0;
/// Relative widening of bounds, for their rounding to f32.
const WIDENING: f64 = 1e-6;

/// Returns the highest degree of a scene's profiles; at least 1.
pub(super) fn degree(scene: &Scene) -> u32 {
    let degree = |shape: &Shape| match &shape.geometry {
        Geometry::Revolution(profile) => profile.segments.iter().map(Curve::degree).max().unwrap_or(1),
        _ => 1,
    };
    scene.shapes.iter().map(degree).max().unwrap_or(1) as u32
}

impl Packer {
    pub(super) fn add_revolution(&mut self, shape: &Shape, profile: &Profile, render_from_object: &DAffine3) {
        let unit = UnitSpace::of(profile);
        let render_from_unit = *render_from_object * unit.to_object();
        let determinant = render_from_unit.matrix3.determinant();
        let body = Revolution {
            unit_from_render: rows(&render_from_unit.inverse()),
            render_from_unit: rows(&render_from_unit),
            material: shape.material as u32,
            // As for quadrics, the normal of a mirrored body is reversed.
            flipped: u32::from(shape.reverse_orientation ^ (determinant < 0.0)),
            determinant: determinant.abs() as f32,
            ..Revolution::zeroed()
        };
        let curves = unit.curves(profile);
        let (first, mut pieces) = (self.revolution_pieces.len(), pieces(&curves));
        for (i, part) in pieces.chunks_mut(MAX_PIECES as usize).enumerate() {
            self.add_part(
                Revolution { first_piece: first as u32 + i as u32 * MAX_PIECES, ..body },
                part,
                &render_from_unit,
            );
        }
        let areas: Vec<f64> = pieces.iter().map(|piece| area(piece, &render_from_unit)).collect();
        let whole = areas.iter().sum();
        let emission = shape.emission.as_ref().filter(|_| whole > 0.0).map(|emission| AreaLight {
            radiance: self.radiance(emission, whole),
            power: None,
            ..emission.clone()
        });
        for (i, (mut piece, area)) in pieces.into_iter().zip(areas).enumerate() {
            let reference = REVOLUTION << KIND_SHIFT | (first + i) as u32;
            let bounds = bounds(&piece, &render_from_unit);
            if let Some(emission) = &emission {
                piece.light = self.add_emitter(emission, reference, area, &bounds);
            }
            self.revolution_pieces.push(piece);
        }
        if let RevolutionSolver::Newton { segments, envelopes } = self.solver {
            self.add_segments(&curves, first, &render_from_unit, segments, envelopes);
        }
    }

    /// Adds a body with some of the pieces of a profile.
    fn add_part(&mut self, body: Revolution, pieces: &mut [RevolutionPiece], render_from_unit: &DAffine3) {
        let index = self.revolutions.len() as u32;
        let mut whole = Aabb::empty();
        for piece in pieces.iter_mut() {
            piece.body = index;
            whole = whole.union(&bounds(piece, render_from_unit));
        }
        for group in pieces.chunks_mut(GROUP as usize) {
            group[0].group_ring = group.iter().map(|piece| piece.ring).fold(group[0].ring, unite);
        }
        self.revolutions.push(Revolution {
            lower: (whole.min - Vec3A::splat(PADDING)).to_array(),
            upper: (whole.max + Vec3A::splat(PADDING)).to_array(),
            piece_count: pieces.len() as u32,
            ..body
        });
        if self.solver == RevolutionSolver::Certified {
            self.add_primitive(REVOLUTION << KIND_SHIFT | index, whole);
        }
    }
}

/// The unit space of a body: the largest radius is in (1/2, 1], and heights are in [-1, 1] with an extreme
/// outside of [-1/2, 1/2]. Both factors are powers of two, so that scaling rounds nothing.
struct UnitSpace {
    middle: f64,
    radius: f64,
    height: f64,
}

impl UnitSpace {
    fn of(profile: &Profile) -> Self {
        let points = || profile.segments.iter().flat_map(|segment| &segment.points);
        let lower = points().fold(f64::INFINITY, |least, point| least.min(point.y));
        let upper = points().fold(f64::NEG_INFINITY, |most, point| most.max(point.y));
        let widest = points().fold(0.0_f64, |most, point| most.max(point.x));
        let power_of_two = |size: f64| size.log2().ceil().exp2();
        let radius = power_of_two(widest);
        let half = 0.5 * (upper - lower);
        // The factor of a flat body is the one of its radius; a height below the bound is rounding.
        let height = if half > 1e-12 * widest { power_of_two(half) } else { radius };
        Self { middle: lower + half, radius, height }
    }

    fn to_object(&self) -> DAffine3 {
        DAffine3::from_translation(DVec3::new(0.0, 0.0, self.middle))
            * DAffine3::from_scale(DVec3::new(self.radius, self.radius, self.height))
    }

    /// Returns the segments of a profile in unit space.
    fn curves(&self, profile: &Profile) -> Vec<Curve> {
        let into = |point: &DVec2| DVec2::new(point.x / self.radius, (point.y - self.middle) / self.height);
        let curve = |segment: &Curve| Curve { points: segment.points.iter().map(into).collect() };
        profile.segments.iter().map(curve).collect()
    }
}

/// Returns the pieces of a profile's segments.
fn pieces(curves: &[Curve]) -> Vec<RevolutionPiece> {
    let mut pieces: Vec<RevolutionPiece> = Vec::new();
    for (i, curve) in curves.iter().enumerate() {
        for stretch in curve.monotone_stretches(PIECES_PER_UNIT) {
            let begin = pieces.last().map(|piece| [piece.ends[2], piece.ends[3]]);
            let along = stretch.range.map(|t| ((i as f64 + t) / curves.len() as f64) as f32);
            pieces.push(piece(&stretch, begin, along));
        }
    }
    pieces
}

/// Returns a piece that begins exactly where the previous one ended, at `begin`.
fn piece(stretch: &Stretch, begin: Option<[f32; 2]>, along: [f32; 2]) -> RevolutionPiece {
    let points = &stretch.curve.points;
    let single = |point: DVec2| point.as_vec2().to_array();
    let [u0, v0] = begin.unwrap_or(single(points[0]));
    let [u1, v1] = single(points[points.len() - 1]);
    // The parameter is x = 2 t - 1, so second derivatives are a quarter of those by t.
    let hodograph = stretch.curve.hodograph();
    let bend = stretch.curve.degree() as f64 - 1.0;
    let curvature =
        hodograph.windows(2).map(|pair| (pair[1] - pair[0]).abs() * (0.25 * bend)).fold(DVec2::ZERO, DVec2::max);
    let mut coefficients = [[0.0; 4]; 5];
    for (i, c) in stretch.curve.coefficients().into_iter().enumerate() {
        coefficients[i / 2][2 * (i % 2)..][..2].copy_from_slice(&single(c));
    }
    RevolutionPiece {
        ring: ring([u0, v0, u1, v1].map(f64::from)),
        group_ring: [0.0; 4],
        ends: [u0, v0, u1, v1],
        curvature: single(curvature * (1.0 + WIDENING)),
        along,
        body: NONE,
        light: NONE,
        pad: [0.0; 2],
        coefficients,
    }
}

/// Returns the ring that contains a rotating piece with these ends, widened by more than the rounding of a
/// ray.
fn ring([u0, v0, u1, v1]: [f64; 4]) -> [f32; 4] {
    let square = |radius: f64, sign: f64| radius * radius * (1.0 + sign * 1e-5) + sign * 1e-6;
    [v0.min(v1) - 1e-6, v0.max(v1) + 1e-6, square(u0.min(u1), -1.0), square(u0.max(u1), 1.0)].map(|x| x as f32)
}

/// Returns the ring around two rings.
fn unite(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]
}

/// Returns the area of a piece in square render units, by the midpoint rule in both parameters.
fn area(piece: &RevolutionPiece, render_from_unit: &DAffine3) -> f64 {
    let linear = render_from_unit.matrix3;
    let cofactors = linear.inverse().transpose() * linear.determinant().abs();
    let coefficients: Vec<DVec2> = piece
        .coefficients
        .iter()
        .flat_map(|pair| [DVec2::new(pair[0].into(), pair[1].into()), DVec2::new(pair[2].into(), pair[3].into())])
        .collect();
    let (along, around) = (16, 32);
    let mut sum = 0.0;
    for i in 0..along {
        let x = (f64::from(i) + 0.5) * 2.0 / f64::from(along) - 1.0;
        let (mut point, mut slope) = (DVec2::ZERO, DVec2::ZERO);
        for c in coefficients.iter().rev() {
            slope = slope * x + point;
            point = point * x + *c;
        }
        for j in 0..around {
            let azimuth = DVec2::from_angle(std::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(around));
            let normal = (azimuth * slope.y).extend(-slope.x);
            sum += (cofactors * normal).length() * point.x.max(0.0);
        }
    }
    sum * 2.0 * std::f64::consts::TAU / f64::from(along * around)
}

/// Returns the box around a piece in render space, widened by the rounding of its evaluation.
pub(super) fn bounds(piece: &RevolutionPiece, render_from_unit: &DAffine3) -> Aabb {
    let [u0, v0, u1, v1] = piece.ends.map(f64::from);
    let (widest, middle, half) = (u0.max(u1), 0.5 * (v0 + v1), 0.5 * (v1 - v0).abs());
    let linear = render_from_unit.matrix3.transpose();
    let center = render_from_unit.transform_point3(DVec3::new(0.0, 0.0, middle));
    let extent = |row: DVec3| row.truncate().length() * widest + row.z.abs() * half;
    let rounding = |row: DVec3| 4.0 * f64::from(f32::EPSILON) * (row.truncate().length() + row.z.abs());
    let rows = [linear.x_axis, linear.y_axis, linear.z_axis];
    let reach = DVec3::from(rows.map(|row| extent(row) + rounding(row))) + center.abs() * f64::from(f32::EPSILON);
    Aabb::new(Vec3A::from((center - reach).as_vec3()), Vec3A::from((center + reach).as_vec3()))
}
