//! Classical recursive ray tracing, in waves.

mod counts;
mod shade;
mod wave;

use crate::{Appearance, InteriorList, Needs, Seen, Tracer, ray_queues::RayQueues};
pub use counts::ShadingCounts;
use rt_geometry::RayKind;
use rt_math::{Interval, Ray, Rgb};
use wave::{DirectLighting, PixelTree, TreePath};

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
    needs: Needs,
    /// Media around the camera.
    surroundings: InteriorList,
    /// Rays of the current wave.
    wave: RayQueues<TreePath>,
    next: RayQueues<TreePath>,
    samples: Vec<PixelTree>,
    /// Samples whose path has ended in this wave.
    ended: Vec<u32>,
    lights: DirectLighting,
    counts: ShadingCounts,
}

impl Whitted {
    /// Integrator of up to `max_depth` bounces after the first hit. Rays whose weight in the pixel is below `min_contribution` in all
    /// components are not traced. It computes only the features of `needs`.
    pub fn new(max_depth: u32, min_contribution: f64, needs: Needs) -> Self {
        Self {
            max_depth,
            min_contribution,
            needs,
            surroundings: InteriorList::default(),
            wave: RayQueues::default(),
            next: RayQueues::default(),
            samples: Vec::new(),
            ended: Vec::new(),
            lights: DirectLighting::default(),
            counts: ShadingCounts::default(),
        }
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
    pub fn radiance(&mut self, world: &mut impl Tracer, appearance: &Appearance, ray: &Ray) -> Seen {
        let mut seen = [Seen::NOTHING];
        self.radiance_of(world, appearance, &[(*ray, Interval::FORWARD)], &mut seen);
        seen[0]
    }

    /// Radiance of camera rays: `seen[i]` is that of `rays[i]`. Entries beyond the shorter slice are unchanged. Non-finite scenes
    /// give non-finite radiance, which the caller handles.
    pub fn radiance_of(
        &mut self,
        world: &mut impl Tracer,
        appearance: &Appearance,
        rays: &[(Ray, Interval)],
        seen: &mut [Seen],
    ) {
        let count = rays.len().min(seen.len());
        let (rays, seen) = (&rays[..count], &mut seen[..count]);
        seen.fill(Seen::NOTHING);
        self.start(count);
        let camera_path = |at| TreePath { sample: at as u32, depth: 0, passages: 0, weight: Rgb::WHITE, start: 0.0 };
        self.intersect_and_shade(world, appearance, RayKind::Primary, rays, camera_path, seen);
        self.end_wave(world, seen);
        while !self.wave.is_empty() {
            let wave = core::mem::take(&mut self.wave);
            for (kind, queue) in wave.queues() {
                self.intersect_and_shade(world, appearance, kind, &queue.rays, |at| queue.paths[at], seen);
            }
            self.wave = wave;
            self.end_wave(world, seen);
        }
    }

    /// Allocates state for the samples of `count` camera rays.
    fn start(&mut self, count: usize) {
        if self.samples.len() < count {
            self.samples.resize_with(count, PixelTree::default);
        }
        if self.needs.refraction {
            for sample in &mut self.samples[..count] {
                sample.interior.clone_from(&self.surroundings);
            }
        }
    }

    /// Traces rays of one kind; `path` returns the path of a ray by its index.
    fn intersect_and_shade(
        &mut self,
        world: &mut impl Tracer,
        appearance: &Appearance,
        kind: RayKind,
        rays: &[(Ray, Interval)],
        path: impl Fn(usize) -> TreePath,
        seen: &mut [Seen],
    ) {
        world.closest_batch(rays, kind, self.needs.surface(), |at, hit| {
            let path = path(at);
            self.shade(appearance, path, &rays[at].0, hit, &mut seen[path.sample as usize]);
        });
    }

    /// Traces the shadow rays of a wave, and fills the next one.
    fn end_wave(&mut self, world: &mut impl Tracer, seen: &mut [Seen]) {
        self.lights.resolve(|rays, blocked| world.occluded_batch(rays, blocked), seen);
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
mod shading_normals;

#[cfg(test)]
mod nested_dielectrics;

#[cfg(test)]
mod tests;
