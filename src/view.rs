//! The camera and its pixel filter, as the eye pass reads them.

use glam::DAffine3;

use crate::kernels;
use crate::pack::rows;
use crate::scene::{Camera, Film, FilterKind};

/// Entries of a filter's table along one axis.
const TABLE: usize = 64;

/// What the eye pass reads.
pub struct View {
    /// The camera.
    pub camera: kernels::Camera,
    /// Inverse distribution of the pixel filter: for x, then for y.
    pub filter_offsets: [f32; 2 * TABLE],
}

/// Packs a camera for an image of `resolution` pixels. Camera space keeps scene units.
pub fn pack_camera(camera: &Camera, film: &Film, resolution: [u32; 2], render_from_world: &DAffine3) -> View {
    let window = fit_window(camera.screen_window, film.resolution, resolution);
    let [left, right, bottom, top] = window.map(|edge| edge * camera.tan_half_fov);
    let mut filter_offsets = [0.0; 2 * TABLE];
    let (x, y) = filter_offsets.split_at_mut(TABLE);
    fill_offsets(x, film.filter.kind, film.filter.radius.x);
    fill_offsets(y, film.filter.kind, film.filter.radius.y);
    let camera = kernels::Camera {
        render_from_camera: rows(&(*render_from_world * camera.world_from_camera)),
        image_lower: [left as f32, top as f32],
        image_extent: [(right - left) as f32, (bottom - top) as f32],
        lens_radius: camera.lens_radius as f32,
        focal_distance: camera.focal_distance as f32,
        width: resolution[0],
        height: resolution[1],
    };
    View { camera, filter_offsets }
}

/// The screen window for another image size: a window that was the default for the film
/// stays the default, one that the scene chose stays as it is.
fn fit_window(window: [f64; 4], film: [u32; 2], resolution: [u32; 2]) -> [f64; 4] {
    if window == default_window(film) { default_window(resolution) } else { window }
}

/// pbrt's: ±1 along the shorter axis.
fn default_window([width, height]: [u32; 2]) -> [f64; 4] {
    let aspect = f64::from(width) / f64::from(height);
    if aspect > 1.0 { [-aspect, aspect, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect] }
}

/// Tabulates the inverse of a filter's distribution: offset by quantile.
fn fill_offsets(offsets: &mut [f32], kind: FilterKind, radius: f64) {
    const STEPS: usize = 4096;
    let density = |x: f64| match kind {
        FilterKind::Box => 1.0,
        FilterKind::Triangle => radius - x.abs(),
        FilterKind::Gaussian { sigma } => {
            let bell = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
            (bell(x) - bell(radius)).max(0.0)
        }
    };
    let step = 2.0 * radius / STEPS as f64;
    let mut sums = vec![0.0];
    for i in 0..STEPS {
        let middle = -radius + (i as f64 + 0.5) * step;
        sums.push(sums[i] + density(middle));
    }
    let last = offsets.len() - 1;
    for (i, offset) in offsets.iter_mut().enumerate() {
        let target = sums[STEPS] * i as f64 / last as f64;
        let cell = sums.partition_point(|sum| *sum <= target).clamp(1, STEPS);
        let part = ((target - sums[cell - 1]) / (sums[cell] - sums[cell - 1]).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        *offset = (-radius + (cell as f64 - 1.0 + part) * step) as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_uniform_and_a_triangle_quadratic() {
        let mut offsets = [0.0; TABLE];
        fill_offsets(&mut offsets, FilterKind::Box, 0.5);
        for (i, offset) in offsets.iter().enumerate() {
            assert!((f64::from(*offset) - (i as f64 / 63.0 - 0.5)).abs() < 1e-6);
        }
        fill_offsets(&mut offsets, FilterKind::Triangle, 2.0);
        for (i, offset) in offsets.iter().enumerate() {
            let u = i as f64 / 63.0;
            let exact = if u < 0.5 { -2.0 + 2.0 * (2.0 * u).sqrt() } else { 2.0 - 2.0 * (2.0 - 2.0 * u).sqrt() };
            assert!((f64::from(*offset) - exact).abs() < 1e-3, "{offset} {exact}");
        }
    }

    #[test]
    fn only_default_windows_follow_the_resolution() {
        assert_eq!(fit_window([-2.0, 2.0, -1.0, 1.0], [200, 100], [100, 100]), [-1.0, 1.0, -1.0, 1.0]);
        assert_eq!(fit_window([-1.0, 1.0, -1.0, 0.5], [200, 100], [100, 100]), [-1.0, 1.0, -1.0, 0.5]);
    }

    #[test]
    fn a_gaussian_is_symmetric_and_bounded() {
        let mut offsets = [0.0; TABLE];
        fill_offsets(&mut offsets, FilterKind::Gaussian { sigma: 0.5 }, 1.5);
        for i in 0..TABLE {
            assert!((offsets[i] + offsets[TABLE - 1 - i]).abs() < 1e-3);
            assert!(offsets[i].abs() <= 1.5);
        }
        assert!(offsets[16] > -0.5 && offsets[16] < -0.25);
    }
}
