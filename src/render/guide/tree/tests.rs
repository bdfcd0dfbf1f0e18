use super::*;

/// Hardly any caution, so that a test sees what is learned.
const BOLD: Caution = Caution { uniform_share: 0.1, spread: 0.0, penalty: 1.0, leaves: MOST_LEAVES };

/// Numbers that are evenly spread by a hash, each below 1.
fn numbers(index: u32) -> [f32; AXES] {
    let hash = |x: u32| {
        let x = (x ^ x >> 16).wrapping_mul(0x45d9_f3b5);
        let x = (x ^ x >> 15).wrapping_mul(0x2c1b_3c6d);
        x ^ x >> 16
    };
    std::array::from_fn(|axis| (hash(index * AXES as u32 + axis as u32 + 1) >> 8) as f32 / 16_777_216.0)
}

/// Samples of a uniform density; `brings` is what a photon brings.
fn samples(count: u32, brings: impl Fn(&[f32; AXES]) -> f64) -> Vec<Sample> {
    let sample = |index| {
        let numbers = numbers(index);
        Sample { numbers, weight: 1.0 / f64::from(count), square: brings(&numbers).powi(2), cost: 1.0 }
    };
    (0..count).map(sample).collect()
}

fn is_in_the_middle(numbers: &[f32; AXES]) -> bool {
    numbers[2..4].iter().all(|number| (0.45..0.55).contains(number))
}

/// The density times volume over all leaves.
fn total(tree: &Tree) -> f64 {
    fn sum(tree: &Tree, node: &GuideNode, volume: f64) -> f64 {
        if node.axis == GUIDE_LEAF {
            return volume / f64::from(node.value);
        }
        let part = |index: u32, share: f64| sum(tree, &tree.nodes[index as usize], share * volume);
        part(node.lower, node.at.into()) + part(node.lower + 1, 1.0 - f64::from(node.at))
    }
    sum(tree, &tree.nodes[0], 1.0)
}

/// Light that goes through a hundredth of the square: the best density is 100 there, and the mean over uniform samples of
/// the square over the density falls to about a hundredth, less what the uniform share and the margins take.
#[test]
fn a_tree_finds_the_middle() {
    let samples = samples(20_000, |numbers| f64::from(u8::from(is_in_the_middle(numbers))));
    let tree = Tree::learn(&samples, BOLD);
    let [inside, outside] = [0.5, 0.2].map(|place| tree.density(&[0.3, 0.3, place, place, 0.3, 0.3]));
    assert!((30.0..120.0).contains(&inside) && (0.1..0.5).contains(&outside), "{inside} {outside}");
    assert!(tree.gain(&samples) > 30.0, "{}", tree.gain(&samples));
    assert!((total(&tree) - 1.0).abs() < 1e-5, "{}", total(&tree));
}

/// What is only noise has no cells: photons that all bring the same, or a random amount.
#[test]
fn noise_is_not_learned() {
    let random = |numbers: &[f32; AXES]| f64::from((numbers.iter().sum::<f32>() * 1000.0).fract());
    for brings in [&(|_: &[f32; AXES]| 1.0) as &dyn Fn(&[f32; AXES]) -> f64, &random] {
        let tree = Tree::learn(&samples(20_000, brings), BOLD);
        assert!(tree.nodes.len() < 20, "{} nodes", tree.nodes.len());
        assert!((tree.density(&[0.5; AXES]) - 1.0).abs() < 0.2);
    }
    assert_eq!(Tree::learn(&samples(100, |_| 0.0), BOLD).nodes.len(), 1, "nothing is seen");
}

/// Where photons cost four times as much, half as many go.
#[test]
fn costly_photons_are_fewer() {
    let mut samples = samples(20_000, |_| 1.0);
    samples.iter_mut().filter(|sample| sample.numbers[0] < 0.5).for_each(|sample| sample.cost = 4.0);
    let tree = Tree::learn(&samples, Caution { uniform_share: 0.0, ..BOLD });
    let [costly, cheap] = [0.25, 0.75].map(|light| tree.density(&[light, 0.3, 0.3, 0.3, 0.3, 0.3]));
    assert!((costly / cheap - 0.5).abs() < 0.03, "{costly} {cheap}");
}

/// No weight is above 1 over the uniform share.
#[test]
fn weights_are_bounded() {
    let samples = samples(20_000, |numbers| f64::from(numbers[0] * numbers[3]).powi(8));
    let tree = Tree::learn(&samples, Caution { uniform_share: 0.25, ..BOLD });
    let weights = tree.nodes.iter().filter(|node| node.axis == GUIDE_LEAF).map(|node| node.value);
    assert!(weights.fold(0.0, f32::max) <= 4.0001);
}

/// A part where no sample brings anything keeps a share of the chance of each cell around it, and the gain on samples
/// that were not learned from is no less for it.
#[test]
fn a_cautious_tree_leaves_no_part_dark() {
    let samples = samples(20_000, |numbers| f64::from(u8::from(is_in_the_middle(numbers))));
    let caution = Caution { spread: 0.1, ..BOLD };
    let outside = |caution| Tree::learn(&samples, caution).density(&[0.3, 0.3, 0.4, 0.5, 0.3, 0.3]);
    assert!(outside(caution) > 1.5 * outside(BOLD), "{} {}", outside(caution), outside(BOLD));
    assert!(gain_of_halves(&samples, caution) > 10.0, "{}", gain_of_halves(&samples, caution));
}

/// One photon in many thousand is enough to look around it.
#[test]
fn a_bold_tree_follows_one_sample() {
    let place = numbers(77);
    let samples = samples(20_000, |numbers| f64::from(u8::from(*numbers == place)));
    let density = |penalty| Tree::learn(&samples, Caution { penalty, ..BOLD }).density(&place);
    assert!(density(0.2) > 50.0, "{}", density(0.2));
    assert!((density(3.0) - 1.0).abs() < 1e-6, "{}", density(3.0));
}
