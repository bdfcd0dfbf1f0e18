//! Packing of media, and of the media on the two sides of each surface.

use std::collections::HashMap;

use glam::DVec3;

use super::Packer;
use super::instance::Placed;
use super::material::has_dispersion;
use crate::kernels::{self, INTERFACE, NONE, VACUUM};
use crate::scene::{MediumInterface, Scene};

/// Returns the number of a medium in the packed media, of which the first is the vacuum.
pub(super) fn packed_medium(medium: Option<usize>) -> u32 {
    medium.map_or(VACUUM, |index| VACUUM + 1 + index as u32)
}

impl Packer {
    /// Packs the media, and sets the media on both sides of every shape: a material is packed once more for
    /// each pair of media of the shapes that have it. Without media that absorb light nothing is packed.
    /// `scale` is the number of render units in a scene unit.
    pub(super) fn add_media(&mut self, scene: &Scene, placed: &mut Placed, scale: f64) {
        if scene.media.is_empty() {
            return;
        }
        let absorption = |coefficient: DVec3| {
            let most = f64::from(f32::MAX);
            let absorption = (coefficient / scale).min(DVec3::splat(most)).as_vec3().to_array();
            kernels::Medium { absorption, spectrum: NONE }
        };
        self.media.push(absorption(DVec3::ZERO));
        let splits_light = has_dispersion(&self.materials);
        for medium in &scene.media {
            let curve = medium.by_wavelength.as_ref().filter(|_| splits_light);
            let spectrum = curve.map_or(NONE, |curve| self.textures.curve(&curve.scaled(1.0 / scale)));
            self.media.push(kernels::Medium { spectrum, ..absorption(medium.absorption) });
        }
        self.medium_interfaces = vec![bytemuck::Zeroable::zeroed(); self.materials.len()];
        let mut places: HashMap<(usize, MediumInterface), usize> = HashMap::new();
        for shape in placed.shapes_mut().filter(|shape| shape.media != MediumInterface::default()) {
            let (material, media) = (shape.material, shape.media);
            shape.to_mut().material = *places.entry((material, media)).or_insert_with(|| {
                let material = self.materials[material];
                self.materials.push(material);
                self.medium_interfaces.push(kernels::MediumInterface {
                    inside: packed_medium(media.inside),
                    outside: packed_medium(media.outside),
                    passes: u32::from(material.kind == INTERFACE),
                    pad: 0,
                });
                self.materials.len() - 1
            });
        }
    }

    /// Returns true if some surface only bounds media.
    pub(super) fn has_interfaces(&self) -> bool {
        self.medium_interfaces.iter().any(|interface| interface.passes != 0)
    }
}
