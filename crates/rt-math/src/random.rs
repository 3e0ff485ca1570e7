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

/// SIMD version of [`mix`]. Equal words are mixed once.
#[inline(always)]
pub fn mix_lanes<const N: usize>(words: [u64; N]) -> [u64; N] {
    let mut mixed = [0; N];
    let mut differences = 0;
    for lane in 1..N {
        differences |= words[lane] ^ words[0];
    }
    if N > 1 && differences == 0 {
        return [mix(words[0]); N];
    }
    for lane in 0..N {
        mixed[lane] = mix(words[lane]);
    }
    mixed
}

/// The top 53 bits as a number in `[0, 1)`.
#[inline]
pub fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// Position of `index` under a pseudo-random permutation of `0..length` chosen by `seed`; 0 for an empty range. Indices beyond
/// the range wrap around.
///
/// A bijection of the next power of two is iterated until the result is in the range (Kensler 2013; cycle walking, Black and
/// Rogaway). Then the range is rotated. The rotation makes all positions of an index equally likely.
pub fn permute(index: u32, length: u32, seed: u64) -> u32 {
    permute_lanes([index], length, [seed])[0]
}

/// SIMD version of [`permute`]: positions of `N` indices, each under the permutation of its own seed.
#[inline(always)]
pub fn permute_lanes<const N: usize>(indices: [u32; N], length: u32, seeds: [u64; N]) -> [u32; N] {
    if length <= 1 {
        return [0; N];
    }
    let bits = (length - 1).ilog2() + 1;
    let mask = u32::MAX >> (32 - bits);
    let half = (bits / 2).max(1);
    let (mut low, mut high, mut values) = ([0; N], [0; N], [0; N]);
    let keys = mix_lanes(seeds);
    for lane in 0..N {
        (low[lane], high[lane]) = (keys[lane] as u32, (keys[lane] >> 32) as u32);
    }
    let mut beyond = false;
    for lane in 0..N {
        values[lane] = indices[lane];
        beyond |= indices[lane] >= length;
    }
    if beyond {
        for value in &mut values {
            *value %= length;
        }
    }
    scramble(&mut values, &low, &high, mask, half);
    // A power of two needs no cycle walk: all values are in the range.
    while mask >= length && values.iter().fold(false, |beyond, &value| beyond | (value >= length)) {
        let mut further = values;
        scramble(&mut further, &low, &high, mask, half);
        for lane in 0..N {
            values[lane] = if values[lane] < length { values[lane] } else { further[lane] };
        }
    }
    for lane in 0..N {
        let rotation = (u64::from(high[lane]).wrapping_mul(u64::from(length)) >> 32) as u32;
        let to_the_end = length.wrapping_sub(rotation);
        let start = if values[lane] < to_the_end { 0 } else { length };
        values[lane] = values[lane].wrapping_add(rotation).wrapping_sub(start);
    }
    values
}

/// Bijection of the numbers up to `mask`, which is a power of two less one, for the halves of a key per lane.
#[inline(always)]
fn scramble<const N: usize>(values: &mut [u32; N], low: &[u32; N], high: &[u32; N], mask: u32, half: u32) {
    for lane in 0..N {
        let (mut value, low, high) = (values[lane], low[lane], high[lane]);
        // Halves of the key, rotated by up to 24 bits. Rotation by 32 bits exchanges the halves.
        let low = [low, low << 8 | high >> 24, low << 16 | high >> 16, low << 24 | high >> 8];
        let high = [high, high << 8 | low[0] >> 24, high << 16 | low[0] >> 16, high << 24 | low[0] >> 8];
        // Xor, odd multiplication and xor-shift are bijections. Multiplication carries changes to higher bits and
        // the shift to lower ones; the shortest ranges need all eight rounds.
        for round in 0..8 {
            let (added, factor) = if round < 4 { (low[round], high[round]) } else { (high[round - 4], low[round - 4]) };
            value ^= added & mask;
            value = value.wrapping_mul(factor | 1) & mask;
            value ^= value >> if round % 2 == 0 { half } else { 1 };
        }
        values[lane] = value;
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
    fn lanes_hold_the_bits_of_their_own_words() {
        for words in [[7; 5], [7, 7, 7, 7, 8], [1, 2, 3, 4, u64::MAX]] {
            assert_eq!(mix_lanes(words), words.map(mix));
        }
    }

    #[test]
    fn lanes_hold_the_positions_of_their_own_permutations() {
        for length in [0, 1, 2, 3, 7, 16, 100, 257, u32::MAX] {
            for seed in 0..20u64 {
                // Permutations of two seeds, and indices around the end of the range.
                let seeds: [u64; 13] = core::array::from_fn(|lane| seed + lane as u64 / 5);
                let indices: [u32; 13] = core::array::from_fn(|lane| length.wrapping_sub(6).wrapping_add(lane as u32));
                let one_by_one = core::array::from_fn(|lane| permute(indices[lane], length, seeds[lane]));
                assert_eq!(permute_lanes(indices, length, seeds), one_by_one, "length {length}, seed {seed}");
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
