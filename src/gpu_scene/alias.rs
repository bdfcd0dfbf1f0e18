//! Choice of one of N indices with given probabilities in constant time.

use crate::kernels::AliasEntry;

/// Returns an alias table (Vose 1991) over non-negative weights, one entry per weight; the entries contain
/// `indices`. The table is empty if all weights are 0.
pub fn table(weights: &[f64], indices: &[u32]) -> Vec<AliasEntry> {
    let total: f64 = weights.iter().sum();
    if total <= 0.0 {
        return Vec::new();
    }
    let mut scaled: Vec<f64> = weights.iter().map(|weight| weight * weights.len() as f64 / total).collect();
    let mut entries: Vec<AliasEntry> =
        indices.iter().map(|index| AliasEntry { threshold: 1.0, keep: *index, alias: *index, chance: 0.0 }).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..scaled.len()).partition(|i| scaled[*i] < 1.0);
    while let (Some(less), Some(more)) = (small.pop(), large.last().copied()) {
        entries[less].threshold = scaled[less] as f32;
        entries[less].alias = indices[more];
        scaled[more] -= 1.0 - scaled[less];
        if scaled[more] < 1.0 {
            large.pop();
            small.push(more);
        }
    }
    entries
}

/// Returns an alias table over all indices, whose entries know the chance of their index (`direct_table` with a guide).
pub fn table_with_chances(weights: &[f64]) -> Vec<AliasEntry> {
    let indices: Vec<u32> = (0..weights.len() as u32).collect();
    let total: f64 = weights.iter().sum();
    let chance = |(entry, weight): (AliasEntry, &f64)| AliasEntry { chance: (weight / total) as f32, ..entry };
    table(weights, &indices).into_iter().zip(weights).map(chance).collect()
}

#[cfg(test)]
mod tests {
    use super::table;

    #[test]
    fn chances_are_the_weights() {
        let weights = [3.0, 0.0, 1.0, 4.0, 0.5];
        let entries = table(&weights, &[10, 11, 12, 13, 14]);
        for (weight, index) in weights.iter().zip(10..) {
            let chance: f64 = entries
                .iter()
                .map(|entry| {
                    let threshold = f64::from(entry.threshold);
                    let kept = if entry.keep == index { threshold } else { 0.0 };
                    kept + if entry.alias == index { 1.0 - threshold } else { 0.0 }
                })
                .sum();
            assert!((chance / weights.len() as f64 - weight / 8.5).abs() < 1e-6);
        }
    }

    #[test]
    fn no_weight_gives_no_entries() {
        assert!(table(&[0.0, 0.0], &[0, 1]).is_empty());
    }
}
