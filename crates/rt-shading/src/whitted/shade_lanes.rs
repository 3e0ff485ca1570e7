//! Shading of queued hits in lanes.
//!
//! ```text
//!   hits ─▶ surfaces ─▶ media on both sides ─▶ secondary rays ─▶ direct light ─▶ shadow rays, next rays
//!            lanes             scalar               lanes           lanes
//! ```
//!
//! Results have the bits of [`Whitted::shade`]. Lanes in which a rare case occurs are shaded one by one.

use super::{
    Whitted,
    hit_block::{HitBlock, PhongLanes, RayBlock, SecondaryRays},
    hit_queue::{QueuedHit, eight},
    lane_phong::LanePhong,
    point_lanes::{ShapeLanes, each},
    wave::TreePath,
};
use crate::{
    Appearance, RadianceSample,
    hit_context::SurfaceTransmission,
    lanes::{LANES, LaneLevel, Simd, dispatch, each_lane, first_lanes, get_rgb, set_rgb},
    medium::absorb,
};
use rt_math::{Interval, Ray};

impl Whitted {
    /// Shades all queued hits, which are of these rays.
    pub(super) fn shade_queue(
        &mut self,
        level: LaneLevel,
        appearance: &Appearance,
        (rays, paths): (&[(Ray, Interval)], &[TreePath]),
        seen: &mut [RadianceSample],
    ) {
        let (mut queue, phongs) = (core::mem::take(&mut self.queue), core::mem::take(&mut self.phongs));
        let batch = (rays, paths);
        self.shade_shapes(level, appearance, (&mut queue.spheres, &phongs), batch, seen);
        self.shade_shapes(level, appearance, (&mut queue.triangles, &phongs), batch, seen);
        self.shade_shapes(level, appearance, (&mut queue.planes, &phongs), batch, seen);
        (self.queue, self.phongs) = (queue, phongs);
    }

    /// Shades hits on shapes of one kind, and removes them.
    fn shade_shapes<T: ShapeLanes>(
        &mut self,
        level: LaneLevel,
        appearance: &Appearance,
        (hits, phongs): (&mut Vec<QueuedHit<T>>, &[Option<LanePhong>]),
        (rays, paths): (&[(Ray, Interval)], &[TreePath]),
        seen: &mut [RadianceSample],
    ) {
        if hits.is_empty() {
            return;
        }
        dispatch!(level, simd => simd.vectorize(
            #[inline(always)]
            || self.shade_blocks(simd, appearance, (hits, phongs), (rays, paths), seen),
        ));
        hits.clear();
    }

    /// Shades hits, eight at a time, and those in which a rare case occurs by themselves.
    #[inline(always)]
    fn shade_blocks<S: Simd, T: ShapeLanes>(
        &mut self,
        simd: S,
        appearance: &Appearance,
        (hits, phongs): (&[QueuedHit<T>], &[Option<LanePhong>]),
        (rays, paths): (&[(Ray, Interval)], &[TreePath]),
        seen: &mut [RadianceSample],
    ) {
        for hits in hits.chunks(LANES) {
            let valid = self.shade_block(simd, appearance, (hits, phongs), (rays, paths));
            let rare = !valid & first_lanes(hits.len());
            self.counts.lanes += LANES as u64;
            self.counts.lanes_used += u64::from(hits.len() as u32 - rare.count_ones());
            for lane in each_lane(rare) {
                let at = hits[lane].ray as usize;
                let (ray, path) = (&rays[at].0, paths[at]);
                let seen = &mut seen[path.sample as usize];
                self.shade(appearance, path, ray, &mut hits[lane].surface(ray), seen);
            }
        }
    }

    /// Shades one to eight hits. Bit `i` of the result is set for hit `i`, unless it must be shaded by itself.
    #[inline(always)]
    fn shade_block<S: Simd, T: ShapeLanes>(
        &mut self,
        simd: S,
        appearance: &Appearance,
        (hits, phongs): (&[QueuedHit<T>], &[Option<LanePhong>]),
        (rays, paths): (&[(Ray, Interval)], &[TreePath]),
    ) -> u8 {
        let materials = each!(eight(hits), |hit| phong(phongs, hit));
        let mut block = HitBlock::new(simd, (hits, materials), (rays, paths), self.max_depth);
        if self.features.refraction {
            self.find_interfaces(appearance, (hits, materials), &mut block, paths);
        }
        let odd = block.odd;
        let phongs = each!(materials, |phong, lane| phong.square(odd >> lane));
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
        self.push_block((hits, materials), (&block, &secondary), paths);
        block.valid
    }

    /// Finds the media on both sides of hits, and applies absorption. Hits on invisible interfaces are marked, to be shaded one by
    /// one.
    #[inline(always)]
    fn find_interfaces<S: Simd, T>(
        &mut self,
        appearance: &Appearance,
        (hits, phongs): (&[QueuedHit<T>], [&LanePhong; LANES]),
        block: &mut HitBlock<S>,
        paths: &[TreePath],
    ) {
        let materials = &appearance.materials;
        for (lane, &QueuedHit { ray, body, t, .. }) in hits.iter().enumerate() {
            let path = &paths[ray as usize];
            let interior = &mut self.samples[path.sample as usize].interior;
            let Some(material) = materials.get(body.material as usize) else { continue };
            let phong = phongs[lane].square(0);
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
    fn push_block<S: Simd, T>(
        &mut self,
        (hits, phongs): (&[QueuedHit<T>], [&LanePhong; LANES]),
        (block, secondary): (&HitBlock<S>, &SecondaryRays),
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
            let event = phongs[lane].square(0).interface.event(&mut state.interior, hit.body, is_inside);
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

/// Phong model of a hit. Only hits on materials with one are queued.
#[inline(always)]
fn phong<'a, T>(phongs: &'a [Option<LanePhong>], queued: &QueuedHit<T>) -> &'a LanePhong {
    phongs.get(queued.body.material as usize).and_then(Option::as_ref).unwrap_or(&LanePhong::BLACK)
}
