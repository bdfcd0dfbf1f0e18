//! Packing of whole segments of profiles, for the classical solver of bodies of revolution in
//! `shaders/include/revolution/newton.glsl`.

use std::fmt;
use std::ops::RangeInclusive;

use glam::{DAffine3, DVec2};
use obvhs::aabb::Aabb;

use super::Packer;
use super::revolution::bounds;
use crate::base::names::named;
use crate::geometry::bezier::Curve;
use crate::kernels::{KIND_SHIFT, NEWTON_COEFFICIENTS, NewtonStart, REVOLUTION, RevolutionPiece, RevolutionSegment};

/// Method of intersection of rays and bodies of revolution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RevolutionSolver {
    /// Certified roots: every root of every piece of the profile, by interval bounds.
    #[default]
    Certified,
    /// The classical method, which misses roots: Newton's method on one polynomial of twice the profile's
    /// degree, with deflation. For comparison only.
    Newton {
        /// Number of pieces of each approximation of a segment, in [`RevolutionSolver::SEGMENTS`].
        segments: u32,
        /// The approximations that give Newton's method its start values.
        envelopes: Envelopes,
    },
}

impl fmt::Display for RevolutionSolver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Certified => write!(f, "certified"),
            Self::Newton { segments, envelopes } => write!(f, "newton, {envelopes:?}, {segments} segments"),
        }
    }
}

named! {
    /// Piecewise linear approximations of a profile. Newton's method starts where the ray hits them.
    pub enum Envelopes = Both {
        /// The chords between points of the profile
        Chord: "chord",
        /// The tangents at these points, up to the intersection with the next tangent
        Tangent: "tangent",
        /// First the chords, then the tangents
        Both: "both",
    }
}

impl RevolutionSolver {
    /// Permitted numbers of pieces of an approximation of a segment.
    pub const SEGMENTS: RangeInclusive<u32> = 1..=64;
    /// Default number of pieces of an approximation.
    pub const DEFAULT_SEGMENTS: u32 = 16;
    /// The classical method with its default settings.
    pub const NEWTON: Self = Self::Newton { segments: Self::DEFAULT_SEGMENTS, envelopes: Envelopes::Both };

    /// Returns true if the number of pieces is in range.
    pub(crate) fn is_valid(self) -> bool {
        match self {
            Self::Certified => true,
            Self::Newton { segments, .. } => Self::SEGMENTS.contains(&segments),
        }
    }
}

impl Packer {
    /// Adds the segments of the body added last, whose pieces begin at `first_piece`, as the primitives
    /// that rays meet.
    pub(super) fn add_segments(
        &mut self,
        curves: &[Curve],
        mut first_piece: usize,
        render_from_unit: &DAffine3,
        segments: u32,
        envelopes: Envelopes,
    ) {
        for (i, curve) in curves.iter().enumerate() {
            let along = [i, i + 1].map(|end| (end as f64 / curves.len() as f64) as f32);
            // The middle of a piece is well inside its segment.
            let inside = |piece: &&RevolutionPiece| 0.5 * (piece.along[0] + piece.along[1]) < along[1];
            let pieces = self.revolution_pieces[first_piece..].iter().take_while(inside);
            let boxes: Vec<Aabb> = pieces.map(|piece| bounds(piece, render_from_unit)).collect();
            if boxes.is_empty() {
                continue; // a segment without length
            }
            let reference = REVOLUTION << KIND_SHIFT | self.revolution_segments.len() as u32;
            let starts = starts(curve, segments, envelopes);
            self.revolution_segments.push(RevolutionSegment {
                body: self.revolutions.len() as u32 - 1,
                degree: 2 * curve.degree() as u32,
                first_piece: first_piece as u32,
                piece_count: boxes.len() as u32,
                first_start: self.newton_starts.len() as u32,
                start_count: starts.len() as u32,
                along,
                powers: powers(curve),
            });
            self.newton_starts.extend(starts);
            first_piece += boxes.len();
            self.add_primitive(reference, boxes.iter().fold(Aabb::empty(), |whole, part| whole.union(part)));
        }
    }
}

/// Returns the coefficients of powers of t of the squared radius, the squared height, the radius and the
/// height.
fn powers(curve: &Curve) -> [[f32; 4]; NEWTON_COEFFICIENTS as usize] {
    let mut powers = [[0.0; 4]; NEWTON_COEFFICIENTS as usize];
    let point = curve.powers();
    let mut squares = vec![DVec2::ZERO; 2 * point.len() - 1];
    for (i, a) in point.iter().enumerate() {
        for (j, b) in point.iter().enumerate() {
            squares[i + j] += *a * *b;
        }
    }
    for (i, power) in powers.iter_mut().enumerate() {
        let of = |list: &[DVec2]| list.get(i).copied().unwrap_or_default().as_vec2();
        let (square, plain) = (of(&squares), of(&point));
        *power = [square.x, square.y, plain.x, plain.y];
    }
    powers
}

/// Returns the vertices of the approximations of a segment, one approximation after the other.
fn starts(curve: &Curve, segments: u32, envelopes: Envelopes) -> Vec<NewtonStart> {
    let mut starts = Vec::new();
    if envelopes != Envelopes::Tangent {
        starts.extend((0..=segments).map(|i| start(curve, f64::from(i) / f64::from(segments))));
    }
    if envelopes != Envelopes::Chord {
        starts.push(start(curve, 0.0));
        for i in 0..segments {
            let ends = [i, i + 1].map(|end| f64::from(end) / f64::from(segments));
            let middle = 0.5 * (ends[0] + ends[1]);
            let vertex = start(curve, middle);
            let point = tangents_meet(curve, ends).map_or(vertex.point, |point| point.as_vec2().to_array());
            starts.push(NewtonStart { point, ..vertex });
        }
        starts.push(start(curve, 1.0));
    }
    starts
}

fn start(curve: &Curve, t: f64) -> NewtonStart {
    NewtonStart { point: curve.at(t).as_vec2().to_array(), t: t as f32, pad: 0.0 }
}

/// Returns the point where the tangents at two parameters intersect, if it is between them. There is none
/// if the curve is straight, has a point of inflection or has a zero derivative.
fn tangents_meet(curve: &Curve, ends: [f64; 2]) -> Option<DVec2> {
    let [from, to] = ends.map(|t| curve.at(t));
    let derivative = Curve { points: curve.hodograph() };
    let [forward, onward] = ends.map(|t| derivative.at(t));
    let sine = forward.perp_dot(onward);
    let chord = to - from;
    let [before, after] = [chord.perp_dot(onward) / sine, forward.perp_dot(chord) / sine];
    let meet = sine.abs() > 1e-9 * forward.length() * onward.length() && before >= 0.0 && after >= 0.0;
    meet.then(|| from + forward * before)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::geometry::bezier::MAX_DEGREE;

    fn curves() -> impl Strategy<Value = Curve> {
        prop::collection::vec((0.0..1.0, -1.0..1.0), 2..=MAX_DEGREE + 1)
            .prop_map(|points| Curve { points: points.into_iter().map(DVec2::from).collect() })
    }

    fn point(start: &NewtonStart) -> DVec2 {
        DVec2::new(start.point[0].into(), start.point[1].into())
    }

    proptest! {
        #[test]
        fn powers_are_the_curve_and_its_squares(curve in curves(), t in 0.0..1.0) {
            let powers = powers(&curve);
            let sum = powers.iter().rev().fold([0.0; 4], |sum: [f64; 4], power| {
                std::array::from_fn(|i| sum[i] * t + f64::from(power[i]))
            });
            let p = curve.at(t);
            for (i, expected) in [p.x * p.x, p.y * p.y, p.x, p.y].into_iter().enumerate() {
                // Each coefficient is rounded to f32, by half a unit of its last place. Coefficients
                // alternate in sign: they may be millions although their sum is below one.
                let size: f64 = powers.iter().map(|power| f64::from(power[i].abs())).sum();
                let rounding = 0.5 * f64::from(f32::EPSILON) * size + 1e-6;
                prop_assert!((sum[i] - expected).abs() < rounding, "{} is not {expected}", sum[i]);
            }
        }

        #[test]
        fn chords_end_on_the_curve(curve in curves(), segments in RevolutionSolver::SEGMENTS) {
            let starts = starts(&curve, segments, Envelopes::Chord);
            prop_assert_eq!(starts.len(), segments as usize + 1);
            for start in &starts {
                prop_assert!((point(start) - curve.at(start.t.into())).length() < 1e-5);
            }
        }

        #[test]
        fn both_are_chords_then_tangents(curve in curves(), segments in RevolutionSolver::SEGMENTS) {
            let [chord, tangent, both] =
                [Envelopes::Chord, Envelopes::Tangent, Envelopes::Both].map(|which| starts(&curve, segments, which));
            prop_assert_eq!(tangent.len(), segments as usize + 2);
            prop_assert_eq!([chord, tangent.clone()].concat(), both);
            prop_assert!(tangent.windows(2).all(|pair| pair[0].t < pair[1].t));
            prop_assert!(tangent.iter().all(|start| point(start).is_finite()));
        }
    }

    /// A quarter of a circle: the corners lie outside, by at most the sagitta of half a piece.
    #[test]
    fn tangents_of_a_convex_profile_lie_outside() {
        let points = [(1.0, 0.0), (1.0, 0.5523), (0.5523, 1.0), (0.0, 1.0)];
        let curve = Curve { points: points.map(DVec2::from).into() };
        let tangents = starts(&curve, 8, Envelopes::Tangent);
        for start in &tangents[1..9] {
            let outside = point(start).length() - curve.at(start.t.into()).length();
            assert!(outside > 1e-4 && outside < 0.01, "{start:?} is {outside} outside");
        }
        for pair in tangents.windows(2) {
            // Each side touches the curve at its parameter, or ends there.
            let side = point(&pair[1]) - point(&pair[0]);
            let touched = [0.0, 1.0].into_iter().chain((1..8).map(|i| f64::from(i) / 8.0)).any(|t| {
                let to = curve.at(t) - point(&pair[0]);
                to.perp_dot(side).abs() < 1e-6 * side.length()
                    && (-1e-6..=1.0 + 1e-6).contains(&(to.dot(side) / side.length_squared()))
            });
            assert!(touched, "{pair:?}");
        }
    }

    #[test]
    fn straight_profiles_have_tangents_too() {
        let points = [(0.5, -1.0), (0.5, -0.5), (0.5, 1.0)];
        let curve = Curve { points: points.map(DVec2::from).into() };
        for start in starts(&curve, 4, Envelopes::Tangent) {
            assert!((point(&start) - curve.at(start.t.into())).length() < 1e-6, "{start:?}");
        }
    }
}
