//! Samples of the paths of a wave.

use rt_geometry::{HitStream, StreamArray};
use rt_math::Sampler;

/// Samples by index of the ray, one array for each number. Those of rays that hit nothing have no meaning.
#[derive(Clone, Debug, Default)]
pub(super) struct WaveSamples {
    /// Point on the sampled light.
    pub(super) light: [StreamArray<f64>; 2],
    /// Choice of a light.
    pub(super) choice: StreamArray<f64>,
    /// Direction of the next ray.
    pub(super) direction: [StreamArray<f64>; 2],
    /// Russian roulette.
    pub(super) roulette: StreamArray<f64>,
    /// Indices of rays that hit, and of their samplers.
    hits: Vec<u32>,
    samplers: Vec<u32>,
    pairs: Vec<[f64; 2]>,
    numbers: Vec<f64>,
}

impl WaveSamples {
    /// Draws the samples of all rays that hit a surface, for one of `n_lights`, and for the next direction.
    pub(super) fn draw<S: Sampler>(
        &mut self,
        samplers: &mut [S],
        (of_rays, hits, n_rays): (&[u32], &HitStream, usize),
        n_lights: usize,
        plays_roulette: bool,
    ) {
        let Self { light, choice, direction, roulette, hits: hit_rays, samplers: which, pairs, numbers } = self;
        hit_rays.clear();
        which.clear();
        let primitives = hits.primitive.as_slice()[..n_rays].iter();
        for ((at, primitive), sampler) in (0..).zip(primitives).zip(of_rays) {
            if *primitive != HitStream::NONE {
                hit_rays.push(at);
                which.push(*sampler);
            }
        }
        let hits = &hit_rays[..];
        pairs.resize(which.len(), [0.0; 2]);
        numbers.resize(which.len(), 0.0);
        if n_lights > 0 {
            S::next_2d_batch(samplers, which, pairs);
            scatter_pairs(hits, pairs, light);
        }
        if n_lights > 1 {
            S::next_1d_batch(samplers, which, numbers);
            scatter(hits, numbers, choice);
        }
        S::next_2d_batch(samplers, which, pairs);
        scatter_pairs(hits, pairs, direction);
        if plays_roulette {
            S::next_1d_batch(samplers, which, numbers);
            scatter(hits, numbers, roulette);
        }
    }
}

fn scatter(hits: &[u32], numbers: &[f64], to: &mut StreamArray<f64>) {
    for (at, number) in hits.iter().zip(numbers) {
        to.set(*at as usize, *number);
    }
}

fn scatter_pairs(hits: &[u32], pairs: &[[f64; 2]], [x, y]: &mut [StreamArray<f64>; 2]) {
    for (at, [u, v]) in hits.iter().zip(pairs) {
        x.set(*at as usize, *u);
        y.set(*at as usize, *v);
    }
}
