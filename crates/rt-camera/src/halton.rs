//! Halton points with Owen scrambling.

use rt_math::random::{mix, permute, unit};

/// Dimensions that have a base of their own.
const DIMENSIONS: usize = 128;

/// Base of each dimension: the first prime numbers.
const BASES: [u32; DIMENSIONS] = first_primes();

const fn first_primes() -> [u32; DIMENSIONS] {
    let mut primes = [2; DIMENSIONS];
    let (mut count, mut candidate) = (1, 3);
    while count < DIMENSIONS {
        let mut divisor = 0;
        while divisor < count && candidate % primes[divisor] != 0 {
            divisor += 1;
        }
        if divisor == count {
            primes[count] = candidate;
            count += 1;
        }
        candidate += 2;
    }
    primes
}

/// Coordinate of the point number `index` of `count`. `key` chooses the pattern and must differ between dimensions. It
/// is the radical inverse of the index in the dimension's base. Each digit goes through a random permutation that
/// depends on the digits before it (Owen 1995).
///
/// The digits that `count` indices need are scrambled; the digits after them are as random as a uniform number, and are
/// drawn as one. Dimensions beyond the 128th are random: a base that is used twice would correlate its two
/// dimensions.
pub(crate) fn coordinate(mut key: u64, index: u32, count: u32, dimension: u32) -> f64 {
    let Some(&base) = BASES.get(dimension as usize) else { return unit(mix(key ^ mix(u64::from(index) + 1))) };
    let (mut rest, mut reach, mut reversed) = (index, 1u64, 0u64);
    while reach < u64::from(count) {
        let digit = rest % base;
        reversed = reversed * u64::from(base) + u64::from(permute(digit, base, key));
        key = mix(key.wrapping_add(u64::from(digit) + 1));
        rest /= base;
        reach *= u64::from(base);
    }
    // Below 2³² · 719 both are exact.
    (reversed as f64 + unit(mix(!key))) / reach as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_are_the_first_primes() {
        assert_eq!(BASES[..10], [2, 3, 5, 7, 11, 13, 17, 19, 23, 29]);
        assert_eq!(BASES[127], 719);
    }

    #[test]
    fn every_interval_of_a_base_holds_its_share() {
        for (dimension, base, count) in [(0, 2, 256u32), (1, 3, 243), (2, 5, 125), (9, 29, 29), (127, 719, 719)] {
            let mut cells: Vec<_> =
                (0..count).map(|index| (coordinate(7, index, count, dimension) * f64::from(count)) as u32).collect();
            // The first samples are spread as evenly as their number allows.
            let mut coarse: Vec<_> = cells[..base as usize].iter().map(|cell| cell / (count / base)).collect();
            cells.sort_unstable();
            coarse.sort_unstable();
            assert!(cells.into_iter().eq(0..count) && coarse.into_iter().eq(0..base), "base {base}");
        }
    }

    #[test]
    fn scrambles_depend_on_the_digits_before() {
        // With one permutation for each place, the second digits of both halves would go the same way for all keys.
        let differs = (0..64).filter(|&key| {
            let quarter = |index| (coordinate(key, index, 4, 0) * 4.0) as u32 % 2;
            quarter(0) != quarter(1)
        });
        assert!((16..48).contains(&differs.count()));
    }
}
