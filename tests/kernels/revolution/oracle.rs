//! All points where a line meets a body of revolution, from the exact fp32 numbers that the
//! kernels get.
//!
//! Where the line is at the height v(x), its distance from the axis is the radius u(x) if
//!     F(x) = dz^2 u^2 - (dx v + A)^2 - (dy v + B)^2 = 0,
//! with A = ox dz - oz dx and B = oy dz - oz dy: a polynomial of twice the profile's degree.
//! Its roots are isolated, with numbers of 106 bits where f64 does not tell a sign; a
//! horizontal line has the roots of v(x) = oz.
//!
//! Neighbouring pieces agree to rounding only. The last [`SEAM`] of either is left out, and
//! a root is required there if its ends are on different sides of the line.

use glam::{DVec2, DVec3};

use crate::fixture::Rng;
use crate::generated::RevolutionPiece;
use crate::revolution::isolate::{Bracket, Isolation, Kind, MOST, Row, bernstein, product, refine};
use crate::revolution::line::{Line, Point, Terms};
use crate::revolution::wide::{Number, Wide};

/// How much of a piece belongs to the seam with its neighbour, in unit space: several times
/// what rounding of nine coefficients moves a piece's end.
const SEAM: f64 = 1e-6;
/// The longest stay inside that fp32 need not see, in unit space.
const SLIVER: f64 = 4e-6;

#[derive(Clone, Copy, Debug)]
pub struct Root {
    /// In lengths of the line's direction.
    pub k: f64,
    /// Of the normal and the direction, in render space. At a seam the lesser of both sides',
    /// 0 if they differ in sign.
    pub cosine: f64,
    /// fp32 must find it unless it grazes: it does not touch, nor cut a sliver.
    pub required: bool,
    /// Between two pieces, where k is known to [`SEAM`] only.
    pub at_seam: bool,
}

/// Bernstein coefficients between the seams of a piece: of u^2, v^2 and v, all with the
/// degree of u^2, and of v with its own.
struct Rows<T> {
    radius2: Row<T>,
    height2: Row<T>,
    raised: Row<T>,
    height: Row<T>,
}

struct Piece {
    degree: usize,
    u: [f64; 9],
    v: [f64; 9],
    /// Where the seams begin.
    inner: [f64; 2],
    /// Least and most of u and of v.
    radii: [f64; 2],
    heights: [f64; 2],
    single: Rows<f64>,
    wide: Rows<Wide>,
    /// The largest of each of the rows.
    sizes: [f64; 4],
}

/// The gap between two pieces, or at the axis, between a piece and its mirror image.
struct Seam {
    pieces: [usize; 2],
    before: Point,
    after: Option<Point>,
}

/// A body, scaled to render space by `scale` across and along the axis.
pub struct Oracle {
    pieces: Vec<Piece>,
    seams: Vec<Seam>,
    scale: [f64; 2],
}

impl Rows<Wide> {
    fn new(radius: &[Wide], height: &[Wide]) -> Self {
        let row = |coefficients: &[Wide]| {
            let mut row = [Wide::of(0.0); MOST];
            row[..coefficients.len()].copy_from_slice(coefficients);
            row
        };
        let ones = vec![Wide::of(1.0); height.len()];
        Self {
            radius2: row(&product(radius, radius)),
            height2: row(&product(height, height)),
            raised: row(&product(height, &ones)),
            height: row(height),
        }
    }

    fn single(&self) -> Rows<f64> {
        let single = |row: &Row<Wide>| row.map(Number::value);
        Rows {
            radius2: single(&self.radius2),
            height2: single(&self.height2),
            raised: single(&self.raised),
            height: single(&self.height),
        }
    }
}

impl<T: Number> Rows<T> {
    /// Coefficients of F.
    fn combine(&self, terms: &Terms<T>) -> Row<T> {
        std::array::from_fn(|i| {
            self.radius2[i] * terms.dz2 - self.height2[i] * terms.a - self.raised[i] * terms.slope - terms.constant
        })
    }

    /// Coefficients of v less a height.
    fn over(&self, height: f64) -> Row<T> {
        self.height.map(|v| v - T::of(height))
    }
}

impl Piece {
    fn new(piece: &RevolutionPiece) -> Self {
        let (mut u, mut v) = ([0.0; 9], [0.0; 9]);
        for i in 0..9 {
            let pair = piece.coefficients[i / 2];
            (u[i], v[i]) = (f64::from(pair[2 * (i % 2)]), f64::from(pair[2 * (i % 2) + 1]));
        }
        let degree = (1..9).rev().find(|i| u[*i] != 0.0 || v[*i] != 0.0).unwrap_or(1);
        let seam = |end: f64| {
            let corner = evaluate(&u, &v, degree, end);
            let mut part = 0.25;
            loop {
                if evaluate(&u, &v, degree, end * (1.0 - part)).distance(&corner) <= 2.0 * SEAM {
                    return part;
                }
                part *= 0.5;
            }
        };
        let inner = [seam(-1.0) - 1.0, 1.0 - seam(1.0)];
        let wide = Rows::new(&bernstein(&u[..=degree], inner), &bernstein(&v[..=degree], inner));
        let single = wide.single();
        let largest = |row: &Row<f64>| row.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
        let sizes = [&single.radius2, &single.height2, &single.raised, &single.height].map(largest);
        let [u0, v0, u1, v1] = piece.ends.map(f64::from);
        let (radii, heights) = ([u0.min(u1), u0.max(u1)], [v0.min(v1), v0.max(v1)]);
        Self { degree, inner, radii, heights, single, wide, sizes, u, v }
    }

    fn at(&self, x: f64) -> Point {
        evaluate(&self.u, &self.v, self.degree, x)
    }

    /// Parts of the piece with a root of F or, if horizontal, of v = oz.
    fn isolate(&self, line: &Line, found: &mut Vec<Bracket>) {
        let count = if line.horizontal { self.degree + 1 } else { 2 * self.degree + 1 };
        let size = if line.horizontal {
            self.sizes[3] + line.height().abs()
        } else {
            let terms = &line.single;
            terms.dz2 * self.sizes[0]
                + terms.a * self.sizes[1]
                + terms.slope.abs() * self.sizes[2]
                + terms.constant.abs()
        };
        let mut isolation = Isolation { size, found };
        let certain = if line.horizontal {
            isolation.run(&self.single.over(line.height())[..count])
        } else {
            isolation.run(&self.single.combine(&line.single)[..count])
        };
        if !certain {
            isolation.found.clear();
            if line.horizontal {
                isolation.run(&self.wide.over(line.height())[..count]);
            } else {
                isolation.run(&self.wide.combine(&line.wide)[..count]);
            }
        }
    }

    /// Ray parameters of a root in a bracket: both of them on a horizontal line.
    fn solve(&self, line: &Line, bracket: &Bracket, mut add: impl FnMut(Point, f64)) {
        let [from, to] = [bracket.from, bracket.to].map(|s| self.inner[0] + (self.inner[1] - self.inner[0]) * s);
        if line.horizontal {
            let x = refine([from, to], bracket.kind, |x| {
                let point = self.at(x);
                [point.v - line.height(), point.dv]
            });
            let point = self.at(x);
            if let Some(chord) = line.chord(point.u) {
                for side in [-1.0, 1.0] {
                    add(point, line.at_radius(chord, side));
                }
            }
            return;
        }
        let mut x = refine([from, to], bracket.kind, |x| line.value(&self.at(x)));
        let mut point = self.at(x);
        let mut k = line.at_height(point.v);
        let side = line.side(k);
        for _ in 0..3 {
            // Where the hyperbola is steep, the radius gives k, and x, with fewer errors.
            let Some(chord) = line.chord(point.u).filter(|chord| *chord > line.direction.z.abs() * point.u) else {
                break;
            };
            k = line.at_radius(chord, side);
            let [value, slope] = line.height_over(&point, chord, side);
            x = (x - value / slope).clamp(from, to);
            point = self.at(x);
        }
        add(point, k);
    }
}

fn evaluate(u: &[f64; 9], v: &[f64; 9], degree: usize, x: f64) -> Point {
    let mut point = Point::default();
    let mut i = degree + 1;
    // Iterators would be half of the test's time, so little optimised.
    while i > 0 {
        i -= 1;
        point.du = point.du * x + point.u;
        point.dv = point.dv * x + point.v;
        point.u = point.u * x + u[i];
        point.v = point.v * x + v[i];
    }
    point
}

impl Oracle {
    pub fn new(pieces: &[RevolutionPiece], scale: [f64; 2]) -> Self {
        let solved: Vec<_> = pieces.iter().map(Piece::new).collect();
        let mut seams = Vec::new();
        let count = pieces.len();
        for (i, piece) in pieces.iter().enumerate() {
            let next = (i + 1) % count;
            let first = solved[i].at(solved[i].inner[0]);
            let last = solved[i].at(solved[i].inner[1]);
            if piece.ends[0] == 0.0 {
                seams.push(Seam { pieces: [i, i], before: first, after: None });
            }
            if piece.ends[2] == 0.0 {
                seams.push(Seam { pieces: [i, i], before: last, after: None });
            } else if piece.ends[2..] == pieces[next].ends[..2] {
                let after = Some(solved[next].at(solved[next].inner[0]));
                seams.push(Seam { pieces: [i, next], before: last, after });
            }
        }
        Self { pieces: solved, seams, scale }
    }

    /// All roots of a line, by k.
    pub fn solve(&self, line: &Line) -> Vec<Root> {
        let mut roots = Vec::new();
        let mut near = Vec::new();
        let mut brackets = Vec::new();
        for (i, piece) in self.pieces.iter().enumerate() {
            if line.misses_ring(piece.radii, piece.heights) {
                continue;
            }
            near.push(i);
            brackets.clear();
            piece.isolate(line, &mut brackets);
            for bracket in &brackets {
                piece.solve(line, bracket, |point, k| {
                    let cosine = line.cosine(&point, k, self.scale);
                    roots.push(Root { k, cosine, required: bracket.kind != Kind::Touching, at_seam: false });
                });
            }
        }
        for seam in self.seams.iter().filter(|seam| seam.pieces.iter().any(|piece| near.binary_search(piece).is_ok())) {
            self.cross_seam(seam, line, &mut roots);
        }
        roots.sort_by(|a, b| a.k.total_cmp(&b.k));
        self.spare_slivers(line, &mut roots);
        roots
    }

    /// A line that leaves again so soon has not been in deeper than rounding.
    fn spare_slivers(&self, line: &Line, roots: &mut [Root]) {
        for i in 1..roots.len() {
            let (before, after) = (roots[i - 1], roots[i]);
            if (after.k - before.k) * line.direction.length() < SLIVER && before.cosine * after.cosine <= 0.0 {
                roots[i - 1].required = false;
                roots[i].required = false;
            }
        }
    }

    fn cross_seam(&self, seam: &Seam, line: &Line, roots: &mut Vec<Root>) {
        let before = &seam.before;
        let inside = |point: &Point| line.rho(line.at_height(point.v)) < point.u;
        let Some(after) = &seam.after else {
            // The line goes through the ring where the seam begins, and so through its cap.
            if !line.horizontal && inside(before) {
                let cosine = line.cosine_on_axis(before, self.scale);
                roots.push(Root { k: line.at_height(before.v), cosine, required: true, at_seam: true });
            }
            return;
        };
        let mut add = |k: f64| {
            let [one, other] = [before, after].map(|point| line.cosine(point, k, self.scale));
            let lesser = if one.abs() < other.abs() { one } else { other };
            let cosine = if one * other > 0.0 { lesser } else { 0.0 };
            roots.push(Root { k, cosine, required: true, at_seam: true });
        };
        let chords = [before, after].map(|point| line.chord(point.u));
        if let [Some(first), Some(last)] = chords
            && first + last >= line.direction.z.abs() * (before.u + after.u)
        {
            for side in [-1.0, 1.0] {
                let above = |point, chord| line.height_over(point, chord, side)[0] > 0.0;
                if above(before, first) != above(after, last) {
                    add(line.at_radius(0.5 * (first + last), side));
                }
            }
        } else if !line.horizontal && inside(before) != inside(after) {
            add(line.at_height(0.5 * (before.v + after.v)));
        }
    }

    /// A tangent of a random meridian in render space: where it touches, and its direction.
    pub fn tangent(&self, rng: &mut Rng, azimuth: DVec2) -> (DVec3, DVec3) {
        let piece = &self.pieces[rng.below(self.pieces.len())];
        let point = piece.at(rng.range(-1.0, 1.0));
        let [across, along] = self.scale;
        let place = (across * point.u * azimuth).extend(along * point.v);
        (place, (across * point.du * azimuth).extend(along * point.dv).normalize_or(DVec3::Z))
    }

    /// Radius and height of an end of some piece, in render space.
    pub fn end(&self, rng: &mut Rng) -> [f64; 2] {
        let piece = &self.pieces[rng.below(self.pieces.len())];
        let end = rng.below(2);
        [self.scale[0] * piece.radii[end], self.scale[1] * piece.heights[end]]
    }

    /// What a root that was found is worth: its cosine, how far the point of the line is from
    /// that of the surface, in render space, and whether this is at a seam or an open end.
    pub fn judge(&self, line: &Line, k: f64, piece: u32, x: f64) -> (f64, f64, bool) {
        let piece = &self.pieces[piece as usize];
        let point = piece.at(x);
        let [across, along] = self.scale;
        let (radial, axial) = (line.rho(k) - point.u, line.origin.z + k * line.direction.z - point.v);
        let off = (across * radial).abs().max((along * axial).abs());
        let at_seam = [-1.0, 1.0].into_iter().any(|end| piece.at(end).distance(&point) <= 4.0 * SEAM);
        (line.cosine(&point, k, self.scale), off, at_seam)
    }
}
