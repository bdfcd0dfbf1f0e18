//! Tests of distributions. Inputs have fixed seeds, so that a test passes always or never;
//! limits are six standard deviations, 2e-9 for a right sampler with an unlucky seed.

/// How far `counts` are from equal chances. Of independent samples it has mean and half
/// variance equal to the degrees of freedom.
pub fn chi_squared(counts: &[u32]) -> f64 {
    let total: f64 = counts.iter().map(|count| f64::from(*count)).sum();
    let expected = total / counts.len() as f64;
    assert!(expected >= 20.0, "too few samples for {} cells", counts.len());
    counts.iter().map(|count| (f64::from(*count) - expected).powi(2) / expected).sum()
}

/// Panics unless `counts` fit equal chances. Better than random is fine: samples may be
/// stratified.
pub fn assert_uniform(counts: &[u32], what: &str) {
    let chi2 = chi_squared(counts);
    let freedom = (counts.len() - 1) as f64;
    let limit = freedom + 6.0 * (2.0 * freedom).sqrt() + 12.0;
    assert!(chi2 <= limit, "{what}: chi squared {chi2:.1} of {freedom} degrees of freedom");
}

/// Counts pairs of numbers in [0, 1] in `side` times `side` cells.
pub fn cells(points: impl IntoIterator<Item = [f64; 2]>, side: usize) -> Vec<u32> {
    let mut counts = vec![0; side * side];
    let place = |x: f64| ((x * side as f64) as usize).min(side - 1);
    for [x, y] in points {
        counts[place(y) * side + place(x)] += 1;
    }
    counts
}

/// Panics unless the values, which a distribution function made of samples, are uniform in
/// [0, 1] by Kolmogorov and Smirnov's test. Its limit exp(-2 n d^2) = 1e-9 is 3.22 / sqrt n.
pub fn assert_quantiles(mut values: Vec<f64>, what: &str) {
    values.sort_by(f64::total_cmp);
    let n = values.len() as f64;
    let distance = values
        .iter()
        .enumerate()
        .map(|(i, value)| (value - i as f64 / n).abs().max((value - (i + 1) as f64 / n).abs()))
        .fold(0.0, f64::max);
    assert!(distance <= 3.22 / n.sqrt(), "{what}: quantiles are off by {distance} of {n} samples");
}

/// Panics unless `value` is within a relative tolerance.
pub fn assert_near(value: f64, expected: f64, tolerance: f64, what: &str) {
    let error = (value - expected).abs() / expected.abs().max(f64::MIN_POSITIVE);
    assert!(error <= tolerance, "{what}: {value} is not {expected}, off by {error:e}");
}
