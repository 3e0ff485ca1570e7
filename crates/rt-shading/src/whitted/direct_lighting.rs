//! Direct light on the surfaces of a wave: a buffer of reflected light and shadow rays, which are traced at the end of the wave.

use super::{
    hit_block::{HitBlock, ReflectedLanes},
    wave::TreePath,
};
use crate::{
    RadianceSample,
    lanes::{LANES, LaneArray, LaneLevel, LaneMask, Lanes, Simd, dispatch, each_lane, get, get_rgb},
};
use rt_math::{Interval, Ray, Rgb, Vector3};

/// Direct light on the surfaces of a wave, and its shadow rays. Buffers are reused.
#[derive(Clone, Debug, Default)]
pub(super) struct DirectLighting {
    surfaces: Vec<ShadedHit>,
    /// Unoccluded reflected radiance, with the light and index of its shadow ray.
    reflected: Vec<(Rgb, Option<(u32, u32)>)>,
    /// Surfaces that were shaded in lanes, eight each.
    blocks: Vec<ShadedBlock>,
    /// Light that these reflect, by block and light.
    reflected_blocks: Vec<ReflectedBlock>,
    n_lights: usize,
    shadows: Vec<ShadowBatch>,
}

/// Shaded hit whose shadow rays are not traced yet.
#[derive(Clone, Copy, Debug)]
struct ShadedHit {
    sample: u32,
    weight: Rgb,
    /// Radiance that needs no shadow ray.
    radiance: Rgb,
    /// End of its lights in [`DirectLighting::reflected`].
    end: u32,
}

/// Version of [`ShadedHit`] for eight hits. Bit `i` of a mask is for lane `i`.
#[derive(Clone, Debug)]
struct ShadedBlock {
    /// Lanes with a hit.
    valid: u8,
    samples: [u32; LANES],
    weight: Vector3<LaneArray>,
    radiance: Vector3<LaneArray>,
}

/// Light from one light that eight surfaces reflect. Bit `i` of a mask is for lane `i`.
#[derive(Clone, Debug)]
struct ReflectedBlock {
    /// Lanes that reflect light.
    lit: u8,
    /// Index of the shadow ray of the first of these lanes, which those of the others follow; `None` if the light casts no shadow.
    first_ray: Option<u32>,
    /// Radiance if the light is not occluded.
    radiance: Vector3<LaneArray>,
}

/// Shadow rays to one light: they are coherent.
#[derive(Clone, Debug, Default)]
struct ShadowBatch {
    rays: Vec<(Ray, Interval)>,
    blocked: Vec<bool>,
}

impl DirectLighting {
    /// Starts a wave of a scene with this number of lights.
    pub(super) fn start(&mut self, n_lights: usize) {
        self.n_lights = n_lights;
        if self.shadows.len() < n_lights {
            self.shadows.resize_with(n_lights, ShadowBatch::default);
        }
    }

    /// Adds light that the current surface reflects, without a shadow ray.
    #[inline]
    pub(super) fn push(&mut self, reflected: Rgb) {
        self.reflected.push((reflected, None));
    }

    /// Adds light that the current surface reflects if the shadow ray is unoccluded.
    #[inline(always)]
    pub(super) fn push_shadowed(&mut self, light: usize, reflected: Rgb, ray: Ray, span: Interval) {
        let rays = &mut self.shadows[light].rays;
        rays.push((ray, span));
        self.reflected.push((reflected, Some((light as u32, rays.len() as u32 - 1))));
    }

    /// Ends the lights of a surface, and adds its emission.
    #[inline]
    pub(super) fn end_surface(&mut self, path: &TreePath, radiance: Rgb) {
        let end = self.reflected.len() as u32;
        self.surfaces.push(ShadedHit { sample: path.sample, weight: path.weight, radiance, end });
    }

    /// Adds light from one light that the current block reflects, and its shadow rays if the light `casts_shadows`. It is called for
    /// all lights in their order, also for those that reach no lane; [`end_block`](Self::end_block) follows.
    #[inline(always)]
    pub(super) fn push_block<S: Simd>(
        &mut self,
        light: usize,
        reflected: &ReflectedLanes<S>,
        (origin, times): (&Vector3<LaneArray>, &LaneArray),
        casts_shadows: bool,
    ) {
        let (lit, radiance) = (reflected.lit, Lanes::store_vector(reflected.radiance));
        let rays = &mut self.shadows[light].rays;
        let first_ray = casts_shadows.then_some(rays.len() as u32);
        if casts_shadows && lit != 0 {
            let directions = Lanes::store_vector(reflected.shadow_direction);
            let ends = reflected.shadow_end.store();
            for lane in each_lane(lit) {
                let ray = Ray { origin: get(origin, lane), direction: get(&directions, lane), time: times[lane] };
                rays.push((ray, Interval { max: ends[lane], ..Interval::SPAWNED }));
            }
        }
        self.reflected_blocks.push(ReflectedBlock { lit, first_ray, radiance });
    }

    /// Ends the lights of a block, and adds its emission.
    #[inline(always)]
    pub(super) fn end_block<S: Simd>(&mut self, block: &HitBlock<S>, radiance: Vector3<Lanes<S>>) {
        let HitBlock { valid, samples, weight, .. } = *block;
        self.blocks.push(ShadedBlock { valid, samples, weight, radiance: Lanes::store_vector(radiance) });
    }

    /// Traces the shadow rays and adds unoccluded light to the radiance of the samples. `level` is that of the blocks.
    pub(super) fn resolve(
        &mut self,
        level: Option<LaneLevel>,
        mut occluded: impl FnMut(&[(Ray, Interval)], &mut [bool]),
        seen: &mut [RadianceSample],
    ) {
        for ShadowBatch { rays, blocked } in &mut self.shadows {
            blocked.clear();
            blocked.resize(rays.len(), false);
            if !rays.is_empty() {
                occluded(rays, blocked);
            }
            rays.clear();
        }
        let is_blocked = |light: u32, ray: u32| self.shadows[light as usize].blocked[ray as usize];
        let mut reflected = self.reflected.iter();
        let mut start = 0;
        for met in &self.surfaces {
            let mut radiance = met.radiance;
            for (light, decided_by) in reflected.by_ref().take((met.end - start) as usize) {
                if !decided_by.is_some_and(|(light, ray)| is_blocked(light, ray)) {
                    radiance += *light;
                }
            }
            start = met.end;
            seen[met.sample as usize].radiance += met.weight * radiance;
        }
        self.surfaces.clear();
        self.reflected.clear();
        if let Some(level) = level {
            dispatch!(level, simd => simd.vectorize(
                #[inline(always)]
                || self.resolve_blocks(simd, seen),
            ));
        }
        self.blocks.clear();
        self.reflected_blocks.clear();
    }

    #[inline(always)]
    fn resolve_blocks<S: Simd>(&self, simd: S, seen: &mut [RadianceSample]) {
        for (at, block) in self.blocks.iter().enumerate() {
            let mut radiance = Lanes::load_vector(simd, &block.radiance);
            let reflected = &self.reflected_blocks[at * self.n_lights..(at + 1) * self.n_lights];
            for (reflected, shadows) in reflected.iter().zip(&self.shadows) {
                let unblocked = reflected.unblocked(&shadows.blocked);
                if unblocked != 0 {
                    let sum = radiance + Lanes::load_vector(simd, &reflected.radiance);
                    radiance = Vector3::select(LaneMask::from_bits(simd, unblocked), sum, radiance);
                }
            }
            let radiance = Lanes::load_vector(simd, &block.weight).scaled_by(radiance);
            let radiance = Lanes::store_vector(radiance);
            for lane in each_lane(block.valid) {
                let seen = &mut seen[block.samples[lane] as usize];
                seen.radiance += get_rgb(&radiance, lane);
                seen.hit = true;
            }
        }
    }
}

impl ReflectedBlock {
    /// Lanes whose light is not blocked.
    #[inline(always)]
    fn unblocked(&self, blocked: &[bool]) -> u8 {
        let Some(first) = self.first_ray else { return self.lit };
        let mut blocked = blocked[first as usize..].iter();
        let mut unblocked = self.lit;
        for lane in each_lane(self.lit) {
            unblocked &= !(u8::from(blocked.next() == Some(&true)) << lane);
        }
        unblocked
    }
}
