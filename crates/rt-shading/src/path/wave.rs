//! Waves of paths: all have had the same number of bounces.

use super::{
    gathered::{Gathered, HitGroups, gather},
    inputs::PathInputs,
    lane_material::{LaneMaterial, VertexKind},
    path_stream::{LightBehind, PathStream, PathStreamsByKind, WavePathState},
    ray_samples::RaySamples,
};
use crate::{
    InteriorList, LaneLevel, RadianceSample, ShadingCounts, StreamPrimitive, StreamQueries,
    bsdf::LaneSurface,
    lane_set::Element,
    mis::power_heuristic,
    wavefront::streams::{DeltaStreams, ShadowRayStream},
};
use rt_geometry::{HitStream, RayKind, RayStream};
use rt_math::{Rgb, Samplers};

/// Camera rays, their samplers, the media around the camera, and the radiance of the rays.
pub(super) struct PathBatch<'a> {
    pub(super) rays: &'a mut RayStream,
    pub(super) samplers: &'a mut dyn Samplers,
    /// One list for all rays, or one for each; none for air.
    pub(super) camera_media: &'a [InteriorList],
    pub(super) radiances: &'a mut [RadianceSample],
}

/// Streams of a wave.
#[derive(Clone, Debug, Default)]
pub(super) struct PathStreams<E: Element> {
    samples: RaySamples,
    paths: PathStreamsByKind<E>,
    /// Paths that have passed null interfaces in this wave.
    null_interface_paths: PathStream<E>,
    hits: HitStream,
    groups: HitGroups,
    /// Paths and hits that are shaded in lanes, without gaps.
    dense: (PathStream<E>, HitStream),
    pub(super) spawned: SpawnedPaths<E>,
}

/// Rays that the hits of a wave spawn, and the state of its paths.
#[derive(Clone, Debug, Default)]
pub(super) struct SpawnedPaths<E: Element> {
    pub(super) paths: PathStreamsByKind<E>,
    /// Rays that continue behind null interfaces, in the same wave.
    pub(super) null_interface_paths: PathStream<E>,
    /// Shadow rays to each delta light, and to the sampled light.
    pub(super) delta: DeltaStreams<E>,
    pub(super) sampled: ShadowRayStream<E>,
    pub(super) states: Vec<WavePathState>,
    /// Surfaces of the hits that are shaded in lanes.
    pub(super) gathered: Gathered<E>,
    /// Directions to lights behind objects that cast no shadow.
    pub(super) behind: Vec<LightBehind>,
    pub(super) counts: ShadingCounts,
}

/// Rays of a wave with their closest hits.
#[derive(Clone, Copy)]
pub(super) struct PathWave<'a, E: Element> {
    pub(super) paths: &'a PathStream<E>,
    pub(super) hits: &'a HitStream,
    /// Number of surfaces that have scattered the paths.
    pub(super) bounces: u32,
}

/// Stage that shades those closest hits of a wave that are shaded in lanes.
pub(super) struct ShadeHits<'a, E: Element> {
    pub(super) spawned: &'a mut SpawnedPaths<E>,
    pub(super) inputs: &'a PathInputs<'a>,
    pub(super) gather: &'a GatherHits<'a, E>,
    pub(super) wave: &'a PathWave<'a, E>,
    pub(super) samples: &'a RaySamples,
    pub(super) radiances: &'a mut [RadianceSample],
}

/// Gathers the surfaces of the hits of some lanes, from an index on.
pub(super) type GatherHits<'a, E> = dyn Fn(usize, u8, &mut Gathered<E>) + 'a;

impl<E: Element> PathStreams<E> {
    /// Traces the paths of camera rays, and shades them at a level.
    pub(super) fn trace(
        &mut self,
        inputs: &PathInputs<'_>,
        level: Option<LaneLevel>,
        world: &mut dyn StreamQueries,
        batch: PathBatch<'_>,
    ) {
        let PathBatch { rays, samplers, camera_media, radiances } = batch;
        radiances.fill(RadianceSample::MISS);
        let n_delta = inputs.lighting.lights.delta_lights().count();
        self.spawned.start(inputs, n_delta, (rays.len(), camera_media));
        self.paths.clear();
        self.paths.diffuse.start(rays);
        let mut diffuse_kind = RayKind::Primary;
        let mut bounces = 0;
        while !self.paths.is_empty() {
            let Self { samples, paths, null_interface_paths, hits, groups, dense, spawned } = self;
            let mut shade = |kind: RayKind, paths: &PathStream<E>, spawned: &mut SpawnedPaths<E>| {
                if paths.rays.is_empty() {
                    return;
                }
                world.closest_stream(&paths.rays, kind, hits);
                let mut wave = &PathWave { paths, hits, bounces };
                spawned.group(inputs, &*world, wave, (groups, samplers), radiances);
                spawned.add_lights_behind(inputs, &mut *world, bounces, radiances);
                let compacted;
                if groups.is_sparse() {
                    groups.compact((wave.paths, wave.hits), dense);
                    compacted = PathWave { paths: &dense.0, hits: &dense.1, bounces };
                    wave = &compacted;
                }
                samples.draw(inputs, samplers, (wave.paths.sample.as_slice(), groups.kinds()), bounces);
                let (world, groups) = (&*world, &*groups);
                let gather_hits = |at: usize, mask: u8, gathered: &mut Gathered<E>| {
                    gather(world, inputs.materials, (wave.hits, groups, at), mask, gathered);
                };
                E::run(level, ShadeHits { spawned, inputs, gather: &gather_hits, wave, samples, radiances });
            };
            for (kind, paths) in [
                (RayKind::Reflection, &paths.reflected),
                (RayKind::Refraction, &paths.refracted),
                (diffuse_kind, &paths.diffuse),
            ] {
                shade(kind, paths, spawned);
                while !spawned.null_interface_paths.rays.is_empty() {
                    null_interface_paths.rays.clear();
                    core::mem::swap(null_interface_paths, &mut spawned.null_interface_paths);
                    shade(RayKind::Refraction, null_interface_paths, spawned);
                }
            }
            let clamp = inputs.settings.clamp;
            for light in spawned.delta.streams.iter_mut().chain([&mut spawned.sampled]) {
                let counts = &mut spawned.counts;
                if inputs.materials.has_shadow_media {
                    let interior = |sample: u32| spawned.states[sample as usize].medium_tracker.interior.clone();
                    light.trace_through_media(world, inputs.scene(), interior, counts);
                } else {
                    light.trace(world);
                }
                light.add_unoccluded(|radiance| clamp.apply(bounces + 1, radiance, counts), radiances);
            }
            paths.clear();
            core::mem::swap(paths, &mut spawned.paths);
            diffuse_kind = RayKind::Diffuse;
            bounces += 1;
        }
    }
}

impl<E: Element> SpawnedPaths<E> {
    /// Makes space for lights and samples.
    fn start(&mut self, inputs: &PathInputs<'_>, n_delta: usize, (n_samples, camera_media): (usize, &[InteriorList])) {
        self.delta.start(n_delta, n_samples);
        if self.states.len() < n_samples {
            self.states.resize_with(n_samples, WavePathState::default);
        }
        if inputs.materials.track_states {
            let air = InteriorList::default();
            let camera_media = if inputs.features.refraction { camera_media } else { &[] };
            let mut camera_media = camera_media.iter().cycle();
            for state in &mut self.states[..n_samples] {
                state.restart(camera_media.next().unwrap_or(&air));
            }
        }
    }

    /// Groups the hits of a wave by the code that shades them. Those that are not shaded in lanes are shaded here.
    fn group(
        &mut self,
        inputs: &PathInputs<'_>,
        world: &dyn StreamQueries,
        wave: &PathWave<'_, E>,
        (groups, samplers): (&mut HitGroups, &mut dyn Samplers),
        radiances: &mut [RadianceSample],
    ) {
        let PathWave { paths, hits, bounces } = wave;
        let (needs, tracks_states) = (inputs.features.surface(), inputs.materials.track_states);
        let ends_all = *bounces > inputs.settings.max_depth;
        groups.clear();
        if let Some(kind) = inputs.materials.kind
            && world.has_only_primitives()
            && !tracks_states
            && !inputs.has_ambient_light(false)
            && !inputs.lighting.lights.is_seen_through_objects
        {
            let primitives = &hits.primitive.as_slice()[..paths.rays.len()];
            groups.fill(primitives, if ends_all { VertexKind::EmissionOnly } else { kind });
            if !inputs.lighting.appearance.background.is_black() {
                let misses = primitives.iter().enumerate().filter(|(_, primitive)| **primitive == HitStream::NONE);
                misses.for_each(|(at, _)| self.add_background(inputs, wave, at, radiances));
            }
            return;
        }
        for at in 0..paths.rays.len() {
            if hits.primitive.get(at) == HitStream::NONE {
                self.add_background(inputs, wave, at, radiances);
                groups.push(VertexKind::Done);
                continue;
            }
            let id = paths.sample.get(at) as usize;
            let hit = world.primitive(hits, at);
            let material = hit.and_then(|hit| inputs.materials.get(hit.material));
            if let (Some(hit), Some(material)) = (hit, material)
                && (hit.casts_shadow || !(inputs.lighting.lights.is_seen_through_objects || material.is_glass()))
                && !(tracks_states && self.states[id].keeps_out_of_lanes(inputs, (wave, at), (&hit, material)))
            {
                let ends = ends_all || (tracks_states && self.states[id].emission_only);
                let is_layered =
                    matches!(material.surface, LaneSurface::MetallicRoughness(_) | LaneSurface::Layered(_));
                if !ends && inputs.has_ambient_light(is_layered) {
                    let weight = paths.throughput(at) * material.ambient;
                    self.add_ambient(inputs, *bounces, weight, &mut radiances[id]);
                }
                groups.push(if ends { VertexKind::EmissionOnly } else { VertexKind::of(&material.surface) });
                continue;
            }
            let (ray, _) = paths.rays.get(at);
            // The surface is large, and not moved.
            let hit = &mut world.surface(&ray, hits, at, needs);
            let is_in_lanes = match (hit, samplers.get(id)) {
                (Some(hit), Some(sampler)) => {
                    self.shade_hit(inputs, (wave, at), hit, (groups, sampler), &mut radiances[id])
                }
                _ => false,
            };
            if !is_in_lanes {
                groups.push(VertexKind::Done);
            }
        }
    }

    /// Adds the background to the sample of a path that hits nothing.
    fn add_background(
        &mut self,
        inputs: &PathInputs<'_>,
        wave: &PathWave<'_, E>,
        at: usize,
        radiances: &mut [RadianceSample],
    ) {
        let background = &inputs.lighting.appearance.background;
        if background.is_black() {
            return;
        }
        let (ray, _) = wave.paths.rays.get(at);
        let sample = wave.paths.sample.get(at) as usize;
        let state = &self.states[sample];
        let omits_environment = state.omits_sampled_lights && inputs.lighting.lights.environment().is_some();
        if inputs.materials.track_states && (state.omits_background || omits_environment) {
            return;
        }
        let vertex = wave.paths.prev_vertex(at, state);
        let light_pdf = vertex.pdf_li_environment(&inputs.lighting, ray.direction);
        let weight = if light_pdf > 0.0 { power_heuristic(vertex.pdf, light_pdf) } else { 1.0 };
        let radiance = wave.paths.throughput(at) * weight * background.radiance(ray.direction);
        radiances[sample].radiance += inputs.settings.clamp.apply(wave.bounces, radiance, &mut self.counts);
    }

    /// Adds ambient light that a surface reflects, with this weight in the pixel.
    pub(super) fn add_ambient(
        &mut self,
        inputs: &PathInputs<'_>,
        bounces: u32,
        weight: Rgb,
        radiance_sample: &mut RadianceSample,
    ) {
        let radiance = weight * inputs.lighting.appearance.ambient;
        radiance_sample.radiance += inputs.settings.clamp.apply(bounces + 1, radiance, &mut self.counts);
    }
}

impl WavePathState {
    /// True if the hit of a path is shaded by itself because of the media around it. That is so for a surface in a medium that absorbs,
    /// and for glass in another medium than air. It is also so where the light of sampled lights is left out.
    fn keeps_out_of_lanes<E: Element>(
        &self,
        inputs: &PathInputs<'_>,
        (wave, at): (&PathWave<'_, E>, usize),
        (hit, material): (&StreamPrimitive<'_>, &LaneMaterial),
    ) -> bool {
        let (tracker, features) = (&self.medium_tracker, inputs.features);
        if self.omits_sampled_lights {
            return true;
        }
        if !material.is_glass() {
            return features.absorption && tracker.absorbs(&inputs.lighting.appearance.materials);
        }
        let leaves = || hit.shape.is_left_by(&wave.paths.rays.get(at).0, wave.hits.t.get(at));
        !(features.refraction && tracker.interior.is_surface_visible(hit.material, leaves))
    }
}
