//! A line as it goes around an axis: a hyperbola in the half plane of (radius, height).

use glam::DVec3;

use crate::revolution::wide::{Number, Wide};

/// Pieces are left out that are farther than this from a line.
const MARGIN: f64 = 1e-5;
/// Directions this near to the horizontal are horizontal: 1e-10 over the longest ray.
const HORIZONTAL: f64 = 1e-12;

/// A point of a profile and its derivative.
#[derive(Clone, Copy, Debug, Default)]
pub struct Point {
    pub u: f64,
    pub v: f64,
    pub du: f64,
    pub dv: f64,
}

impl Point {
    /// The larger of both differences.
    pub fn distance(&self, other: &Self) -> f64 {
        (self.u - other.u).abs().max((self.v - other.v).abs())
    }
}

/// F = dz^2 u^2 - a v^2 - slope v - constant.
#[derive(Clone, Copy)]
pub struct Terms<T> {
    pub dz2: T,
    pub a: T,
    pub slope: T,
    pub constant: T,
}

/// A ray in unit space; `k` counts its directions.
pub struct Line {
    pub origin: DVec3,
    pub direction: DVec3,
    /// Whether the height changes too little to matter.
    pub horizontal: bool,
    pub wide: Terms<Wide>,
    pub single: Terms<f64>,
    a: f64,
    /// Squared distance from the axis times `a`, and where it is reached.
    moment2: f64,
    closest: f64,
    /// Squared distance from the axis.
    base: f64,
}

impl Line {
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let (o, d) = (origin, direction);
        let square = |x: f64| Wide::product(x, x);
        let at_height_0 = |o_side: f64, d_side: f64| Wide::product(o_side, d.z) - Wide::product(o.z, d_side);
        let (x0, y0) = (at_height_0(o.x, d.x), at_height_0(o.y, d.y));
        let wide = Terms {
            dz2: square(d.z),
            a: square(d.x) + square(d.y),
            slope: (x0 * Wide::of(d.x) + y0 * Wide::of(d.y)) * Wide::of(2.0),
            constant: x0 * x0 + y0 * y0,
        };
        let a = wide.a.value();
        let moment = (Wide::product(o.x, d.y) - Wide::product(o.y, d.x)).value();
        let along = o.x * d.x + o.y * d.y;
        let vertical = a == 0.0;
        Self {
            origin,
            direction,
            horizontal: d.z.abs() <= HORIZONTAL * d.length(),
            single: Terms { dz2: wide.dz2.value(), a, slope: wide.slope.value(), constant: wide.constant.value() },
            wide,
            a,
            moment2: moment * moment,
            closest: if vertical { 0.0 } else { -along / a },
            base: if vertical { o.x * o.x + o.y * o.y } else { moment * moment / a },
        }
    }

    /// The distance from the axis.
    pub fn rho(&self, k: f64) -> f64 {
        (self.a * (k - self.closest).powi(2) + self.base).sqrt()
    }

    /// Where a line that is not horizontal has a height.
    pub fn at_height(&self, v: f64) -> f64 {
        (v - self.origin.z) / self.direction.z
    }

    /// The height of a horizontal line.
    pub fn height(&self) -> f64 {
        self.origin.z + self.direction.z * self.closest
    }

    /// sqrt(a) times half the chord of a cylinder, if the line meets it.
    pub fn chord(&self, u: f64) -> Option<f64> {
        let chord2 = (self.a.sqrt() * u - self.moment2.sqrt()) * (self.a.sqrt() * u + self.moment2.sqrt());
        (chord2 > 0.0).then(|| chord2.sqrt())
    }

    /// Where the line enters (side -1) or leaves (side 1) a cylinder.
    pub fn at_radius(&self, chord: f64, side: f64) -> f64 {
        self.closest + side * chord / self.a
    }

    /// Which of the two is nearer.
    pub fn side(&self, k: f64) -> f64 {
        if k < self.closest { -1.0 } else { 1.0 }
    }

    /// F and its derivative.
    pub fn value(&self, p: &Point) -> [f64; 2] {
        let (d, rise) = (self.direction, p.v - self.origin.z);
        let x = d.x * rise + self.origin.x * d.z;
        let y = d.y * rise + self.origin.y * d.z;
        let dz2 = d.z * d.z;
        let slope = dz2 * p.u * p.du - (x * d.x + y * d.y) * p.dv;
        [dz2 * p.u * p.u - x * x - y * y, 2.0 * slope]
    }

    /// Height over the line's branch, and its derivative.
    pub fn height_over(&self, p: &Point, chord: f64, side: f64) -> [f64; 2] {
        let z = self.origin.z + self.direction.z * self.at_radius(chord, side);
        [p.v - z, p.dv - self.direction.z * side * p.u * p.du / chord]
    }

    /// Whether the line passes by a ring, by more than rounding.
    pub fn misses_ring(&self, radii: [f64; 2], heights: [f64; 2]) -> bool {
        let [least, most] = [(radii[0] - MARGIN).max(0.0), radii[1] + MARGIN];
        let [bottom, top] = [heights[0] - MARGIN, heights[1] + MARGIN];
        if self.base > most * most {
            return true;
        }
        if self.horizontal {
            return self.height() < bottom || self.height() > top;
        }
        let (k0, k1) = (self.at_height(bottom), self.at_height(top));
        let rho2 = |k: f64| self.a * (k - self.closest).powi(2) + self.base;
        let nearest = self.closest.clamp(k0.min(k1), k0.max(k1));
        rho2(k0).max(rho2(k1)) < least * least || rho2(nearest) > most * most
    }

    /// Cosine between the normal at a point of the body and the direction, where unit space
    /// is scaled across and along the axis.
    pub fn cosine(&self, p: &Point, k: f64, [across, along]: [f64; 2]) -> f64 {
        let (o, d) = (self.origin, self.direction);
        let (x, y) = (o.x + k * d.x, o.y + k * d.y);
        let rho = x.hypot(y);
        let outward = if rho > 0.0 { (x * d.x + y * d.y) / rho } else { 0.0 };
        let normal = (along * p.dv).hypot(across * p.du);
        let size = (across * across * self.a + along * along * d.z * d.z).sqrt();
        across * along * (p.dv * outward - p.du * d.z) / (normal * size).max(f64::MIN_POSITIVE)
    }

    /// The least cosine, of any azimuth, on the axis.
    pub fn cosine_on_axis(&self, p: &Point, [across, along]: [f64; 2]) -> f64 {
        let normal = (along * p.dv).hypot(across * p.du);
        let size = (across * across * self.a + along * along * self.direction.z.powi(2)).sqrt();
        let (rise, spread) = (-p.du * self.direction.z, p.dv.abs() * self.a.sqrt());
        across * along * rise.signum() * (rise.abs() - spread).max(0.0) / (normal * size).max(f64::MIN_POSITIVE)
    }
}
