//! The iterations of a render: their order in rounds, and their distribution over shards.

/// One of several renders that share the iterations: it renders every `count`-th round, starting with round
/// `index`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// The index of the shard, from 0.
    pub index: u32,
    /// The number of shards.
    pub count: u32,
}

impl Default for Shard {
    fn default() -> Self {
        Self::WHOLE
    }
}

impl Shard {
    /// The only shard of a render, with all rounds.
    pub const WHOLE: Self = Self { index: 0, count: 1 };
    /// The largest number of shards. With it, 64 bits are enough for the numbers of all iterations.
    pub const MAX_COUNT: u32 = 1 << 16;
}

/// The iterations of a shard. The iterations of a round share their eye paths. A round has one iteration in
/// stochastic progressive photon mapping, and many in progressive photon mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sequence {
    /// The number of iterations in a round.
    pub round_length: u32,
    /// The shard, which determines the rounds.
    pub shard: Shard,
}

/// The position of an iteration in the sequence of all shards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IterationIndex {
    /// The number of its round among the rounds of all shards, from 0.
    pub round: u32,
    /// Its number within the round, from 0.
    pub step: u32,
    /// Its number among the iterations of all shards, from 0.
    pub iteration: u64,
    /// The half of its round, 0 or 1. The random numbers of the two halves are independent.
    pub half: u32,
    /// The number of its round among the rounds of its half, from 0.
    pub turn: u32,
    /// Its number among the iterations of its half, from 0.
    pub iteration_of_half: u64,
}

/// Returns the half of a round. Of rounds 2k and 2k + 1, one is in each half. The half is the parity of the
/// bits of the number (Thue and Morse), so that the rounds of each shard are divided evenly too.
fn half(round: u64) -> u32 {
    round.count_ones() % 2
}

impl Sequence {
    /// Returns the place of this shard's next iteration after `done` iterations.
    pub fn index(&self, done: u32) -> IterationIndex {
        let round = u64::from(self.shard.index) + u64::from(self.shard.count) * u64::from(done / self.round_length);
        let step = done % self.round_length;
        let length = u64::from(self.round_length);
        let turn = round / 2;
        IterationIndex {
            // Random numbers use 32 bits of the number of the round, and repeat after 2^32 rounds.
            round: round as u32,
            step,
            iteration: round * length + u64::from(step),
            half: half(round),
            turn: turn as u32,
            iteration_of_half: turn * length + u64::from(step),
        }
    }

    /// Returns the number of this shard's iterations among the first `total` iterations of all shards.
    pub fn share(&self, total: u32) -> u32 {
        let (rounds, rest) = (total / self.round_length, total % self.round_length);
        let Shard { index, count } = self.shard;
        let full = rounds / count + u32::from(rounds % count > index);
        let partial = if rounds % count == index { rest } else { 0 };
        full * self.round_length + partial
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_all_iterations_without_overlap() {
        for round_length in [1, 3, 16] {
            for count in [1, 2, 3, 7] {
                for total in [0, 1, 2, 15, 16, 17, 100] {
                    let mut seen = vec![0; total as usize];
                    for index in 0..count {
                        let sequence = Sequence { round_length, shard: Shard { index, count } };
                        for done in 0..sequence.share(total) {
                            let index = sequence.index(done);
                            assert_eq!(index.iteration / u64::from(round_length), u64::from(index.round));
                            seen[index.iteration as usize] += 1;
                        }
                    }
                    assert!(seen.iter().all(|times| *times == 1), "{round_length} {count} {total}: {seen:?}");
                }
            }
        }
    }

    #[test]
    fn iterations_are_counted_beyond_32_bits() {
        let sequence = Sequence { round_length: 1 << 20, shard: Shard { index: 5, count: 8 } };
        let index = sequence.index(u32::MAX);
        assert_eq!(index.iteration, (5 + 8 * 4095) * (1 << 20) + (1 << 20) - 1);
        assert_eq!(index.iteration_of_half, ((5 + 8 * 4095) / 2) * (1 << 20) + (1 << 20) - 1);
    }

    #[test]
    fn halves_take_turns_in_every_shard() {
        for (round_length, index, count) in [(1, 0, 1), (3, 0, 1), (1, 1, 2), (1, 2, 4), (4, 5, 7)] {
            let sequence = Sequence { round_length, shard: Shard { index, count } };
            let mut halves = [0_u64; 2];
            let mut turns = [std::collections::HashSet::new(), std::collections::HashSet::new()];
            for done in 0..100 * round_length {
                let index = sequence.index(done);
                halves[index.half as usize] += 1;
                assert!(turns[index.half as usize].insert(index.iteration_of_half), "{index:?}");
            }
            assert!(halves[0].abs_diff(halves[1]) <= 20 * u64::from(round_length), "{sequence:?}: {halves:?}");
        }
    }
}
