//! Owen-scrambled Sobol' points, four dimensions at a time.
//!
//! ```text
//!      index ──reversed──> nested scramble ──> Sobol' matrix of each dimension ──> nested scramble ──reversed──> coordinate
//!                          (the order of points)                                   (a set of points)
//! ```
//!
//! Bits stay reversed in between. The hash of Laine and Karras (2011) carries from low to high bits: each bit of its result
//! depends on the lower bits alone. On reversed numbers, this is the nested scramble of Owen (1995) in base 2. Burley, "Practical
//! Hash-based Owen Scrambling", JCGT 9(4), 2020, sections 3 and 4.

use crate::simd::lanes;

/// One scramble yields 2^`INDEX_BITS` points.
pub(crate) const INDEX_BITS: u32 = 16;

/// Dimensions of a set. Further dimensions are further sets, each with its own scramble and order ("padding", Burley 2020,
/// section 5). They are well distributed within a set, and independent between sets.
pub(crate) const SET: u32 = 4;

/// Polynomials of the third and the fourth dimension and their first direction numbers, from `new-joe-kuo-6` (Joe and Kuo 2008).
/// Bits are coefficients: `0b111` is x² + x + 1.
const POLYNOMIALS: [(u32, &[u32]); 2] = [(0b111, &[1, 3]), (0b1011, &[1, 3, 1])];

/// Columns of the matrices of the third (low half) and the fourth dimension (high half), with reversed bits.
const COLUMNS: [u32; INDEX_BITS as usize] = {
    let (third, fourth) = (columns(POLYNOMIALS[0]), columns(POLYNOMIALS[1]));
    let mut columns = [0; INDEX_BITS as usize];
    let mut at = 0;
    while at < columns.len() {
        columns[at] = third[at] | fourth[at] << INDEX_BITS;
        at += 1;
    }
    columns
};

/// Direction numbers of a polynomial (Sobol' 1967; Joe and Kuo 2008, equation 3) with reversed bits: bit 0 is the half.
const fn columns((polynomial, first): (u32, &[u32])) -> [u32; INDEX_BITS as usize] {
    let degree = first.len();
    let mut columns = [0u32; INDEX_BITS as usize];
    let mut at = 0;
    while at < columns.len() {
        columns[at] = if at < degree {
            // The number m of column k is the fraction m / 2^(k + 1).
            first[at].reverse_bits() >> (31 - at)
        } else {
            let mut column = columns[at - degree] << degree;
            let mut back = 1;
            while back <= degree {
                column ^= columns[at - back] * (polynomial >> (degree - back) & 1);
                back += 1;
            }
            column
        };
        at += 1;
    }
    columns
}

/// Two coordinates, in `[0, 1)`, of one point of each of `N` sets: the first two dimensions, or the last two where `last` is true.
///
/// A set is chosen by its seed, and a point by its index, below 2^`INDEX_BITS`. Coordinates are multiples of 2⁻²³.
#[inline(always)]
pub(crate) fn pairs<const N: usize>(seeds: &[u32; N], indices: &[u32; N], last: &[bool; N]) -> [[f64; 2]; N] {
    let (mut x, mut y) = ([0; N], [0; N]);
    for lane in 0..N {
        [x[lane], y[lane]] = pair(seeds[lane], indices[lane], last[lane]);
    }
    lanes(|lane| [unit(x[lane]), unit(y[lane])])
}

/// The top 23 bits as a number in `[0, 1)`.
#[inline(always)]
fn unit(bits: u32) -> f64 {
    // Signed, for which processors have an instruction.
    f64::from((bits >> 9) as i32) * (1.0 / (1 << 23) as f64)
}

#[inline(always)]
const fn pair(seed: u32, index: u32, last: bool) -> [u32; 2] {
    let shuffled = owen_scrambled(index.reverse_bits(), hash(seed ^ 0x79c6_8e4a));
    let index = shuffled.reverse_bits() & 0xffff;
    let mut last_pair = 0;
    let mut bit = 0;
    while bit < INDEX_BITS {
        last_pair ^= COLUMNS[bit as usize] & (index >> bit & 1).wrapping_neg();
        bit += 1;
    }
    let [x, y] = if last { [last_pair & 0xffff, last_pair >> 16] } else { [index, pascal(index)] };
    let [key_x, key_y] = if last { [0x691e_72ca, 0xb40c_c1b8] } else { [0x912f_69ba, 0x174f_18ab] };
    let seed = seed.wrapping_mul(0x9c8f_2d3b);
    [owen_scrambled(x, hash(seed ^ key_x)).reverse_bits(), owen_scrambled(y, hash(seed ^ key_y)).reverse_bits()]
}

/// Reversed bits of the second coordinate. Its polynomial is x + 1, and its matrix is Pascal's triangle modulo 2. Bit k of the
/// result is the parity of those bits of the index whose number has all binary digits of k.
#[inline(always)]
const fn pascal(index: u32) -> u32 {
    let sums = index ^ (index >> 1 & 0x5555);
    let sums = sums ^ (sums >> 2 & 0x3333);
    let sums = sums ^ (sums >> 4 & 0x0f0f);
    sums ^ (sums >> 8 & 0x00ff)
}

/// The hash of Laine and Karras, with the constants that Vegdahl found ("Building a Better LK Hash", 2021).
#[inline(always)]
const fn owen_scrambled(reversed: u32, key: u32) -> u32 {
    let bits = reversed ^ reversed.wrapping_mul(0x3d20_adea);
    let bits = bits.wrapping_add(key).wrapping_mul(key >> 16 | 1);
    let bits = bits ^ bits.wrapping_mul(0x0552_6c56);
    bits ^ bits.wrapping_mul(0x53a2_2864)
}

/// A bijection of 32 bits (`lowbias32`, Wellons 2018). It maps `0xe6fe_3beb` to 0.
#[inline(always)]
const fn hash(bits: u32) -> u32 {
    let bits = bits ^ 0xe6fe_3beb;
    let bits = (bits ^ bits >> 16).wrapping_mul(0x7feb_352d);
    let bits = (bits ^ bits >> 15).wrapping_mul(0x846c_a68b);
    bits ^ bits >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(seed: u32, index: u32) -> [f64; 4] {
        let [first, last] = pairs(&[seed; 2], &[index; 2], &[false, true]);
        [first[0], first[1], last[0], last[1]]
    }

    /// The recurrence for the odd numbers m of direction numbers m / 2^k, as Joe and Kuo (2008) state it.
    #[test]
    fn columns_are_direction_numbers() {
        for (axis, (coefficients, first)) in [([1, 0], [1, 3, 0]), ([0, 1], [1, 3, 1])].into_iter().enumerate() {
            let degree = axis + 2;
            let mut numbers = first[..degree].to_vec();
            for at in degree..16 {
                let highest = numbers[at - degree] ^ numbers[at - degree] << degree;
                let terms = (1..degree).map(|back| (coefficients[back - 1] * numbers[at - back]) << back);
                numbers.push(terms.fold(highest, |sum: u32, term| sum ^ term));
            }
            for (at, number) in numbers.into_iter().enumerate() {
                let column = COLUMNS[at] >> (16 * axis) & 0xffff;
                // Both as parts of 2³².
                assert_eq!(number << (31 - at), column.reverse_bits());
            }
        }
    }

    /// Equation 2 of Joe and Kuo (2008) for x + 1, where all numbers follow from m = 1.
    #[test]
    fn the_second_dimension_is_that_of_x_plus_1() {
        let columns = columns((0b11, &[1]));
        for index in 0..1 << 16 {
            let sum = (0..16).filter(|bit| index >> bit & 1 == 1).fold(0, |sum, bit| sum ^ columns[bit]);
            assert_eq!(pascal(index), sum, "{index}");
        }
    }

    /// Multiples of 2⁻²³, recorded from version 0.5.0 of the crate `sobol_burley`.
    #[test]
    fn points_are_those_recorded() {
        for (seed, index, expected) in [
            (0, 0, [2_199_104, 4_503_796, 6_002_907, 6_850_746]),
            (0, 1, [8_147_970, 3_863_781, 633_150, 622_077]),
            (0, 65535, [4_590_216, 6_255_024, 2_462_402, 6_540_068]),
            (1, 2, [1_463_801, 3_049_908, 7_037_533, 4_928_321]),
            (1, 255, [3_599_208, 8_061_261, 2_710_261, 430_454]),
            (0x9e37_79b9, 0, [7_556_201, 5_321_231, 3_916_799, 1_793_679]),
            (0x9e37_79b9, 4096, [8_169_531, 1_122_650, 860_832, 4_517_894]),
            (0x8000_0000, 3, [4_221_652, 425_173, 146_181, 6_847_944]),
            (0xffff_ffff, 40000, [5_595_272, 2_725_651, 6_322_343, 597_827]),
            (12345, 65535, [7_747_940, 1_718_562, 2_434_329, 6_406_798]),
        ] {
            assert_eq!(point(seed, index).map(|x| (x * 8_388_608.0) as u32), expected, "seed {seed}, index {index}");
        }
    }

    /// Hash of 2²² coordinates as `f32`, recorded from the same crate.
    #[test]
    fn all_points_of_sixteen_sets_are_those_recorded() {
        let sets = (0..16u32).flat_map(|set| (0..1 << 16).map(move |index| (set.wrapping_mul(0x9e37_79b9), index)));
        let hash = sets.flat_map(|(seed, index)| point(seed, index)).fold(0u64, |hash, x| {
            let bits = (x as f32).to_bits();
            assert_eq!(f64::from(f32::from_bits(bits)), x);
            (hash.rotate_left(5) ^ u64::from(bits)).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        });
        assert_eq!(hash, 0xa89d_dc4e_74f1_912e);
    }

    #[test]
    fn scrambling_is_a_nested_permutation() {
        // The digits before a digit of a coordinate are the lower bits of its reversed bits.
        let low = |bits: u32, digits: u32| bits & ((1 << digits) - 1);
        let scrambled: Vec<_> = (0..64).map(|bits| owen_scrambled(bits, 0x1234_5678)).collect();
        for (a, b) in (0..64u32).flat_map(|a| (0..64).map(move |b| (a, b))) {
            for digits in 1..=6 {
                let same = low(scrambled[a as usize], digits) == low(scrambled[b as usize], digits);
                assert_eq!(low(a, digits) == low(b, digits), same, "{a} and {b}");
            }
        }
    }
}
