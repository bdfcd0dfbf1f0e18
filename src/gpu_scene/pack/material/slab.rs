//! Reflection of a scattering coat, by adding and doubling of layers (van de Hulst 1980, "Multiple Light
//! Scattering", chapter 4), averaged over azimuths.
//!
//! The slab absorbs and scatters light between a boundary above and a base below, as in pbrt-v4's layered BSDF, with
//! Henyey and Greenstein's phase function. Radiances are those inside the coat, at the cosines of [`Grid`]. A rough
//! boundary transmits and reflects the shares of light that its facets do, but in the directions of a smooth boundary.

use std::f64::consts::PI;

use super::boundary::shares;
use super::coat::fresnel;

/// Moments of the phase function; the rest of it is a peak straight on (delta-M, Wiscombe 1977).
const MOMENTS: usize = 12;
/// Nodes of Gauss's quadrature for cosines that total reflection keeps in the coat, and for the others.
const NODES: [usize; 2] = [6, 8];
/// log2 of the thickness of the first layer, which scatters once.
const FIRST_LAYER: f64 = -21.0;
/// Thicker coats look the same.
const MOST_THICKNESS: f64 = 128.0;
/// Largest magnitude of the mean cosine of scattering.
pub(super) const MOST_G: f64 = 0.95;
/// Cosines of a result: the nodes of Chebyshev's polynomial between the least cosine that leaves the coat and 1.
const COSINES: usize = 3;

/// The scattering of a coat's inside for one wavelength.
#[derive(Clone, Copy, Debug)]
pub(super) struct Medium {
    /// Thickness in mean free paths, 0 or more.
    pub thickness: f64,
    /// Share of the extinguished light that is scattered, 0 to 1.
    pub albedo: f64,
    /// Mean cosine of scattering, -1 to 1; its magnitude is limited to 0.95.
    pub g: f64,
}

/// What a coat does to diffuse light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    /// Upward radiance under the boundary over the radiance of a Lambertian base that reflects nothing, at
    /// the cosines of the result. A smooth boundary passes 1 - F of it; if the boundary is rough, the radiance is
    /// multiplied by what it passes over that.
    pub from_base: [f64; COSINES],
    /// Upward radiance under the boundary over the square of the index, if a radiance of 1 comes from all outer
    /// directions and the base is black. Times 1 - F it is the share of light that the coat scatters back.
    pub scattered: [f64; COSINES],
    /// Share of the base's light that comes back to it.
    pub sent_back: f64,
    /// Share of the base's light that leaves the coat.
    pub leaving: f64,
    /// Mean of the share of light that the coat scatters back, over the cosines of Lambertian light from outside.
    pub mean_scattered: f64,
}

/// Cosines inside a coat.
pub(super) struct Grid {
    cos: Vec<f64>,
    /// Weights of the quadrature over cosines; 0 at the last ones, which are those of the result.
    weight: Vec<f64>,
    /// Shares of light that the boundary reflects back into the coat, and passes.
    reflected: Vec<f64>,
    passed: Vec<f64>,
    /// Share of light from outside that a rough boundary passes, over that of a smooth one; at the result's cosines.
    entering: [f64; COSINES],
    /// Index of the coat over that outside.
    eta: f64,
}

impl Grid {
    /// Returns the grid of a coat with an index over that outside, and GGX's alpha of its boundary.
    pub fn new(eta: f64, alpha: f64) -> Self {
        let least = least_cosine(eta);
        let entering = std::array::from_fn(|i| {
            let inside = Self::cosine(eta, i);
            let outside = (1.0 - eta * eta * (1.0 - inside * inside)).max(0.0).sqrt();
            shares(outside, eta, alpha).1 / (1.0 - fresnel(outside, eta))
        });
        let mut grid =
            Self { cos: Vec::new(), weight: Vec::new(), reflected: Vec::new(), passed: Vec::new(), entering, eta };
        for (from, to, count) in [(0.0, least, NODES[0]), (least, 1.0, NODES[1])] {
            if to > from {
                for (x, weight) in gauss(count) {
                    grid.cos.push(from + (to - from) * 0.5 * (x + 1.0));
                    grid.weight.push(0.5 * (to - from) * weight);
                }
            }
        }
        grid.cos.extend((0..COSINES).map(|i| Self::cosine(eta, i)));
        grid.weight.resize(grid.cos.len(), 0.0);
        (grid.reflected, grid.passed) = grid.cos.iter().map(|cos| shares(*cos, 1.0 / eta, alpha)).unzip();
        grid
    }

    /// Returns the i-th cosine of the result.
    fn cosine(eta: f64, i: usize) -> f64 {
        let least = least_cosine(eta);
        let node = (PI * (i as f64 + 0.5) / COSINES as f64).cos();
        least + (1.0 - least) * 0.5 * (1.0 - node)
    }

    /// Returns what a coat of this grid's index with this inside does.
    pub fn response(&self, layer: &Layer) -> Response {
        let count = self.cos.len();
        let ones = vec![1.0; count];
        let inner = layer.reflection.clone().columns_times(&self.reflected).one_minus();
        let below = inner.solve(&layer.transmission.apply(&ones));
        let entered: Vec<f64> = self.passed.iter().map(|passed| self.eta * self.eta * passed).collect();
        let above = inner.solve(&layer.reflection.apply(&entered));
        let reflected: Vec<f64> = below.iter().zip(&self.reflected).map(|(u, f)| u * f).collect();
        let back = layer.transmission.apply(&reflected);
        let again = layer.reflection.apply(&ones);
        let flux = |value: &dyn Fn(usize) -> f64| {
            (0..count).map(|i| 2.0 * self.cos[i] * self.weight[i] * value(i)).sum::<f64>()
        };
        let at = |values: &[f64], scale: f64| {
            let mut result = [0.0; COSINES];
            let last = &values[count - result.len()..];
            for ((result, value), entering) in result.iter_mut().zip(last).zip(&self.entering) {
                *result = value * entering * scale;
            }
            result
        };
        Response {
            sent_back: flux(&|i| back[i] + again[i]),
            leaving: flux(&|i| self.passed[i] * below[i]),
            mean_scattered: flux(&|i| self.passed[i] * above[i]),
            from_base: at(&below, 1.0),
            scattered: at(&above, 1.0 / (self.eta * self.eta)),
        }
    }

    /// Returns the layer of a medium without its boundary: doubled from a layer that scatters once.
    pub fn layer(&self, medium: Medium) -> Layer {
        let g = medium.g.clamp(-MOST_G, MOST_G);
        let albedo = medium.albedo.clamp(0.0, 1.0);
        let peak = g.powi(MOMENTS as i32);
        let straight_on = albedo * peak;
        let thickness = (1.0 - straight_on) * medium.thickness.min(MOST_THICKNESS);
        let doublings = (thickness.max(f64::MIN_POSITIVE).log2() - FIRST_LAYER).ceil().max(0.0);
        let moments: Vec<f64> = (0..MOMENTS).map(|l| (g.powi(l as i32) - peak) / (1.0 - peak)).collect();
        let albedo = if straight_on < 1.0 { albedo * (1.0 - peak) / (1.0 - straight_on) } else { 0.0 };
        let mut layer = self.thin(thickness * (-doublings).exp2(), albedo, &moments);
        for _ in 0..doublings as u32 {
            layer = layer.doubled();
        }
        layer
    }

    /// Returns a layer in which light scatters at most once.
    fn thin(&self, thickness: f64, albedo: f64, moments: &[f64]) -> Layer {
        let count = self.cos.len();
        let polynomials: Vec<Vec<f64>> = self.cos.iter().map(|cos| legendre(*cos, moments.len())).collect();
        let (mut reflection, mut transmission) = (Matrix::zero(count), Matrix::zero(count));
        for (i, mu) in self.cos.iter().enumerate() {
            let direct = (-thickness / mu).exp();
            for (j, mu_in) in self.cos.iter().enumerate() {
                let (mut on, mut back) = (0.0, 0.0);
                for (l, moment) in moments.iter().enumerate() {
                    let term = (2 * l + 1) as f64 * moment * polynomials[i][l] * polynomials[j][l];
                    on += term;
                    back += if l % 2 == 0 { term } else { -term };
                }
                let share = 0.5 * albedo * self.weight[j] * thickness / mu;
                let both = thickness * (1.0 / mu + 1.0 / mu_in);
                *reflection.at(i, j) = share * back * exp_m1_over(-both);
                *transmission.at(i, j) = share * on * direct * exp_m1_over(thickness * (1.0 / mu - 1.0 / mu_in));
            }
            *transmission.at(i, i) += direct;
        }
        Layer { reflection, transmission }
    }
}

/// Returns the least cosine inside of a coat from which light can leave it.
fn least_cosine(eta: f64) -> f64 {
    (1.0 - 1.0 / (eta * eta)).max(0.0).sqrt()
}

/// Returns (exp(x) - 1) / x.
fn exp_m1_over(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.exp_m1() / x }
}

/// Returns Legendre's polynomials 0 to `count` - 1 at x.
fn legendre(x: f64, count: usize) -> Vec<f64> {
    let mut values = vec![1.0, x];
    for l in 2..count {
        let n = l as f64;
        values.push(((2.0 * n - 1.0) * x * values[l - 1] - (n - 1.0) * values[l - 2]) / n);
    }
    values
}

/// Returns nodes in [-1, 1] and weights of Gauss's quadrature.
fn gauss(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let node = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..10 {
            let values = legendre(x, count + 1);
            slope = n * (x * values[count] - values[count - 1]) / (x * x - 1.0);
            x -= values[count] / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

/// A layer that is the same from both sides: operators on radiances.
pub(super) struct Layer {
    reflection: Matrix,
    transmission: Matrix,
}

impl Layer {
    /// Returns two of these layers, one upon the other.
    pub fn doubled(&self) -> Self {
        let between = self.reflection.times(&self.reflection).one_minus();
        let down = between.solve_all(&self.transmission);
        let up = self.reflection.times(&down);
        let mut reflection = self.transmission.times(&up);
        reflection.values.iter_mut().zip(&self.reflection.values).for_each(|(sum, once)| *sum += once);
        Self { reflection, transmission: self.transmission.times(&down) }
    }
}

/// A square matrix, row by row.
#[derive(Clone)]
struct Matrix {
    size: usize,
    values: Vec<f64>,
}

impl Matrix {
    fn zero(size: usize) -> Self {
        Self { size, values: vec![0.0; size * size] }
    }

    fn at(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.values[row * self.size + column]
    }

    fn apply(&self, vector: &[f64]) -> Vec<f64> {
        let dot = |row: &[f64]| row.iter().zip(vector).map(|(a, b)| a * b).sum();
        self.values.chunks_exact(self.size).map(dot).collect()
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = Self::zero(self.size);
        let rows = product.values.chunks_exact_mut(self.size).zip(self.values.chunks_exact(self.size));
        for (out, row) in rows {
            for (factor, other) in row.iter().zip(other.values.chunks_exact(self.size)) {
                out.iter_mut().zip(other).for_each(|(out, other)| *out += factor * other);
            }
        }
        product
    }

    /// Returns the matrix with each column times a factor.
    fn columns_times(mut self, factors: &[f64]) -> Self {
        for row in self.values.chunks_exact_mut(self.size) {
            row.iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor);
        }
        self
    }

    /// Returns the unit matrix minus this one.
    fn one_minus(mut self) -> Self {
        self.values.iter_mut().for_each(|value| *value = -*value);
        for i in 0..self.size {
            *self.at(i, i) += 1.0;
        }
        self
    }

    fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut matrix = Self::zero(self.size);
        for (row, value) in right.iter().enumerate() {
            *matrix.at(row, 0) = *value;
        }
        let solved = self.solve_all(&matrix);
        solved.values.chunks_exact(self.size).map(|row| row[0]).collect()
    }

    /// Returns this matrix's inverse times another. Elimination needs no pivots: layers reflect less than all of the
    /// light, so that the diagonal dominates.
    fn solve_all(&self, right: &Self) -> Self {
        let size = self.size;
        let (mut left, mut right) = (self.clone(), right.clone());
        for i in 0..size {
            let pivot = left.values[i * size + i].recip();
            let left_row: Vec<f64> = left.values[i * size..][..size].iter().map(|value| value * pivot).collect();
            let right_row: Vec<f64> = right.values[i * size..][..size].iter().map(|value| value * pivot).collect();
            for other in (0..size).filter(|other| *other != i) {
                let factor = left.values[other * size + i];
                let rows = [(&mut left, &left_row), (&mut right, &right_row)];
                for (matrix, row) in rows {
                    let to = &mut matrix.values[other * size..][..size];
                    to.iter_mut().zip(row).for_each(|(to, from)| *to -= factor * from);
                }
            }
            left.values[i * size..][..size].copy_from_slice(&left_row);
            right.values[i * size..][..size].copy_from_slice(&right_row);
        }
        right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn media() -> impl Iterator<Item = Medium> {
        [0.0, 0.01, 0.7, 20.0, 1e9]
            .into_iter()
            .flat_map(|thickness| [-0.6, 0.0, 0.5, 1.0].map(|g| Medium { thickness, albedo: 1.0, g }))
    }

    /// Without absorption, light that meets the boundary is reflected, scattered back, or on the base.
    #[test]
    fn nothing_is_lost_without_absorption() {
        for eta in [0.8, 1.0, 1.3, 1.5, 2.4] {
            let grid = Grid::new(eta, 0.0);
            for medium in media() {
                let coat = grid.response(&grid.layer(medium));
                let whole = coat.sent_back + coat.leaving;
                assert!((whole - 1.0).abs() < 2e-3, "{eta} {medium:?}: {whole}");
                for i in 0..COSINES {
                    let share = coat.from_base[i] + coat.scattered[i];
                    assert!((share - 1.0).abs() < 5e-3, "{eta} {medium:?} at {i}: {share}");
                }
            }
        }
    }

    #[test]
    fn without_scattering_only_absorption_is_left() {
        let grid = Grid::new(1.5, 0.0);
        for thickness in [0.0, 0.01, 0.3, 2.0] {
            let coat = grid.response(&grid.layer(Medium { thickness, albedo: 0.0, g: 0.3 }));
            let exact = super::super::coat::Base::Lambertian.sent_back(1.5, thickness);
            assert!((coat.sent_back - exact).abs() < 2e-3, "{thickness}: {} is not {exact}", coat.sent_back);
            for (i, value) in coat.from_base.iter().enumerate() {
                let exact = (-thickness / Grid::cosine(1.5, i)).exp();
                assert!((value - exact).abs() < 1e-9, "{thickness} {i}: {value} is not {exact}");
            }
            assert_eq!(coat.scattered, [0.0; COSINES]);
        }
    }
}
