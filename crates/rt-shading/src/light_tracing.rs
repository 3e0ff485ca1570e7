//! Light tracing in waves: caustics by paths from the lights.

mod projection_map;
mod scatter;
mod sources;
mod wave;

pub use projection_map::{ProjectionMap, TargetSphere};
pub use sources::LightSources;

use crate::{
    Lighting, SceneQueries, ShadingCounts, ShadingFeatures,
    path::PathSettings,
    ray_queues::{RayQueue, RayQueues},
};
use rt_math::{DVec2, DVec3, Interval, Rgb, Sampler};
use wave::{Connection, LightPath};

/// Projection of a point to a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraWiSample {
    /// Origin of the camera ray to the point, world space.
    pub origin: DVec3,
    /// Position on the image, in raster coordinates.
    pub raster: DVec2,
    /// Pixels that a unit of area covers at the point, if it faces the camera.
    pub importance: f64,
}

/// Scene data of light tracing.
#[derive(Clone, Copy, Debug)]
pub struct LightTracingScene<'a> {
    /// Materials and lights.
    pub lighting: Lighting<'a>,
    /// Lights that start paths, and their targets.
    pub sources: &'a LightSources,
}

/// Light tracing for caustics: paths from lights reach the camera via specular surfaces (Arvo 1986; Dutré, Lafortune, Willems
/// 1993; Veach 1997, 10.1).
///
/// ```text
///                    light □                        path tracing finds   E … D S L   by chance, if the light is large,
///                           ╲                       and never, if it is a point
///   camera ◁─ ─ ─ ─ ─ ─      ╲ mirror or glass
///                      ╲     ╱                      light tracing connects each non-specular vertex to
///                       ● ──●                       the camera
///                        ╲    ╲
///                         ●    …
/// ```
///
/// **Paths.** The light is a sampled or delta light, the first surface specular (S), and the surface that the camera sees
/// not (D):
///
/// ```text
///   L S (S | D)* D E
/// ```
///
/// [`Transport::NonCaustic`](crate::Transport::NonCaustic) omits exactly these paths: the sum of the two is all light. Camera paths
/// find the light of environments and of emissive surfaces that are not sampled. They also find all light that reaches the camera
/// by specular surfaces. Only light tracing finds caustics of delta lights.
///
/// A contribution is the power of the path over the number of paths, times f and the camera's importance. The arguments of f are
/// swapped against radiance. Interpolated normals need the correction (Veach 1997, 5.3.2)
///
/// ```text
///   |ω·Nₛ| |ω'·N| / (|ω·N| |ω'·Nₛ|)          ω towards the light, ω' the next direction; N the geometric normal
/// ```
///
/// Keep one instance per thread: all buffers are reused.
#[derive(Clone, Debug)]
pub struct LightTracingIntegrator<S> {
    settings: PathSettings,
    features: ShadingFeatures,
    paths: Vec<LightPath<S>>,
    connections: Vec<Connection>,
    /// Rays of the current wave.
    ray_queues: RayQueues<u32>,
    next: RayQueues<u32>,
    /// Rays from surfaces to the camera.
    to_camera: RayQueue<u32>,
    counts: ShadingCounts,
}

impl<S: Sampler> LightTracingIntegrator<S> {
    /// Integrator with these settings. It computes only these `features`.
    pub fn new(settings: PathSettings, features: ShadingFeatures) -> Self {
        Self {
            settings,
            features,
            paths: Vec::new(),
            connections: Vec::new(),
            ray_queues: RayQueues::default(),
            next: RayQueues::default(),
            to_camera: RayQueue::default(),
            counts: ShadingCounts::default(),
        }
    }

    /// Work done since the counts were last taken.
    pub fn take_counts(&mut self) -> ShadingCounts {
        core::mem::take(&mut self.counts)
    }

    /// Traces a path for each sampler, at its time.
    ///
    /// `sample_wi` projects a point of the world to the camera at a time; it may sample a point of the lens. `splat` receives
    /// contributions by raster position. Their filtered sum over the number of paths is the radiance of a pixel. Non-finite scenes
    /// give non-finite contributions, which the caller handles.
    pub fn trace(
        &mut self,
        world: &mut impl SceneQueries,
        scene: LightTracingScene<'_>,
        samplers: impl IntoIterator<Item = (S, f64)>,
        sample_wi: impl Fn(DVec3, f64, &mut S) -> Option<CameraWiSample>,
        mut splat: impl FnMut(DVec2, Rgb),
    ) {
        self.paths.clear();
        for (sampler, time) in samplers {
            self.sample_le(world, scene, sampler, time);
        }
        while !self.ray_queues.is_empty() {
            let ray_queues = core::mem::take(&mut self.ray_queues);
            for (kind, queue) in ray_queues.queues() {
                world.closest_batch(&queue.rays, kind, self.features.surface(), |at, hit| {
                    if let Some(hit) = hit {
                        self.shade_hit(scene.lighting, queue.paths[at], &queue.rays[at].0, hit, &sample_wi);
                    }
                });
            }
            self.ray_queues = ray_queues;
            self.ray_queues.clear();
            core::mem::swap(&mut self.ray_queues, &mut self.next);
            self.resolve_connections(world, scene.lighting, &mut splat);
        }
    }

    /// Traces the rays to the camera, through null interfaces.
    fn resolve_connections(
        &mut self,
        world: &mut impl SceneQueries,
        lighting: Lighting<'_>,
        splat: &mut impl FnMut(DVec2, Rgb),
    ) {
        let mut queue = core::mem::take(&mut self.to_camera);
        while !queue.rays.is_empty() {
            let next = &mut self.to_camera;
            let (connections, counts, features) = (&mut self.connections, &mut self.counts, &self.features);
            world.closest_batch(&queue.rays, rt_geometry::RayKind::Shadow, self.features.surface(), |at, hit| {
                let (id, ray) = (queue.paths[at], &queue.rays[at].0);
                let connection = &mut connections[id as usize];
                match hit {
                    None => splat(connection.raster, connection.arriving(lighting, features, ray)),
                    Some(hit) => {
                        if let Some(min) = connection.skip_interface(lighting, features, ray, hit, counts) {
                            next.push(*ray, Interval { min, ..Interval::SEGMENT }, id);
                        }
                    }
                }
            });
            queue.clear();
            core::mem::swap(&mut queue, &mut self.to_camera);
        }
        self.to_camera = queue;
        self.connections.clear();
    }
}
