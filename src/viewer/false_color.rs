//! False colours of the quantities that a window shows: from dark violet for the least value to yellow for the most.
//! Black is for no value.

use crate::image::false_color::Palette;

/// Returns the colour at a place of the scale: 0 is its beginning, 1 its end.
pub fn color(at: f32) -> [f32; 3] {
    Palette::Viridis.color(at)
}

/// Returns the colours of shares from 0 to 1; black for 0.
pub fn shares(values: &[f32]) -> Vec<[f32; 4]> {
    values.iter().map(|share| shown(*share, |share| share)).collect()
}

/// Returns the colours of amounts by their logarithms: the first one for `least` and less, the last one for `most` and
/// more, and black for 0.
pub fn amounts(values: &[f32], [least, most]: [f32; 2]) -> Vec<[f32; 4]> {
    let per_log = 1.0 / (most / least).ln();
    values.iter().map(|amount| shown(*amount, |amount| (amount / least).ln() * per_log)).collect()
}

fn shown(value: f32, place: impl Fn(f32) -> f32) -> [f32; 4] {
    let [r, g, b] = if value > 0.0 { color(place(value)) } else { [0.0; 3] };
    [r, g, b, 0.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_go_from_end_to_end_and_amounts_by_decades() {
        let [first, last] = [color(0.0), color(1.0)].map(|[r, g, b]| [r, g, b, 0.0]);
        let [black, middle] = [[0.0; 3], color(0.5)].map(|[r, g, b]| [r, g, b, 0.0]);
        assert_eq!(shares(&[0.0, 1e-12, 0.5, 1.0]), [black, first, middle, last]);
        let of = |values: &[f32]| amounts(values, [7e-4, 7.0]);
        assert_eq!(of(&[0.0, 7e-9, 700.0, f32::INFINITY]), [black, first, last, last]);
        for (amount, expected) in [(7e-4, first), (7e-2, middle), (7.0, last)] {
            let found = of(&[amount])[0];
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{amount}: {found:?}");
        }
    }
}
