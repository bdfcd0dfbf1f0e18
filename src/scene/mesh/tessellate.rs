//! Tessellation of bodies of revolution, for renderers that do not know the shape.
//!
//! The mesh has two errors, each at most half the tolerance. Along the profile, a stretch becomes a chord
//! as soon as its control points are near enough to that chord: the curve lies in their hull, and its
//! projection covers the chord, so that the distance between curve and chord is bounded in both directions.
//! Around the axis, circles become polygons with the same number of corners at every height, so that the
//! mesh has no gaps; the sagitta of the widest circle is the error.

mod mesh;
#[cfg(test)]
mod tests;

use glam::DVec2;

use crate::geometry::bezier::Curve;
use crate::scene::Profile;

pub use mesh::Vertex;

/// Minimum and maximum tolerance of [`Tessellation::new`], relative to the body's size.
pub const TOLERANCES: [f64; 2] = [1e-7, 0.1];
/// Maximum number of triangles of a mesh: about 1.3 GB as a file.
pub const MAX_TRIANGLES: u64 = 50_000_000;

/// Minimum number of sectors: fewer are visible as corners even on a thin body.
const LEAST_SECTORS: u32 = 12;
/// Cosine of the largest angle by which the profile may turn along a chord, 30°: normals are interpolated
/// along it.
const MOST_TURN: f64 = 0.866;
/// A stretch that bends by less than this fraction of the size is straight; changes of its direction are
/// rounding.
const STRAIGHT: f64 = 1e-12;
/// Joints whose directions differ by less than this angle, in radians, are smooth.
const SMOOTH: f64 = 1e-4;
/// A control point coincides with an end if its distance is below this fraction of the largest distance.
const COINCIDENT: f64 = 1e-6;
/// Maximum number of halvings: more of them change nothing, and the recursion must end for every input.
const MAX_DEPTH: u32 = 40;

/// The error that a profile's mesh would have more than [`MAX_TRIANGLES`] triangles.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "a mesh within {tolerance:e} of the body's size has {triangles} triangles; expected at most {MAX_TRIANGLES}{}",
    .fitting.as_ref().map_or_else(String::new, |fitting| format!(", as a tolerance of {fitting} gives"))
)]
pub struct TooFine {
    /// The requested tolerance.
    pub tolerance: f64,
    /// Number of triangles that the tolerance requires.
    pub triangles: u64,
    /// The smallest round tolerance that gives few enough triangles; `None` if no tolerance up to the
    /// maximum of [`TOLERANCES`] does.
    pub fitting: Option<String>,
}

/// A mesh of a body of revolution, in the body's object space: rings of vertices, and the
/// bands between them.
///
/// Vertices are shared within a smooth stretch of the profile. A crease has two vertices at each place,
/// each with its own normal; the seam has two for its texture coordinates. Where the profile meets the
/// axis, every sector has its own vertex.
#[derive(Clone, Debug)]
pub struct Tessellation {
    /// Smooth stretches of the profile, each of two rings or more.
    strips: Vec<Vec<Ring>>,
    /// Number of sectors around the axis.
    sectors: u32,
    /// Whether normals and windings are reversed.
    inside_out: bool,
}

/// A circle of vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ring {
    /// Radius; 0 if the profile is on the axis.
    radius: f64,
    height: f64,
    /// Normal along the radius and the axis, unit length.
    normal: DVec2,
    /// Position on the whole profile, in [0, 1].
    along: f64,
}

/// A stretch of the profile that is approximated by a straight line.
#[derive(Clone, Copy, Debug)]
struct Chord {
    ends: [DVec2; 2],
    /// Direction of the profile at each end; unit length.
    directions: [DVec2; 2],
    /// Positions of the ends on the whole profile, in [0, 1].
    along: [f64; 2],
}

impl Tessellation {
    /// Returns a mesh whose distance from the true surface is at most `tolerance`, measured from either to
    /// the other. The unit of `tolerance` is the body's size: the larger of its diameter and its height. A
    /// tolerance outside of [`TOLERANCES`] is clamped. `inside_out` reverses normals and windings.
    ///
    /// # Errors
    /// The mesh would have more than [`MAX_TRIANGLES`] triangles.
    pub fn new(profile: &Profile, tolerance: f64, inside_out: bool) -> Result<Self, TooFine> {
        let outline = Outline::of(profile);
        let [least, most] = TOLERANCES;
        let tolerance = if tolerance.is_nan() { least } else { tolerance.clamp(least, most) };
        let mesh = outline.mesh(tolerance, inside_out);
        let triangles = mesh.triangle_count();
        if triangles <= MAX_TRIANGLES {
            return Ok(mesh);
        }
        let fits = |text: &String| {
            text.parse().is_ok_and(|coarser| {
                coarser > tolerance && outline.mesh(coarser, inside_out).triangle_count() <= MAX_TRIANGLES
            })
        };
        let round_numbers = (-7..=-1).flat_map(|power| [1, 2, 5].map(|digit| format!("{digit}e{power}")));
        let fitting = round_numbers.take_while(|text| text != "2e-1").find(fits);
        Err(TooFine { tolerance, triangles, fitting })
    }
}

/// A profile in stretches on which radius and height are monotone: a stretch turns by at most a right
/// angle, and cusps are at its ends.
struct Outline {
    /// Stretches, with the positions on the whole profile where each begins and ends. Heights are relative
    /// to `middle`, so that rounding is relative to the size and not to the height.
    stretches: Vec<(Curve, [f64; 2])>,
    middle: f64,
    /// Size of the body: the larger of diameter and height.
    size: f64,
}

impl Outline {
    fn of(profile: &Profile) -> Self {
        let heights = || profile.segments.iter().flat_map(|segment| &segment.points).map(|point| point.y);
        let middle = 0.5 * (heights().fold(f64::INFINITY, f64::min) + heights().fold(f64::NEG_INFINITY, f64::max));
        let mut stretches = Vec::new();
        for (i, segment) in profile.segments.iter().enumerate() {
            let points = segment.points.iter().map(|point| DVec2::new(point.x, point.y - middle)).collect();
            for stretch in (Curve { points }).monotone_stretches(1.0) {
                let along = stretch.range.map(|t| (i as f64 + t) / profile.segments.len() as f64);
                stretches.push((stretch.curve, along));
            }
        }
        let ends = || stretches.iter().flat_map(|(curve, _)| ends(curve));
        let least = ends().fold(DVec2::INFINITY, DVec2::min);
        let most = ends().fold(DVec2::NEG_INFINITY, DVec2::max);
        Self { size: (2.0 * most.x).max(most.y - least.y), stretches, middle }
    }

    fn mesh(&self, tolerance: f64, inside_out: bool) -> Tessellation {
        let bound = 0.5 * tolerance * self.size;
        let mut chords = Vec::new();
        for (curve, along) in &self.stretches {
            self.halve(curve, *along, bound, 0, &mut chords);
        }
        let mut strips = strips(&chords);
        let rings = || strips.iter().flatten();
        let sectors = sectors(rings().map(|ring| ring.radius).fold(0.0, f64::max), bound);
        strips.iter_mut().flatten().for_each(|ring| ring.height += self.middle);
        Tessellation { strips, sectors, inside_out }
    }

    /// Cuts a stretch into chords whose distance from it is at most `bound`.
    fn halve(&self, curve: &Curve, along: [f64; 2], bound: f64, depth: u32, chords: &mut Vec<Chord>) {
        let bend = bend(curve);
        let directions = [direction(curve.points.iter()), -direction(curve.points.iter().rev())];
        let turns_little = bend <= STRAIGHT * self.size || directions[0].dot(directions[1]) >= MOST_TURN;
        if bend <= bound && turns_little || depth >= MAX_DEPTH {
            chords.push(Chord { ends: ends(curve), directions, along });
            return;
        }
        let middle = 0.5 * (along[0] + along[1]);
        let [before, after] = curve.split(0.5);
        self.halve(&before, [along[0], middle], bound, depth + 1, chords);
        self.halve(&after, [middle, along[1]], bound, depth + 1, chords);
    }
}

fn ends(curve: &Curve) -> [DVec2; 2] {
    [curve.points[0], curve.points[curve.degree()]]
}

/// Returns the largest distance of the control points from the chord, an upper bound of the curve's
/// distance.
fn bend(curve: &Curve) -> f64 {
    let [start, end] = ends(curve);
    let chord = end - start;
    let squared = chord.length_squared();
    let distance = |point: &DVec2| {
        let t = if squared > 0.0 { ((*point - start).dot(chord) / squared).clamp(0.0, 1.0) } else { 0.0 };
        (*point - start - chord * t).length()
    };
    curve.points.iter().map(distance).fold(0.0, f64::max)
}

/// Returns the unit direction in which a curve leaves the first of its control points: towards the next one
/// at another place, which is the limit of the tangent even if the derivative vanishes.
fn direction<'a>(points: impl Iterator<Item = &'a DVec2> + Clone) -> DVec2 {
    let Some(start) = points.clone().next() else { return DVec2::ZERO };
    let steps = points.map(|point| *point - *start);
    let farthest = steps.clone().map(DVec2::length).fold(0.0, f64::max);
    let first = steps.clone().find(|step| step.length() > COINCIDENT * farthest);
    first.unwrap_or_default().normalize_or_zero()
}

/// Joins chords into smooth strips of rings.
fn strips(chords: &[Chord]) -> Vec<Vec<Ring>> {
    let mut strips: Vec<Vec<Ring>> = Vec::new();
    // End and direction of the last strip, unless a gap follows it.
    let mut joint: Option<(DVec2, DVec2)> = None;
    for chord in chords {
        // A stretch begins where the previous one ended, except for rounding.
        let start = joint.map_or(chord.ends[0], |(end, _)| end);
        if start == chord.ends[1] {
            continue;
        }
        if start.x <= 0.0 && chord.ends[1].x <= 0.0 {
            joint = None;
            continue;
        }
        let [leaving, arriving] = chord.directions;
        let smooth = joint.filter(|(_, d)| d.dot(leaving) > 0.0 && d.perp_dot(leaving).abs() < SMOOTH);
        match (smooth, strips.last_mut().and_then(|strip| strip.last_mut())) {
            (Some((_, d)), Some(shared)) => shared.normal = normal((d + leaving).normalize_or_zero()),
            _ => strips.push(vec![ring(start, leaving, chord.along[0])]),
        }
        if let Some(strip) = strips.last_mut() {
            strip.push(ring(chord.ends[1], arriving, chord.along[1]));
        }
        joint = Some((chord.ends[1], arriving));
    }
    strips
}

fn ring(point: DVec2, direction: DVec2, along: f64) -> Ring {
    Ring { radius: point.x.max(0.0), height: point.y, normal: normal(direction), along }
}

/// Returns the normal to the right of the direction of travel.
fn normal(direction: DVec2) -> DVec2 {
    DVec2::new(direction.y, -direction.x)
}

/// Returns the number of sectors that keeps the sagitta `r (1 - cos(π / n)) = 2 r sin²(π / 2n)` within the
/// bound.
fn sectors(radius: f64, bound: f64) -> u32 {
    let half_angle = (bound / (2.0 * radius)).sqrt().min(1.0).asin();
    let least = (std::f64::consts::FRAC_PI_2 / half_angle).ceil();
    (least as u32).max(LEAST_SECTORS)
}
