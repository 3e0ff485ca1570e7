//! Light transport along paths from the lights, by random choice, in waves.

mod scatter;
mod sources;
mod targets;
mod wave;

pub use sources::LightSources;
pub use targets::{Ball, Targets};

use crate::{
    Lighting, Needs, ShadingCounts, Tracer,
    path::PathSettings,
    ray_queues::{RayQueue, RayQueues},
};
use rt_math::{DVec2, DVec3, Interval, Rgb, Sampler};
use wave::{Connection, LightPath};

/// How a camera sees a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraWiSample {
    /// Where the camera ray that leads to the point starts, world space.
    pub origin: DVec3,
    /// Where the point appears, in raster coordinates.
    pub raster: DVec2,
    /// Pixels that a unit of area covers at the point, if it faces the camera.
    pub importance: f64,
}

/// What light paths do not know of the scene themselves.
#[derive(Clone, Copy, Debug)]
pub struct LightTracingScene<'a> {
    /// Materials and lights.
    pub lighting: Lighting<'a>,
    /// Which of the lights are followed, and where to.
    pub sources: &'a LightSources,
}

/// Light tracing: paths from the lights that come to the camera by way of a mirror or glass (Arvo 1986; Dutré, Lafortune,
/// Willems 1993; Veach 1997, 10.1).
///
/// ```text
///                    light □                        path tracing finds   E … D S L   by chance, if the light is large,
///                           ╲                       and never, if it is a point
///   camera ◁─ ─ ─ ─ ─ ─      ╲ mirror or glass
///                      ╲     ╱                      light tracing sends the light where it goes, and asks at each surface
///                       ● ──●                       that spreads light whether the camera sees it
///                        ╲    ╲
///                         ●    …
/// ```
///
/// **What it finds, and nothing else.** A path is followed here if it leaves a light that can be drawn from, is scattered by
/// its first surface into a single direction (S), and is spread by the surface that the camera sees (D):
///
/// ```text
///   L S (S | D)* D E
/// ```
///
/// [`Follows::AllButCaustics`](crate::Follows::AllButCaustics) leaves out exactly these, so that the sum of the two is all
/// light. What comes from the environment or from lamps that cannot be drawn from stays with the paths from the camera, and
/// so does what the camera sees in a mirror or through glass. Light without extent is found here for the first time.
///
/// The power of a path over the number of paths counts, times f and the solid angle of the camera; f is that of radiance with the
/// arguments swapped, and interpolated normals are corrected for as Veach says (1997, 5.3.2):
///
/// ```text
///   |ω·Nₛ| |ω'·N| / (|ω·N| |ω'·Nₛ|)          ω towards the light, ω' where light goes on; N the actual normal
/// ```
///
/// Keep one instance per thread: all buffers are reused.
#[derive(Clone, Debug)]
pub struct LightTracingIntegrator<S> {
    settings: PathSettings,
    needs: Needs,
    paths: Vec<LightPath<S>>,
    connections: Vec<Connection>,
    /// What is traced now, while the flow after it grows.
    ray_queues: RayQueues<u32>,
    next: RayQueues<u32>,
    /// Rays from surfaces to the camera.
    to_camera: RayQueue<u32>,
    counts: ShadingCounts,
}

impl<S: Sampler> LightTracingIntegrator<S> {
    /// Follows paths as far as the settings say, and computes only what `needs` names.
    pub fn new(settings: PathSettings, needs: Needs) -> Self {
        Self {
            settings,
            needs,
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

    /// Follows a path for each sampler, at the moment that goes with it. `sample_wi` says how the camera sees a point of the world at
    /// a moment, and may draw a point of its lens. `splat` gets what arrives at a place of the image: the mean over all paths of the sum of it
    /// times the filter is a pixel's radiance. Infinite or NaN if the scene is; the caller decides about such light.
    pub fn trace(
        &mut self,
        world: &mut impl Tracer,
        scene: LightTracingScene<'_>,
        samplers: impl IntoIterator<Item = (S, f64)>,
        sight: impl Fn(DVec3, f64, &mut S) -> Option<CameraWiSample>,
        mut splat: impl FnMut(DVec2, Rgb),
    ) {
        self.paths.clear();
        for (sampler, time) in samplers {
            self.sample_le(world, scene, sampler, time);
        }
        while !self.ray_queues.is_empty() {
            let ray_queues = core::mem::take(&mut self.ray_queues);
            for (kind, queue) in ray_queues.queues() {
                world.closest_batch(&queue.rays, kind, self.needs.surface(), |at, hit| {
                    if let Some(hit) = hit {
                        self.shade_hit(scene.lighting, queue.paths[at], &queue.rays[at].0, hit, &sight);
                    }
                });
            }
            self.ray_queues = ray_queues;
            self.ray_queues.clear();
            core::mem::swap(&mut self.ray_queues, &mut self.next);
            self.resolve_connections(world, scene.lighting, &mut splat);
        }
    }

    /// Traces the rays to the camera, through whatever does nothing to them.
    fn resolve_connections(
        &mut self,
        world: &mut impl Tracer,
        lighting: Lighting<'_>,
        splat: &mut impl FnMut(DVec2, Rgb),
    ) {
        let mut queue = core::mem::take(&mut self.to_camera);
        while !queue.rays.is_empty() {
            let next = &mut self.to_camera;
            let (connections, counts, needs) = (&mut self.connections, &mut self.counts, &self.needs);
            world.closest_batch(&queue.rays, rt_geometry::RayKind::Shadow, self.needs.surface(), |at, hit| {
                let (id, ray) = (queue.paths[at], &queue.rays[at].0);
                let connection = &mut connections[id as usize];
                match hit {
                    None => splat(connection.raster, connection.arriving(lighting, needs, ray)),
                    Some(hit) => {
                        if let Some(min) = connection.skip_interface(lighting, needs, ray, hit, counts) {
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
