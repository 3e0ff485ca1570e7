//! Samples of the paths of a wave.

use super::{inputs::PathInputs, lane_material::VertexKind};
use rt_geometry::StreamArray;
use rt_math::Samplers;

/// Samples by index of the ray (pbrt: `RaySamples`), one array for each number. Those of rays that are not
/// shaded in lanes have no meaning.
#[derive(Clone, Debug, Default)]
pub(super) struct RaySamples {
    /// Point on the sampled light.
    pub(super) direct_u: [StreamArray<f64>; 2],
    /// Choice of a light.
    pub(super) direct_uc: StreamArray<f64>,
    /// Direction of the next ray.
    pub(super) indirect_u: [StreamArray<f64>; 2],
    /// Choice of the lobe that it is sampled from.
    pub(super) indirect_uc: StreamArray<f64>,
    /// Russian roulette.
    pub(super) indirect_rr: StreamArray<f64>,
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

impl RaySamples {
    /// Draws the samples of the rays that are shaded in lanes, after this many bounces: for a light, and for the
    /// next direction.
    pub(super) fn draw(
        &mut self,
        inputs: &PathInputs<'_>,
        samplers: &mut dyn Samplers,
        (of_rays, kinds): (&[u32], &[VertexKind]),
        bounces: u32,
    ) {
        let Self { direct_u, direct_uc, indirect_u, indirect_uc, indirect_rr, buffers } = self;
        let n_lights = inputs.lighting.lights.sampled_lights().len();
        let is_shaded = |kind: VertexKind| kind > VertexKind::EmissionOnly;
        if n_lights > 0 {
            buffers.select(of_rays, kinds, |kind| is_shaded(kind) && !kind.is_delta());
            buffers.draw_pairs(samplers, direct_u);
            if n_lights > 1 {
                buffers.draw_numbers(samplers, direct_uc);
            }
        }
        let follows_specular_only = inputs.follows_specular_only();
        let is_sampled = |kind: VertexKind| is_shaded(kind) && !(follows_specular_only && kind.is_diffuse());
        if n_lights == 0 || follows_specular_only || kinds.iter().any(|kind| kind.is_delta()) {
            buffers.select(of_rays, kinds, is_sampled);
        }
        buffers.draw_pairs(samplers, indirect_u);
        if kinds.iter().any(|kind| kind.chooses_lobe()) {
            buffers.select(of_rays, kinds, VertexKind::chooses_lobe);
            buffers.draw_numbers(samplers, indirect_uc);
            buffers.select(of_rays, kinds, is_sampled);
        }
        if inputs.uses_russian_roulette(bounces) {
            buffers.draw_numbers(samplers, indirect_rr);
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

    fn draw_numbers(&mut self, samplers: &mut dyn Samplers, to: &mut StreamArray<f64>) {
        self.numbers.resize(self.rays.len(), 0.0);
        samplers.next_1d_batch(&self.samplers, &mut self.numbers);
        for (at, number) in self.rays.iter().zip(&self.numbers) {
            to.set(*at as usize, *number);
        }
    }

    fn draw_pairs(&mut self, samplers: &mut dyn Samplers, [x, y]: &mut [StreamArray<f64>; 2]) {
        self.pairs.resize(self.rays.len(), [0.0; 2]);
        samplers.next_2d_batch(&self.samplers, &mut self.pairs);
        for (at, [u, v]) in self.rays.iter().zip(&self.pairs) {
            x.set(*at as usize, *u);
            y.set(*at as usize, *v);
        }
    }
}
