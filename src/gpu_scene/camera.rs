//! The camera and its pixel filter, as the eye pass reads them.

use std::f64::consts::PI;

use glam::DAffine3;

use crate::gpu_scene::pack::rows;
use crate::kernels::{self, CameraFeatures, FILTER_CELLS};
use crate::scene::{Camera, Film, FilterKind, Projection, default_window};

/// Number of cells of a filter along one axis; all cells have the same probability.
const CELLS: usize = FILTER_CELLS as usize;
/// Number of edges of the cells.
const EDGES: usize = CELLS + 1;

/// The camera data that the eye pass reads.
pub struct View {
    /// The camera as the kernels read it.
    pub camera: kernels::Camera,
    /// Cells of the pixel filter: edges along x, edges along y, then the weights of samples in the cells
    /// along x and along y. Each of the four parts has CELLS + 1 entries.
    pub filter_table: Vec<f32>,
    /// Width of a pixel in render units: at distance 1, or at any distance for an orthographic camera.
    pub pixel_width: f64,
    projection: Projection,
}

impl View {
    /// Length of [`View::filter_table`].
    pub const FILTER_TABLE: u32 = 4 * EDGES as u32;

    /// Returns true if the lines of sight are parallel.
    pub fn is_parallel(&self) -> bool {
        self.projection == Projection::Orthographic
    }

    /// Returns a name of the projection, which differs between projections.
    pub fn projection_name(&self) -> &'static [u8] {
        match self.projection {
            Projection::Perspective { .. } => b"perspective",
            Projection::Orthographic => b"orthographic",
            Projection::Equirectangular => b"equirectangular",
            Projection::EqualArea => b"equal area",
        }
    }

    /// Returns the view with a pixel filter that is narrower by a factor. An image of fewer pixels then has the pixels of
    /// the full image at as many places.
    pub fn with_narrow_filter(mut self, factor: f64) -> Self {
        self.filter_table[..2 * EDGES].iter_mut().for_each(|edge| *edge *= factor as f32);
        self
    }

    /// Returns the features that the camera and its filter require of kernels.
    pub fn features(&self) -> CameraFeatures {
        CameraFeatures {
            has_signed_filter: self.filter_table[2 * EDGES..].iter().any(|weight| *weight < 0.0),
            is_orthographic: self.is_parallel(),
            is_spherical: matches!(self.projection, Projection::Equirectangular | Projection::EqualArea),
            is_equal_area: self.projection == Projection::EqualArea,
        }
    }
}

/// Packs a camera with an image of `resolution` pixels, of which the film renders a part. Units of camera
/// space are about one render unit, so that squares of directions fit in fp32 for any size of the scene.
/// The scale is a power of two, which rounds nothing.
pub fn pack_camera(camera: &Camera, film: &Film, resolution: [u32; 2], render_from_world: &DAffine3) -> View {
    let mut render_from_camera = *render_from_world * camera.world_from_camera;
    let scale = render_from_camera.matrix3.x_axis.length().log2().round().exp2();
    render_from_camera.matrix3 *= 1.0 / scale;
    // The image plane of a perspective camera is at distance 1 in any unit.
    let in_units = if camera.projection == Projection::Orthographic { scale } else { 1.0 };
    let [width, height] = resolution.map(f64::from);
    let ImagePlane { lower, upper, size, across } = ImagePlane::new(camera, film, resolution);
    let pixel_width = match camera.projection {
        Projection::Perspective { .. } => across.abs(),
        Projection::Orthographic => across.abs() * scale * render_from_camera.matrix3.x_axis.length(),
        Projection::Equirectangular => PI / height,
        Projection::EqualArea => (4.0 * PI / (width * height)).sqrt(),
    };
    let packed = kernels::Camera {
        render_from_camera: rows(&render_from_camera),
        image_lower: lower.map(|edge| (edge * in_units) as f32),
        image_extent: [0, 1].map(|axis| ((upper[axis] - lower[axis]) * in_units) as f32),
        lens_radius: (camera.lens_radius * scale) as f32,
        focal_distance: (camera.focal_distance * scale) as f32,
        width: size[0],
        height: size[1],
    };
    View { camera: packed, filter_table: filter_table(film), pixel_width, projection: camera.projection }
}

/// The rendered part of the image: on the plane z = 1 of a perspective camera, on z = 0 of an orthographic
/// camera, in the unit square of all directions otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImagePlane {
    /// The upper left corner.
    pub lower: [f64; 2],
    /// The lower right corner.
    pub upper: [f64; 2],
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Width of a pixel; negative if the image is mirrored.
    pub across: f64,
}

impl ImagePlane {
    /// Returns the image plane of a camera with an image of `resolution` pixels, of which the film renders
    /// a part.
    pub fn new(camera: &Camera, film: &Film, resolution: [u32; 2]) -> Self {
        let window = fit_window(camera.screen_window, film.resolution, resolution);
        let [left, right, bottom, top] = match camera.projection {
            Projection::Perspective { tan_half_fov } => window.map(|edge| edge * tan_half_fov),
            Projection::Orthographic => window,
            Projection::Equirectangular | Projection::EqualArea => [0.0, 1.0, 1.0, 0.0],
        };
        let [width, height] = resolution.map(f64::from);
        let [first, end] = film.bounds(resolution);
        let part = |low: f64, high: f64, pixels: u32, of: f64| low + (high - low) * (f64::from(pixels) / of);
        Self {
            lower: [part(left, right, first[0], width), part(top, bottom, first[1], height)],
            upper: [part(left, right, end[0], width), part(top, bottom, end[1], height)],
            size: [end[0] - first[0], end[1] - first[1]],
            across: (right - left) / width,
        }
    }
}

fn filter_table(film: &Film) -> Vec<f32> {
    let mut table = vec![0.0; View::FILTER_TABLE as usize];
    let (edges, weights) = table.split_at_mut(2 * EDGES);
    let axes = edges.chunks_exact_mut(EDGES).zip(weights.chunks_exact_mut(EDGES));
    for ((edges, weights), radius) in axes.zip(film.filter.radius.to_array()) {
        fill_cells(edges, weights, film.filter.kind, radius);
    }
    table
}

/// Returns the screen window for another image size: the default window for the film becomes the default
/// window for the new size; a window that the scene chose stays.
fn fit_window(window: [f64; 4], film: [u32; 2], resolution: [u32; 2]) -> [f64; 4] {
    let default = |[width, height]: [u32; 2]| default_window(f64::from(width) / f64::from(height));
    if window == default(film) { default(resolution) } else { window }
}

/// Returns the value of a filter along one axis; the filter is not normalised.
fn evaluate(kind: FilterKind, radius: f64, x: f64) -> f64 {
    match kind {
        FilterKind::Box => 1.0,
        FilterKind::Triangle => radius - x.abs(),
        FilterKind::Gaussian { sigma } => {
            let bell = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
            (bell(x) - bell(radius)).max(0.0)
        }
        FilterKind::Mitchell { b, c } => mitchell(b, c, 2.0 * (x / radius).abs()),
        FilterKind::Sinc { tau } => sinc(x) * sinc(x / tau),
    }
}

/// Returns the filter of Mitchell and Netravali 1988, eq. 8, without the factor 1/6.
fn mitchell(b: f64, c: f64, x: f64) -> f64 {
    if x < 1.0 {
        (12.0 - 9.0 * b - 6.0 * c) * x.powi(3) + (-18.0 + 12.0 * b + 6.0 * c) * x.powi(2) + (6.0 - 2.0 * b)
    } else {
        (-b - 6.0 * c) * x.powi(3)
            + (6.0 * b + 30.0 * c) * x.powi(2)
            + (-12.0 * b - 48.0 * c) * x
            + (8.0 * b + 24.0 * c)
    }
}

fn sinc(x: f64) -> f64 {
    let angle = PI * x;
    if angle.abs() < 1e-9 { 1.0 } else { angle.sin() / angle }
}

/// Cuts a filter into cells with equal integrals of its magnitude, and weighs each cell by its share of the
/// filter's integral. All weights are 1 if the filter has no negative lobes.
fn fill_cells(edges: &mut [f32], weights: &mut [f32], kind: FilterKind, radius: f64) {
    const STEPS: usize = 1 << 14;
    let step = 2.0 * radius / STEPS as f64;
    let (mut magnitudes, mut sums) = (vec![0.0], vec![0.0]);
    for i in 0..STEPS {
        let value = evaluate(kind, radius, -radius + (i as f64 + 0.5) * step);
        magnitudes.push(magnitudes[i] + value.abs());
        sums.push(sums[i] + value);
    }
    let mut before = 0.0;
    for i in 0..EDGES {
        let target = magnitudes[STEPS] * i as f64 / CELLS as f64;
        let cell = magnitudes.partition_point(|sum| *sum <= target).clamp(1, STEPS);
        let [low, high] = [magnitudes[cell - 1], magnitudes[cell]];
        let part = ((target - low) / (high - low).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        edges[i] = (-radius + (cell as f64 - 1.0 + part) * step) as f32;
        let sum = sums[cell - 1] + part * (sums[cell] - sums[cell - 1]);
        if i > 0 {
            weights[i - 1] = (CELLS as f64 * (sum - before) / sums[STEPS]) as f32;
        }
        before = sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(kind: FilterKind, radius: f64) -> ([f32; EDGES], [f32; EDGES]) {
        let (mut edges, mut weights) = ([0.0; EDGES], [0.0; EDGES]);
        fill_cells(&mut edges, &mut weights, kind, radius);
        (edges, weights)
    }

    #[test]
    fn a_box_is_uniform_and_a_triangle_quadratic() {
        let (edges, _) = cells(FilterKind::Box, 0.5);
        for (i, edge) in edges.iter().enumerate() {
            assert!((f64::from(*edge) - (i as f64 / CELLS as f64 - 0.5)).abs() < 1e-6);
        }
        let (edges, _) = cells(FilterKind::Triangle, 2.0);
        for (i, edge) in edges.iter().enumerate() {
            let u = i as f64 / CELLS as f64;
            let exact = if u < 0.5 { -2.0 + 2.0 * (2.0 * u).sqrt() } else { 2.0 - 2.0 * (2.0 - 2.0 * u).sqrt() };
            assert!((f64::from(*edge) - exact).abs() < 1e-3, "{edge} {exact}");
        }
        assert_eq!(cells(FilterKind::Box, 0.0).0, [0.0; EDGES]);
    }

    #[test]
    fn only_default_windows_follow_the_resolution() {
        assert_eq!(fit_window([-2.0, 2.0, -1.0, 1.0], [200, 100], [100, 100]), [-1.0, 1.0, -1.0, 1.0]);
        assert_eq!(fit_window([-1.0, 1.0, -1.0, 0.5], [200, 100], [100, 100]), [-1.0, 1.0, -1.0, 0.5]);
    }

    #[test]
    fn a_gaussian_is_symmetric_and_bounded() {
        let (edges, _) = cells(FilterKind::Gaussian { sigma: 0.5 }, 1.5);
        for i in 0..EDGES {
            assert!((edges[i] + edges[EDGES - 1 - i]).abs() < 1e-3);
            assert!(edges[i].abs() <= 1.5);
        }
        let quarter = edges[EDGES / 4];
        assert!(quarter > -0.5 && quarter < -0.25);
    }

    /// The cells have the integrals of the filter: the total is 1, and the integral up to any edge is that
    /// of the filter.
    #[test]
    fn weights_add_up_to_the_filter() {
        let third = 1.0 / 3.0;
        for (kind, radius, negative) in [
            (FilterKind::Box, 0.5, false),
            (FilterKind::Gaussian { sigma: 0.5 }, 1.5, false),
            (FilterKind::Mitchell { b: third, c: third }, 2.0, true),
            (FilterKind::Sinc { tau: 3.0 }, 4.0, true),
        ] {
            let (edges, weights) = cells(kind, radius);
            let total: f32 = weights[..CELLS].iter().sum();
            assert!((total / CELLS as f32 - 1.0).abs() < 1e-4, "{kind:?} {total}");
            assert_eq!(weights.iter().any(|weight| *weight < 0.0), negative, "{kind:?}");
            if !negative {
                assert!(weights[..CELLS].iter().all(|weight| (weight - 1.0).abs() < 2e-3), "{kind:?}");
            }
            let integral = |end: f64| {
                let step = (end + radius) / 1e3;
                (0..1000).map(|i| evaluate(kind, radius, -radius + (f64::from(i) + 0.5) * step) * step).sum::<f64>()
            };
            let mut share = 0.0;
            for i in 0..CELLS {
                share += f64::from(weights[i]) / CELLS as f64;
                let expected = integral(edges[i + 1].into()) / integral(radius);
                assert!((share - expected).abs() < 1e-3, "{kind:?} at {}: {share} {expected}", edges[i + 1]);
            }
        }
    }

    /// With B + 2C = 1 the shifted splines add up to 1, as the authors state; the filter is continuous for
    /// any B and C.
    #[test]
    fn mitchell_splines_are_a_partition_of_unity() {
        for (b, c) in [(1.0 / 3.0, 1.0 / 3.0), (1.0, 0.0), (0.0, 0.5), (0.4, 0.3)] {
            for step in 0..20 {
                let x = f64::from(step) / 20.0;
                let sum: f64 = [x + 1.0, x, 1.0 - x, 2.0 - x].map(|x| mitchell(b, c, x)).iter().sum();
                assert!((sum - 6.0).abs() < 1e-12, "{b} {c} {x}: {sum}");
            }
            assert!(mitchell(b, c, 2.0).abs() < 1e-12);
        }
    }
}
