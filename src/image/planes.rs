//! The layers of an image as planes of values: positions, normals, parts of the light, and so on.

use glam::{DAffine3, DVec3};

use crate::image::estimate::Estimate;
use crate::image::film::balanced_luminance;
use crate::image::layers::Group;
use crate::image::sum::{from_whole, whole};

/// A plane of values for each channel, row by row, the top row first.
pub type Planes = Vec<Vec<f32>>;

fn planes<const N: usize>(values: impl Iterator<Item = [f64; N]>) -> Planes {
    let mut planes = vec![Vec::new(); N];
    for pixel in values {
        planes.iter_mut().zip(pixel).for_each(|(plane, value)| plane.push(value as f32));
    }
    planes
}

/// Returns a quotient; 0 where the divisor is not above 0.
fn over(value: f64, divisor: f64) -> f64 {
    if divisor > 0.0 { value / divisor } else { 0.0 }
}

/// Returns the luminance of linear RGB after the white balance.
fn luminance(light: [f64; 3]) -> f64 {
    light.iter().zip(balanced_luminance(None)).map(|(channel, weight)| channel * weight).sum()
}

/// Returns the unit vector; 0 for 0.
fn direction(sum: DVec3) -> [f64; 3] {
    sum.normalize_or_zero().to_array()
}

impl Estimate {
    /// Returns the mean over iterations of a group; `None` if there is no such group.
    fn layer(&self, group: Group) -> Option<impl Iterator<Item = [f64; 4]>> {
        let scale = 1.0 / self.iterations().max(1) as f64;
        Some(self.layers.sums(group)?.map(move |sums| sums.map(|sum| from_whole(sum) * scale)))
    }

    /// Returns the mean of a group over the paths that meet a surface; 0 where none does.
    fn over_hits(&self, group: Group) -> Option<impl Iterator<Item = Option<[f64; 4]>>> {
        let hits = self.layer(Group::Albedo)?.map(|[.., hits]| hits);
        let mean = |(sums, hits): ([f64; 4], f64)| (hits > 0.0).then(|| sums.map(|sum| sum / hits));
        Some(self.layer(group)?.zip(hits).map(mean))
    }

    /// Returns the albedo: red, green and blue, 0 where nothing is seen.
    pub fn albedo(&self) -> Option<Planes> {
        Some(planes(self.layer(Group::Albedo)?.map(|[r, g, b, _]| [r, g, b])))
    }

    /// Returns the position in the coordinate system of the layers; 0 where nothing is seen.
    pub fn position(&self) -> Option<Planes> {
        self.transformed(self.layers.form.from_render(), |point| point.to_array())
    }

    /// Returns the depth: z of the position in camera space; 0 where nothing is seen.
    pub fn depth(&self) -> Option<Planes> {
        self.transformed(self.layers.form.camera_from_render, |point| [point.z])
    }

    fn transformed<const N: usize>(&self, transform: DAffine3, part: fn(DVec3) -> [f64; N]) -> Option<Planes> {
        let of = |mean: Option<[f64; 4]>| {
            mean.map_or([0.0; N], |[x, y, z, _]| part(transform.transform_point3(DVec3::new(x, y, z))))
        };
        Some(planes(self.over_hits(Group::Position)?.map(of)))
    }

    /// Returns the unit geometric normal in the coordinate system of the layers; 0 where nothing is seen.
    pub fn normal(&self) -> Option<Planes> {
        self.direction_of(Group::Normal)
    }

    /// Returns the unit shading normal in the coordinate system of the layers; 0 where nothing is seen.
    pub fn shading_normal(&self) -> Option<Planes> {
        self.direction_of(Group::ShadingNormal)
    }

    fn direction_of(&self, group: Group) -> Option<Planes> {
        // Normals are transformed by the transpose of the inverse.
        let cofactors = self.layers.form.from_render().matrix3.inverse().transpose();
        Some(planes(self.layer(group)?.map(|[x, y, z, _]| direction(cofactors * DVec3::new(x, y, z)))))
    }

    /// Returns texture coordinate u; 0 where nothing is seen.
    pub fn u(&self) -> Option<Planes> {
        Some(planes(self.over_hits(Group::Slope)?.map(|mean| mean.map_or([0.0], |[.., u, _]| [u]))))
    }

    /// Returns texture coordinate v; 0 where nothing is seen.
    pub fn v(&self) -> Option<Planes> {
        Some(planes(self.over_hits(Group::Slope)?.map(|mean| mean.map_or([0.0], |[.., v]| [v]))))
    }

    /// Returns the magnitude of the change of the position's z from a pixel to the next: along x for axis 0, along
    /// y for axis 1; 0 where nothing is seen.
    pub fn slope(&self, axis: usize) -> Option<Planes> {
        let scale = self.layers.form.slope_axis().length();
        let of = |mean: Option<[f64; 4]>| mean.map_or([0.0], |slopes| [(scale * slopes[axis]).abs()]);
        Some(planes(self.over_hits(Group::Slope)?.map(of)))
    }

    /// Returns the light without photons, as the image has it, W/(m² sr).
    pub fn direct(&self) -> Option<Planes> {
        Some(planes(self.layer(Group::Light)?.map(|[r, g, b, _]| self.balanced([r, g, b]))))
    }

    /// Returns the light of photons, as the image has it, W/(m² sr): the image less [`Estimate::direct`].
    pub fn photons(&self) -> Option<Planes> {
        Some(planes(self.photon_light()?))
    }

    /// Returns the light of photons, red, green and blue, as the image has it, W/(m² sr).
    fn photon_light(&self) -> Option<impl Iterator<Item = [f64; 3]>> {
        let scale = 1.0 / self.iterations().max(1) as f64;
        let [red, green, blue] = &self.radiance;
        let all = red.iter().zip(green).zip(blue).map(|((r, g), b)| [*r, *g, *b].map(whole));
        let less = move |(all, direct): ([i128; 3], [i128; 4])| {
            self.balanced([0, 1, 2].map(|channel| from_whole(all[channel].wrapping_sub(direct[channel])) * scale))
        };
        Some(all.zip(self.layers.sums(Group::Light)?).map(less))
    }

    /// Returns the share of the luminance that photons bring, 0 to 1; 0 where the pixel is black.
    pub fn photon_share(&self) -> Option<Planes> {
        let image = self.means().map(|mean| luminance(self.balanced(mean)));
        let share = |(photons, all): ([f64; 3], f64)| [over(luminance(photons), all).clamp(0.0, 1.0)];
        Some(planes(self.photon_light()?.zip(image).map(share)))
    }

    /// Returns the luminance of the light of photons over [`Estimate::density`], W/(m² sr) for a photon on each square
    /// scene unit: what a photon brings; 0 where no photon is on the disc. Light of rough surfaces, which have no disc,
    /// counts as if the photons on the disc had brought it.
    pub fn light_per_photon(&self) -> Option<Planes> {
        let densities = self.photons_per_area()?;
        let each = |(photons, density): ([f64; 3], f64)| [over(luminance(photons), density).max(0.0)];
        Some(planes(self.photon_light()?.zip(densities).map(each)))
    }

    /// Returns the part of [`Estimate::photons`] that came from its light by specular or rough surfaces only.
    pub fn caustic(&self) -> Option<Planes> {
        Some(planes(self.layer(Group::Caustic)?.map(|[r, g, b, _]| self.balanced([r, g, b]))))
    }

    /// Returns the mean over iterations of the radius of the disc on which photons are gathered, in scene units; an
    /// iteration without a visible point has a radius of 0.
    pub fn radius(&self) -> Option<Planes> {
        let length = self.layers.form.length();
        Some(planes(self.layer(Group::Square)?.map(|[.., radius]| [length * radius])))
    }

    /// Returns the mean over iterations of the photons on that disc over its area, per square scene unit.
    pub fn density(&self) -> Option<Planes> {
        Some(planes(self.photons_per_area()?.map(|density| [density])))
    }

    fn photons_per_area(&self) -> Option<impl Iterator<Item = f64>> {
        let scale = self.layers.form.photons as f64 / self.layers.form.length().powi(2);
        Some(self.layer(Group::Light)?.map(move |[.., density]| scale * density))
    }

    /// Returns the variance over iterations of the image of an iteration: red, green and blue, (W/(m² sr))²; 0 after
    /// one iteration.
    pub fn variance(&self) -> Option<Planes> {
        Some(planes(self.variances()?.map(|pixel| pixel.map(|[_, variance]| variance))))
    }

    /// Returns the variance over the mean, W/(m² sr), as pbrt-v4 has it; 0 where the mean is 0.
    pub fn relative_variance(&self) -> Option<Planes> {
        let ratio = |[mean, variance]: [f64; 2]| if mean == 0.0 { 0.0 } else { variance / mean };
        Some(planes(self.variances()?.map(|pixel| pixel.map(ratio))))
    }

    /// Returns the mean and the variance over iterations of each channel.
    fn variances(&self) -> Option<impl Iterator<Item = [[f64; 2]; 3]>> {
        let count = self.iterations() as f64;
        let unbiased = if count > 1.0 { count / (count - 1.0) } else { 0.0 };
        let of = move |(mean, squares): ([f64; 3], [f64; 4])| {
            let mean = self.balanced(mean);
            [0, 1, 2].map(|channel| {
                let square = squares[channel] * self.unit * self.unit;
                [mean[channel], ((square - mean[channel] * mean[channel]) * unbiased).max(0.0)]
            })
        };
        Some(self.means().zip(self.layer(Group::Square)?).map(of))
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::image::film::{CoordinateSystem, Window};
    use crate::image::layers::{Groups, LayerForm, Layers};
    use crate::image::sum::Sum;

    fn sum(value: f64) -> Sum {
        let bits = (value * 56.0_f64.exp2()) as i128;
        [0, 32, 64, 96].map(|shift| (bits >> shift) as u32)
    }

    /// One pixel after four iterations, of which half of the paths have met a surface.
    fn estimate(form: LayerForm, values: &[[f64; 4]]) -> Estimate {
        let sums = values.iter().map(|values| values.map(|value| vec![sum(value)])).collect();
        Estimate {
            resolution: [1, 1],
            window: Window::whole([1, 1]),
            unit: 2.0,
            white_balance: None,
            halves: [2, 2],
            radiance: [4.0, 8.0, 12.0].map(|value| vec![sum(value)]),
            second_half: vec![sum(0.0)],
            layers: Layers { form, sums },
        }
    }

    fn first(planes: Option<Planes>) -> Vec<f32> {
        planes.expect("the group").iter().map(|plane| plane[0]).collect()
    }

    #[test]
    fn values_of_surfaces_are_means_over_the_paths_that_meet_one() {
        let groups = Groups::of(&[Group::Albedo, Group::Position, Group::Normal, Group::ShadingNormal, Group::Slope]);
        let world_from_render = DAffine3::from_scale_rotation_translation(
            DVec3::splat(1e6),
            glam::DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
            DVec3::new(3e6, 0.0, 0.0),
        );
        let camera_from_render = DAffine3::from_translation(DVec3::new(0.0, 0.0, 5.0));
        let system = CoordinateSystem::World;
        let form = LayerForm { groups, system, camera_from_render, world_from_render, ..LayerForm::default() };
        let values = [
            [1.0, 0.5, -0.25, 2.0],
            [2.0, 0.0, -1.0, 0.0],
            [2.0, 0.0, 0.0, 0.0],
            [0.0, -1.0, 0.0, 0.0],
            [0.5, -1.0, 0.5, 1.5],
        ];
        let world = estimate(form, &values);
        let near = |planes: Option<Planes>, expected: &[f32]| {
            let found = first(planes);
            let is_near = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-6 * (1.0 + b.abs());
            assert!(found.len() == expected.len() && found.iter().zip(expected).all(is_near), "{found:?} {expected:?}");
        };
        near(world.albedo(), &[0.25, 0.125, -0.0625]);
        near(world.position(), &[3e6, 1e6, -5e5]);
        near(world.depth(), &[4.5]);
        near(world.normal(), &[0.0, 1.0, 0.0]);
        near(world.shading_normal(), &[1.0, 0.0, 0.0]);
        near(world.u(), &[0.25]);
        near(world.v(), &[0.75]);
        near(world.slope(0), &[2.5e5]);
        near(world.slope(1), &[5e5]);
        let camera = estimate(LayerForm { system: CoordinateSystem::Camera, ..form }, &values);
        near(camera.position(), &[1.0, 0.0, 4.5]);
        near(camera.normal(), &[1.0, 0.0, 0.0]);
        assert_eq!(camera.direct(), None);
        let nothing = estimate(form, &[[0.0; 4]; 5]);
        for planes in [nothing.position(), nothing.depth(), nothing.normal(), nothing.u(), nothing.slope(1)] {
            assert!(first(planes).iter().all(|value| *value == 0.0));
        }
    }

    #[test]
    fn light_without_and_with_photons_is_the_image_after_its_white_balance() {
        let groups = Groups::of(&[Group::Light, Group::Caustic, Group::Square]);
        let world_from_render = DAffine3::from_scale(DVec3::splat(10.0));
        let form = LayerForm { groups, world_from_render, photons: 1000, ..LayerForm::default() };
        let values = [[1.0, 8.0, 0.0, 0.8], [2.0, 0.0, 4.0, 0.0], [8.0, 16.0, 36.0, 0.4]];
        let plain = estimate(form, &values);
        assert_eq!(first(plain.direct()), [0.5, 4.0, 0.0]);
        assert_eq!(first(plain.photons()), [1.5, 0.0, 6.0]);
        assert_eq!(first(plain.caustic()), [1.0, 0.0, 2.0]);
        assert_eq!(first(plain.radius()), [1.0]);
        assert_eq!(first(plain.density()), [2.0]);
        // The weights of the luminance are 0.2126, 0.7152 and 0.0722.
        let of_photons = 0.2126 * 1.5 + 0.0722 * 6.0;
        let all = of_photons + 0.2126 * 0.5 + 0.7152 * 4.0;
        let near = |planes: Option<Planes>, expected: f64| {
            let value = f64::from(first(planes)[0]);
            assert!((value - expected).abs() < 1e-6, "{value}, not {expected}");
        };
        near(plain.photon_share(), of_photons / all);
        near(plain.light_per_photon(), of_photons / 2.0);
        let dark =
            estimate(form, &[[1.0, 2.0, 3.0, 0.0], [0.0; 4], [0.0; 4]].map(|group| group.map(|value| 4.0 * value)));
        assert_eq!((first(dark.photon_share()), first(dark.light_per_photon())), (vec![0.0], vec![0.0]));
        let black = Estimate { radiance: [(); 3].map(|()| vec![sum(0.0)]), ..estimate(form, &[[0.0; 4]; 3]) };
        assert_eq!((first(black.photon_share()), first(black.light_per_photon())), (vec![0.0], vec![0.0]));
        // In the unit, means are 1, 2 and 3, and those of squares 2, 4 and 9.
        assert_eq!(first(plain.variance()), [16.0 / 3.0, 0.0, 0.0]);
        assert_eq!(first(plain.relative_variance()), [8.0 / 3.0, 0.0, 0.0]);
        let swap = DMat3::from_cols_array_2d(&[[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 2.0]]);
        let balanced = Estimate { white_balance: Some(swap), ..plain };
        assert_eq!(first(balanced.direct()), [4.0, 0.5, 0.0]);
        assert_eq!(first(balanced.photons()), [0.0, 1.5, 12.0]);
        let of_photons = 0.7152 * 1.5 + 0.0722 * 12.0;
        near(balanced.photon_share(), of_photons / (of_photons + 0.2126 * 4.0 + 0.7152 * 0.5));
        near(balanced.light_per_photon(), of_photons / 2.0);
    }
}
