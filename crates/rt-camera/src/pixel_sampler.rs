//! Sample coordinates as a pure function of (seed, pixel, sample, dimension).

use rt_math::{
    Sampler,
    random::{Permutation, hash, mix, permute, unit},
};

use crate::{SamplerKind, blue_noise::CurveIndex, halton, pattern::grid_side, sobol::SobolSet};

/// The largest number below 1.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// Makes the samples of every pixel of an image.
///
/// The first two coordinates of a sample are its position in the pixel, and follow the pattern to the letter. Later
/// ones choose points on lights, times, lobes; there, fixed or half-covered patterns would be wrong and not just
/// coarse, so that
///
/// | pattern | position in the pixel | later pairs |
/// |---|---|---|
/// | centre | (½, ½) | random |
/// | grid | (i + ½) / n | jittered |
/// | random | ξ | random |
/// | jittered | (i + ξ) / n | jittered |
/// | half-jittered | (i + ¼ + ½ξ) / n | jittered |
/// | multi-jittered | Chiu et al. 1994 | multi-jittered |
/// | Sobol' | dimensions 0, 1 | dimensions 2, 3, then further sets of four, each scrambled anew |
/// | Halton | bases 2, 3 | the next two primes; random beyond 128 dimensions |
/// | blue noise | dimensions 0, 1 of Sobol' | the same, ordered and scrambled anew |
///
/// with n² samples per pixel and uniform ξ in [0, 1). The samples of a pixel visit the cells in a random order, another
/// one for each pair of coordinates. So pairs are independent of each other, and any first part of the samples is
/// spread over the whole pixel. Single coordinates are stratified over all samples (random for centre and random).
/// Pixels are independent of each other, but for blue noise, where a block of 128 by 128 pixels shares one sequence.
///
/// Samples beyond the promised number start a new, independent pattern.
///
/// ```
/// use rt_camera::{PixelSampler, SamplerKind};
/// use rt_math::Sampler;
///
/// let pattern = SamplerKind::Jittered;
/// let sampler = PixelSampler::new(pattern, pattern.round_up(5), 42);
/// assert_eq!(sampler.spp(), 9);
/// let mut sample = sampler.sample([10, 20], 3);
/// let in_pixel = sample.next_2d();
/// let on_light = sample.next_2d();
/// assert_ne!(in_pixel, on_light);
/// // Samples do not depend on each other.
/// assert_eq!(sampler.sample([10, 20], 3).next_2d(), in_pixel);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelSampler {
    pattern: SamplerKind,
    spp: u32,
    /// Side of the grid of `spp` cells.
    side: u32,
    seed: u64,
}

impl PixelSampler {
    /// A sampler for `spp` samples per pixel; a count that the pattern cannot have is rounded up by
    /// [`SamplerKind::round_up`].
    pub const fn new(pattern: SamplerKind, spp: u32, seed: u64) -> Self {
        let spp = pattern.round_up(spp);
        Self { pattern, spp, side: grid_side(spp), seed }
    }

    /// The pattern.
    pub const fn pattern(&self) -> SamplerKind {
        self.pattern
    }

    /// Samples per pixel of one whole pattern.
    pub const fn spp(&self) -> u32 {
        self.spp
    }

    /// The sample number `index` of a pixel.
    pub fn sample(&self, pixel: [u32; 2], index: u32) -> SampleStream {
        let (round, index) = self.round_of(index);
        let sharing = if self.pattern == SamplerKind::BlueNoise { CurveIndex::block(pixel) } else { pixel };
        let key = round_key(self.pixel_key(sharing), round);
        SampleStream { sampler: *self, pixel, index, key, dimension: 0, sobol: SobolSet::EMPTY }
    }

    /// Positions in the pixel of the samples from number `first` on: the first pair of each [`sample`](Self::sample).
    /// Values that all samples of a pixel share are computed once.
    pub fn positions(&self, pixel: [u32; 2], first: u32, positions: &mut [[f64; 2]]) {
        match self.pattern {
            SamplerKind::Centre => positions.fill([0.5; 2]),
            SamplerKind::Sobol | SamplerKind::Halton | SamplerKind::BlueNoise => {
                for (position, index) in positions.iter_mut().zip(first..) {
                    *position = self.sample(pixel, index).next_2d();
                }
            }
            _ => self.arranged_positions(pixel, first, positions),
        }
    }

    fn arranged_positions(&self, pixel: [u32; 2], first: u32, positions: &mut [[f64; 2]]) {
        let pixel_key = self.pixel_key(pixel);
        let (mut round, mut index) = self.round_of(first);
        let mut arrangement = Arrangement::new(self, round_key(pixel_key, round), 0);
        let mut rest = positions;
        loop {
            let (positions, others) = rest.split_at_mut(rest.len().min((self.spp - index) as usize));
            arrangement.pairs(index, positions);
            if others.is_empty() {
                return;
            }
            rest = others;
            (round, index) = (round.wrapping_add(1), 0);
            arrangement = Arrangement::new(self, round_key(pixel_key, round), 0);
        }
    }

    /// Random bits of a pixel.
    fn pixel_key(&self, pixel: [u32; 2]) -> u64 {
        hash(&[self.seed, u64::from(pixel[0]) << 32 | u64::from(pixel[1])])
    }

    /// Replication of the whole pattern that a sample belongs to, and its index there.
    const fn round_of(&self, index: u32) -> (u32, u32) {
        match self.pattern {
            SamplerKind::Sobol => (index >> SobolSet::INDEX_BITS, index & SobolSet::INDEX_MASK),
            _ => (index / self.spp, index % self.spp),
        }
    }
}

/// Each replication of the pattern has its own random bits.
fn round_key(pixel_key: u64, round: u32) -> u64 {
    mix(pixel_key ^ u64::from(round))
}

/// The coordinates of one sample of one pixel, drawn in order.
#[derive(Clone, Copy, Debug)]
pub struct SampleStream {
    sampler: PixelSampler,
    pixel: [u32; 2],
    /// Position in the pattern, below `spp`.
    index: u32,
    /// Hash of seed, round, and the pixel or the block of pixels.
    key: u64,
    /// The next dimension to draw.
    dimension: u32,
    sobol: SobolSet,
}

impl Sampler for SampleStream {
    fn next_1d(&mut self) -> f64 {
        let dimension = self.dimension;
        self.dimension += 1;
        let PixelSampler { pattern, spp, .. } = self.sampler;
        let key = dimension_key(self.key, dimension);
        let jitter = || unit(noise(key, self.index));
        match pattern {
            SamplerKind::Sobol => self.sobol.coordinate(self.key, self.index, dimension),
            SamplerKind::Halton => halton::coordinate(key, self.index, spp, dimension),
            SamplerKind::BlueNoise => self.curve_index().point(key)[0],
            SamplerKind::Centre | SamplerKind::Random => jitter(),
            _ => in_stratum(permute(self.index, spp, key), spp, jitter()),
        }
    }

    fn next_2d(&mut self) -> [f64; 2] {
        let PixelSampler { pattern, spp, .. } = self.sampler;
        if pattern == SamplerKind::Sobol {
            // A pair must not straddle two sets, which are independent of each other.
            self.dimension = self.dimension.next_multiple_of(2);
        }
        let dimension = self.dimension;
        self.dimension += 2;
        match pattern {
            SamplerKind::Sobol => {
                let mut coordinate = |dimension| self.sobol.coordinate(self.key, self.index, dimension);
                [coordinate(dimension), coordinate(dimension + 1)]
            }
            SamplerKind::Halton => [dimension, dimension + 1]
                .map(|dimension| halton::coordinate(dimension_key(self.key, dimension), self.index, spp, dimension)),
            SamplerKind::BlueNoise => self.curve_index().point(dimension_key(self.key, dimension)),
            _ => Arrangement::new(&self.sampler, self.key, dimension).pair(self.index),
        }
    }
}

impl SampleStream {
    /// This sample among those of its block of pixels.
    fn curve_index(&self) -> CurveIndex {
        CurveIndex::new(self.pixel, self.index, self.sampler.spp.ilog2())
    }
}

/// Random bits for all samples of a round in one dimension.
fn dimension_key(round_key: u64, dimension: u32) -> u64 {
    mix(round_key ^ u64::from(dimension))
}

/// Random bits for one sample only.
#[inline]
fn noise(dimension_key: u64, index: u32) -> u64 {
    // Index 0 must not give the bits that `permute` makes of the same key, so the count starts at 1.
    mix(dimension_key.wrapping_add(mix(u64::from(index) + 1)))
}

/// Arrangement of the samples of a replication in one pair of dimensions, for all patterns except sequences.
struct Arrangement {
    pattern: SamplerKind,
    /// True for the pair that is the position in the pixel.
    is_position: bool,
    spp: u32,
    side: u32,
    key: u64,
    /// Takes samples to their cells.
    cells: Permutation,
}

impl Arrangement {
    fn new(sampler: &PixelSampler, round_key: u64, dimension: u32) -> Self {
        let PixelSampler { pattern, spp, side, .. } = *sampler;
        let key = dimension_key(round_key, dimension);
        Self { pattern, is_position: dimension == 0, spp, side, key, cells: Permutation::new(spp, key) }
    }

    /// The coordinates of a sample.
    #[inline]
    fn pair(&self, index: u32) -> [f64; 2] {
        self.pair_in(if self.has_cells() { self.cells.position(index) } else { 0 }, index)
    }

    /// The coordinates of the samples from one on, all of the same round.
    #[inline]
    fn pairs(&self, first: u32, pairs: &mut [[f64; 2]]) {
        const SIDE_BY_SIDE: usize = 16;
        let mut index = first;
        for pairs in pairs.chunks_mut(SIDE_BY_SIDE) {
            let mut cells = [0; SIDE_BY_SIDE];
            if self.has_cells() {
                self.cells.positions(index, &mut cells[..pairs.len()]);
            }
            for (pair, cell) in pairs.iter_mut().zip(cells) {
                *pair = self.pair_in(cell, index);
                index += 1;
            }
        }
    }

    /// True if each sample has a cell of its own.
    const fn has_cells(&self) -> bool {
        !matches!(self.pattern, SamplerKind::Centre | SamplerKind::Random)
    }

    /// The coordinates of a sample in its cell.
    #[inline(always)]
    fn pair_in(&self, cell: u32, index: u32) -> [f64; 2] {
        let bits = noise(self.key, index);
        let jitter = [unit(bits), unit(mix(bits))];
        match (self.pattern, self.is_position) {
            (SamplerKind::Centre, true) => [0.5; 2],
            (SamplerKind::Centre | SamplerKind::Random, _) => jitter,
            (SamplerKind::Grid, true) => self.in_cell(cell, [0.5; 2]),
            (SamplerKind::HalfJittered, true) => self.in_cell(cell, jitter.map(|xi| 0.25 + 0.5 * xi)),
            (SamplerKind::MultiJittered, _) => self.multi_jittered(cell, jitter),
            _ => self.in_cell(cell, jitter),
        }
    }

    /// A place in a cell of the square grid, given by its coordinates within the cell.
    #[inline]
    fn in_cell(&self, cell: u32, within: [f64; 2]) -> [f64; 2] {
        [in_stratum(cell % self.side, self.side, within[0]), in_stratum(cell / self.side, self.side, within[1])]
    }

    /// Multi-jittering (Chiu, Shirley, Wang 1994). There is a point in each cell, and in each column and row of a grid
    /// that is finer by another factor of n. One permutation for all columns of cells, and one for all rows (Kensler
    /// 2013), would be cheaper. But the measured error of a smooth integrand then falls as N^-0.8 instead of 1/N.
    fn multi_jittered(&self, cell: u32, jitter: [f64; 2]) -> [f64; 2] {
        let Self { side, spp, key, .. } = *self;
        let (column, row) = (cell % side, cell / side);
        let sub_column = permute(row, side, key ^ mix(u64::from(column) + 1));
        let sub_row = permute(column, side, !key ^ mix(u64::from(row) + 1));
        [in_stratum(column * side + sub_column, spp, jitter[0]), in_stratum(row * side + sub_row, spp, jitter[1])]
    }
}

/// The point at `offset`, in [0, 1), of stratum number `stratum` of `count`.
fn in_stratum(stratum: u32, count: u32, offset: f64) -> f64 {
    // The sum can round up to the end of the last stratum, which is outside [0, 1).
    ((f64::from(stratum) + offset) / f64::from(count)).min(BELOW_ONE)
}

#[cfg(test)]
mod convergence;
#[cfg(test)]
mod stratification;
