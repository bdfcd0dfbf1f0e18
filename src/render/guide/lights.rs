//! The properties of the scene's lights that a guide uses.

use crate::kernels::{AREA, GONIOMETRIC, GuideLight, Light, POINT, PROJECTION, SPOT};

/// The properties of the scene's lights that a guide uses; empty without a guide.
#[derive(Debug, Default)]
pub struct GuideLights {
    /// The lights that emit photons, in the order of guided emission. Lights that are near each other are near in this
    /// order, so that a few cells of the tree contain the lights of one place.
    pub order: Vec<GuideLight>,
    /// The probability by power with which next-event estimation picks each light. It is 0 for a constant infinite light,
    /// which only sampling of the BSDF finds.
    pub direct: Vec<f64>,
}

impl GuideLights {
    /// Returns the properties of a scene's lights.
    pub fn of(lights: &[Light]) -> Self {
        Self { order: ordered(lights), direct: lights.iter().map(|light| light.direct_pmf.into()).collect() }
    }
}

/// Returns the lights that emit photons, each with the sum of its probability and those of the lights before it. Lights
/// that are infinitely far away come first, then the others along a space-filling curve (Morton 1966).
fn ordered(lights: &[Light]) -> Vec<GuideLight> {
    let is_local = |light: &Light| [POINT, SPOT, AREA, GONIOMETRIC, PROJECTION].contains(&light.kind);
    let key = |index: &u32| {
        let light = &lights[*index as usize];
        if is_local(light) { 1 + morton_code(light.position) } else { 0 }
    };
    let mut order: Vec<u32> = (0..lights.len() as u32).collect();
    order.retain(|index| lights[*index as usize].emission_pmf > 0.0);
    order.sort_by_key(key);
    let mut sum = 0.0;
    let end = |index: &u32| {
        sum += f64::from(lights[*index as usize].emission_pmf);
        GuideLight { end: sum as f32, light: *index, pad0: 0, pad1: 0 }
    };
    order.iter().map(end).collect()
}

/// Returns the light that a random number selects (`sample_guide_light` in `shaders/include/light/guide.glsl`).
pub fn light_of(order: &[GuideLight], number: f32) -> usize {
    let index = order.partition_point(|light| number >= light.end).min(order.len().saturating_sub(1));
    order.get(index).map_or(0, |light| light.light as usize)
}

/// Returns the Morton code of a position in render units: the interleaved bits of its coordinates, 21 of each. Coordinates
/// outside the range from -2 to 2, which contains the scene, are clamped to it.
pub fn morton_code(position: [f32; 3]) -> u64 {
    let bits =
        |coordinate: f32| ((f64::from(coordinate) / 4.0 + 0.5).clamp(0.0, 1.0) * f64::from((1 << 21) - 1)) as u64;
    (0..21)
        .flat_map(|bit| [0, 1, 2].map(|axis| (bit, axis)))
        .fold(0, |code, (bit, axis)| code | (bits(position[axis]) >> bit & 1) << (3 * bit + axis))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_of_one_place_are_neighbours_and_keep_their_chances() {
        let light = |x: f32, kind: u32, emission_pmf: f32| Light {
            position: [x, 0.1, 0.1],
            kind,
            emission_pmf,
            ..bytemuck::Zeroable::zeroed()
        };
        let lights = [
            light(0.9, POINT, 0.25),
            light(-0.9, AREA, 0.25),
            light(0.91, SPOT, 0.25),
            light(0.0, 5, 0.25),
            light(0.0, POINT, 0.0),
        ];
        let order = ordered(&lights);
        let found: Vec<(u32, f32)> = order.iter().map(|light| (light.light, light.end)).collect();
        assert_eq!(found, [(3, 0.25), (1, 0.5), (0, 0.75), (2, 1.0)]);
        assert_eq!([0.0, 0.24, 0.25, 0.6, 0.9999].map(|number| light_of(&order, number)), [3, 3, 1, 0, 2]);
    }
}
