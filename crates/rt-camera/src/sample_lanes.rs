//! Coordinates of several samples of one pattern, computed side by side in SIMD lanes.
//!
//! Loops over the lanes hold straight-line code on arrays, which the compiler turns into vector instructions. One lane gives the
//! same bits as many.

use rt_math::random::{mix, mix_lanes, permute_lanes, unit};

use crate::{SamplerKind, blue_noise, halton, sampler_kind::grid_side, simd::lanes, sobol};

/// The largest number below 1.
pub(crate) const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// A pattern for a number of samples per pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pattern {
    pub(crate) kind: SamplerKind,
    pub(crate) spp: u32,
    /// Side of the grid of `spp` cells.
    side: u32,
}

/// Samples of one pattern, and the dimension that each of them draws.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleLanes<const N: usize> {
    /// Hash of seed, replication, and the pixel or the block of pixels.
    pub(crate) keys: [u64; N],
    /// Position in the pattern, below `spp`; for Sobol' points, below 2^[`sobol::INDEX_BITS`].
    pub(crate) indices: [u32; N],
    /// First dimension of the coordinates to draw.
    pub(crate) dimensions: [u32; N],
    pub(crate) pixels: [[u32; 2]; N],
}

/// Coordinates that are drawn together: one, or a pair.
pub(crate) trait Coordinates: Copy {
    /// Number of dimensions.
    const COUNT: u32;

    /// The coordinates of each sample, in `[0, 1)`.
    fn draw<const N: usize>(pattern: &Pattern, samples: &SampleLanes<N>) -> [Self; N];

    /// Version of [`draw`](Self::draw) that takes less time to compile. The pattern must not be
    /// [drawn digit by digit](Pattern::has_digits).
    fn draw_without_digits<const N: usize>(pattern: &Pattern, samples: &SampleLanes<N>) -> [Self; N];
}

impl Coordinates for f64 {
    const COUNT: u32 = 1;

    #[inline(always)]
    fn draw<const N: usize>(pattern: &Pattern, samples: &SampleLanes<N>) -> [f64; N] {
        match pattern.kind {
            SamplerKind::Halton => samples.halton_coordinates(pattern.spp, 0),
            SamplerKind::BlueNoise => {
                let pairs = samples.blue_noise_pairs(pattern.spp);
                lanes(|lane| pairs[lane][0])
            }
            _ => Self::draw_without_digits(pattern, samples),
        }
    }

    #[inline(always)]
    fn draw_without_digits<const N: usize>(pattern: &Pattern, samples: &SampleLanes<N>) -> [f64; N] {
        debug_assert!(!pattern.has_digits(), "{pattern:?}");
        let Pattern { kind, spp, .. } = *pattern;
        match kind {
            SamplerKind::Sobol => {
                let pairs = samples.sobol_pairs();
                lanes(|lane| pairs[lane][samples.dimensions[lane] as usize % 2])
            }
            SamplerKind::Centre | SamplerKind::Random => {
                let bits = samples.noise(&samples.dimension_keys(0));
                lanes(|lane| unit(bits[lane]))
            }
            _ => {
                let keys = samples.dimension_keys(0);
                let (strata, bits) = (permute_lanes(samples.indices, spp, keys), samples.noise(&keys));
                lanes(|lane| in_stratum(strata[lane], spp, unit(bits[lane])))
            }
        }
    }
}

impl Coordinates for [f64; 2] {
    const COUNT: u32 = 2;

    #[inline(always)]
    fn draw<const N: usize>(pattern: &Pattern, samples: &SampleLanes<N>) -> [[f64; 2]; N] {
        match pattern.kind {
            SamplerKind::Halton => {
                let [x, y] = [0, 1].map(|axis| samples.halton_coordinates(pattern.spp, axis));
                lanes(|lane| [x[lane], y[lane]])
            }
            SamplerKind::BlueNoise => samples.blue_noise_pairs(pattern.spp),
            _ => Self::draw_without_digits(pattern, samples),
        }
    }

    #[inline(always)]
    fn draw_without_digits<const N: usize>(pattern: &Pattern, samples: &SampleLanes<N>) -> [[f64; 2]; N] {
        debug_assert!(!pattern.has_digits(), "{pattern:?}");
        match pattern.kind {
            SamplerKind::Sobol => samples.sobol_pairs(),
            _ => pattern.arranged_pairs(samples),
        }
    }
}

impl Pattern {
    pub(crate) const fn new(kind: SamplerKind, spp: u32) -> Self {
        let spp = kind.round_up(spp);
        Self { kind, spp, side: grid_side(spp) }
    }

    /// True for patterns that are drawn digit by digit.
    pub(crate) const fn has_digits(&self) -> bool {
        matches!(self.kind, SamplerKind::Halton | SamplerKind::BlueNoise)
    }

    /// Dimension from which on coordinates are drawn, where `dimension` follows the last ones.
    #[inline(always)]
    pub(crate) const fn first_dimension<C: Coordinates>(&self, dimension: u32) -> u32 {
        match self.kind {
            // A pair must not straddle two sets, which are independent of each other.
            SamplerKind::Sobol if C::COUNT == 2 => dimension.wrapping_add(dimension % 2),
            _ => dimension,
        }
    }

    /// Samples of one replication of the pattern.
    pub(crate) const fn period(&self) -> u32 {
        match self.kind {
            SamplerKind::Sobol => 1 << sobol::INDEX_BITS,
            _ => self.spp,
        }
    }

    /// Pairs of all patterns except sequences.
    #[inline(always)]
    fn arranged_pairs<const N: usize>(&self, samples: &SampleLanes<N>) -> [[f64; 2]; N] {
        let Self { kind, spp, side } = *self;
        let keys = samples.dimension_keys(0);
        let bits = samples.noise(&keys);
        let mut x: [_; N] = lanes(|lane| unit(bits[lane]));
        let mut y: [_; N] = lanes(|lane| unit(mix(bits[lane])));
        if matches!(kind, SamplerKind::Centre | SamplerKind::Grid | SamplerKind::HalfJittered) {
            let (start, width) = if kind == SamplerKind::HalfJittered { (0.25, 0.5) } else { (0.5, 0.0) };
            for lane in 0..N {
                // The first pair is the position in the pixel.
                if samples.dimensions[lane] == 0 {
                    (x[lane], y[lane]) = (start + width * x[lane], start + width * y[lane]);
                }
            }
        }
        if matches!(kind, SamplerKind::Centre | SamplerKind::Random) {
            return lanes(|lane| [x[lane], y[lane]]);
        }
        let cells = permute_lanes(samples.indices, spp, keys);
        let rows = quotients(&cells, side);
        let columns: [_; N] = lanes(|lane| cells[lane] - rows[lane] * side);
        if kind != SamplerKind::MultiJittered {
            return lanes(|lane| [in_stratum(columns[lane], side, x[lane]), in_stratum(rows[lane], side, y[lane])]);
        }
        // Multi-jittering (Chiu, Shirley, Wang 1994). There is a point in each cell, and in each column and row of a grid
        // that is finer by another factor of n. One permutation for all columns of cells, and one for all rows (Kensler
        // 2013), would be cheaper. But the measured error of a smooth integrand then falls as N^-0.8 instead of 1/N.
        let sub_columns =
            permute_lanes(rows, side, lanes(|lane| keys[lane] ^ mix(u64::from(columns[lane]).wrapping_add(1))));
        let sub_rows =
            permute_lanes(columns, side, lanes(|lane| !keys[lane] ^ mix(u64::from(rows[lane]).wrapping_add(1))));
        let fine = |cell: u32, within: u32| cell.wrapping_mul(side).wrapping_add(within);
        lanes(|lane| {
            let (column, row) = (fine(columns[lane], sub_columns[lane]), fine(rows[lane], sub_rows[lane]));
            [in_stratum(column, spp, x[lane]), in_stratum(row, spp, y[lane])]
        })
    }
}

impl<const N: usize> SampleLanes<N> {
    /// No samples: all lanes are zero.
    pub(crate) const EMPTY: Self = Self { keys: [0; N], indices: [0; N], dimensions: [0; N], pixels: [[0; 2]; N] };

    /// Positions in a pixel, from the sample `first` of a replication on, at most up to `last`. All share the key, which the
    /// compiler then hashes once.
    #[inline(always)]
    pub(crate) fn positions(key: u64, pixel: [u32; 2], first: u32, last: u32) -> Self {
        let indices = lanes(|lane| first.wrapping_add(lane as u32).min(last));
        Self { keys: [key; N], indices, dimensions: [0; N], pixels: [pixel; N] }
    }

    /// `M` of the samples, from one on.
    #[inline(always)]
    pub(crate) fn lanes<const M: usize>(&self, first: usize) -> SampleLanes<M> {
        let mut some = SampleLanes::EMPTY;
        for lane in 0..M {
            some.keys[lane] = self.keys[first + lane];
            some.indices[lane] = self.indices[first + lane];
            some.dimensions[lane] = self.dimensions[first + lane];
            some.pixels[lane] = self.pixels[first + lane];
        }
        some
    }

    /// Random bits for all samples of a replication, in the dimension `offset` after the first.
    #[inline(always)]
    fn dimension_keys(&self, offset: u32) -> [u64; N] {
        mix_lanes(lanes(|lane| self.keys[lane] ^ u64::from(self.dimensions[lane].wrapping_add(offset))))
    }

    /// Random bits for each sample only.
    #[inline(always)]
    fn noise(&self, dimension_keys: &[u64; N]) -> [u64; N] {
        // Index 0 must not give the bits that `permute` makes of the same key, so the count starts at 1.
        lanes(|lane| mix(dimension_keys[lane].wrapping_add(mix(u64::from(self.indices[lane]).wrapping_add(1)))))
    }

    /// Pairs of Sobol' points, each of the first or the last two dimensions of a set of four.
    #[inline(always)]
    fn sobol_pairs(&self) -> [[f64; 2]; N] {
        // Random bits for the set.
        let seeds = lanes(|lane| (mix(self.keys[lane] ^ u64::from(self.dimensions[lane] / sobol::SET)) >> 32) as u32);
        let draws_last_pair = lanes(|lane| self.dimensions[lane] % sobol::SET >= 2);
        sobol::pairs(&seeds, &self.indices, &draws_last_pair)
    }

    /// Halton coordinates in the dimension `offset` after the first. The number of digits differs between dimensions, so lanes
    /// would wait for each other.
    #[inline(always)]
    fn halton_coordinates(&self, spp: u32, offset: u32) -> [f64; N] {
        let keys = self.dimension_keys(offset);
        lanes(|lane| {
            halton::coordinate(keys[lane], self.indices[lane], spp, self.dimensions[lane].wrapping_add(offset))
        })
    }

    #[inline(always)]
    fn blue_noise_pairs(&self, spp: u32) -> [[f64; 2]; N] {
        blue_noise::pairs(&self.pixels, &self.indices, spp.ilog2(), &self.dimension_keys(0))
    }
}

/// Quotients, rounded down, of numbers below the square of `divisor`.
#[inline(always)]
fn quotients<const N: usize>(numbers: &[u32; N], divisor: u32) -> [u32; N] {
    if divisor > MAX_DIVISOR {
        return lanes(|lane| numbers[lane] / divisor);
    }
    // The factor exceeds 2³² / d by less than 1. The error n / 2³² is less than the 1 / d to the next quotient, as n d < d³ < 2³².
    let factor = u64::from(u32::MAX / divisor) + 1;
    lanes(|lane| (u64::from(numbers[lane]).wrapping_mul(factor) >> 32) as u32)
}

/// Largest divisor for which a product gives exact quotients: the largest number whose cube is below 2³².
const MAX_DIVISOR: u32 = 1625;

/// The point at `offset`, in [0, 1), of stratum number `stratum` of `count`.
#[inline(always)]
pub(crate) fn in_stratum(stratum: u32, count: u32, offset: f64) -> f64 {
    // The sum can round up to the end of the last stratum, which is outside [0, 1).
    ((f64::from(stratum) + offset) / f64::from(count)).min(BELOW_ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_are_those_of_integer_division() {
        for divisor in (1..=MAX_DIVISOR + 2).chain([u32::from(u16::MAX)]) {
            let numbers: Vec<u32> = (0..divisor)
                .step_by(1 + divisor as usize / 50)
                .chain([divisor - 1])
                .flat_map(|row| [row * divisor, row * divisor + divisor / 2, row * divisor + divisor - 1])
                .collect();
            for chunk in numbers.chunks_exact(3) {
                let numbers = [chunk[0], chunk[1], chunk[2]];
                assert_eq!(quotients(&numbers, divisor), numbers.map(|number| number / divisor), "{divisor}");
            }
        }
    }
}
