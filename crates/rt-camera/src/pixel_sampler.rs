//! Sample coordinates as a pure function of (seed, pixel, sample, dimension).

use rt_math::{
    Sampler,
    random::{hash, mix},
};

use crate::{
    SamplerKind, blue_noise,
    sample_lanes::{Coordinates, Pattern, SampleLanes},
    simd::try_vectorize,
};

/// Samples that are computed side by side: enough for the compiler to make loops of vector instructions.
const MANY_LANES: usize = 64;

/// Samples that are computed side by side where there are fewer.
const FEW_LANES: usize = 16;

/// Smallest group that is drawn in lanes; fewer are faster one by one.
const MIN_LANES: usize = 4;

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
    pattern: Pattern,
    seed: u64,
}

impl PixelSampler {
    /// A sampler for `spp` samples per pixel; a count that the pattern cannot have is rounded up by
    /// [`SamplerKind::round_up`].
    pub const fn new(pattern: SamplerKind, spp: u32, seed: u64) -> Self {
        Self { pattern: Pattern::new(pattern, spp), seed }
    }

    /// The pattern.
    pub const fn pattern(&self) -> SamplerKind {
        self.pattern.kind
    }

    /// Samples per pixel of one whole pattern.
    pub const fn spp(&self) -> u32 {
        self.pattern.spp
    }

    /// The sample number `index` of a pixel.
    pub fn sample(&self, pixel: [u32; 2], index: u32) -> SampleStream {
        self.replication(pixel, index).stream()
    }

    /// The samples of a pixel from number `first` on, without end: each [`sample`](Self::sample). The number after the
    /// largest `u32` starts another pattern.
    pub fn samples(&self, pixel: [u32; 2], first: u32) -> impl Iterator<Item = SampleStream> + use<> {
        let mut replication = self.replication(pixel, first);
        core::iter::repeat_with(move || {
            let stream = replication.stream();
            replication.advance();
            stream
        })
    }

    /// Positions in the pixel of the samples from number `first` on: the first pair of each of the
    /// [`samples`](Self::samples).
    pub fn positions(&self, pixel: [u32; 2], first: u32, positions: &mut [[f64; 2]]) {
        if self.pattern.kind == SamplerKind::Centre {
            return positions.fill([0.5; 2]);
        }
        let mut replication = self.replication(pixel, first);
        let mut positions = positions;
        while !positions.is_empty() {
            let count = positions.len().min((self.pattern.period() - replication.index) as usize);
            let (drawn, rest) = core::mem::take(&mut positions).split_at_mut(count);
            replication.draw_positions(drawn);
            replication.restart();
            positions = rest;
        }
    }

    /// The replication of the whole pattern that a sample of a pixel belongs to, at the sample.
    fn replication(&self, pixel: [u32; 2], index: u32) -> Replication {
        let sharing = if self.pattern.kind == SamplerKind::BlueNoise { blue_noise::block(pixel) } else { pixel };
        let pixel_key = hash(&[self.seed, u64::from(sharing[0]) << 32 | u64::from(sharing[1])]);
        let number = index / self.pattern.period();
        let index = index % self.pattern.period();
        Replication { pattern: self.pattern, pixel, pixel_key, number, key: replication_key(pixel_key, number), index }
    }
}

/// A replication of the whole pattern in a pixel, and a place in it.
struct Replication {
    pattern: Pattern,
    pixel: [u32; 2],
    /// Hash of seed, and the pixel or the block of pixels.
    pixel_key: u64,
    number: u32,
    key: u64,
    index: u32,
}

impl Replication {
    /// The sample at the place.
    const fn stream(&self) -> SampleStream {
        let Self { pattern, pixel, key, index, .. } = *self;
        SampleStream { pattern, pixel, index, key, dimension: 0 }
    }

    /// Goes to the next sample.
    #[inline(always)]
    fn advance(&mut self) {
        self.index += 1;
        if self.index == self.pattern.period() {
            self.restart();
        }
    }

    /// Goes to the first sample of the next replication.
    #[inline(always)]
    fn restart(&mut self) {
        self.number = self.number.wrapping_add(1);
        (self.key, self.index) = (replication_key(self.pixel_key, self.number), 0);
    }

    /// Positions in the pixel of the samples from the place on. There must not be more than the replication has left.
    fn draw_positions(&self, positions: &mut [[f64; 2]]) {
        let Self { pattern, pixel, key, index, .. } = *self;
        let last = pattern.period() - 1;
        let many = if pattern.has_digits() { 0 } else { positions.len() / MANY_LANES * MANY_LANES };
        let (many, few) = positions.split_at_mut(many);
        let first_of_few = index + many.len() as u32;
        let drawn = try_vectorize(
            #[inline(always)]
            || {
                for (group, first) in many.chunks_exact_mut(MANY_LANES).zip((index..).step_by(MANY_LANES)) {
                    let samples = SampleLanes::<MANY_LANES>::positions(key, pixel, first, last);
                    group.copy_from_slice(&Coordinates::draw_without_digits(&pattern, &samples));
                }
                for (group, first) in few.chunks_mut(FEW_LANES).zip((first_of_few..).step_by(FEW_LANES)) {
                    let drawn =
                        Coordinates::draw(&pattern, &SampleLanes::<FEW_LANES>::positions(key, pixel, first, last));
                    match <&mut [_; FEW_LANES]>::try_from(&mut *group) {
                        Ok(group) => *group = drawn,
                        Err(_) => group.copy_from_slice(&drawn[..group.len()]),
                    }
                }
            },
        );
        if drawn.is_none() {
            for (position, index) in positions.iter_mut().zip(index..) {
                *position = draw_one(&pattern, &SampleLanes::positions(key, pixel, index, last));
            }
        }
    }
}

/// Each replication of the pattern has its own random bits.
#[inline(always)]
fn replication_key(pixel_key: u64, number: u32) -> u64 {
    mix(pixel_key ^ u64::from(number))
}

/// The coordinates of one sample of one pixel, drawn in order.
///
/// Draws of many samples at once take a fraction of the time:
///
/// ```
/// use rt_camera::{PixelSampler, SamplerKind};
/// use rt_math::Sampler;
///
/// let sampler = PixelSampler::new(SamplerKind::Sobol, 16, 42);
/// let mut paths: Vec<_> = [[0, 0], [1, 0]].iter().flat_map(|&pixel| sampler.samples(pixel, 0).take(16)).collect();
/// // Paths that have hit a surface choose a point on a light.
/// let hits = [0, 1, 5, 17, 30];
/// let mut on_light = [[0.0; 2]; 5];
/// Sampler::next_2d_batch(&mut paths, &hits, &mut on_light);
/// assert_eq!(on_light[3], sampler.sample([1, 0], 1).next_2d());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SampleStream {
    pattern: Pattern,
    pixel: [u32; 2],
    /// Position in the pattern, below its period.
    index: u32,
    /// Hash of seed, replication, and the pixel or the block of pixels.
    key: u64,
    /// The next dimension to draw.
    dimension: u32,
}

impl Sampler for SampleStream {
    fn next_1d(&mut self) -> f64 {
        self.next()
    }

    fn next_2d(&mut self) -> [f64; 2] {
        self.next()
    }

    fn next_1d_batch(samplers: &mut [Self], which: &[u32], values: &mut [f64]) {
        draw_batch(samplers, which, values);
    }

    fn next_2d_batch(samplers: &mut [Self], which: &[u32], pairs: &mut [[f64; 2]]) {
        draw_batch(samplers, which, pairs);
    }
}

impl SampleStream {
    /// Leaves out the position in the pixel, the first pair, which [`PixelSampler::positions`] draws for many samples. For samples that
    /// have drawn nothing else.
    pub const fn skip_position(&mut self) {
        self.dimension = 2;
    }

    #[inline]
    fn next<C: Coordinates>(&mut self) -> C {
        let Self { pattern, pixel, index, key, .. } = *self;
        let samples = SampleLanes { keys: [key], indices: [index], dimensions: [self.advance::<C>()], pixels: [pixel] };
        draw_one(&pattern, &samples)
    }

    /// First dimension of the next coordinates, which are then drawn.
    #[inline(always)]
    const fn advance<C: Coordinates>(&mut self) -> u32 {
        let dimension = self.pattern.first_dimension::<C>(self.dimension);
        self.dimension = dimension.wrapping_add(C::COUNT);
        dimension
    }
}

/// Batch of draws, by the rules of [`Sampler::next_1d_batch`]. Samples of one pattern that follow each other share lanes.
fn draw_batch<C: Coordinates>(samplers: &mut [SampleStream], which: &[u32], values: &mut [C]) {
    let mut samples = SampleLanes::<MANY_LANES>::EMPTY;
    let mut pattern = Pattern::new(SamplerKind::Centre, 1);
    let draws = which.len().min(values.len());
    let (mut which, mut values) = (&which[..draws], &mut values[..draws]);
    while !which.is_empty() {
        let mut count = 0;
        for &index in which {
            let Some(sampler) = samplers.get_mut(index as usize) else { break };
            if count == 0 {
                pattern = sampler.pattern;
            } else if count == MANY_LANES || sampler.pattern != pattern {
                break;
            }
            samples.keys[count] = sampler.key;
            samples.indices[count] = sampler.index;
            samples.pixels[count] = sampler.pixel;
            samples.dimensions[count] = sampler.advance::<C>();
            count += 1;
        }
        let group;
        (group, values) = core::mem::take(&mut values).split_at_mut(count);
        let has_many = count == MANY_LANES && !pattern.has_digits();
        if let Some(many) = if has_many { draw_many(&pattern, &samples) } else { None } {
            group.copy_from_slice(&many);
        } else {
            for (few, first) in group.chunks_mut(FEW_LANES).zip((0..).step_by(FEW_LANES)) {
                let has_few = few.len() >= MIN_LANES;
                if let Some(drawn) = if has_few { draw_few(&pattern, &samples.lanes(first)) } else { None } {
                    few.copy_from_slice(&drawn[..few.len()]);
                } else {
                    for (value, lane) in few.iter_mut().zip(first..) {
                        *value = draw_one(&pattern, &samples.lanes(lane));
                    }
                }
            }
        }
        if count == 0 {
            // Keep the value of a sampler that does not exist.
            (_, values) = core::mem::take(&mut values).split_at_mut(1);
            count = 1;
        }
        which = &which[count..];
    }
}

/// Coordinates of many samples of a pattern that is not drawn digit by digit; `None` without lanes.
fn draw_many<C: Coordinates>(pattern: &Pattern, samples: &SampleLanes<MANY_LANES>) -> Option<[C; MANY_LANES]> {
    try_vectorize(
        #[inline(always)]
        || C::draw_without_digits(pattern, samples),
    )
}

/// Coordinates of a few samples; `None` without lanes.
fn draw_few<C: Coordinates>(pattern: &Pattern, samples: &SampleLanes<FEW_LANES>) -> Option<[C; FEW_LANES]> {
    try_vectorize(
        #[inline(always)]
        || C::draw(pattern, samples),
    )
}

/// Coordinates of one sample.
fn draw_one<C: Coordinates>(pattern: &Pattern, sample: &SampleLanes<1>) -> C {
    let [coordinates] = C::draw(pattern, sample);
    coordinates
}

#[cfg(test)]
mod batches;
#[cfg(test)]
mod convergence;
#[cfg(test)]
mod stratification;
