//! The light that the photons of a pilot bring to a sample of the visible points.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use crate::kernels::{PhotonRecord, VisiblePoint};
use crate::render::buffers::Buffers;
use crate::render::radius::FirstRadius;
use crate::render::settings::Settings;
use crate::render::stage::Stage;

/// The approximate largest number of visible points in the sample.
const MOST_POINTS: u64 = 4096;
/// The least radius of a point's disc, in distances of neighbouring points of the sample, so that the discs cover the
/// visible surfaces.
const REACH: f64 = 1.5;
/// The largest ratio of a radius to the median radius, and of the median radius to a radius.
const SPREAD: f64 = 4.0;
/// Radiance relative to the mean radiance; errors of darker points count about as much as at this radiance.
const DARK: f64 = 0.1;
/// The largest number of points per cell.
const MOST_NEAR: usize = 64;
/// The cosine of the largest angle between normals, and the height of a disc divided by its radius, as in the gather pass.
const MIN_COSINE: f32 = 0.5;
const MAX_HEIGHT: f32 = 0.25;

/// A visible point.
struct Point {
    position: Vec3,
    normal: Vec3,
    radius2: f32,
    /// Throughput divided by the disc's area, 1/(m² sr), of red, green and blue.
    response: Vec3,
    /// Radiance of the light that eye paths find, as the mean of the channels.
    direct: f64,
}

/// The sample of visible points, in cells.
pub struct Seen {
    points: Vec<Point>,
    cell_size: f32,
    /// Points whose discs may reach into a cell.
    cells: HashMap<[i32; 3], Vec<u32>>,
}

/// The light that a photon record brings to a point.
#[derive(Clone, Copy, Debug)]
pub struct Brought {
    /// The photon's index among all samples.
    pub sample: u32,
    /// The point's index.
    pub point: u32,
    /// Radiance at the point divided by the flux of all lights, 1/(m² sr), as the mean of the channels: the radiance if all
    /// photons were emitted with density 1 and brought as much as this one.
    pub radiance: f64,
}

/// The arrays of visible points of a round, by pixel.
struct Pixels {
    points: Vec<VisiblePoint>,
    /// Throughput in 1/sr, and the length of the eye path, which is 0 if there is no visible point.
    throughputs: Vec<[f32; 4]>,
    /// Radiance of the light that eye paths find, W/(m² sr).
    radiances: Vec<[f32; 4]>,
}

fn unpack_normal(packed: u32) -> Vec3 {
    let part = |bits: u32| f32::from(bits as u16 as i16) / 32767.0;
    let v = Vec2::new(part(packed), part(packed >> 16));
    let z = 1.0 - v.x.abs() - v.y.abs();
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let folded = Vec2::new((1.0 - v.y.abs()) * sign(v.x), (1.0 - v.x.abs()) * sign(v.y));
    (if z < 0.0 { folded } else { v }).extend(z).normalize()
}

fn mean(color: Vec3) -> f64 {
    f64::from(color.element_sum()) / 3.0
}

impl Seen {
    /// Returns a sample of the visible points on the device. `first` is their gather radius in the first iteration.
    ///
    /// # Errors
    /// The device fails.
    pub fn on_device(on: Stage<'_>, first: FirstRadius) -> goblet_host::Result<Self> {
        let Buffers { visible_points, visible_throughputs, visible_radiances, .. } = on.buffers;
        let Settings { resolution, pixel_width, is_parallel, .. } = *on.settings;
        let pixels = Pixels {
            points: on.device.read_first_texels(visible_points, on.settings.pixels())?,
            throughputs: on.device.read_first_texels(visible_throughputs, on.settings.pixels())?,
            radiances: on.device.read_first_texels(visible_radiances, on.settings.pixels())?,
        };
        Ok(Self::new(resolution, &pixels, pixel_width, is_parallel, first))
    }

    /// Returns a sample of the visible points that is spread evenly over the image. `pixel_width` is the width of a pixel
    /// at distance 1, or at any distance if rays are parallel, in render units.
    fn new(resolution: [u32; 2], pixels: &Pixels, pixel_width: f64, is_parallel: bool, first: FirstRadius) -> Self {
        let [width, height] = resolution.map(u64::from);
        let spacing = (width * height).div_ceil(MOST_POINTS).isqrt().max(1);
        let length = |pixel: usize| f64::from(pixels.throughputs[pixel][3]);
        let chosen: Vec<usize> = (0..height.div_ceil(spacing))
            .flat_map(|row| (0..width.div_ceil(spacing)).map(move |column| (row, column)))
            .map(|(row, column)| {
                // The shift by row and column avoids alignment of the sample with lines of the scene.
                let [x, y] = [column * spacing + row * 7 % spacing, row * spacing + column * 5 % spacing];
                (y.min(height - 1) * width + x.min(width - 1)) as usize
            })
            .filter(|pixel| length(*pixel) > 0.0)
            .collect();
        let footprint = |pixel: &usize| pixel_width * if is_parallel { 1.0 } else { length(*pixel) };
        let mut footprints: Vec<f64> = chosen.iter().map(footprint).collect();
        footprints.sort_unstable_by(f64::total_cmp);
        let median = footprints.get(footprints.len() / 2).copied().unwrap_or(1.0);
        let reach = REACH * spacing as f64;
        let point = |pixel: &usize| {
            let between = reach * footprint(pixel).clamp(median / SPREAD, median * SPREAD);
            let radius = between.max(first.at(length(*pixel)));
            let [red, green, blue, _] = pixels.throughputs[*pixel];
            let [r, g, b, _] = pixels.radiances[*pixel];
            let VisiblePoint { position, normal } = pixels.points[*pixel];
            Point {
                position: position.into(),
                normal: unpack_normal(normal),
                radius2: (radius * radius) as f32,
                response: Vec3::new(red, green, blue) * (1.0 / (std::f64::consts::PI * radius * radius)) as f32,
                direct: mean(Vec3::new(r, g, b)).max(0.0),
            }
        };
        Self::in_cells(chosen.iter().map(point).collect())
    }

    fn in_cells(points: Vec<Point>) -> Self {
        let largest = points.iter().map(|point| point.radius2).fold(0.0, f32::max).sqrt();
        let cell_size = (2.0 * largest).max(1e-6);
        let mut cells: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
        for (index, point) in points.iter().enumerate() {
            let radius = point.radius2.sqrt();
            let cell = |offset: f32| cell_of(point.position + offset, cell_size);
            let [lower, upper] = [cell(-radius), cell(radius)];
            for x in lower[0]..=upper[0] {
                for y in lower[1]..=upper[1] {
                    for z in lower[2]..=upper[2] {
                        cells.entry([x, y, z]).or_default().push(index as u32);
                    }
                }
            }
        }
        for near in cells.values_mut() {
            // Where many pixels show the same place, as through a lens, a part of their points is enough.
            let step = near.len().div_ceil(MOST_NEAR).max(1);
            *near = near.iter().step_by(step).copied().collect();
        }
        Self { points, cell_size, cells }
    }

    /// Returns the number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Returns whether there is no visible point.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Appends the light that a photon brings to each point on whose disc it lies. `density` is the density with which the
    /// photon was emitted.
    pub fn add_brought(&self, photon: &PhotonRecord, sample: u32, density: f64, brought: &mut Vec<Brought>) {
        let position = Vec3::from(photon.position);
        let Some(near) = self.cells.get(&cell_of(position, self.cell_size)) else { return };
        let normal = unpack_normal(photon.normal);
        for index in near {
            let point = &self.points[*index as usize];
            let d = position - point.position;
            let height = d.dot(point.normal);
            let is_on_disc = d.length_squared() < point.radius2
                && normal.dot(point.normal) > MIN_COSINE
                && height * height < MAX_HEIGHT * MAX_HEIGHT * point.radius2;
            // Colors of single wavelengths have negative channels.
            let radiance = mean((point.response * Vec3::from(photon.weight)).abs()) * density;
            if is_on_disc && radiance > 0.0 && radiance.is_finite() {
                brought.push(Brought { sample, point: *index, radiance });
            }
        }
    }

    /// Returns for each point 1 over the square of its radiance. The radiance is estimated from the light of eye paths and
    /// of the pilot's photons, whose weights are `weights`. `power` is the power of all lights in W.
    pub fn importances(&self, brought: &[Brought], weights: &[f64], power: f64) -> Vec<f64> {
        let mut radiances: Vec<f64> = self.points.iter().map(|point| point.direct).collect();
        for Brought { sample, point, radiance } in brought {
            radiances[*point as usize] += radiance * weights[*sample as usize] * power;
        }
        Self::importances_of(&radiances)
    }

    /// Returns 1 over the square of each radiance, so that a relative error counts alike in dark and in bright places. To
    /// the square, that of a share of the mean radiance is added.
    pub fn importances_of(radiances: &[f64]) -> Vec<f64> {
        let mean = radiances.iter().sum::<f64>() / radiances.len().max(1) as f64;
        let dark = (DARK * mean).max(f64::MIN_POSITIVE.sqrt());
        radiances.iter().map(|radiance| 1.0 / (radiance * radiance + dark * dark)).collect()
    }

    /// Returns the position of a point in render units.
    pub fn position(&self, point: usize) -> [f32; 3] {
        self.points[point].position.to_array()
    }

    /// Returns the radiance of the light that eye paths find at a point, as the mean of the channels.
    pub fn direct(&self, point: usize) -> f64 {
        self.points[point].direct
    }

    /// Returns the nearness of a photon to the visible points: the mean of 1 / (squared distance + squared radius) over a
    /// few points. It is a power of the distance, without a length of its own, so that it works at any distance.
    pub fn nearness(&self, photon: &PhotonRecord) -> f64 {
        let step = self.points.len().div_ceil(128).max(1);
        let position = Vec3::from(photon.position);
        let near = |point: &Point| {
            1.0 / f64::from(position.distance_squared(point.position) + point.radius2).max(f64::MIN_POSITIVE.sqrt())
        };
        self.points.iter().step_by(step).map(near).sum::<f64>() / self.points.len().div_ceil(step).max(1) as f64
    }
}

fn cell_of(position: Vec3, size: f32) -> [i32; 3] {
    (position / size).floor().as_ivec3().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point_at(x: f32, length: f32) -> (VisiblePoint, [f32; 4], [f32; 4]) {
        // The packed normal 0 is +z.
        (VisiblePoint { position: [x, 0.0, 0.0], normal: 0 }, [0.5, 0.5, 0.5, length], [0.1, 0.2, 0.3, 1.0])
    }

    fn photon_at(x: f32, z: f32, normal: u32) -> PhotonRecord {
        PhotonRecord { position: [x, 0.0, z], normal, weight: [3.0, 0.0, 0.0], cell: 0 }
    }

    #[test]
    fn photons_bring_light_to_points_on_whose_discs_they_lie() {
        let pixels = [point_at(0.0, 1.0), point_at(10.0, 1.0), point_at(20.0, 0.0)];
        let pixels = Pixels {
            points: pixels.iter().map(|pixel| pixel.0).collect(),
            throughputs: pixels.iter().map(|pixel| pixel.1).collect(),
            radiances: pixels.iter().map(|pixel| pixel.2).collect(),
        };
        let seen = Seen::new([3, 1], &pixels, 0.4, false, FirstRadius::constant(0.1));
        assert_eq!(seen.points.len(), 2, "the third pixel has no visible point");
        let radius = 0.6_f64;
        let mut brought = Vec::new();
        seen.add_brought(&photon_at(10.2, 0.0, 0), 1, 2.0, &mut brought);
        // Of the mean of (0.5 x 3, 0, 0), twice.
        let expected = 2.0 * 0.5 / (std::f64::consts::PI * radius * radius);
        assert!((brought[0].radiance / expected - 1.0).abs() < 1e-6 && brought[0].point == 1 && brought[0].sample == 1);
        // Down is (0, 0, -1): the octahedron's corners, 32767 in both halves.
        for (x, z, normal) in
            [(10.61, 0.0, 0), (10.0, 0.16, 0), (10.0, 0.0, 0x7fff_7fff), (5.0, 0.0, 0), (20.0, 0.0, 0)]
        {
            seen.add_brought(&photon_at(x, z, normal), 0, 1.0, &mut brought);
            assert_eq!(brought.len(), 1, "{x} {z} {normal}");
        }
        let [dark, bright] = seen.importances(&brought, &[0.5, 0.5], 1.0)[..] else { panic!("two points") };
        assert!(dark > 5.0 * bright, "{dark} {bright}");
        assert!(seen.nearness(&photon_at(10.0, 0.0, 0)) > 2.0 * seen.nearness(&photon_at(5.0, 0.0, 0)));
    }
}
