//! Waves of rays: all rays of the ray trees of a batch after the same number of surfaces, null interfaces included.
//!
//! ```text
//!   camera ray ───● mirror ───● glass ─── mirrored ray: the same branch
//!                              ╲───────── refracted ray: a branch of its own
//! ```
//!
//! A surface that spawns one ray continues a branch of its ray tree. Each branch has at most one ray in a wave. The sum of a branch is
//! that of its surfaces in their order, then that of the branches that start there, the last one first. It thus does not depend on the
//! rest of the wave.

use super::{counts::ShadingCounts, inputs::RayTreeInputs, lane_phong::LanePhong, streams::RayTreeStream};
use crate::{
    InteriorList, LaneLevel, RadianceSample,
    interior_list::{InteriorLists, ListRange},
    lane_set::Element,
    medium_tracker::MediumTracker,
    stream_queries::{StreamPrimitive, StreamQueries, StreamShape},
    wavefront::{
        gathered_shapes::GatheredShapes,
        streams::{DeltaStreams, batch_size},
    },
};
use rt_geometry::{HitStream, RayKind, RayStream, STREAM_CAPACITY};
use rt_math::Rgb;

/// Entries of interior lists that may be without use.
const MAX_UNUSED_ENTRIES: usize = if cfg!(test) { 1 << 8 } else { 1 << 16 };

/// Camera rays, the media around the camera, and the radiance of the rays.
pub(super) struct RayTreeBatch<'a> {
    pub(super) rays: &'a mut RayStream,
    /// One list for all rays, or one for each; none for air.
    pub(super) camera_media: &'a [InteriorList],
    pub(super) radiances: &'a mut [RadianceSample],
}

#[derive(Clone, Debug, Default)]
pub(super) struct RayTreeStreams<E: Element> {
    /// Rays of the current wave, by kind.
    reflected: RayTreeStream<E>,
    refracted: RayTreeStream<E>,
    hits: HitStream,
    pub(super) spawned: SpawnedRays<E>,
    /// Radiance of each branch; none beyond the last one.
    branch_radiances: Vec<RadianceSample>,
    /// Stack of refracted rays that wait, and behind it empty streams.
    waiting: Vec<WaitingRays<E>>,
    n_waiting: usize,
}

/// Refracted rays that wait until all rays are shaded that the mirrored ones of their wave lead to. There are too many for one wave.
#[derive(Clone, Debug, Default)]
struct WaitingRays<E: Element> {
    rays: RayTreeStream<E>,
    /// Numbers of branches, and of entries of interior lists, when they began to wait.
    n_branches: usize,
    n_entries: usize,
}

/// Rays that the hits of a wave spawn, and the state of ray trees.
#[derive(Clone, Debug, Default)]
pub(super) struct SpawnedRays<E: Element> {
    /// Rays of the next wave, by kind.
    pub(super) reflected: RayTreeStream<E>,
    pub(super) refracted: RayTreeStream<E>,
    /// Shadow rays by light.
    pub(super) lights: DeltaStreams<E>,
    /// Rays of a wave for whose shadow rays there is space.
    max_rays: usize,
    /// By branch: the one from which it starts. Those of the camera rays come first, and start from none.
    parents: Vec<u32>,
    /// Interior lists of the rays.
    pub(super) lists: InteriorLists,
    /// By branch: the list around its ray in this wave, for shadow rays.
    interiors: Vec<ListRange>,
    /// Media of the ray whose hit is shaded.
    pub(super) media: MediumTracker,
    /// Media before and behind the hits that are shaded together.
    pub(super) sides: [[ListRange; 2]; 8],
    /// Rays whose hits are shaded in lanes.
    pub(super) in_lanes: RaySet,
    /// Absorption of the media before the hits that are shaded together, per world unit, where they absorb.
    pub(super) absorption: [Rgb; 8],
    /// Shapes of the hits that are shaded together.
    pub(super) gathered: GatheredShapes,
    pub(super) counts: ShadingCounts,
}

/// Rays of a wave with their closest hits.
pub(super) type RayTreeWave<'a, E> = (&'a RayTreeStream<E>, &'a HitStream);

/// Stage that shades those closest hits of a wave that are shaded in lanes.
pub(super) struct ShadeRayTreeHits<'a, E: Element> {
    pub(super) spawned: &'a mut SpawnedRays<E>,
    pub(super) inputs: &'a RayTreeInputs<'a>,
    pub(super) world: &'a dyn StreamQueries,
    pub(super) wave: RayTreeWave<'a, E>,
    /// Radiance of each branch.
    pub(super) radiances: &'a mut [RadianceSample],
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

impl<E: Element> RayTreeStreams<E> {
    /// Traces the ray trees of camera rays, and shades them at a level.
    pub(super) fn trace(
        &mut self,
        inputs: &RayTreeInputs<'_>,
        level: Option<LaneLevel>,
        world: &mut dyn StreamQueries,
        batch: RayTreeBatch<'_>,
    ) {
        let RayTreeBatch { rays, camera_media, radiances } = batch;
        let n_samples = radiances.len();
        self.start(inputs, rays, camera_media);
        let mut first_kind = RayKind::Primary;
        loop {
            let Self { reflected, refracted, hits, spawned, branch_radiances: radiances, .. } = self;
            let max_branches = spawned.parents.len() + STREAM_CAPACITY;
            if radiances.len() < max_branches {
                radiances.resize(max_branches, RadianceSample::MISS);
            }
            for (paths, kind) in [(&*reflected, first_kind), (&*refracted, RayKind::Refraction)] {
                if !paths.is_empty() {
                    world.closest_stream(&paths.rays, kind, hits);
                    spawned.group(inputs, &*world, (paths, hits), radiances);
                    E::run(level, ShadeRayTreeHits { spawned, inputs, world: &*world, wave: (paths, hits), radiances });
                }
            }
            first_kind = RayKind::Reflection;
            if inputs.phongs.has_shadow_media {
                spawned.trace_shadow_media(inputs, world, [reflected, refracted]);
            } else {
                spawned.lights.streams.iter_mut().for_each(|light| light.trace(world));
            }
            for light in &mut spawned.lights.streams {
                light.add_unoccluded(|radiance| radiance, radiances);
            }
            if !self.next_wave(n_samples) {
                break;
            }
        }
        for (radiance, of_branch) in radiances.iter_mut().zip(&mut self.branch_radiances) {
            *radiance = core::mem::replace(of_branch, RadianceSample::MISS);
        }
    }

    /// Starts with camera rays in these media.
    fn start(&mut self, inputs: &RayTreeInputs<'_>, rays: &mut RayStream, camera_media: &[InteriorList]) {
        let Self { reflected, refracted, spawned, .. } = self;
        let n_lights = inputs.appearance.lights.len();
        spawned.max_rays = batch_size(n_lights).max(rays.len());
        spawned.lights.start(n_lights, spawned.max_rays);
        spawned.parents.clear();
        spawned.parents.extend(0..rays.len() as u32);
        refracted.clear();
        reflected.start(rays);
        if inputs.settings.features.refraction {
            spawned.lists.truncate(0);
            reflected.start_in(camera_media, &mut spawned.lists);
        }
    }

    /// Starts the next wave. Returns false after the last one.
    fn next_wave(&mut self, n_samples: usize) -> bool {
        let Self { reflected, refracted, spawned, waiting, n_waiting, .. } = self;
        for (wave, next) in [(&mut *reflected, &mut spawned.reflected), (&mut *refracted, &mut spawned.refracted)] {
            wave.clear();
            core::mem::swap(wave, next);
        }
        if reflected.len() + refracted.len() > spawned.max_rays {
            if *n_waiting == waiting.len() {
                waiting.push(WaitingRays::default());
            }
            let last = &mut waiting[*n_waiting];
            core::mem::swap(&mut last.rays, refracted);
            (last.n_branches, last.n_entries) = (spawned.parents.len(), spawned.lists.len());
            *n_waiting += 1;
        }
        if !(reflected.is_empty() && refracted.is_empty()) {
            let first = n_waiting.checked_sub(1).map_or(0, |last| waiting[last].n_entries);
            if spawned.lists.len() - first > MAX_UNUSED_ENTRIES {
                spawned.lists.keep_only(first, reflected.interiors().chain(refracted.interiors()));
            }
            return true;
        }
        let Some(last) = n_waiting.checked_sub(1) else {
            self.end_branches(n_samples);
            return false;
        };
        *n_waiting = last;
        let WaitingRays { n_branches, n_entries, .. } = waiting[last];
        spawned.lists.truncate(n_entries);
        core::mem::swap(&mut waiting[last].rays, refracted);
        self.end_branches(n_branches);
        true
    }

    /// Adds the radiance of the branches from this one on to those that they start from, the last one first, and removes them.
    fn end_branches(&mut self, first: usize) {
        let Self { spawned: SpawnedRays { parents, .. }, branch_radiances, .. } = self;
        for branch in (first..parents.len()).rev() {
            let ended = core::mem::replace(&mut branch_radiances[branch], RadianceSample::MISS);
            branch_radiances[parents[branch] as usize].radiance += ended.radiance;
        }
        parents.truncate(first);
    }
}

impl<E: Element> SpawnedRays<E> {
    /// Starts a branch from another one.
    #[inline(always)]
    pub(super) fn start_branch(&mut self, parent: u32) -> u32 {
        self.parents.push(parent);
        self.parents.len() as u32 - 1
    }

    /// Traces shadow rays in scenes with media that these pass. They start in the media of the rays of the wave.
    fn trace_shadow_media(
        &mut self,
        inputs: &RayTreeInputs<'_>,
        world: &mut dyn StreamQueries,
        wave: [&RayTreeStream<E>; 2],
    ) {
        if self.interiors.len() < self.parents.len() {
            self.interiors.resize(self.parents.len(), ListRange::default());
        }
        for paths in wave {
            for at in 0..paths.len() {
                self.interiors[paths.branch.get(at) as usize] = paths.media.get(at).interior;
            }
        }
        let interior = |branch: u32| {
            let mut interior = InteriorList::default();
            self.lists.read(self.interiors[branch as usize], &mut interior);
            interior
        };
        let scene = (&inputs.settings.features, inputs.appearance.materials.as_slice());
        for light in &mut self.lights.streams {
            light.trace_through_media(world, scene, interior, &mut self.counts);
        }
    }

    /// Finds the hits that are shaded in lanes, and shades all others.
    fn group(
        &mut self,
        inputs: &RayTreeInputs<'_>,
        world: &dyn StreamQueries,
        (paths, hits): RayTreeWave<'_, E>,
        radiances: &mut [RadianceSample],
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
            if let Some(hit) = &mut world.surface(&ray, hits, at, needs) {
                let radiance_sample = &mut radiances[paths.branch.get(at) as usize];
                self.shade_hit(inputs, paths.get(at), &ray, hit, radiance_sample);
            }
        }
    }
}

impl LanePhong {
    /// True if hits on shapes of this kind are shaded in lanes: these have no texture coordinates of spheres and polygons.
    fn shades(&self, shape: &StreamShape<'_>) -> bool {
        !(self.is_checkered() && matches!(shape, StreamShape::Sphere(_) | StreamShape::Polygon(_)))
    }
}
