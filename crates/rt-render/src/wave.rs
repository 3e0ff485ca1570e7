//! Waves of camera rays: the samples of some pixels, traced together.

use rt_math::{DVec2, Interval, Ray};
use rt_shading::Seen;

use crate::{RenderPlan, pixel::Pixel, tile::Finished, tiles::Tile};

/// Camera rays in a wave: enough for rays to be traced side by side, and few enough for all that is known of them to
/// stay in a core's own cache.
const WAVE: usize = 256;

/// The camera rays of a wave, and what they see.
#[derive(Debug, Default)]
pub(crate) struct CameraWave {
    positions: Vec<[f64; 2]>,
    rays: Vec<(Ray, Interval)>,
    /// What each sample weighs in its pixel.
    weights: Vec<f64>,
    seen: Vec<Seen>,
}

impl CameraWave {
    const fn room(&self) -> usize {
        WAVE - self.rays.len()
    }
}

/// Adds samples to pixels, which are full after so many.
struct Sums {
    finished: Finished,
    pixel: Pixel,
    missing: u32,
    spp: u32,
}

impl Sums {
    fn new(finished: Finished, pixel: Pixel, spp: u32) -> Self {
        Self { finished, pixel, missing: spp, spp }
    }

    #[inline]
    fn add(&mut self, seen: &Seen, weight: f64) {
        self.pixel.add(seen, weight);
        self.missing -= 1;
        if self.missing == 0 {
            self.finished.push(&self.pixel);
            self.pixel = self.pixel.emptied();
            self.missing = self.spp;
        }
    }
}

impl RenderPlan<'_> {
    /// Takes all samples of a tile, pixel by pixel and in the order of their numbers. `radiance` is the integrator: what
    /// the rays of a wave see.
    pub(crate) fn sample_tile(
        &self,
        tile: Tile,
        wave: &mut CameraWave,
        mut radiance: impl FnMut(&[(Ray, Interval)], &mut [Seen]),
    ) -> Finished {
        let mut sums = Sums::new(Finished::new(tile, self.transparent), Pixel::new(self.transparent), self.spp);
        for pixel in tile.pixels() {
            let mut first = 0;
            while first < self.spp {
                let count = wave.room().min((self.spp - first) as usize);
                self.generate(pixel, first, count, wave);
                first += count as u32;
                if wave.room() == 0 {
                    trace(wave, &mut sums, &mut radiance);
                }
            }
        }
        trace(wave, &mut sums, &mut radiance);
        sums.finished
    }

    /// Puts so many camera rays of a pixel into the wave, beginning with sample `first`.
    fn generate(&self, [x, y]: [u32; 2], first: u32, count: usize, wave: &mut CameraWave) {
        let corner = DVec2::new(f64::from(x), f64::from(y)) + self.sample_offset;
        wave.positions.resize(count, [0.0; 2]);
        self.sampler.positions([x, y], first, &mut wave.positions);
        for &position in &wave.positions {
            let (offset, weight) = self.filter.sample(position);
            wave.rays.push((self.camera.ray(corner + offset, 0.0), Interval::FORWARD));
            wave.weights.push(weight);
        }
    }
}

/// Traces a wave and empties it into the pixels.
fn trace(wave: &mut CameraWave, sums: &mut Sums, radiance: &mut impl FnMut(&[(Ray, Interval)], &mut [Seen])) {
    wave.seen.resize(wave.rays.len(), Seen::NOTHING);
    radiance(&wave.rays, &mut wave.seen);
    for (seen, weight) in wave.seen.iter().zip(&wave.weights) {
        sums.add(seen, *weight);
    }
    wave.rays.clear();
    wave.weights.clear();
}
