//! Whitted's integrator in stages that read and write structures of arrays.
//!
//! ```text
//!   rays ──> closest hits ──> shade in lanes ──> shadow rays ──> occluded? ──> samples
//!    ▲                              │
//!    └──── mirrored, refracted <────┘
//! ```
//!
//! Eight rays that follow each other in a stream are shaded together: all that hit the same primitive at once. So the numbers of the
//! shape and of its material are the same in all lanes, and no lane gathers its own.

mod shade;
mod streams;

use super::{ShadingCounts, lane_phong::LanePhong, wave::RayTree};
use crate::{
    Appearance, Background, InteriorList, LaneLevel, Material, RadianceSample, ShadingFeatures,
    lane_set::{Element, LaneSet, OneLane, SimdLanes},
    lanes::dispatch,
    stream_queries::StreamQueries,
    wavefront::{MAX_LIGHTS, delta_lights::is_usual_light, is_in_range, streams::ShadowRayStream},
};
use core::ops::RangeInclusive;
use fearless_simd::Simd as _;
use rt_geometry::{HitStream, RayKind, RayStream, STREAM_CAPACITY};
use rt_math::{Interval, Ray, Rgb};
use streams::TreeStream;

/// Largest exponent of a highlight: the power multiplies the rounding error of the cosine by it.
const MAX_EXPONENT: f64 = 1000.0;

/// Indices of refraction.
const IOR_RANGE: RangeInclusive<f64> = 1e-3..=1e3;

/// [`Whitted`](super::Whitted) for worlds of spheres, planes, polygons and flat triangles that do not move, with uniform or checkered
/// materials. It shades in `f32`; positions, hits and sums are `f64`.
///
/// Ray trees are traversed as there. The radiance of a camera ray is bit-identical in every wave, with every instruction set, and
/// with one lane. Keep one instance per thread: all buffers are reused.
#[derive(Clone, Debug)]
pub struct WavefrontWhitted {
    settings: Settings,
    /// Instruction set of lanes; `None` to shade hits one by one.
    lanes: Option<LaneLevel>,
    /// False as long as all rays are at time 0.
    has_time: bool,
    streams: Wavefront<f32>,
}

/// Settings, the same for all waves.
#[derive(Clone, Debug)]
struct Settings {
    max_depth: u32,
    min_contribution: f64,
    features: ShadingFeatures,
    /// Media around the camera: one list for all rays, or one for each; none for air.
    surroundings: Vec<InteriorList>,
    /// Phong models by material.
    phongs: Vec<Option<LanePhong>>,
}

/// Streams of a wave.
#[derive(Clone, Debug, Default)]
struct Wavefront<E: Element> {
    /// Rays of the current wave, by kind.
    reflected: TreeStream<E>,
    refracted: TreeStream<E>,
    hits: HitStream,
    spawned: Spawned<E>,
}

/// Rays that the hits of a wave spawn, and the state of samples.
#[derive(Clone, Debug, Default)]
struct Spawned<E: Element> {
    /// Rays of the next wave, by kind.
    reflected: TreeStream<E>,
    refracted: TreeStream<E>,
    /// Shadow rays by light.
    lights: Vec<ShadowRayStream<E>>,
    /// Ray trees of the samples; empty in scenes that defer no rays.
    trees: Vec<RayTree>,
    /// Samples whose path has ended in this wave, in scenes that defer rays.
    ended: Vec<u32>,
    counts: ShadingCounts,
}

impl WavefrontWhitted {
    /// Integrator of up to `max_depth` bounces after the first hit. Rays whose weight in the pixel is below `min_contribution` in all
    /// components are not traced. It computes only these `features`. All later calls must be with this appearance.
    pub fn new(max_depth: u32, min_contribution: f64, features: ShadingFeatures, appearance: &Appearance) -> Self {
        let phongs = LanePhong::of_all(appearance, &features);
        Self {
            settings: Settings { max_depth, min_contribution, features, surroundings: Vec::new(), phongs },
            lanes: LaneLevel::best(),
            has_time: false,
            streams: Wavefront::default(),
        }
    }

    /// Shades in SIMD lanes of this level, or with `None` one hit at a time. The result is bit-identical.
    pub const fn set_lanes(&mut self, level: Option<LaneLevel>) {
        self.lanes = level;
    }

    /// True if it supports the lights and all materials of an appearance. Phong models must be uniform or checkered. Highlights and cones
    /// of spots must not be too narrow for `f32`, and numbers must be in its usual range. Light with inverse-square falloff may still
    /// overflow at a distance of less than 10⁻¹³.
    pub fn supports(appearance: &Appearance) -> bool {
        let background = match appearance.background {
            Background::Constant(radiance) => radiance,
            _ => Rgb::BLACK,
        };
        let has_usual_media =
            |material: &Material| material.interior.is_none_or(|interior| IOR_RANGE.contains(&interior.ior));
        appearance.lights.len() <= MAX_LIGHTS
            && is_in_range(background)
            && appearance.lights.iter().all(is_usual_light)
            && appearance.materials.iter().all(has_usual_media)
            && LanePhong::of_all(appearance, &ShadingFeatures::ALL)
                .iter()
                .all(|phong| phong.as_ref().is_some_and(is_usual_phong))
    }

    /// Sets the media around the camera: one list for all rays, or one for each ray of the next call. Without a list, all rays start
    /// in air.
    pub fn set_surroundings(&mut self, surroundings: &[InteriorList]) {
        surroundings.clone_into(&mut self.settings.surroundings);
    }

    /// Work done since the counts were last taken.
    pub fn take_counts(&mut self) -> ShadingCounts {
        core::mem::take(&mut self.streams.spawned.counts)
    }

    /// Radiance of camera rays: `seen[i]` is that of `rays[i]`. Entries beyond the shorter slice are unchanged. Non-finite scenes
    /// give non-finite radiance, which the caller handles.
    pub fn radiance_of(
        &mut self,
        world: &mut impl StreamQueries,
        appearance: &Appearance,
        rays: &[(Ray, Interval)],
        seen: &mut [RadianceSample],
    ) {
        let mut stream = RayStream::default();
        let batches = rays.chunks(STREAM_CAPACITY).zip(seen.chunks_mut(STREAM_CAPACITY));
        for (number, (rays, seen)) in batches.enumerate() {
            stream.clear();
            rays.iter().take(seen.len()).for_each(|(ray, span)| stream.push(ray, *span));
            let count = stream.len();
            self.trace(world, appearance, (number * STREAM_CAPACITY, &mut stream, &mut seen[..count]));
        }
    }

    /// Version of [`radiance_of`](Self::radiance_of) for a stream, whose rays are lost. Does nothing unless `seen` has an entry for each
    /// ray.
    pub fn radiance_of_stream(
        &mut self,
        world: &mut impl StreamQueries,
        appearance: &Appearance,
        rays: &mut RayStream,
        seen: &mut [RadianceSample],
    ) {
        if seen.len() == rays.len() {
            self.trace(world, appearance, (0, rays, seen));
        }
    }

    fn trace(&mut self, world: &mut impl StreamQueries, appearance: &Appearance, batch: Batch<'_>) {
        self.has_time |= batch.1.has_time();
        let (settings, has_time) = (&self.settings, self.has_time);
        match self.lanes {
            Some(level) => dispatch!(level, simd => {
                let shade = &Shade { lanes: SimdLanes(simd), settings, appearance, has_time };
                self.streams.trace(shade, world, batch, |world, wave, spawned, seen| simd.vectorize(
                    #[inline(always)]
                    || spawned.shade(shade, world, wave, seen),
                ));
            }),
            None => {
                let shade = &Shade { lanes: OneLane::new(), settings, appearance, has_time };
                self.streams.trace(shade, world, batch, |world, wave, spawned, seen| {
                    spawned.shade(shade, world, wave, seen);
                });
            }
        }
    }
}

/// True for colours in range, and highlights that are wide enough for cosines in `f32`.
fn is_usual_phong(phong: &LanePhong) -> bool {
    phong.colors().all(is_in_range) && phong.exponent() <= MAX_EXPONENT
}

/// Number of the first ray in the call, camera rays, and their radiance.
type Batch<'a> = (usize, &'a mut RayStream, &'a mut [RadianceSample]);

/// Inputs of all shading stages of a batch.
struct Shade<'a, L> {
    lanes: L,
    settings: &'a Settings,
    appearance: &'a Appearance,
    /// False if all rays are at time 0.
    has_time: bool,
}

/// Rays of a wave with their closest hits.
type Wave<'a, E> = (&'a TreeStream<E>, &'a HitStream);

impl<E: Element> Wavefront<E> {
    /// Traces the ray trees of camera rays. `shade_stage` calls [`Spawned::shade`], compiled for the lanes.
    fn trace<W: StreamQueries, L: LaneSet<Element = E>>(
        &mut self,
        shade: &Shade<'_, L>,
        world: &mut W,
        (first, rays, seen): Batch<'_>,
        shade_stage: impl Fn(&W, Wave<'_, E>, &mut Spawned<E>, &mut [RadianceSample]),
    ) {
        seen.fill(RadianceSample::MISS);
        self.spawned.start(shade.settings, shade.appearance.lights.len(), (first, rays.len()));
        self.refracted.clear();
        self.reflected.start(rays);
        let mut first_kind = RayKind::Primary;
        while !self.reflected.is_empty() || !self.refracted.is_empty() {
            let Self { reflected, refracted, hits, spawned } = self;
            for (paths, kind) in [(&*reflected, first_kind), (&*refracted, RayKind::Refraction)] {
                if !paths.is_empty() {
                    world.closest_stream(&paths.rays, kind, hits);
                    shade_stage(world, (paths, hits), spawned, seen);
                }
            }
            first_kind = RayKind::Reflection;
            for light in &mut spawned.lights {
                light.resolve(|rays, blocked| world.occluded_stream(rays, blocked), |radiance| radiance, seen);
            }
            self.next_wave();
        }
    }

    /// Starts the next wave, with deferred rays of samples whose path has ended.
    fn next_wave(&mut self) {
        let Self { reflected, refracted, spawned, .. } = self;
        spawned.pop_deferred();
        for (wave, next) in [(reflected, &mut spawned.reflected), (refracted, &mut spawned.refracted)] {
            wave.clear();
            core::mem::swap(wave, next);
        }
    }
}

impl<E: Element> Spawned<E> {
    /// Makes space for lights and samples.
    fn start(&mut self, settings: &Settings, n_lights: usize, (first, n_samples): (usize, usize)) {
        if self.lights.len() < n_lights {
            self.lights.resize_with(n_lights, ShadowRayStream::default);
        }
        if settings.features.refraction {
            if self.trees.len() < n_samples {
                self.trees.resize_with(n_samples, RayTree::default);
            }
            let air = InteriorList::default();
            let surroundings = settings.surroundings.get(if settings.surroundings.len() > 1 { first.. } else { 0.. });
            let mut surroundings = surroundings.unwrap_or_default().iter().cycle();
            for tree in &mut self.trees[..n_samples] {
                tree.restart(surroundings.next().unwrap_or(&air));
            }
        }
    }

    /// Continues samples whose path has ended with their last deferred ray.
    fn pop_deferred(&mut self) {
        for sample in self.ended.drain(..) {
            if let Some((ray, path)) = self.trees[sample as usize].pop() {
                self.refracted.push(&ray, Interval::SPAWNED, &path);
            }
        }
    }
}

#[cfg(test)]
mod tests;
