//! False colours: from dark violet for the least value to yellow for the most. They get brighter from one end to the
//! other, so that they can be told apart without hues too. Black is left for what has no value.

/// Encoded sRGB colours at equal distances, which are blended linearly.
const COLORS: [[f32; 3]; 6] = [
    [0.22, 0.05, 0.36],
    [0.16, 0.23, 0.62],
    [0.06, 0.45, 0.62],
    [0.10, 0.63, 0.45],
    [0.55, 0.79, 0.20],
    [1.0, 0.92, 0.20],
];

/// Returns the colour at a place of the scale: 0 is its beginning, 1 its end.
pub fn color(at: f32) -> [f32; 3] {
    let place = at.clamp(0.0, 1.0) * (COLORS.len() - 1) as f32;
    let lower = (place as usize).min(COLORS.len() - 2);
    let t = place - lower as f32;
    [0, 1, 2].map(|channel| COLORS[lower][channel] * (1.0 - t) + COLORS[lower + 1][channel] * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::film::{luminance, srgb_decode};

    #[test]
    fn colors_get_brighter_along_the_scale() {
        let brightness = |step: u16| luminance(color(f32::from(step) / 100.0).map(srgb_decode));
        assert!(brightness(0) > 0.0, "black is for no value");
        for step in 1..=100 {
            assert!(brightness(step) > brightness(step - 1), "{step} %");
        }
    }
}
