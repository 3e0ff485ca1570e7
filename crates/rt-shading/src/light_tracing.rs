//! Light tracing in waves: caustics by paths from the lights.

mod light_rays;
mod projection_map;
mod scatter;
mod sources;
mod wave;

pub use projection_map::{ProjectionMap, TargetSphere};
pub use sources::LightSources;

use crate::{Lighting, SceneQueries, ShadingCounts, ShadingFeatures, StreamQueries, path::PathSettings};
use light_rays::{LightRayStream, LightRays};
use rt_geometry::{HitStream, RayKind, STREAM_CAPACITY};
use rt_math::{CameraWiSample, DVec2, DVec3, Interval, Rgb, Sampler};
use wave::LightPaths;

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
    /// Rays of the current wave.
    rays: LightRays,
    to_camera: LightRayStream,
    hits: HitStream,
    paths: LightPaths<S>,
}

impl<S: Sampler> LightTracingIntegrator<S> {
    /// Integrator with these settings. It computes only these `features`.
    pub fn new(settings: PathSettings, features: ShadingFeatures) -> Self {
        Self {
            rays: LightRays::default(),
            to_camera: LightRayStream::default(),
            hits: HitStream::default(),
            paths: LightPaths::new(settings, features),
        }
    }

    /// Work done since the counts were last taken.
    pub fn take_counts(&mut self) -> ShadingCounts {
        core::mem::take(&mut self.paths.counts)
    }

    /// Traces a path for each sampler, at its time.
    ///
    /// `sample_wi` projects a point of the world to the camera at a time; it may sample a point of the lens. `splat` receives
    /// contributions by raster position. Their filtered sum over the number of paths is the radiance of a pixel. Non-finite scenes
    /// give non-finite contributions, which the caller handles.
    pub fn trace(
        &mut self,
        world: &mut (impl SceneQueries + StreamQueries),
        scene: LightTracingScene<'_>,
        samplers: impl IntoIterator<Item = (S, f64)>,
        sample_wi: impl Fn(DVec3, f64, &mut S) -> Option<CameraWiSample>,
        mut splat: impl FnMut(DVec2, Rgb),
    ) {
        let mut samplers = samplers.into_iter().peekable();
        while samplers.peek().is_some() {
            self.paths.clear();
            for (sampler, time) in samplers.by_ref().take(STREAM_CAPACITY) {
                self.paths.sample_le(world, scene, sampler, time);
            }
            while !self.paths.next.is_empty() {
                self.shade_hits(world, scene.lighting, &sample_wi);
                self.resolve_connections(world, scene.lighting, &mut splat);
            }
        }
    }

    /// Traces the next rays of all paths, and shades their hits.
    fn shade_hits(
        &mut self,
        world: &mut impl StreamQueries,
        lighting: Lighting<'_>,
        sample_wi: &impl Fn(DVec3, f64, &mut S) -> Option<CameraWiSample>,
    ) {
        let Self { rays, hits, paths, .. } = self;
        rays.clear();
        core::mem::swap(rays, &mut paths.next);
        for (kind, stream) in rays.by_kind() {
            if stream.rays.is_empty() {
                continue;
            }
            world.closest_stream(&stream.rays, kind, hits);
            for at in 0..stream.rays.len() {
                let (ray, _) = stream.rays.get(at);
                if let Some(mut hit) = world.surface(&ray, hits, at, paths.features.surface()) {
                    paths.shade_hit(lighting, stream.ids.get(at), &ray, &mut hit, sample_wi);
                }
            }
        }
    }

    /// Traces the rays to the camera, through null interfaces.
    fn resolve_connections(
        &mut self,
        world: &mut impl StreamQueries,
        lighting: Lighting<'_>,
        splat: &mut impl FnMut(DVec2, Rgb),
    ) {
        let Self { to_camera, hits, paths: LightPaths { connections, to_camera: next, counts, features, .. }, .. } =
            self;
        while !next.rays.is_empty() {
            to_camera.rays.clear();
            core::mem::swap(to_camera, next);
            world.closest_stream(&to_camera.rays, RayKind::Shadow, hits);
            for at in 0..to_camera.rays.len() {
                let (id, (ray, _)) = (to_camera.ids.get(at), to_camera.rays.get(at));
                let connection = &mut connections[id as usize];
                match world.surface(&ray, hits, at, features.surface()) {
                    None => splat(connection.raster, connection.arriving(lighting, features, &ray)),
                    Some(hit) => {
                        if let Some(min) = connection.skip_interface(lighting, features, &ray, &hit, counts) {
                            next.push(&ray, Interval { min, ..Interval::SEGMENT }, id);
                        }
                    }
                }
            }
        }
        connections.clear();
    }
}
