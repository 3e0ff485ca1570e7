//! Path tracing in waves.

mod clamp;
mod scatter;
mod wave;

use crate::{
    Appearance, BsdfCache, InteriorList, Needs, Seen, ShadingCounts, Tracer, emitter::EmitterSet, ray_queues::RayQueues,
};
pub use clamp::Clamp;
use rt_geometry::RayKind;
use rt_math::{Interval, Ray, Sampler};
use wave::{Path, ShadowRayQueue};

/// Light transport beyond the first surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follows {
    /// All of it: the rendering equation (Kajiya 1986).
    Everything,
    /// All but what [`LightTracingIntegrator`](crate::LightTracingIntegrator) finds: the light of lamps that comes to a surface which is seen by
    /// single directions at its end.
    AllButCaustics,
    /// Specular and glossy transport; diffuse surfaces show direct and ambient light alone ("Distributed Ray
    /// Tracing", Cook, Porter, Carpenter 1984).
    Reflections,
}

/// Parameters of path tracing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSettings {
    /// Bounces after the first surface: 0 for emission and direct light.
    pub max_depth: u32,
    /// Bounces before Russian roulette may end a path.
    pub rr_start_depth: u32,
    /// Light transport beyond the first surface.
    pub follows: Follows,
    /// Bound of what a path adds to its pixel where indirect light arrives; none by default.
    pub clamp: Clamp,
}

/// Unidirectional path tracing with next-event estimation (Kajiya 1986; Veach 1997, 10.2).
///
/// At each surface a light with extent is drawn from, and a direction from the BSDF; where the two can find the same light,
/// they are weighted by the power heuristic (Veach, Guibas 1995). All delta lights are sampled at each surface, since
/// they are few. Paths end by Russian roulette, of which the chances follow what the path carries.
///
/// ```text
///   camera ────● x₁ ─ ─ ─ ─ □ light          L ≈ Lₑ(x₁)  +  w · f L cos / p(light)  +  f cos / p(BSDF) · [ w · Lₑ(x₂) + … ]
///               ╲
///                ● x₂ ─ ─ ─ □
/// ```
///
/// Classical lights and surfaces are taken so that they keep the brightness that they have under [`Whitted`](crate::Whitted): the
/// intensity of a light in classical units counts π times, and kd is an albedo. Transparent bodies lie within each other as they do there.
/// Shadow rays pass through no surface: light behind glass is found by directions from the BSDF alone.
///
/// Many paths are followed together, each with its own sampler, so that what a camera ray sees is the same to the bit
/// whatever else is in the wave. Keep one instance per thread: all buffers are reused.
#[derive(Clone, Debug)]
pub struct PathTracer<S> {
    settings: PathSettings,
    needs: Needs,
    /// Media around the camera.
    surroundings: InteriorList,
    paths: Vec<Path<S>>,
    /// Rays of the current wave.
    ray_queues: RayQueues<u32>,
    next: RayQueues<u32>,
    shadows: ShadowRayQueue,
    /// True if a ray that ends at the next surface may find light.
    scene_emits: bool,
    counts: ShadingCounts,
}

/// Materials and lights for an integrator.
#[derive(Clone, Copy, Debug)]
pub struct Lighting<'a> {
    /// Materials, textures, lights without extent, and the background.
    pub appearance: &'a Appearance,
    /// Lights with extent.
    pub emitters: &'a EmitterSet,
    /// BSDFs of uniform materials of this appearance, or `default()`.
    pub bsdfs: &'a BsdfCache,
}

impl<S: Sampler + Clone> PathTracer<S> {
    /// Follows paths as the settings say, and computes only what `needs` names.
    pub fn new(settings: PathSettings, needs: Needs) -> Self {
        Self {
            settings,
            needs,
            surroundings: InteriorList::default(),
            paths: Vec::new(),
            ray_queues: RayQueues::default(),
            next: RayQueues::default(),
            shadows: ShadowRayQueue::default(),
            scene_emits: false,
            counts: ShadingCounts::default(),
        }
    }

    /// Sets the media around the camera; air by default.
    pub fn set_surroundings(&mut self, surroundings: &InteriorList) {
        self.surroundings.clone_from(surroundings);
    }

    /// Work done since the counts were last taken.
    pub fn take_counts(&mut self) -> ShadingCounts {
        core::mem::take(&mut self.counts)
    }

    /// An estimate of the radiance that camera rays see: `seen[i]` answers `rays[i]`, whose path draws from `samplers[i]`. What
    /// is beyond the shortest slice is left alone. Infinite or NaN if the scene is; the caller decides about such samples.
    pub fn radiance_of(
        &mut self,
        world: &mut impl Tracer,
        lighting: Lighting<'_>,
        rays: &[(Ray, Interval)],
        samplers: &[S],
        seen: &mut [Seen],
    ) {
        let count = rays.len().min(samplers.len()).min(seen.len());
        let seen = &mut seen[..count];
        seen.fill(Seen::NOTHING);
        self.scene_emits = self.needs.emission || !lighting.appearance.background.is_black();
        self.start(&samplers[..count]);
        self.trace(world, lighting, RayKind::Primary, &rays[..count], |at| at as u32, seen);
        self.end_wave(world, seen);
        while !self.ray_queues.is_empty() {
            let ray_queues = core::mem::take(&mut self.ray_queues);
            for (kind, queue) in ray_queues.queues() {
                self.trace(world, lighting, kind, &queue.rays, |at| queue.paths[at], seen);
            }
            self.ray_queues = ray_queues;
            self.end_wave(world, seen);
        }
    }

    /// Traces rays of one kind, each for the path whose number belongs to its place.
    fn trace(
        &mut self,
        world: &mut impl Tracer,
        lighting: Lighting<'_>,
        kind: RayKind,
        rays: &[(Ray, Interval)],
        path: impl Fn(usize) -> u32,
        seen: &mut [Seen],
    ) {
        world.closest_batch(rays, kind, self.needs.surface(), |at, hit| {
            let id = path(at);
            self.shade_hit(lighting, id, &rays[at].0, hit, &mut seen[id as usize]);
        });
    }

    /// Traces the shadow rays of a wave, and makes the next one that which is traced.
    fn end_wave(&mut self, world: &mut impl Tracer, seen: &mut [Seen]) {
        let (clamp, counts) = (self.settings.clamp, &mut self.counts);
        let bounded = |radiance| clamp.bounded(radiance, counts);
        self.shadows.resolve(|rays, blocked| world.occluded_batch(rays, blocked), bounded, seen);
        self.ray_queues.clear();
        core::mem::swap(&mut self.ray_queues, &mut self.next);
    }

    /// Begins a path for each sampler.
    fn start(&mut self, samplers: &[S]) {
        // Lists of bodies keep their memory from wave to wave.
        self.paths.truncate(samplers.len());
        for (path, sampler) in self.paths.iter_mut().zip(samplers) {
            path.reset(sampler.clone());
        }
        for sampler in &samplers[self.paths.len()..] {
            self.paths.push(Path::new(sampler.clone()));
        }
        if self.needs.refraction {
            for path in &mut self.paths {
                path.medium_tracker.interior.clone_from(&self.surroundings);
            }
        }
    }
}

#[cfg(test)]
mod tests;
