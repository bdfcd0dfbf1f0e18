//! random_pair: bits against a twin, nets, and independence.

use crate::fixture::Fixture;
use crate::generated::{DrawPairs, Place, Specialization};
use crate::statistics::{assert_uniform, cells, chi_squared};

fn draw(places: &[Place]) -> Vec<[f32; 2]> {
    let fixture = Fixture::new();
    let (places, pairs) = (fixture.upload(places), fixture.output(places.len()));
    fixture.run(&DrawPairs { places: &places, pairs: &pairs }, places.len() as usize);
    fixture.read(&pairs)
}

fn place(seed: u32, index: u32, pair: u32) -> Place {
    Place { seed, index, pair, pad0: 0 }
}

/// Indices 0 .. count of one pair of dimensions.
fn sequence(seed: u32, pair: u32, count: u32) -> Vec<[f64; 2]> {
    let places: Vec<_> = (0..count).map(|index| place(seed, index, pair)).collect();
    draw(&places).into_iter().map(|pair| pair.map(f64::from)).collect()
}

fn low_discrepancy_pairs() -> u32 {
    Specialization::DECLARED.render.low_discrepancy_pairs
}

const SEEDS: [u32; 5] = [0, 1, 2, 0xdead_beef, u32::MAX];

/// The published algorithms in integers: pcg3d (Jarzynski and Olano 2020), and Burley's
/// nested uniform scramble of Sobol points made of direction numbers.
mod twin {
    pub fn pcg3d(mut v: [u32; 3]) -> [u32; 3] {
        let mix = |v: &mut [u32; 3]| {
            for i in 0..3 {
                v[i] = v[i].wrapping_add(v[(i + 1) % 3].wrapping_mul(v[(i + 2) % 3]));
            }
        };
        v = v.map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
        mix(&mut v);
        v = v.map(|x| x ^ (x >> 16));
        mix(&mut v);
        v
    }

    fn laine_karras(mut x: u32, seed: u32) -> u32 {
        x = x.wrapping_add(seed);
        for factor in [0x6c50_b47c_u32, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
            x ^= x.wrapping_mul(factor);
        }
        x
    }

    fn nested_uniform_scramble(x: u32, seed: u32) -> u32 {
        laine_karras(x.reverse_bits(), seed).reverse_bits()
    }

    /// Sobol's second dimension has the direction numbers v[i + 1] = v[i] ^ v[i] >> 1.
    fn sobol(index: u32) -> [u32; 2] {
        let mut direction = 1_u32 << 31;
        let mut second = 0;
        for bit in 0..32 {
            second ^= if index >> bit & 1 == 1 { direction } else { 0 };
            direction ^= direction >> 1;
        }
        [index.reverse_bits(), second]
    }

    pub fn random_pair(seed: u32, index: u32, pair: u32, low_discrepancy_pairs: u32) -> [f32; 2] {
        let unit = |bits: u32| (bits >> 8) as f32 * (-24.0_f32).exp2();
        if pair >= low_discrepancy_pairs {
            let [x, y, _] = pcg3d([seed, index, pair]);
            return [unit(x), unit(y)];
        }
        let [shuffle, scramble_x, scramble_y] = pcg3d([seed, 0x9e37_79b9, pair]);
        let [x, y] = sobol(nested_uniform_scramble(index, shuffle));
        [unit(nested_uniform_scramble(x, scramble_x)), unit(nested_uniform_scramble(y, scramble_y))]
    }
}

#[test]
fn random_numbers_are_the_published_sequences_bit_for_bit() {
    let mut rng = crate::fixture::Rng(1);
    let places: Vec<_> = (0..300_000)
        .map(|i| {
            let index = rng.bits() as u32 >> (i % 32);
            place(rng.bits() as u32, index, rng.below(40) as u32)
        })
        .collect();
    for (place, drawn) in places.iter().zip(draw(&places)) {
        let expected = twin::random_pair(place.seed, place.index, place.pair, low_discrepancy_pairs());
        assert_eq!(drawn, expected, "{place:?}");
        assert!(drawn.iter().all(|x| (0.0..1.0).contains(x)), "{place:?}: {drawn:?}");
    }
}

/// Every elementary interval of area 1 / points.len() must hold one point.
fn assert_net(points: &[[f64; 2]], what: &str) {
    let bits = points.len().ilog2();
    for x_bits in 0..=bits {
        let (columns, rows) = (1_usize << x_bits, 1_usize << (bits - x_bits));
        let mut taken = vec![false; points.len()];
        for [x, y] in points {
            let cell = (y * rows as f64) as usize * columns + (x * columns as f64) as usize;
            assert!(!taken[cell], "{what}: two points in one of {columns} by {rows} cells");
            taken[cell] = true;
        }
    }
}

/// Not only the first points: each aligned run of a power of two, as batches take them.
#[test]
fn low_discrepancy_pairs_are_nets_at_every_power_of_two() {
    const COUNT: u32 = 1 << 14;
    for seed in SEEDS {
        for pair in 0..low_discrepancy_pairs() {
            let points = sequence(seed, pair, COUNT);
            for bits in 0..=COUNT.ilog2() {
                for run in points.chunks_exact(1 << bits).take(3) {
                    assert_net(run, &format!("seed {seed}, pair {pair}"));
                }
            }
        }
    }
}

#[test]
fn hashed_pairs_are_uniform() {
    for seed in SEEDS {
        for pair in [low_discrepancy_pairs(), low_discrepancy_pairs() + 1, 37, 1000] {
            let points = sequence(seed, pair, 1 << 16);
            assert_uniform(&cells(points, 32), &format!("seed {seed}, pair {pair}"));
        }
    }
}

/// Pixels have seeds of their own and begin at index 0: across seeds, each index must be
/// uniform, for pairs of either kind.
#[test]
fn any_index_is_uniform_over_seeds() {
    for pair in [0, 1, low_discrepancy_pairs() - 1, low_discrepancy_pairs()] {
        for index in [0, 1, 2, 1023] {
            let places: Vec<_> = (0..1 << 16).map(|seed| place(seed, index, pair)).collect();
            let points = draw(&places).into_iter().map(|pair| pair.map(f64::from));
            assert_uniform(&cells(points, 32), &format!("pair {pair}, index {index}"));
        }
    }
}

/// One coordinate of each of two sequences makes points that fill the square.
///
/// Chi squared of 2^14 consecutive points in 16 by 16 cells is wider than of independent
/// ones: runs of 16 indices are nested permutations, which are alike as a whole where their
/// first flips agree. That adds 16 times the square of a normal variable, and half as much
/// for each finer level: up to 32 * 36 in six standard deviations.
fn assert_unrelated(a: &[[f64; 2]], b: &[[f64; 2]], what: &str) {
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let points = a.iter().zip(b).map(|(a, b)| [a[i], b[j]]);
        let chi2 = chi_squared(&cells(points, 16));
        assert!(chi2 <= 255.0 + 32.0 * 36.0, "{what}, coordinates {i} and {j}: chi squared {chi2:.0}");
    }
}

#[test]
fn pairs_of_dimensions_are_unrelated() {
    let sequences: Vec<_> = (0..low_discrepancy_pairs() + 3).map(|pair| sequence(7, pair, 1 << 14)).collect();
    for (i, a) in sequences.iter().enumerate() {
        for (j, b) in sequences.iter().enumerate().skip(i + 1) {
            assert_unrelated(a, b, &format!("pairs {i} and {j}"));
        }
    }
}

#[test]
fn seeds_are_unrelated() {
    for pair in [0, 3, low_discrepancy_pairs()] {
        let sequences: Vec<_> = SEEDS.iter().map(|seed| sequence(*seed, pair, 1 << 14)).collect();
        for (i, a) in sequences.iter().enumerate() {
            for (j, b) in sequences.iter().enumerate().skip(i + 1) {
                assert_unrelated(a, b, &format!("pair {pair}, seeds {} and {}", SEEDS[i], SEEDS[j]));
            }
        }
    }
}

/// Far apart, points of two dimensions are independent, so that chi squared is sharp.
#[test]
fn scattered_points_of_two_pairs_are_independent() {
    let mut rng = crate::fixture::Rng(3);
    let indices: Vec<u32> = (0..1 << 14).map(|_| rng.bits() as u32 >> 8).collect();
    let drawn: Vec<Vec<_>> = (0..low_discrepancy_pairs() + 2)
        .map(|pair| draw(&indices.iter().map(|index| place(11, *index, pair)).collect::<Vec<_>>()))
        .collect();
    for (i, a) in drawn.iter().enumerate() {
        for (j, b) in drawn.iter().enumerate().skip(i + 1) {
            for (x, y) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let points = a.iter().zip(b).map(|(a, b)| [a[x], b[y]].map(f64::from));
                assert_uniform(&cells(points, 16), &format!("pairs {i} and {j}, coordinates {x} and {y}"));
            }
        }
    }
}

#[test]
fn neighbouring_indices_are_unrelated_where_pairs_are_hashed() {
    let points = sequence(5, low_discrepancy_pairs() + 2, (1 << 15) + 1);
    assert_unrelated(&points[1..], &points[..1 << 15], "one index apart");
}
