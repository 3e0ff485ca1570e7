//! Path tracing in stages that read and write structures of arrays.
//!
//! ```text
//!   rays ──> closest hits ──> draw samples ──> shade in lanes ──> shadow rays ──> occluded? ──> samples
//!    ▲                                              │
//!    └────────────────── next rays <────────────────┘
//! ```
//!
//! All paths of a wave have had the same number of bounces. Each lane gathers the numbers of its shape: after the first surface, rays that
//! follow each other hit different primitives. Paths that have ended leave no gaps in the stream.

mod diffuse_material;
mod gathered;
mod shade;
mod wave_samples;

use super::{Lighting, PathSettings};
use crate::{
    Appearance, Background, LaneLevel, RadianceSample, ShadingCounts, ShadingFeatures, StreamQueries,
    lane_set::{Element, LaneSet, OneLane, SimdLanes},
    lanes::dispatch,
    light::LightSet,
    wavefront::{MAX_LIGHTS, delta_lights::is_usual_light, is_in_range, streams::ShadowRayStream},
};
use diffuse_material::DiffuseMaterial;
use fearless_simd::Simd as _;
use gathered::{Gathered, gather};
use rt_geometry::{HitStream, RayKind, RayStream, StreamArray};
use rt_math::{Rgb, Sampler};
use wave_samples::WaveSamples;

/// [`PathTracer`](super::PathTracer) for worlds of spheres, planes, polygons and triangles that do not move, with uniform diffuse
/// materials. It computes all light transport but [`Transport::Specular`](super::Transport), and shades in `f32`; positions, hits,
/// densities of lights and sums are `f64`.
///
/// Paths use the same samples as there. The radiance of a camera ray is bit-identical in every wave, with every instruction set, and
/// with one lane. Keep one instance per thread: all buffers are reused.
#[derive(Clone, Debug)]
pub struct WavefrontPathTracer<S> {
    settings: PathSettings,
    features: ShadingFeatures,
    /// Instruction set of lanes; `None` to shade hits one by one.
    lanes: Option<LaneLevel>,
    materials: Vec<Option<DiffuseMaterial>>,
    streams: PathStreams<S, f32>,
}

/// Streams of a wave, and the samplers of its paths.
#[derive(Clone, Debug)]
struct PathStreams<S, E: Element> {
    samplers: Vec<S>,
    samples: WaveSamples,
    paths: PathStream<E>,
    hits: HitStream,
    spawned: SpawnedPaths<E>,
}

/// Rays that the hits of a wave spawn.
#[derive(Clone, Debug, Default)]
struct SpawnedPaths<E: Element> {
    paths: PathStream<E>,
    /// Shadow rays to each delta light, and to the sampled light.
    delta: Vec<ShadowRayStream<E>>,
    sampled: ShadowRayStream<E>,
    /// Surfaces of the hits that are shaded.
    gathered: Gathered,
    counts: ShadingCounts,
}

/// Rays of paths, one array for each number.
#[derive(Clone, Debug, Default)]
struct PathStream<E: Element> {
    rays: RayStream,
    /// Index of the camera ray.
    sample: StreamArray<u32>,
    /// Throughput (β): weight of radiance in the pixel.
    throughput: [StreamArray<E>; 3],
    /// Density of the direction over solid angle.
    pdf: StreamArray<E>,
    /// Unit normal at the origin, on the side of the ray.
    normal: [StreamArray<E>; 3],
}

impl<S: Sampler + Clone> WavefrontPathTracer<S> {
    /// Integrator with these settings. It computes only these `features`. All later calls must be with this appearance. Under
    /// [`Transport::Specular`](super::Transport) it computes full transport.
    pub fn new(settings: PathSettings, features: ShadingFeatures, appearance: &Appearance) -> Self {
        Self {
            settings,
            features,
            lanes: LaneLevel::best(),
            materials: appearance.materials.iter().map(DiffuseMaterial::of).collect(),
            streams: PathStreams::new(),
        }
    }

    /// Shades in SIMD lanes of this level, or with `None` one hit at a time. The result is bit-identical.
    pub const fn set_lanes(&mut self, level: Option<LaneLevel>) {
        self.lanes = level;
    }

    /// True if it supports the lights and surfaces of these materials. Materials must be uniform and diffuse. Numbers must be in the
    /// usual range of `f32`.
    pub fn supports(appearance: &Appearance, lights: &LightSet, materials: impl IntoIterator<Item = u32>) -> bool {
        let is_usual = |material: DiffuseMaterial| {
            let DiffuseMaterial { albedo, emission: [front, back] } = material;
            [albedo, front, back].into_iter().all(is_in_range)
        };
        let is_usual_background = match &appearance.background {
            Background::Constant(radiance) => is_in_range(*radiance),
            Background::Gradient { bottom, top } => is_in_range(*bottom) && is_in_range(*top),
            Background::Environment(_) => true,
        };
        let is_supported = |index: u32| {
            let material = appearance.materials.get(index as usize);
            material.and_then(DiffuseMaterial::of).is_some_and(is_usual)
        };
        is_usual_background
            && lights.delta_lights().count() <= MAX_LIGHTS
            && lights.delta_lights().all(is_usual_light)
            && materials.into_iter().all(is_supported)
    }

    /// Work done since the counts were last taken.
    pub fn take_counts(&mut self) -> ShadingCounts {
        core::mem::take(&mut self.streams.spawned.counts)
    }

    /// Estimates the radiance of camera rays: `seen[i]` is that of ray `i`, whose path uses `samplers[i]`. The rays are lost. Does nothing
    /// unless `samplers` and `seen` have an entry for each ray.
    pub fn radiance_of_stream(
        &mut self,
        world: &mut impl StreamQueries,
        lighting: Lighting<'_>,
        rays: &mut RayStream,
        samplers: &[S],
        seen: &mut [RadianceSample],
    ) {
        if seen.len() != rays.len() || samplers.len() != rays.len() {
            return;
        }
        let (settings, features, materials) = (&self.settings, &self.features, &self.materials[..]);
        let batch = (rays, samplers, seen);
        match self.lanes {
            Some(level) => dispatch!(level, simd => {
                let shade = &PathShading { lanes: SimdLanes(simd), settings, features, lighting, materials };
                self.streams.trace(shade, world, batch, |gather, wave, spawned, seen| simd.vectorize(
                    #[inline(always)]
                    || spawned.shade(shade, gather, wave, seen),
                ));
            }),
            None => {
                let shade = &PathShading { lanes: OneLane::new(), settings, features, lighting, materials };
                self.streams.trace(shade, world, batch, |gather, wave, spawned, seen| {
                    spawned.shade(shade, gather, wave, seen);
                });
            }
        }
    }
}

/// Camera rays, their samplers, and their radiance.
type PathBatch<'a, S> = (&'a mut RayStream, &'a [S], &'a mut [RadianceSample]);

/// Inputs of all shading stages of a batch.
struct PathShading<'a, L> {
    lanes: L,
    settings: &'a PathSettings,
    features: &'a ShadingFeatures,
    lighting: Lighting<'a>,
    materials: &'a [Option<DiffuseMaterial>],
}

/// Rays of a wave with their closest hits and samples.
#[derive(Clone, Copy)]
struct PathWave<'a, E: Element> {
    paths: &'a PathStream<E>,
    hits: &'a HitStream,
    samples: &'a WaveSamples,
    /// Number of surfaces that have scattered the paths.
    bounces: u32,
    plays_roulette: bool,
    /// True if paths end after the emission of their next surface.
    emission_only: bool,
}

impl<S: Sampler + Clone, E: Element> PathStreams<S, E> {
    fn new() -> Self {
        Self {
            samplers: Vec::new(),
            samples: WaveSamples::default(),
            paths: PathStream::default(),
            hits: HitStream::default(),
            spawned: SpawnedPaths::default(),
        }
    }

    /// Traces the paths of camera rays. `shade_stage` calls [`SpawnedPaths::shade`], compiled for the lanes.
    fn trace<W: StreamQueries, L: LaneSet<Element = E>>(
        &mut self,
        shade: &PathShading<'_, L>,
        world: &mut W,
        (rays, samplers, seen): PathBatch<'_, S>,
        shade_stage: impl Fn(&GatherHits<'_>, &PathWave<'_, E>, &mut SpawnedPaths<E>, &mut [RadianceSample]),
    ) {
        let &PathShading { settings: PathSettings { max_depth, rr_start_depth, clamp, .. }, lighting, .. } = shade;
        seen.fill(RadianceSample::MISS);
        samplers.clone_into(&mut self.samplers);
        let n_lights = lighting.lights.sampled_lights().len();
        let n_delta = lighting.lights.delta_lights().count();
        if self.spawned.delta.len() < n_delta {
            self.spawned.delta.resize_with(n_delta, ShadowRayStream::default);
        }
        self.paths.start(rays);
        let mut kind = RayKind::Primary;
        let mut bounces = 0;
        while !self.paths.rays.is_empty() {
            let Self { samplers, samples, paths, hits, spawned } = self;
            world.closest_stream(&paths.rays, kind, hits);
            let emission_only = bounces > *max_depth;
            let plays_roulette = bounces >= *rr_start_depth;
            if !emission_only {
                samples.draw(samplers, (paths.sample.as_slice(), hits, paths.rays.len()), n_lights, plays_roulette);
            }
            let wave = PathWave { paths, hits, samples, bounces, plays_roulette, emission_only };
            let world_of_hits = &*world;
            let gather_hits = |at: usize, mask: u8, gathered: &mut Gathered| {
                gather(world_of_hits, shade.materials, (wave.hits, at), mask, gathered);
            };
            shade_stage(&gather_hits, &wave, spawned, seen);
            for light in spawned.delta.iter_mut().take(n_delta).chain([&mut spawned.sampled]) {
                let counts = &mut spawned.counts;
                let bounded = |radiance| clamp.apply(bounces + 1, radiance, counts);
                light.resolve(|rays, blocked| world.occluded_stream(rays, blocked), bounded, seen);
            }
            paths.rays.clear();
            core::mem::swap(paths, &mut spawned.paths);
            kind = RayKind::Diffuse;
            bounces += 1;
        }
    }
}

/// Gathers the surfaces of the hits of some lanes, from an index on.
type GatherHits<'a> = dyn Fn(usize, u8, &mut Gathered) + 'a;

impl<E: Element> PathStream<E> {
    /// Replaces the rays by camera rays, each of its own sample. `rays` is an unspecified stream afterwards.
    fn start(&mut self, rays: &mut RayStream) {
        core::mem::swap(&mut self.rays, rays);
        for (sample, number) in self.sample.as_mut_slice().iter_mut().zip(0..) {
            *sample = number;
        }
        for throughput in &mut self.throughput {
            throughput.as_mut_slice().fill(E::rounded(1.0));
        }
    }

    /// Throughput of a path.
    fn throughput(&self, at: usize) -> Rgb {
        let [r, g, b] = &self.throughput;
        Rgb::new(r.get(at).into(), g.get(at).into(), b.get(at).into())
    }
}

#[cfg(test)]
mod tests;
