//! Sobol' points that are handed to pixels along a space-filling curve, so that errors of neighbouring pixels differ.
//!
//! ```text
//!      pixels of a block along the curve     index of a sample: digits of base 4
//!          0 1 4 5                               curve position of the pixel | index of the sample
//!          2 3 6 7     each digit permuted           d d d d d d d d         |     d d d d
//!          8 9 ...     by the digits before it
//! ```

use rt_math::random::{mix, permute, unit};

/// Pixels along the side of a block that shares one sequence, as a power of two: 128. Blocks are independent of each other.
const LOG_SIDE: u32 = 7;

/// A sample of a pixel among all samples of its block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CurveIndex {
    /// Position on the curve, with the index of the sample in the low digits.
    index: u64,
    /// Binary digits of the index.
    digits: u32,
}

impl CurveIndex {
    /// The sample number `number` of `2^log_count` samples of a pixel.
    pub(crate) fn new(pixel: [u32; 2], number: u32, log_count: u32) -> Self {
        let place = interleaved(pixel[0] % (1 << LOG_SIDE)) | interleaved(pixel[1] % (1 << LOG_SIDE)) << 1;
        Self { index: place << log_count | u64::from(number), digits: 2 * LOG_SIDE + log_count }
    }

    /// The block that a pixel lies in.
    pub(crate) const fn block(pixel: [u32; 2]) -> [u32; 2] {
        [pixel[0] >> LOG_SIDE, pixel[1] >> LOG_SIDE]
    }

    /// The point of a block for this sample, for the pair of dimensions chosen by `key`.
    ///
    /// Samples of a pixel, of 2×2, of 4×4 pixels and so on are whole parts of a (0, 2)-sequence. Together they cover
    /// the square evenly (Ahmed and Wonka 2020). Each pair of dimensions has its own permutation of digits, which makes
    /// the pairs independent. Owen scrambling makes each point uniform.
    pub(crate) fn point(self, key: u64) -> [f64; 2] {
        let index = self.shuffled(mix(key));
        [(index.reverse_bits(), key ^ 1), (second_inverse(index), key ^ 2)]
            .map(|(bits, key)| unit(owen_scrambled(bits, self.digits, mix(key))))
    }

    /// Each digit of base 4 permuted by one of 24 permutations, which depends on the digits before it. A single binary digit
    /// that is left over is flipped or not.
    fn shuffled(self, key: u64) -> u64 {
        let (mut place, mut result) = (self.digits, 0);
        while place > 0 {
            let width = place.min(2);
            place -= width;
            let before = self.index >> (place + width);
            let digit = (self.index >> place) as u32 & ((1 << width) - 1);
            // The leading one distinguishes equal digits at different places.
            let node = 1 << (self.digits - place - width) | before;
            result = result << width | u64::from(permute(digit, 1 << width, mix(key ^ node)));
        }
        result
    }
}

/// The bits of a number below 2¹⁶, with zeros between.
const fn interleaved(number: u32) -> u64 {
    let mut bits = number as u64 & 0xffff;
    bits = (bits | bits << 8) & 0x00ff_00ff;
    bits = (bits | bits << 4) & 0x0f0f_0f0f;
    bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

/// The second coordinate of the Sobol' sequence as a fraction of 2⁶⁴; the first is the index with its bits reversed. Column k of
/// its matrix is row k of Pascal's triangle modulo 2 (Sobol' 1967).
fn second_inverse(mut index: u64) -> u64 {
    let (mut inverse, mut column) = (0, 1 << 63);
    while index != 0 {
        if index & 1 == 1 {
            inverse ^= column;
        }
        column ^= column >> 1;
        index >>= 1;
    }
    inverse
}

/// Owen's scramble of a binary fraction of 2⁶⁴ (1995). The digits before each of the first `count` digits decide
/// whether it is flipped. The digits after them are random.
fn owen_scrambled(bits: u64, count: u32, key: u64) -> u64 {
    let mut scrambled = 0;
    for place in 0..=count {
        let before = if place == 0 { 0 } else { bits >> (64 - place) };
        let random = mix(key ^ (1 << place | before));
        // Below the last digit, all bits are random.
        let kept = if place == count { u64::MAX } else { 1 << 63 };
        let digit = if place == count { random } else { random ^ bits << place };
        scrambled |= (digit & kept) >> place;
    }
    scrambled
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_visits_quarters_of_quarters() {
        let place = |x: u32, y: u32| CurveIndex::new([x, y], 0, 0).index;
        assert_eq!([place(0, 0), place(1, 0), place(0, 1), place(1, 1), place(2, 0)], [0, 1, 2, 3, 4]);
        assert_eq!([place(127, 127), place(128, 0)], [(1 << 14) - 1, 0]);
        assert_eq!(CurveIndex::new([1, 0], 5, 3), CurveIndex { index: 13, digits: 17 });
        assert_eq!(CurveIndex::block([300, 127]), [2, 0]);
    }

    #[test]
    fn the_second_coordinate_is_that_of_sobol() {
        // 0, 1/2, 3/4, 1/4, 5/8, 1/8, 3/8, 7/8.
        let eighths = (0..8).map(|index| second_inverse(index) >> 61);
        assert!(eighths.eq([0, 4, 6, 2, 5, 1, 3, 7]));
    }

    #[test]
    fn shuffling_keeps_every_part_together() {
        for log_count in [0, 3, 4] {
            for key in 0..20 {
                let of = |index| CurveIndex { index, digits: 14 + log_count }.shuffled(key);
                let mut seen: Vec<_> = (0..256).map(of).collect();
                let whole = seen[0] >> 8;
                if (14 + log_count) % 2 == 0 {
                    assert!(seen.iter().all(|index| index >> 8 == whole));
                    assert!(seen.chunks(4).all(|part| part.iter().all(|index| index >> 2 == part[0] >> 2)));
                }
                seen.sort_unstable();
                seen.dedup();
                assert_eq!(seen.len(), 256);
            }
        }
    }

    #[test]
    fn scrambling_is_a_nested_permutation() {
        let top = |index: u64, digits: u32| owen_scrambled(index << 58, 6, 99) >> (64 - digits);
        let mut seen: Vec<_> = (0..64).map(|index| top(index, 6)).collect();
        // Numbers that agree in their first digits agree there afterwards.
        for (a, b) in (0..64).flat_map(|a| (0..64).map(move |b| (a, b))) {
            for digits in 1..=6 {
                assert_eq!(a >> (6 - digits) == b >> (6 - digits), top(a, digits) == top(b, digits));
            }
        }
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..64));
    }
}
