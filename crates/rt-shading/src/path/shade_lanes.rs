//! Shading of queued path vertices in lanes.

use super::{
    Lighting, PathTracer, Transport,
    vertex_block::FollowedLobes,
    vertex_queue::{QueueKind, SampledDelta, VertexQueue},
    wave::PrevVertex,
};
use crate::{
    RadianceSample,
    bsdf::Scattering,
    lanes::{LANES, LaneLevel},
    vertex::Vertex,
    viewed_surface::ViewedSurface,
};
use rt_math::{Interval, Ray, Sampler};

impl<S: Sampler + Clone> PathTracer<S> {
    /// Shades the queued vertices that a wave has found.
    pub(super) fn shade_queues(&mut self, lighting: Lighting<'_>, seen: &mut [RadianceSample]) {
        let Some(level) = self.lanes else { return };
        for kind in QueueKind::ALL {
            let queue = &mut self.queues[kind as usize];
            if !queue.is_empty() {
                let mut queue = core::mem::replace(queue, VertexQueue::new(kind));
                self.shade_queue(level, lighting, &mut queue, seen);
                queue.clear();
                self.queues[kind as usize] = queue;
            }
        }
    }

    /// Shades the vertices of a queue.
    fn shade_queue(
        &mut self,
        level: LaneLevel,
        lighting: Lighting<'_>,
        queue: &mut VertexQueue<S>,
        seen: &mut [RadianceSample],
    ) {
        let lobes = queue.sampled_lobes(self.settings.transport != Transport::Specular);
        let (clamp, n_lights) = (self.settings.clamp, lighting.lights.sampled_lights().len());
        let n_delta = lighting.lights.delta_lights().count();
        queue.draw(&mut self.samplers, n_lights, lobes);
        queue.shade(level, lighting.lights, lobes);
        self.counts.lanes += queue.vertices().len().next_multiple_of(LANES) as u64;
        for (at, queued) in queue.vertices().iter().enumerate() {
            let id = queued.path;
            let Some(scattered) = queue.scattered(at) else {
                self.samplers[id as usize] = queue.sampler_before(at);
                let (mut surface, (direction, is_inside), bsdf) = queue.surface(at);
                let view = ViewedSurface::new(direction, is_inside, &mut surface);
                let vertex = Vertex::new(view, &bsdf, queued.time);
                let specular = if lobes == FollowedLobes::Specular { bsdf.without_diffuse() } else { None };
                let vertex =
                    if lobes == FollowedLobes::All { vertex } else { vertex.with_sampled_lobes(specular.as_ref()) };
                self.scatter(lighting, id, &vertex, None, &mut seen[id as usize]);
                continue;
            };
            self.counts.lanes_used += 1;
            let path = &mut self.paths[id as usize];
            let is_clamped = clamp.applies_after(path.bounces + 1);
            for (number, light) in lighting.lights.delta_lights().enumerate() {
                match queue.delta_light(at, number, n_delta) {
                    SampledDelta::Unlit => {}
                    SampledDelta::Black => self.counts.shadow_rays_skipped += u64::from(light.casts_shadows),
                    SampledDelta::Lit { radiance, origin, direction, end } if light.casts_shadows => {
                        let ray = Ray { origin, direction, time: queued.time };
                        self.shadows.push((ray, Interval { max: end, ..Interval::SPAWNED }), id, radiance, is_clamped);
                    }
                    SampledDelta::Lit { radiance, .. } => {
                        seen[id as usize].radiance += clamp.apply(path.bounces + 1, radiance, &mut self.counts);
                    }
                }
            }
            if let Some((origin, direction, radiance)) = scattered.direct {
                let span = if scattered.is_light_infinite { Interval::SPAWNED } else { Interval::SEGMENT };
                let ray = Ray { origin, direction, time: queued.time };
                self.shadows.push((ray, span), id, radiance, is_clamped);
            } else {
                self.counts.shadow_rays_skipped += u64::from(n_lights > 0);
            }
            let Some(next) = scattered.next else { continue };
            let ends = path.bounces >= self.settings.max_depth || (lobes == FollowedLobes::Specular && next.is_diffuse);
            if ends && !self.scene_emits {
                self.counts.depth_limited += 1;
                continue;
            }
            if !next.is_alive {
                continue;
            }
            let (point, normal) = queue.point_and_normal(at);
            path.throughput = next.throughput;
            path.first_bounce_nonspecular |= path.bounces == 0;
            path.bounces += 1;
            path.emission_only = ends;
            path.prev = PrevVertex { point, normal: Some(normal), pdf: Some(next.pdf) };
            path.medium_tracker.scatter(None, Scattering::Reflection);
            let ray = Ray { origin: next.origin, direction: next.direction, time: queued.time };
            let next = if next.is_diffuse { &mut self.next.diffuse } else { &mut self.next.reflected };
            next.push(ray, Interval::SPAWNED, id);
        }
    }
}
