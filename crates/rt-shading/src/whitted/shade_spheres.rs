//! Shading of queued hits on spheres in lanes.

use super::{
    Whitted,
    sphere_queue::{QueuedHit, SphereQueue},
    uniform_phong::UniformPhong,
    wave::TreePath,
};
use crate::{
    Appearance, Seen,
    hit_context::HitContext,
    interior_list::MediumEntry,
    lanes::{LANES, LaneLevel, get, get_rgb},
};
use rt_math::{Interval, Ray};

impl Whitted {
    /// Shades all queued hits on spheres.
    pub(super) fn shade_spheres(
        &mut self,
        level: LaneLevel,
        appearance: &Appearance,
        rays: &[(Ray, Interval)],
        seen: &mut [Seen],
    ) {
        if self.spheres.hits.is_empty() {
            return;
        }
        let mut queue = core::mem::take(&mut self.spheres);
        queue.compute_surfaces(level, rays);
        self.find_interfaces(appearance, &mut queue);
        queue.shade(level, &self.phongs, &appearance.lights, &self.needs);
        for (at, queued) in queue.hits.iter().enumerate() {
            let (ray, seen) = (&rays[queued.ray as usize].0, &mut seen[queued.path.sample as usize]);
            if queue.blocks[at / LANES].valid >> (at % LANES) & 1 == 0 {
                self.shade(appearance, queued.path, ray, Some(&mut queued.hit.surface(ray)), seen);
            } else {
                self.finish_sphere(appearance, &queue, at, ray.time, seen);
            }
        }
        queue.clear();
        self.spheres = queue;
    }

    /// Finds the media on both sides of queued hits. Hits on invisible interfaces are marked, to be shaded one by one.
    fn find_interfaces(&mut self, appearance: &Appearance, queue: &mut SphereQueue) {
        for (at, queued) in queue.hits.iter().enumerate() {
            let (block, lane) = (&mut queue.blocks[at / LANES], at % LANES);
            block.continues |= u8::from(queued.path.depth < self.max_depth) << lane;
            if !self.needs.refraction {
                continue;
            }
            queue.interfaces.push(None);
            let Some(material) = appearance.materials.get(queued.hit.material as usize) else { continue };
            let is_inside = block.inside >> lane & 1 == 1;
            let along = (get(&block.direction, lane), block.length[lane]);
            let context = HitContext::of(&self.needs, material, along, is_inside);
            let interior = &mut self.samples[queued.path.sample as usize].interior;
            let body = MediumEntry { object: queued.hit.object, material: queued.hit.material };
            let interface = &mut queue.interfaces[at];
            *interface = context.interface(interior, &appearance.materials, body);
            if !context.is_visible(interface.as_ref()) {
                block.valid &= !(1 << lane);
            } else if let Some(interface) = interface {
                block.eta[lane] = interface.before.ior / interface.after.ior;
                block.transmits |= 1 << lane;
            }
        }
    }

    /// Adds the light of a hit that was shaded in lanes, and its secondary rays.
    #[inline(always)]
    fn finish_sphere(&mut self, appearance: &Appearance, queue: &SphereQueue, at: usize, time: f64, seen: &mut Seen) {
        let (block, lane) = (&queue.blocks[at / LANES], at % LANES);
        let QueuedHit { hit, mut path, .. } = queue.hits[at];
        let interface = queue.interfaces.get(at).and_then(Option::as_ref);
        let Some(Some(phong)) = self.phongs.get(hit.material as usize) else { return };
        let &UniformPhong { radiance, mirror, transmission, .. } = phong;
        seen.hit = true;
        if self.needs.absorption {
            let interior = &self.samples[path.sample as usize].interior;
            let medium = interface.map_or_else(|| interior.medium(&appearance.materials), |c| c.before);
            self.absorb(&mut path.weight, medium.absorption, (hit.t - path.start) * block.length[lane]);
        }
        let is = |mask: u8| mask >> lane & 1 == 1;
        for (number, (light, lit)) in appearance.lights.iter().zip(queue.lit(at)).enumerate() {
            let shadowed = self.needs.shadows && light.casts_shadows;
            self.counts.highlights += u64::from(is(lit.highlights));
            if !is(lit.lit) {
                self.counts.shadow_rays_skipped += u64::from(shadowed);
                continue;
            }
            let reflected = get_rgb(&lit.reflected, lane);
            if shadowed {
                let (ray, span) = lit.shadow_ray(block, lane, time);
                self.direct_lighting.push_shadowed(number, reflected, ray, span);
            } else {
                self.direct_lighting.push(reflected);
            }
        }
        self.direct_lighting.end_surface(&path, radiance[usize::from(is(block.inside))]);

        let transmission = interface.zip(transmission);
        if path.depth >= self.max_depth {
            self.counts.depth_limited += u64::from(transmission.is_some() || !mirror.is_black());
            return self.ended.push(path.sample);
        }
        let bounced = |weight| TreePath { depth: path.depth + 1, passages: 0, start: 0.0, weight, ..path };
        let mut reflected_part = 1.0;
        let mut refracted = None;
        if let Some((interface, (coefficient, has_fresnel))) = transmission {
            self.counts.refractions += 1;
            if self.needs.fresnel && has_fresnel {
                self.counts.fresnel += 1;
                reflected_part = if interface.is_null() { 0.0 } else { block.reflectance[lane] };
            }
            let passed_part = if has_fresnel { 1.0 - reflected_part } else { 1.0 };
            let weight = path.weight * coefficient * passed_part;
            refracted = (self.is_significant(weight) && is(block.refracts)).then(|| (interface, bounced(weight)));
        }
        let mirrored = self.needs.reflection.then(|| {
            self.counts.mirrors += 1;
            path.weight * mirror * reflected_part
        });
        let mirrored = mirrored.filter(|weight| self.is_significant(*weight)).map(|weight| {
            let (origin, direction) = (get(&block.near_origin, lane), get(&block.mirrored, lane));
            (Ray { origin, direction, time }, bounced(weight))
        });
        let refracted = refracted.map(|(interface, path)| {
            let (origin, direction) = (get(&block.refracted_origin, lane), get(&block.refracted, lane));
            (Ray { origin, direction, time }, path, interface)
        });
        self.push_secondary_rays(path.sample, mirrored, refracted);
    }
}
