//! Samples of the paths of a wave.

use super::{inputs::PathInputs, lane_material::VertexKind};
use rt_geometry::StreamArray;
use rt_math::Sampler;

/// Samples by index of the ray, one array for each number. Those of rays that are not shaded in lanes have no meaning.
#[derive(Clone, Debug, Default)]
pub(super) struct WaveSamples {
    /// Point on the sampled light.
    pub(super) light: [StreamArray<f64>; 2],
    /// Choice of a light.
    pub(super) choice: StreamArray<f64>,
    /// Direction of the next ray.
    pub(super) direction: [StreamArray<f64>; 2],
    /// Choice of the lobe that it is sampled from.
    pub(super) lobe: StreamArray<f64>,
    pub(super) roulette: StreamArray<f64>,
    buffers: Draws,
}

/// Rays for which samples are drawn, their samplers, and the samples.
#[derive(Clone, Debug, Default)]
struct Draws {
    rays: Vec<u32>,
    samplers: Vec<u32>,
    pairs: Vec<[f64; 2]>,
    numbers: Vec<f64>,
}

impl WaveSamples {
    /// Draws the samples of the rays that are shaded in lanes, after this many bounces: for a light, and for the next direction.
    pub(super) fn draw<S: Sampler>(
        &mut self,
        inputs: &PathInputs<'_>,
        samplers: &mut [S],
        (of_rays, kinds): (&[u32], &[VertexKind]),
        bounces: u32,
    ) {
        let Self { light, choice, direction, lobe, roulette, buffers } = self;
        let n_lights = inputs.lighting.lights.sampled_lights().len();
        let is_shaded = |kind: VertexKind| kind > VertexKind::EmissionOnly;
        if n_lights > 0 {
            buffers.select(of_rays, kinds, |kind| is_shaded(kind) && !kind.is_delta());
            buffers.draw_pairs(samplers, light);
            if n_lights > 1 {
                buffers.draw_numbers(samplers, choice);
            }
        }
        let follows_specular_only = inputs.follows_specular_only();
        let is_sampled = |kind: VertexKind| is_shaded(kind) && !(follows_specular_only && kind.is_diffuse());
        if n_lights == 0 || follows_specular_only || kinds.iter().any(|kind| kind.is_delta()) {
            buffers.select(of_rays, kinds, is_sampled);
        }
        buffers.draw_pairs(samplers, direction);
        if kinds.iter().any(|kind| kind.chooses_lobe()) {
            buffers.select(of_rays, kinds, VertexKind::chooses_lobe);
            buffers.draw_numbers(samplers, lobe);
            buffers.select(of_rays, kinds, is_sampled);
        }
        if inputs.uses_russian_roulette(bounces) {
            buffers.draw_numbers(samplers, roulette);
        }
    }
}

impl Draws {
    fn select(&mut self, of_rays: &[u32], kinds: &[VertexKind], is_wanted: impl Fn(VertexKind) -> bool) {
        self.rays.clear();
        self.samplers.clear();
        for ((at, kind), sampler) in (0..).zip(kinds).zip(of_rays) {
            if is_wanted(*kind) {
                self.rays.push(at);
                self.samplers.push(*sampler);
            }
        }
    }

    fn draw_numbers<S: Sampler>(&mut self, samplers: &mut [S], to: &mut StreamArray<f64>) {
        self.numbers.resize(self.rays.len(), 0.0);
        S::next_1d_batch(samplers, &self.samplers, &mut self.numbers);
        for (at, number) in self.rays.iter().zip(&self.numbers) {
            to.set(*at as usize, *number);
        }
    }

    fn draw_pairs<S: Sampler>(&mut self, samplers: &mut [S], [x, y]: &mut [StreamArray<f64>; 2]) {
        self.pairs.resize(self.rays.len(), [0.0; 2]);
        S::next_2d_batch(samplers, &self.samplers, &mut self.pairs);
        for (at, [u, v]) in self.rays.iter().zip(&self.pairs) {
            x.set(*at as usize, *u);
            y.set(*at as usize, *v);
        }
    }
}
