//! Shading of queued hits on spheres in lanes.
//!
//! ```text
//!   hits ─▶ surfaces ─▶ media on both sides ─▶ secondary rays ─▶ direct light ─▶ shadow rays, next rays
//!            lanes             scalar               lanes           lanes
//! ```
//!
//! Results have the bits of [`Whitted::shade`]. Lanes in which a rare case occurs are shaded one by one.

use super::{
    Whitted,
    sphere_block::{PhongLanes, QueuedHit, RayBlock, SecondaryRays, SphereBlock, four},
    uniform_phong::UniformPhong,
    wave::TreePath,
};
use crate::{
    Appearance, RadianceSample,
    hit_context::SurfaceTransmission,
    lanes::{LANES, LaneLevel, Simd, each_lane, get_rgb, set_rgb},
    medium::absorb,
};
use rt_math::{Interval, Ray};

impl Whitted {
    /// Shades all queued hits on spheres, which are of these rays.
    pub(super) fn shade_spheres(
        &mut self,
        level: LaneLevel,
        appearance: &Appearance,
        (rays, paths): (&[(Ray, Interval)], &[TreePath]),
        seen: &mut [RadianceSample],
    ) {
        if self.spheres.is_empty() {
            return;
        }
        let mut hits = core::mem::take(&mut self.spheres);
        self.shade_at(level, appearance, &hits, (rays, paths), seen);
        hits.clear();
        self.spheres = hits;
    }

    /// Shades hits with an instruction set.
    fn shade_at(
        &mut self,
        level: LaneLevel,
        appearance: &Appearance,
        hits: &[QueuedHit],
        (rays, paths): (&[(Ray, Interval)], &[TreePath]),
        seen: &mut [RadianceSample],
    ) {
        match level {
            #[cfg(target_arch = "x86_64")]
            LaneLevel::Avx2(simd) => simd.vectorize(
                #[inline(always)]
                || self.shade_blocks(simd, appearance, hits, (rays, paths), seen),
            ),
        }
    }

    /// Shades hits, four at a time, and those in which a rare case occurs by themselves.
    #[inline(always)]
    fn shade_blocks<S: Simd>(
        &mut self,
        simd: S,
        appearance: &Appearance,
        hits: &[QueuedHit],
        (rays, paths): (&[(Ray, Interval)], &[TreePath]),
        seen: &mut [RadianceSample],
    ) {
        for hits in hits.chunks(LANES) {
            let valid = self.shade_block(simd, appearance, hits, (rays, paths));
            let rare = !valid & ((1 << hits.len()) - 1);
            self.counts.lanes += LANES as u64;
            self.counts.lanes_used += u64::from(hits.len() as u32 - rare.count_ones());
            for lane in each_lane(rare) {
                let (hit, at) = (hits[lane].hit(), hits[lane].ray as usize);
                let (ray, path) = (&rays[at].0, paths[at]);
                let seen = &mut seen[path.sample as usize];
                self.shade(appearance, path, ray, &mut hit.surface(ray), seen);
            }
        }
    }

    /// Shades one to four hits. Bit `i` of the result is set for hit `i`, unless it must be shaded by itself.
    #[inline(always)]
    fn shade_block<S: Simd>(
        &mut self,
        simd: S,
        appearance: &Appearance,
        hits: &[QueuedHit],
        (rays, paths): (&[(Ray, Interval)], &[TreePath]),
    ) -> u8 {
        let mut block = SphereBlock::new(simd, hits, (rays, paths), self.max_depth);
        if self.features.refraction {
            self.find_interfaces(appearance, hits, &mut block, paths);
        }
        let (phongs, [a, b, c, d]) = (&self.phongs, four(hits));
        let phongs = [phong(phongs, a), phong(phongs, b), phong(phongs, c), phong(phongs, d)];
        let secondary = block.secondary_rays(simd, phongs, (&self.features, self.min_contribution));
        block.exclude_grazing_lights(simd, &appearance.lights);
        let radiance = block.radiance(simd, phongs);

        let phongs = PhongLanes::new(simd, phongs);
        let near_origin = block.near_origin();
        for (number, light) in appearance.lights.iter().enumerate() {
            let shadowed = self.features.shadows && light.casts_shadows;
            let reflected = block.reflect(simd, light, &phongs);
            self.counts.highlights += u64::from(reflected.highlights.count_ones());
            if shadowed {
                self.counts.shadow_rays_skipped += u64::from((block.valid & !reflected.lit).count_ones());
            }
            self.direct_lighting.push_block(number, &reflected, (&near_origin, &block.times), shadowed);
        }
        self.direct_lighting.end_block(&block, radiance);
        self.push_block(hits, (&block, &secondary), paths);
        block.valid
    }

    /// Finds the media on both sides of hits, and applies absorption. Hits on invisible interfaces are marked, to be shaded one by
    /// one.
    #[inline(always)]
    fn find_interfaces<S: Simd>(
        &mut self,
        appearance: &Appearance,
        hits: &[QueuedHit],
        block: &mut SphereBlock<S>,
        paths: &[TreePath],
    ) {
        let materials = &appearance.materials;
        for (lane, &QueuedHit { ray, body, t, .. }) in hits.iter().enumerate() {
            let path = &paths[ray as usize];
            let interior = &mut self.samples[path.sample as usize].interior;
            let (Some(Some(phong)), Some(material)) =
                (self.phongs.get(body.material as usize), materials.get(body.material as usize))
            else {
                continue;
            };
            let surface = phong.interface;
            if surface == SurfaceTransmission::None && (interior.is_empty() || !self.features.absorption) {
                continue;
            }
            let interface = surface.interface(interior, materials, body, block.inside >> lane & 1 == 1);
            let interface = interface.as_ref();
            if !surface.is_visible(material, interface) {
                block.valid &= !(1 << lane);
                continue;
            }
            if self.features.absorption {
                let around = interface.map_or_else(|| interior.medium(materials), |c| c.before);
                let way = (t - path.start) * block.length[lane];
                let mut weight = path.weight;
                if absorb(&mut weight, around.absorption, way) {
                    set_rgb(&mut block.weight, lane, weight);
                    block.absorbed |= 1 << lane;
                }
            }
            if let Some(interface) = interface.filter(|_| phong.transmission.is_some()) {
                block.eta[lane] = interface.before.ior / interface.after.ior;
                block.transmits |= 1 << lane;
            }
        }
    }

    /// Appends the secondary rays of a block, as [`push_secondary_rays`](Self::push_secondary_rays) does.
    #[inline(always)]
    fn push_block<S: Simd>(
        &mut self,
        hits: &[QueuedHit],
        (block, secondary): (&SphereBlock<S>, &SecondaryRays),
        paths: &[TreePath],
    ) {
        let continues = block.valid & block.continues;
        let ends = block.valid & !continues;
        let count = |mask: u8| u64::from(mask.count_ones());
        self.counts.absorption += count(block.valid & block.absorbed);
        self.counts.depth_limited += count(ends & secondary.is_specular);
        self.counts.refractions += count(continues & block.transmits);
        self.counts.fresnel += count(continues & secondary.fresnel);
        self.counts.mirrors += if self.features.reflection { count(continues) } else { 0 };

        let (mirrored, refracted) = (continues & secondary.mirrored.mask, continues & secondary.refracted.mask);
        let bounced = |lane: usize, rays: &RayBlock| {
            let path = &paths[hits[lane].ray as usize];
            let weight = get_rgb(&rays.weight, lane);
            TreePath { sample: block.samples[lane], depth: path.depth + 1, passages: 0, weight, start: 0.0 }
        };
        for lane in each_lane(mirrored) {
            let ray = secondary.mirrored.ray(lane, block.times[lane]);
            self.next.reflected.push(ray, Interval::SPAWNED, bounced(lane, &secondary.mirrored));
        }
        for lane in each_lane(refracted) {
            let (hit, is_inside) = (&hits[lane], block.inside >> lane & 1 == 1);
            let state = &mut self.samples[block.samples[lane] as usize];
            let event = phong(&self.phongs, hit).interface.event(&mut state.interior, hit.body, is_inside);
            let ray = secondary.refracted.ray(lane, block.times[lane]);
            let path = bounced(lane, &secondary.refracted);
            if mirrored >> lane & 1 == 1 {
                state.defer(ray, &path, event);
            } else {
                state.interior.apply(event);
                self.next.refracted.push(ray, Interval::SPAWNED, path);
            }
        }
        for lane in each_lane(block.valid & !(mirrored | refracted)) {
            self.ended.push(block.samples[lane]);
        }
    }
}

/// Phong model of a hit. Only hits on uniform materials are queued.
#[inline(always)]
fn phong<'a>(phongs: &'a [Option<UniformPhong>], queued: &QueuedHit) -> &'a UniformPhong {
    phongs.get(queued.body.material as usize).and_then(Option::as_ref).unwrap_or(&UniformPhong::BLACK)
}
