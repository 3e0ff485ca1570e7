//! Classical recursive ray tracing, in waves.

mod counts;
mod direct_lighting;
mod hit_block;
mod hit_queue;
mod lane_phong;
mod point_lanes;
mod shade;
mod shade_lanes;
mod wave;
mod wavefront;

use crate::{
    Appearance, ClosestHit, InteriorList, LazyShapes, RadianceSample, SceneQueries, ShadingFeatures, lanes::LaneLevel,
    ray_queues::RayQueues,
};
pub use counts::ShadingCounts;
use direct_lighting::DirectLighting;
use hit_queue::HitQueue;
use lane_phong::LanePhong;
use rt_geometry::RayKind;
use rt_math::{Interval, Ray, Rgb};
use wave::{RayTree, TreePath};
pub use wavefront::WavefrontWhitted;

/// Whitted's integrator (1980): local Phong shading with shadow rays, mirror reflection and refraction.
///
/// Waves hold many camera rays (Laine, Karras and Aila, "Megakernels Considered Harmful: Wavefront Path Tracing on GPUs", 2013).
/// A wave traces one ray of each to its closest hit, then all shadow rays from there.
///
/// The ray tree of each camera ray is traversed depth first with a stack of its own. Only `max_depth` limits the depth, and the
/// radiance of a camera ray is bit-identical in every wave. Keep one instance per thread: all buffers are reused.
///
/// Rays carry the list of dielectrics that they are inside of ([`InteriorList`]). At equal indices of refraction on both sides of a
/// surface, Fresnel reflection is 0 and light is not deflected. If nothing else makes the surface visible
/// ([`Phong::is_clear`](crate::Phong::is_clear)), the same ray continues, and no bounce is counted.
#[derive(Clone, Debug)]
pub struct Whitted {
    max_depth: u32,
    min_contribution: f64,
    features: ShadingFeatures,
    /// Media around the camera.
    surroundings: InteriorList,
    /// Rays of the current wave.
    wave: RayQueues<TreePath>,
    next: RayQueues<TreePath>,
    /// Paths of camera rays.
    camera_paths: Vec<TreePath>,
    samples: Vec<RayTree>,
    /// Samples whose path has ended in this wave.
    ended: Vec<u32>,
    direct_lighting: DirectLighting,
    /// Hits that are shaded in lanes.
    queue: HitQueue,
    /// Phong models by material, for lanes.
    phongs: Vec<Option<LanePhong>>,
    /// Instruction set of lanes; `None` to shade all hits one by one.
    lanes: Option<LaneLevel>,
    counts: ShadingCounts,
}

impl Whitted {
    /// Integrator of up to `max_depth` bounces after the first hit. Rays whose weight in the pixel is below `min_contribution` in all
    /// components are not traced. It computes only these `features`.
    pub fn new(max_depth: u32, min_contribution: f64, features: ShadingFeatures) -> Self {
        Self {
            max_depth,
            min_contribution,
            features,
            surroundings: InteriorList::default(),
            wave: RayQueues::default(),
            next: RayQueues::default(),
            camera_paths: Vec::new(),
            samples: Vec::new(),
            ended: Vec::new(),
            direct_lighting: DirectLighting::default(),
            queue: HitQueue::default(),
            phongs: Vec::new(),
            lanes: None,
            counts: ShadingCounts::default(),
        }
    }

    /// Shades spheres, flat triangles and planes in SIMD lanes of this level. The result is bit-identical. All later calls must
    /// be with this appearance.
    pub fn shade_in_lanes(&mut self, level: LaneLevel, appearance: &Appearance) {
        self.lanes = Some(level);
        self.phongs = LanePhong::of_all(appearance, &self.features);
    }

    /// Sets the media around the camera; air by default.
    pub fn set_surroundings(&mut self, surroundings: &InteriorList) {
        self.surroundings.clone_from(surroundings);
    }

    /// Work done so far.
    pub const fn counts(&self) -> ShadingCounts {
        self.counts
    }

    /// Work done since the counts were last taken.
    pub fn take_counts(&mut self) -> ShadingCounts {
        core::mem::take(&mut self.counts)
    }

    /// Version of [`radiance_of`](Self::radiance_of) for one camera ray.
    pub fn radiance(&mut self, world: &mut impl SceneQueries, appearance: &Appearance, ray: &Ray) -> RadianceSample {
        let mut seen = [RadianceSample::MISS];
        self.radiance_of(world, appearance, &[(*ray, Interval::FORWARD)], &mut seen);
        seen[0]
    }

    /// Radiance of camera rays: `seen[i]` is that of `rays[i]`. Entries beyond the shorter slice are unchanged. Non-finite scenes
    /// give non-finite radiance, which the caller handles.
    pub fn radiance_of(
        &mut self,
        world: &mut impl SceneQueries,
        appearance: &Appearance,
        rays: &[(Ray, Interval)],
        seen: &mut [RadianceSample],
    ) {
        let count = rays.len().min(seen.len());
        let (rays, seen) = (&rays[..count], &mut seen[..count]);
        seen.fill(RadianceSample::MISS);
        self.start(count);
        self.direct_lighting.start(appearance.lights.len());
        let camera_paths = core::mem::take(&mut self.camera_paths);
        self.intersect_and_shade(world, appearance, RayKind::Primary, (rays, &camera_paths), seen);
        self.camera_paths = camera_paths;
        self.end_wave(world, seen);
        while !self.wave.is_empty() {
            let wave = core::mem::take(&mut self.wave);
            for (kind, queue) in wave.queues() {
                self.intersect_and_shade(world, appearance, kind, (&queue.rays, &queue.paths), seen);
            }
            self.wave = wave;
            self.end_wave(world, seen);
        }
    }

    /// Allocates state for the samples of `count` camera rays.
    fn start(&mut self, count: usize) {
        if self.samples.len() < count {
            self.samples.resize_with(count, RayTree::default);
            let camera_path = |at| TreePath { sample: at, depth: 0, passages: 0, weight: Rgb::WHITE, start: 0.0 };
            self.camera_paths.extend((self.camera_paths.len() as u32..count as u32).map(camera_path));
        }
        if self.features.refraction {
            for sample in &mut self.samples[..count] {
                sample.interior.clone_from(&self.surroundings);
            }
        }
    }

    /// Traces rays of one kind, and shades their hits.
    fn intersect_and_shade(
        &mut self,
        world: &mut impl SceneQueries,
        appearance: &Appearance,
        kind: RayKind,
        (rays, paths): (&[(Ray, Interval)], &[TreePath]),
        seen: &mut [RadianceSample],
    ) {
        let Some(level) = self.lanes else {
            return world.closest_batch(rays, kind, self.features.surface(), |at, hit| {
                let path = paths[at];
                let (ray, seen) = (&rays[at].0, &mut seen[path.sample as usize]);
                match hit {
                    Some(hit) => self.shade(appearance, path, ray, hit, seen),
                    None => self.leave_scene(appearance, &path, ray, seen),
                }
            });
        };
        world.closest_hits(
            rays,
            kind,
            (self.features.surface(), LazyShapes::All),
            // Inlined, so that a hit stays in registers until it is in the queue.
            #[inline(always)]
            |at, hit| match hit {
                Some(ClosestHit::Sphere(hit)) if self.is_in_lanes(hit.material) => self.queue.push_sphere(at, hit),
                Some(ClosestHit::Triangle(hit)) if self.is_in_lanes(hit.material) => self.queue.push_triangle(at, hit),
                Some(ClosestHit::Plane(hit)) if self.is_in_lanes(hit.material) => self.queue.push_plane(at, hit),
                Some(hit) => {
                    let path = paths[at];
                    self.shade_closest(appearance, path, &rays[at].0, hit, &mut seen[path.sample as usize]);
                }
                None => {
                    let path = &paths[at];
                    self.leave_scene(appearance, path, &rays[at].0, &mut seen[path.sample as usize]);
                }
            },
        );
        self.shade_queue(level, appearance, (rays, paths), seen);
    }

    /// Shades a hit by itself.
    fn shade_closest(
        &mut self,
        appearance: &Appearance,
        path: TreePath,
        ray: &Ray,
        hit: ClosestHit<'_>,
        seen: &mut RadianceSample,
    ) {
        match hit {
            ClosestHit::Sphere(hit) => self.shade(appearance, path, ray, &mut hit.surface(ray), seen),
            ClosestHit::Triangle(hit) => self.shade(appearance, path, ray, &mut hit.surface(ray), seen),
            ClosestHit::Plane(hit) => self.shade(appearance, path, ray, &mut hit.surface(ray), seen),
            ClosestHit::Surface(hit) => self.shade(appearance, path, ray, hit, seen),
        }
    }

    /// True if lanes shade the material.
    #[inline(always)]
    fn is_in_lanes(&self, material: u32) -> bool {
        matches!(self.phongs.get(material as usize), Some(Some(_)))
    }

    /// Traces the shadow rays of a wave, and fills the next one.
    fn end_wave(&mut self, world: &mut impl SceneQueries, seen: &mut [RadianceSample]) {
        self.direct_lighting.resolve(self.lanes, |rays, blocked| world.occluded_batch(rays, blocked), seen);
        self.next_wave();
    }

    /// Starts the next wave, with deferred rays of samples whose path has ended.
    fn next_wave(&mut self) {
        for &sample in &self.ended {
            self.samples[sample as usize].pop_deferred(&mut self.next);
        }
        self.ended.clear();
        self.wave.clear();
        core::mem::swap(&mut self.wave, &mut self.next);
    }
}

#[cfg(test)]
mod tests;
