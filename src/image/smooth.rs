//! Means over pixels that are robust to noise.

/// Returns the mean over a square of 5 x 5 pixels around each, without those outside of the image.
pub fn blurred(image: &[f64], width: usize) -> Vec<f64> {
    /// Returns the mean over 5 pixels of a line around each; pixels of a line are `step` apart.
    fn along(image: &[f64], length: usize, place: impl Fn(usize) -> usize, step: usize) -> Vec<f64> {
        let at = |i: usize| {
            let p = place(i);
            let (from, to) = (p.saturating_sub(2), (p + 2).min(length - 1));
            let first = i - (p - from) * step;
            (0..=to - from).map(|k| image[first + k * step]).sum::<f64>() / (to - from + 1) as f64
        };
        (0..image.len()).map(at).collect()
    }
    let rows = along(image, width, |i| i % width, 1);
    along(&rows, image.len() / width, |i| i / width, width)
}

/// Returns the mean without the 0.1 % of the values that are largest in magnitude, as comparisons of
/// images leave them out: a few pixels can have half of an error, and which ones is chance.
pub fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    let left_out = values.len() / 1000;
    if left_out > 0 {
        values.select_nth_unstable_by(left_out, |a, b| b.abs().total_cmp(&a.abs()));
    }
    let kept = &values[left_out..];
    kept.iter().sum::<f64>() / kept.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blurring_keeps_constants_and_spreads_a_point() {
        assert!(blurred(&[3.0; 35], 7).iter().all(|value| (value - 3.0).abs() < 1e-12));
        let mut point = vec![0.0; 63];
        point[4 * 7 + 3] = 25.0;
        let spread = blurred(&point, 7);
        assert!((spread[4 * 7 + 3] - 1.0).abs() < 1e-12 && (spread[2 * 7 + 2] - 1.0).abs() < 1e-12);
        assert_eq!((spread[7 + 3], spread[4 * 7]), (0.0, 0.0));
        assert!(blurred(&[], 1).is_empty() && blurred(&[2.0], 1) == [2.0]);
    }
}
