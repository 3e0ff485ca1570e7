//! Path tracing in waves, with next-event estimation and MIS.

mod clamp;
mod direct_lighting;
mod direct_lighting_lanes;
mod lane_bsdf;
mod shade;
mod shade_lanes;
pub(crate) mod transport;
mod vertex_block;
mod vertex_queue;
mod vertex_stages;
mod wave;
mod wavefront;

use crate::{
    Appearance, BsdfCache, ClosestHit, InteriorList, LazyShapes, RadianceSample, SceneQueries, ShadingCounts,
    ShadingFeatures, lanes::LaneLevel, light::LightSet, ray_queues::RayQueues,
};
pub use clamp::Clamp;
use rt_geometry::RayKind;
use rt_math::{Interval, Ray, Sampler};
pub use transport::Transport;
use vertex_queue::{LazyShapeHit, QueueKind, VertexQueue};
use wave::{Path, ShadowRayQueue};
pub use wavefront::WavefrontPathTracer;

/// Parameters of path tracing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSettings {
    /// Maximum bounces after the first surface: 0 for emission and direct light.
    pub max_depth: u32,
    /// Bounces before Russian roulette starts.
    pub rr_start_depth: u32,
    /// Light transport beyond the first surface.
    pub transport: Transport,
    /// Bound on contributions of indirect light; none by default.
    pub clamp: Clamp,
}

/// Unidirectional path tracing with next-event estimation (Kajiya 1986; Veach 1997, 10.2).
///
/// Each vertex samples all delta lights, one area or environment light, and a direction of the BSDF. MIS weights combine the last
/// two by the power heuristic (Veach, Guibas 1995). Russian roulette ends paths by their throughput.
///
/// ```text
///   camera ────● x₁ ─ ─ ─ ─ □ light          L ≈ Lₑ(x₁)  +  w · f L cos / p(light)  +  f cos / p(BSDF) · [ w · Lₑ(x₂) + … ]
///               ╲
///                ● x₂ ─ ─ ─ □
/// ```
///
/// Classical lights and surfaces are as bright as under [`Whitted`](crate::Whitted). The intensity of a light in classical units
/// thus counts π times, and kd is an albedo. Dielectrics nest as they do there. Shadow rays pass through no surface: only BSDF samples
/// find light behind glass.
///
/// A wave traces many paths, each with its own sampler. The radiance of a camera ray is thus bit-identical in every wave. Keep one
/// instance per thread: all buffers are reused.
#[derive(Clone, Debug)]
pub struct PathTracer<S> {
    settings: PathSettings,
    features: ShadingFeatures,
    /// Media around the camera: one list for all paths, or one for each.
    surroundings: Vec<InteriorList>,
    paths: Vec<Path>,
    /// Samplers of the paths.
    samplers: Vec<S>,
    /// Rays of the current wave.
    ray_queues: RayQueues<u32>,
    next: RayQueues<u32>,
    shadows: ShadowRayQueue,
    /// Vertices that are shaded in lanes, one queue for each kind of surface.
    queues: [VertexQueue<S>; 3],
    /// Instruction set of lanes; `None` to shade all vertices one by one.
    lanes: Option<LaneLevel>,
    /// True if the emission of the next surface or the background may contribute.
    scene_emits: bool,
    counts: ShadingCounts,
}

/// Materials and lights for an integrator.
#[derive(Clone, Copy, Debug)]
pub struct Lighting<'a> {
    /// Materials, textures and the background.
    pub appearance: &'a Appearance,
    /// All lights.
    pub lights: &'a LightSet,
    /// BSDFs of uniform materials of this appearance, or `default()`.
    pub bsdfs: &'a BsdfCache,
}

impl<S: Sampler + Clone> PathTracer<S> {
    /// Integrator with these settings. It computes only these `features`.
    pub fn new(settings: PathSettings, features: ShadingFeatures) -> Self {
        Self {
            settings,
            features,
            surroundings: Vec::new(),
            paths: Vec::new(),
            samplers: Vec::new(),
            ray_queues: RayQueues::default(),
            next: RayQueues::default(),
            shadows: ShadowRayQueue::default(),
            queues: QueueKind::ALL.map(VertexQueue::new),
            lanes: LaneLevel::best(),
            scene_emits: false,
            counts: ShadingCounts::default(),
        }
    }

    /// Shades in SIMD lanes of this level, or with `None` one vertex at a time. The result is bit-identical.
    pub fn set_lanes(&mut self, level: Option<LaneLevel>) {
        self.lanes = level;
    }

    /// Sets the media around the camera: one list for all paths, or one for each path of the next wave. Without a list, all
    /// paths start in air.
    pub fn set_surroundings(&mut self, surroundings: &[InteriorList]) {
        surroundings.clone_into(&mut self.surroundings);
    }

    /// Work done since the counts were last taken.
    pub fn take_counts(&mut self) -> ShadingCounts {
        core::mem::take(&mut self.counts)
    }

    /// Estimates the radiance of camera rays: `seen[i]` is that of `rays[i]`, whose path uses `samplers[i]`. Entries beyond the
    /// shortest slice are unchanged. Non-finite scenes give non-finite radiance, which the caller handles.
    pub fn radiance_of(
        &mut self,
        world: &mut impl SceneQueries,
        lighting: Lighting<'_>,
        rays: &[(Ray, Interval)],
        samplers: &[S],
        seen: &mut [RadianceSample],
    ) {
        let count = rays.len().min(samplers.len()).min(seen.len());
        let seen = &mut seen[..count];
        seen.fill(RadianceSample::MISS);
        self.scene_emits = self.features.emission || !lighting.appearance.background.is_black();
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

    /// Traces rays of one kind; `path` maps the index of a ray to that of its path.
    fn trace(
        &mut self,
        world: &mut impl SceneQueries,
        lighting: Lighting<'_>,
        kind: RayKind,
        rays: &[(Ray, Interval)],
        path: impl Fn(usize) -> u32,
        seen: &mut [RadianceSample],
    ) {
        let needs = self.features.surface();
        if self.lanes.is_none() {
            return world.closest_batch(rays, kind, needs, |at, hit| {
                let (id, ray) = (path(at), &rays[at].0);
                let seen = &mut seen[id as usize];
                match hit {
                    Some(hit) => self.shade_hit(lighting, id, ray, hit, seen),
                    None => self.shade_miss(lighting, id, ray, seen),
                }
            });
        }
        world.closest_hits(rays, kind, (needs, LazyShapes::SpheresAndTriangles), |at, hit| {
            let (id, ray) = (path(at), &rays[at].0);
            let seen = &mut seen[id as usize];
            match hit {
                Some(ClosestHit::Triangle(hit)) => {
                    self.shade_lazily(lighting, id, ray, LazyShapeHit::Triangle(hit), seen);
                }
                Some(ClosestHit::Sphere(hit)) => self.shade_lazily(lighting, id, ray, LazyShapeHit::Sphere(hit), seen),
                Some(ClosestHit::Plane(hit)) => self.shade_hit(lighting, id, ray, &mut hit.surface(ray), seen),
                Some(ClosestHit::Surface(hit)) => self.shade_hit(lighting, id, ray, hit, seen),
                None => self.shade_miss(lighting, id, ray, seen),
            }
        });
        self.shade_queues(lighting, seen);
    }

    /// Traces the shadow rays of a wave, and starts the next wave.
    fn end_wave(&mut self, world: &mut impl SceneQueries, seen: &mut [RadianceSample]) {
        let (clamp, counts) = (self.settings.clamp, &mut self.counts);
        let bounded = |radiance| clamp.bounded(radiance, counts);
        self.shadows.resolve(|rays, blocked| world.occluded_batch(rays, blocked), bounded, seen);
        self.ray_queues.clear();
        core::mem::swap(&mut self.ray_queues, &mut self.next);
    }

    /// Starts a path for each sampler.
    fn start(&mut self, samplers: &[S]) {
        samplers.clone_into(&mut self.samplers);
        // Lists of bodies keep their memory from wave to wave.
        self.paths.truncate(samplers.len());
        self.paths.iter_mut().for_each(Path::reset);
        self.paths.resize_with(samplers.len(), Path::default);
        if self.features.refraction {
            for (path, surroundings) in self.paths.iter_mut().zip(self.surroundings.iter().cycle()) {
                path.medium_tracker.interior.clone_from(surroundings);
            }
        }
    }
}

#[cfg(test)]
mod tests;
