//! Random numbers by hashing: no state, so that any thread can compute any number in any order.

/// Mixes words into 64 well-distributed bits.
///
/// Each word is folded in with the finaliser of SplitMix64 (Steele, Lea, Flood 2014, as tuned by Stafford, mix 13),
/// so `hash(&[a, b])` differs from `hash(&[b, a])`.
pub fn hash(words: &[u64]) -> u64 {
    words.iter().fold(0x9e37_79b9_7f4a_7c15, |state, &word| {
        mix(state.rotate_left(23) ^ mix(word.wrapping_add(0x9e37_79b9_7f4a_7c15)))
    })
}

/// Bijection of 64-bit words in which every input bit flips about half of the output bits.
#[inline]
pub fn mix(word: u64) -> u64 {
    let word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ (word >> 31)
}

/// The top 53 bits as a number in `[0, 1)`.
#[inline]
pub fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// Position of `index` under a pseudo-random permutation of `0..length` chosen by `seed`; 0 for an empty range. For more
/// than one index of the same permutation, prepare a [`Permutation`].
pub fn permute(index: u32, length: u32, seed: u64) -> u32 {
    Permutation::new(length, seed).position(index)
}

/// A pseudo-random permutation of `0..length` (after Kensler 2013).
///
/// A bijection of the next power of two is iterated until the result is in the range (cycle walking, Black and
/// Rogaway). Then the range is rotated. The rotation makes all positions of an index equally likely.
#[derive(Clone, Copy, Debug)]
pub struct Permutation {
    length: u32,
    mask: u32,
    /// Half of the bits of a position.
    half: u32,
    rotation: u32,
    key: u64,
}

impl Permutation {
    /// Permutation of `0..length` for this `seed`.
    #[inline]
    pub fn new(length: u32, seed: u64) -> Self {
        let bits = if length <= 1 { 1 } else { (length - 1).ilog2() + 1 };
        let key = mix(seed);
        let rotation = (((key >> 32) * u64::from(length)) >> 32) as u32;
        Self { length, mask: u32::MAX >> (32 - bits), half: (bits / 2).max(1), rotation, key }
    }

    /// Position of `index`; 0 in an empty range. Indices beyond the range wrap around.
    #[inline]
    pub fn position(&self, index: u32) -> u32 {
        if self.length <= 1 {
            return 0;
        }
        let mut value = [if index < self.length { index } else { index % self.length }];
        self.scramble(&mut value);
        self.cycle_walk(value[0])
    }

    /// Positions of consecutive indices from `first` on: each [`position`](Self::position).
    #[inline]
    pub fn positions(&self, first: u32, positions: &mut [u32]) {
        const SIDE_BY_SIDE: usize = 16;
        if self.length <= 1 {
            return positions.fill(0);
        }
        let mut index = first % self.length;
        for positions in positions.chunks_mut(SIDE_BY_SIDE) {
            let mut values = [0; SIDE_BY_SIDE];
            for value in &mut values[..positions.len()] {
                *value = index;
                index = if index + 1 < self.length { index + 1 } else { 0 };
            }
            self.scramble(&mut values);
            for (position, value) in positions.iter_mut().zip(values) {
                *position = self.cycle_walk(value);
            }
        }
    }

    /// Bijection of the numbers below the next power of two.
    #[inline(always)]
    fn scramble<const N: usize>(&self, values: &mut [u32; N]) {
        // Xor, odd multiplication and xor-shift are bijections. Multiplication carries changes to higher bits and
        // the shift to lower ones; the shortest ranges need all eight rounds.
        for round in 0..8u32 {
            let key = self.key.rotate_left(8 * round);
            let shift = if round % 2 == 0 { self.half } else { 1 };
            for value in values.iter_mut() {
                *value ^= key as u32 & self.mask;
                *value = value.wrapping_mul((key >> 32) as u32 | 1) & self.mask;
                *value ^= *value >> shift;
            }
        }
    }

    /// Cycle walking: repeats the bijection until the number is in the range.
    #[inline(always)]
    fn cycle_walk(&self, value: u32) -> u32 {
        let mut value = [value];
        while value[0] >= self.length {
            self.scramble(&mut value);
        }
        let to_the_end = self.length - self.rotation;
        if value[0] < to_the_end { value[0] + self.rotation } else { value[0] - to_the_end }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_of_words_matters() {
        assert_ne!(hash(&[1, 2]), hash(&[2, 1]));
        assert_ne!(hash(&[0]), hash(&[0, 0]));
    }

    #[test]
    fn unit_numbers_are_uniform() {
        let bins = 64;
        let draws = 64_000u64;
        let mut counts = vec![0.0; bins];
        for i in 0..draws {
            let x = unit(hash(&[7, i]));
            assert!((0.0..1.0).contains(&x));
            counts[(x * bins as f64) as usize] += 1.0;
        }
        let expected = draws as f64 / bins as f64;
        let chi2: f64 = counts.iter().map(|c| (c - expected) * (c - expected) / expected).sum();
        // 63 degrees of freedom: mean 63, standard deviation 11.2.
        assert!((30.0..110.0).contains(&chi2), "chi² = {chi2}");
    }

    #[test]
    fn unit_never_reaches_one() {
        assert!(unit(u64::MAX) < 1.0);
        assert_eq!(unit(0), 0.0);
    }

    #[test]
    fn positions_side_by_side_are_those_one_by_one() {
        for length in [0, 1, 2, 3, 7, 16, 100, 257] {
            for first in [0, 1, 5, length, length + 3] {
                let permutation = Permutation::new(length, u64::from(length) * 31 + 1);
                let mut positions = [0; 40];
                permutation.positions(first, &mut positions);
                let one_by_one: Vec<_> = (first..first + 40).map(|index| permutation.position(index)).collect();
                assert_eq!(positions[..], one_by_one[..], "length {length} from {first}");
            }
        }
    }

    #[test]
    fn permute_is_a_permutation() {
        for length in [1, 2, 3, 7, 16, 100, 257] {
            for seed in 0..20 {
                let mut seen = vec![false; length as usize];
                for i in 0..length {
                    let p = permute(i, length, seed) as usize;
                    assert!(!seen[p], "length {length}, seed {seed}: {p} twice");
                    seen[p] = true;
                }
            }
        }
    }

    /// Regression: short ranges had a favourite position for each index, and pairs that never occurred together.
    #[test]
    fn permutations_of_short_ranges_are_equally_likely() {
        let seeds = 20_000;
        for length in [2u32, 3, 4, 5, 6, 8, 9, 16] {
            for (i, j) in [(0, 1), (0, length - 1), (length / 2, 0), (length - 1, length / 2 - 1)] {
                let mut counts = vec![0.0; (length * length) as usize];
                for seed in 0..seeds {
                    counts[(permute(i, length, seed) * length + permute(j, length, seed)) as usize] += 1.0;
                }
                let choices = f64::from(length * (length - 1));
                let expected = seeds as f64 / choices;
                let pairs = counts.iter().enumerate().filter(|(at, _)| at / length as usize != at % length as usize);
                let chi2: f64 = pairs.map(|(_, c)| (c - expected) * (c - expected) / expected).sum();
                let freedom = choices - 1.0;
                // Six standard deviations, and 4 % for what eight rounds leave.
                let limit = freedom + 6.0 * (2.0 * freedom).sqrt() + 0.04 * 0.04 * seeds as f64;
                assert!(chi2 < limit, "length {length}, {i} and {j}: chi² = {chi2}, limit {limit}");
            }
        }
    }

    #[test]
    fn permute_depends_on_the_seed() {
        let at = |seed| (0..16).map(|i| permute(i, 16, seed)).collect::<Vec<_>>();
        let distinct: std::collections::HashSet<_> = (0..50).map(at).collect();
        assert!(distinct.len() > 45, "{}", distinct.len());
    }
}
