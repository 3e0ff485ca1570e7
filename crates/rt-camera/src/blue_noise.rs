//! Sobol' points that are handed to pixels along a space-filling curve, so that errors of neighbouring pixels differ.
//!
//! ```text
//!      pixels of a block along the curve     index of a sample: digits of base 4
//!          0 1 4 5                               curve position of the pixel | index of the sample
//!          2 3 6 7     each digit permuted           d d d d d d d d         |     d d d d
//!          8 9 ...     by the digits before it
//! ```

use rt_math::random::{mix, permute_lanes, unit};

use crate::simd::lanes;

/// Pixels along the side of a block that shares one sequence, as a power of two: 128. Blocks are independent of each other.
const LOG_SIDE: u32 = 7;

/// The block that a pixel lies in.
pub(crate) const fn block(pixel: [u32; 2]) -> [u32; 2] {
    [pixel[0] >> LOG_SIDE, pixel[1] >> LOG_SIDE]
}

/// The points of a block, in `[0, 1)²`, for samples of pixels: each has a number below `2^log_count`, which is the count of samples
/// per pixel. A key chooses the pair of dimensions.
///
/// Samples of a pixel, of 2×2, of 4×4 pixels and so on are whole parts of a (0, 2)-sequence. Together they cover
/// the square evenly (Ahmed and Wonka 2020). Each pair of dimensions has its own permutation of digits, which makes
/// the pairs independent. Owen scrambling makes each point uniform.
#[inline(always)]
pub(crate) fn pairs<const N: usize>(
    pixels: &[[u32; 2]; N],
    numbers: &[u32; N],
    log_count: u32,
    keys: &[u64; N],
) -> [[f64; 2]; N] {
    let digits = 2 * LOG_SIDE + log_count;
    let indices: [_; N] = lanes(|lane| curve_index(pixels[lane], numbers[lane], log_count));
    let indices = shuffled(indices, digits, lanes(|lane| mix(keys[lane])));
    let x: [_; N] = lanes(|lane| indices[lane].reverse_bits());
    let x = owen_scrambled(x, digits, lanes(|lane| mix(keys[lane] ^ 1)));
    let y: [_; N] = lanes(|lane| second_inverse(indices[lane]));
    let y = owen_scrambled(y, digits, lanes(|lane| mix(keys[lane] ^ 2)));
    lanes(|lane| [unit(x[lane]), unit(y[lane])])
}

/// A sample of a pixel among all samples of its block: position on the curve, with the number of the sample in the low digits.
#[inline(always)]
const fn curve_index(pixel: [u32; 2], number: u32, log_count: u32) -> u64 {
    let place = interleaved(pixel[0] % (1 << LOG_SIDE)) | interleaved(pixel[1] % (1 << LOG_SIDE)) << 1;
    place << log_count | number as u64
}

/// Each digit of base 4 permuted by one of 24 permutations, which depends on the digits before it. A single binary digit
/// that is left over is flipped or not. `count` is the number of binary digits.
#[inline(always)]
fn shuffled<const N: usize>(indices: [u64; N], count: u32, keys: [u64; N]) -> [u64; N] {
    let (mut place, mut results) = (count, [0; N]);
    while place > 0 {
        let width = place.min(2);
        place -= width;
        let digits: [_; N] = lanes(|lane| (indices[lane] >> place) as u32 & ((1 << width) - 1));
        // The leading one distinguishes equal digits at different places.
        let leading = 1 << (count - place - width);
        let nodes = lanes(|lane| mix(keys[lane] ^ (leading | indices[lane] >> (place + width))));
        let permuted = permute_lanes(digits, 1 << width, nodes);
        for lane in 0..N {
            results[lane] = results[lane] << width | u64::from(permuted[lane]);
        }
    }
    results
}

/// The bits of a number below 2¹⁶, with zeros between.
#[inline(always)]
const fn interleaved(number: u32) -> u64 {
    let mut bits = number as u64 & 0xffff;
    bits = (bits | bits << 8) & 0x00ff_00ff;
    bits = (bits | bits << 4) & 0x0f0f_0f0f;
    bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

/// The second coordinate of the Sobol' sequence as a fraction of 2⁶⁴; the first is the index with its bits reversed. The columns of
/// its matrix are rows of Pascal's triangle modulo 2 (Sobol' 1967), so that a bit is the parity of the bits of the index whose
/// number has all binary digits of its own.
#[inline(always)]
const fn second_inverse(index: u64) -> u64 {
    let sums = index ^ (index >> 1 & 0x5555_5555_5555_5555);
    let sums = sums ^ (sums >> 2 & 0x3333_3333_3333_3333);
    let sums = sums ^ (sums >> 4 & 0x0f0f_0f0f_0f0f_0f0f);
    let sums = sums ^ (sums >> 8 & 0x00ff_00ff_00ff_00ff);
    let sums = sums ^ (sums >> 16 & 0x0000_ffff_0000_ffff);
    (sums ^ sums >> 32).reverse_bits()
}

/// Owen's scramble of binary fractions of 2⁶⁴ (1995). The digits before each of the first `count` digits decide
/// whether it is flipped. The digits after them are random.
#[inline(always)]
fn owen_scrambled<const N: usize>(fractions: [u64; N], count: u32, keys: [u64; N]) -> [u64; N] {
    let mut scrambled = [0; N];
    for place in 0..count {
        for lane in 0..N {
            let bits = fractions[lane];
            // In two steps, because the first digit has none before it.
            let before = bits >> 1 >> (63 - place);
            let digit = (mix(keys[lane] ^ (1 << place | before)) ^ bits << place) >> 63;
            scrambled[lane] |= digit << (63 - place);
        }
    }
    // Below the last digit, all bits are random.
    lanes(|lane| {
        let before = fractions[lane] >> 1 >> (63 - count);
        scrambled[lane] | mix(keys[lane] ^ (1 << count | before)) >> count
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_visits_quarters_of_quarters() {
        let place = |x: u32, y: u32| curve_index([x, y], 0, 0);
        assert_eq!([place(0, 0), place(1, 0), place(0, 1), place(1, 1), place(2, 0)], [0, 1, 2, 3, 4]);
        assert_eq!([place(127, 127), place(128, 0)], [(1 << 14) - 1, 0]);
        assert_eq!(curve_index([1, 0], 5, 3), 13);
        assert_eq!(block([300, 127]), [2, 0]);
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
                let of = |index| shuffled([index], 14 + log_count, [key])[0];
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
        let top = |index: u64, digits: u32| owen_scrambled([index << 58], 6, [99])[0] >> (64 - digits);
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
