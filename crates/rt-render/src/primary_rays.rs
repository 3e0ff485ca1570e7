//! Batches of camera rays: samples of some pixels, traced together.

use rt_camera::{PixelSampler, RayArrays, SampleStream};
use rt_geometry::{RayStream, STREAM_CAPACITY};
use rt_math::{DVec2, Interval, Rgb, Sampler};
use rt_shading::RadianceSample;

use crate::{
    RenderPlan,
    film::{pixel_accumulator::PixelAccumulator, tile_accumulator::TileAccumulator},
    tile_job::{TileJob, TileResult},
};

/// Maximum number of camera rays per batch: enough for batch traversal, with data that fits the cache of a core.
const BATCH_SIZE: usize = STREAM_CAPACITY;

/// Indices of all samplers of a batch, for draws.
const ALL: [u32; BATCH_SIZE] = {
    let mut all = [0; BATCH_SIZE];
    let mut index = 0;
    while index < BATCH_SIZE {
        all[index] = index as u32;
        index += 1;
    }
    all
};

/// Camera rays of a batch with their radiance.
#[derive(Debug, Default)]
pub(crate) struct PrimaryRayBatch {
    /// Slots that stay free, for smaller batches.
    unused: usize,
    /// Positions in the pixel of the samples that are generated.
    positions: Vec<[f64; 2]>,
    /// Points on the lens of these samples, in the unit square.
    on_lens: Vec<[f64; 2]>,
    /// Times of these samples, as parts of the open shutter.
    times: Vec<f64>,
    rays: RayStream,
    /// Filter weight of each sample.
    weights: Vec<f64>,
    radiances: Vec<RadianceSample>,
    /// Samplers of the integrator; empty if it uses none.
    samplers: Vec<SampleStream>,
}

impl PrimaryRayBatch {
    /// Rays with their intervals.
    pub(crate) const fn rays(&self) -> &RayStream {
        &self.rays
    }

    /// Batch of at most `size` rays.
    pub(crate) fn new(size: usize) -> Self {
        Self { unused: BATCH_SIZE.saturating_sub(size), ..Self::default() }
    }

    pub(crate) const fn free_slots(&self) -> usize {
        BATCH_SIZE - self.unused - self.weights.len()
    }

    pub(crate) fn clear(&mut self) {
        self.rays.clear();
        self.weights.clear();
        self.samplers.clear();
    }
}

impl RenderPlan<'_> {
    /// Takes the samples of a tile, ordered by pixel, pass and sample index. `radiance` is the integrator: it computes the
    /// radiance of a stream of rays, which it may replace. There is a sampler for each ray if the integrator uses any.
    pub(crate) fn sample_tile(
        &self,
        job: &TileJob<'_>,
        batch: &mut PrimaryRayBatch,
        mut radiance: impl FnMut(&mut RayStream, &mut [SampleStream], &mut [RadianceSample]),
    ) -> TileResult {
        let pass_spec = job.pass_spec;
        let counts = pass_spec.pixels_of(job.tile).map(|pixel| job.spp_of(pixel));
        let finished = TileResult::new(job);
        let mut accumulator =
            TileAccumulator::new(finished, PixelAccumulator::new(self.frame.transparent), counts, pass_spec.count);
        let mut interrupted_since = None;
        for pixel in pass_spec.pixels_of(job.tile) {
            let spp = job.spp_of(pixel);
            for pass in 0..pass_spec.count {
                let sampler = self.frame.pass_sampler(pass_spec.first + pass, spp);
                let mut first = 0;
                while first < spp {
                    let count = batch.free_slots().min((spp - first) as usize);
                    self.generate(&sampler, pixel, first, count, batch);
                    first += count as u32;
                    if batch.free_slots() == 0 {
                        trace(batch, &mut accumulator, self.frame.backdrop, &mut radiance);
                        if job.is_overdue(&mut interrupted_since) {
                            return TileResult { is_abandoned: true, ..accumulator.finished };
                        }
                    }
                }
            }
        }
        trace(batch, &mut accumulator, self.frame.backdrop, &mut radiance);
        accumulator.finished
    }

    /// Appends `count` camera rays of a pixel to the batch, from sample `first` of a pass on.
    pub(crate) fn generate(
        &self,
        sampler: &PixelSampler,
        [x, y]: [u32; 2],
        first: u32,
        count: usize,
        batch: &mut PrimaryRayBatch,
    ) {
        debug_assert!(count <= batch.free_slots(), "more samples than a batch has left");
        let count = count.min(batch.free_slots());
        let corner = DVec2::new(f64::from(x), f64::from(y)) + self.frame.sample_offset;
        let PrimaryRayBatch { positions, on_lens, times, rays, weights, samplers, .. } = batch;
        positions.resize(count, [0.0; 2]);
        on_lens.resize(count, [0.5; 2]);
        times.resize(count, 0.0);
        let (has_lens, has_motion) = (self.frame.camera.has_lens(), self.frame.has_motion);
        sampler.positions([x, y], first, positions);
        if has_lens || has_motion || self.integrator.uses_samplers() {
            let start = samplers.len();
            samplers.extend(sampler.samples([x, y], first).take(count));
            let samples = &mut samplers[start..];
            samples.iter_mut().for_each(SampleStream::skip_position);
            if has_lens {
                Sampler::next_2d_batch(samples, &ALL, on_lens);
            }
            if has_motion {
                Sampler::next_1d_batch(samples, &ALL, times);
            }
        }
        if !self.integrator.uses_samplers() {
            samplers.clear();
        }
        self.frame.filter.sample_all(positions, weights);
        if self.frame.camera.moves() {
            for ((&offset, &on_lens), &time) in positions.iter().zip(&*on_lens).zip(&*times) {
                let time = self.frame.camera.shutter_time(time);
                let ray = self.frame.camera.generate_ray(corner + DVec2::from_array(offset), on_lens, time);
                rays.push(&ray, Interval::FORWARD);
            }
            return;
        }
        let start = rays.len();
        self.frame.camera.rays(
            corner,
            positions,
            on_lens,
            RayArrays {
                origin: rays.origin.each_mut().map(|numbers| &mut numbers.as_mut_slice()[start..]),
                direction: rays.direction.each_mut().map(|numbers| &mut numbers.as_mut_slice()[start..]),
            },
        );
        let Interval { min, max } = Interval::FORWARD;
        rays.min.as_mut_slice()[start..start + count].fill(min);
        rays.max.as_mut_slice()[start..start + count].fill(max);
        let of_rays = &mut rays.time.as_mut_slice()[start..start + count];
        if has_motion {
            of_rays.iter_mut().zip(&*times).for_each(|(of_ray, part)| *of_ray = self.frame.camera.shutter_time(*part));
        } else {
            of_rays.fill(0.0);
        }
        rays.grow(count);
    }
}

/// Traces a batch and adds it to the pixels. Rays that leave the scene take the radiance of the backdrop, if there is one.
fn trace<N: Iterator<Item = u32>>(
    batch: &mut PrimaryRayBatch,
    accumulator: &mut TileAccumulator<N>,
    backdrop: Option<Rgb>,
    radiance: &mut impl FnMut(&mut RayStream, &mut [SampleStream], &mut [RadianceSample]),
) {
    batch.radiances.resize(batch.weights.len(), RadianceSample::MISS);
    let PrimaryRayBatch { rays, samplers, radiances, .. } = batch;
    radiance(rays, samplers, radiances);
    for (radiance_sample, weight) in batch.radiances.iter_mut().zip(&batch.weights) {
        match backdrop {
            Some(backdrop) if !radiance_sample.hit => radiance_sample.radiance = backdrop,
            _ => {}
        }
        accumulator.finished.statistics.camera_hits += u64::from(radiance_sample.hit);
        accumulator.add(radiance_sample, *weight);
    }
    batch.clear();
}
