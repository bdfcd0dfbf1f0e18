//! Packing of skies that are seen through a portal.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::{Tables, pack_weighed};
use crate::geometry::equal_area;
use crate::image::film::Image;
use crate::kernels::{self, LightTexel};
use crate::scene::{LightImage, Portal, Rgb};

/// Least side of an image: within a texel, the cosine to the portal should vary little.
const LEAST_SIDE: u32 = 32;
/// Texels behind the portal up to this cosine are chosen as well: a texel is not flat.
const BEHIND: f64 = 0.1;
/// Least weight of a texel that a part of the sky may be seen in.
const LEAST_WEIGHT: f64 = 0.01;

/// A portal in render space.
pub struct PlacedPortal {
    corner: DVec3,
    edges: [DVec3; 2],
    /// Points to the sky; of unit length.
    normal: DVec3,
}

impl PlacedPortal {
    pub fn new(portal: &Portal, render_from_world: &DAffine3) -> Self {
        let edges = portal.edges.map(|edge| render_from_world.transform_vector3(edge));
        let normal = edges[1].cross(edges[0]).normalize_or_zero();
        Self { corner: render_from_world.transform_point3(portal.corner), edges, normal }
    }

    pub fn area(&self) -> f64 {
        self.edges[0].length() * self.edges[1].length()
    }

    /// Appends the portal and an image to `texels`, and returns the packed image and the mean of the texels' colours
    /// times their cosine. Before the image are the corner and the edges, in place of colours; after it are the weights
    /// with which texels are chosen besides their colours.
    pub fn pack(&self, image: &LightImage, tables: Tables, texels: &mut Vec<LightTexel>) -> (kernels::LightImage, Rgb) {
        let vector = |v: DVec3| LightTexel { color: v.as_vec3().to_array(), choice: 0 };
        texels.extend([self.corner, self.edges[1], self.edges[0]].map(vector));
        let image = LightImage { pixels: fine(&image.pixels), ..image.clone() };
        let size = DVec2::new(image.pixels.width.into(), image.pixels.height.into());
        let weight = |place: DVec2| {
            let cosine = |x: f64, y: f64| {
                let corner = place + DVec2::new(x, y) * 0.5 / size;
                self.normal.dot(image.world_from_image * equal_area::direction(corner))
            };
            let corners = [cosine(-1.0, -1.0), cosine(1.0, -1.0), cosine(-1.0, 1.0), cosine(1.0, 1.0)];
            let most = corners.into_iter().fold(cosine(0.0, 0.0), f64::max);
            if most > -BEHIND { most.max(LEAST_WEIGHT) } else { 0.0 }
        };
        let packed = pack_weighed(&image, weight, tables, texels);
        let places = (0..image.pixels.height).flat_map(|y| (0..image.pixels.width).map(move |x| (x, y)));
        texels.extend(places.map(|(x, y)| {
            let place = (DVec2::new(x.into(), y.into()) + 0.5) / size;
            LightTexel { color: [weight(place) as f32, 0.0, 0.0], choice: 0 }
        }));
        packed
    }
}

/// Returns an image with the same colour in each direction, whose sides are long enough.
fn fine(image: &Arc<Image>) -> Arc<Image> {
    let factor = LEAST_SIDE.div_ceil(image.width.max(1));
    if factor <= 1 {
        return Arc::clone(image);
    }
    let mut fine = Image::new(image.width * factor, image.height * factor);
    let width = fine.width;
    for (i, pixel) in (0..).zip(&mut fine.pixels) {
        let (x, y) = (i % width / factor, i / width / factor);
        *pixel = image.pixels[(y * image.width + x) as usize];
    }
    Arc::new(fine)
}
