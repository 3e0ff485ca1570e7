//! Waves of rays: one of each ray tree.

use super::{counts::ShadingCounts, inputs::TreeInputs, lane_phong::LanePhong, ray_tree::RayTree, streams::TreeStream};
use crate::{
    InteriorList, LaneLevel, RadianceSample,
    lane_set::Element,
    stream_queries::{StreamPrimitive, StreamQueries, StreamShape},
    wavefront::{gathered_shapes::GatheredShapes, streams::DeltaStreams},
};
use rt_geometry::{HitStream, RayKind, RayStream, STREAM_CAPACITY};
use rt_math::{Interval, Rgb};

/// Camera rays, the media around the camera, and the radiance of the rays.
pub(super) struct TreeBatch<'a> {
    pub(super) rays: &'a mut RayStream,
    /// One list for all rays, or one for each; none for air.
    pub(super) surroundings: &'a [InteriorList],
    pub(super) seen: &'a mut [RadianceSample],
}

#[derive(Clone, Debug, Default)]
pub(super) struct TreeStreams<E: Element> {
    /// Rays of the current wave, by kind.
    reflected: TreeStream<E>,
    refracted: TreeStream<E>,
    hits: HitStream,
    pub(super) spawned: SpawnedRays<E>,
}

/// Rays that the hits of a wave spawn, and the state of samples.
#[derive(Clone, Debug, Default)]
pub(super) struct SpawnedRays<E: Element> {
    /// Rays of the next wave, by kind.
    pub(super) reflected: TreeStream<E>,
    pub(super) refracted: TreeStream<E>,
    /// Shadow rays by light.
    pub(super) lights: DeltaStreams<E>,
    pub(super) trees: Vec<RayTree>,
    /// Samples whose path has ended in this wave, in scenes that defer rays.
    pub(super) ended: Vec<u32>,
    /// Rays whose hits are shaded in lanes.
    pub(super) in_lanes: RaySet,
    /// Absorption of the media before the hits that are shaded together, per world unit, where they absorb.
    pub(super) absorption: [Rgb; 8],
    /// Triangles of the hits that are shaded together.
    pub(super) gathered: GatheredShapes,
    pub(super) counts: ShadingCounts,
}

/// Rays of a wave with their closest hits.
pub(super) type TreeWave<'a, E> = (&'a TreeStream<E>, &'a HitStream);

/// Stage that shades those closest hits of a wave that are shaded in lanes.
pub(super) struct ShadeTreeHits<'a, W, E: Element> {
    pub(super) spawned: &'a mut SpawnedRays<E>,
    pub(super) inputs: &'a TreeInputs<'a>,
    pub(super) world: &'a W,
    pub(super) wave: TreeWave<'a, E>,
    pub(super) seen: &'a mut [RadianceSample],
}

/// Set of rays of a stream.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RaySet([u64; STREAM_CAPACITY / 64]);

impl RaySet {
    /// All rays, or none.
    const fn all(is_in: bool) -> Self {
        Self([if is_in { !0 } else { 0 }; STREAM_CAPACITY / 64])
    }

    #[inline(always)]
    pub(super) fn insert(&mut self, at: usize) {
        self.0[at / 64 % self.0.len()] |= 1 << (at % 64);
    }

    /// Bits of up to eight rays, from a multiple of their number on.
    #[inline(always)]
    pub(super) fn bits(&self, at: usize) -> u8 {
        (self.0[at / 64 % self.0.len()] >> (at % 64)) as u8
    }
}

impl<E: Element> TreeStreams<E> {
    /// Traces the ray trees of camera rays, and shades them at a level.
    pub(super) fn trace<W: StreamQueries>(
        &mut self,
        inputs: &TreeInputs<'_>,
        level: Option<LaneLevel>,
        world: &mut W,
        batch: TreeBatch<'_>,
    ) {
        let TreeBatch { rays, surroundings, seen } = batch;
        seen.fill(RadianceSample::MISS);
        self.spawned.start(inputs, (rays.len(), surroundings));
        self.refracted.clear();
        self.reflected.start(rays);
        let mut first_kind = RayKind::Primary;
        while !self.reflected.is_empty() || !self.refracted.is_empty() {
            let Self { reflected, refracted, hits, spawned } = self;
            for (paths, kind) in [(&*reflected, first_kind), (&*refracted, RayKind::Refraction)] {
                if !paths.is_empty() {
                    world.closest_stream(&paths.rays, kind, hits);
                    spawned.group(inputs, &*world, (paths, hits), seen);
                    E::run(level, ShadeTreeHits { spawned, inputs, world: &*world, wave: (paths, hits), seen });
                }
            }
            first_kind = RayKind::Reflection;
            for light in &mut spawned.lights.streams {
                if inputs.phongs.has_shadow_media {
                    let scene = (&inputs.settings.features, inputs.appearance.materials.as_slice());
                    let interior = |sample: u32| &spawned.trees[sample as usize].media.interior;
                    light.trace_through_media(world, scene, interior, &mut spawned.counts);
                } else {
                    light.trace(world);
                }
                light.add_unblocked(|radiance| radiance, seen);
            }
            self.next_wave();
        }
    }

    /// Starts the next wave, with deferred rays of samples whose path has ended.
    fn next_wave(&mut self) {
        let Self { reflected, refracted, spawned, .. } = self;
        for &sample in &spawned.ended {
            if let Some((ray, path)) = spawned.trees[sample as usize].pop() {
                spawned.refracted.push(&ray, Interval::SPAWNED, &path);
            }
        }
        spawned.ended.clear();
        for (wave, next) in [(reflected, &mut spawned.reflected), (refracted, &mut spawned.refracted)] {
            wave.clear();
            core::mem::swap(wave, next);
        }
    }
}

impl<E: Element> SpawnedRays<E> {
    /// Makes space for lights and samples.
    fn start(&mut self, inputs: &TreeInputs<'_>, (n_samples, surroundings): (usize, &[InteriorList])) {
        self.lights.start(inputs.appearance.lights.len(), n_samples);
        if self.trees.len() < n_samples {
            self.trees.resize_with(n_samples, RayTree::default);
        }
        if inputs.settings.features.refraction {
            let air = InteriorList::default();
            let mut surroundings = surroundings.iter().cycle();
            for tree in &mut self.trees[..n_samples] {
                tree.restart(surroundings.next().unwrap_or(&air));
            }
        }
    }

    /// Finds the hits that are shaded in lanes, and shades all others.
    fn group<W: StreamQueries>(
        &mut self,
        inputs: &TreeInputs<'_>,
        world: &W,
        (paths, hits): TreeWave<'_, E>,
        seen: &mut [RadianceSample],
    ) {
        let are_all = inputs.phongs.are_complete && world.has_only_primitives();
        self.in_lanes = RaySet::all(are_all);
        if are_all {
            return;
        }
        let needs = inputs.settings.features.surface();
        for (at, primitive) in hits.primitive.as_slice()[..paths.len()].iter().enumerate() {
            if *primitive == HitStream::NONE {
                continue;
            }
            let is_in_lanes = |primitive: StreamPrimitive<'_>| {
                inputs.phongs.get(primitive.material).is_some_and(|phong| phong.shades(&primitive.shape))
            };
            if world.primitive(hits, at).is_some_and(is_in_lanes) {
                self.in_lanes.insert(at);
                continue;
            }
            let (ray, _) = paths.rays.get(at);
            // The surface is large, and not moved.
            match &mut world.surface(&ray, hits, at, needs) {
                Some(hit) => {
                    let seen = &mut seen[paths.sample.get(at) as usize];
                    self.shade_hit(inputs, paths.get(at), &ray, hit, seen);
                }
                None => self.end_path(inputs, paths.sample.get(at)),
            }
        }
    }

    /// Ends the path of a sample: its last deferred ray is next.
    #[inline(always)]
    pub(super) fn end_path(&mut self, inputs: &TreeInputs<'_>, sample: u32) {
        if inputs.settings.features.refraction {
            self.ended.push(sample);
        }
    }
}

impl LanePhong {
    /// True if hits on shapes of this kind are shaded in lanes: these have no texture coordinates of spheres and polygons.
    fn shades(&self, shape: &StreamShape<'_>) -> bool {
        !(self.is_checkered() && matches!(shape, StreamShape::Sphere(_) | StreamShape::Polygon(_)))
    }
}
