//! Classical recursive ray tracing, in waves.

mod counts;
mod shade;
mod wave;

use crate::{Appearance, InteriorList, Needs, Seen, Tracer, ray_queues::RayQueues};
pub use counts::ShadingCounts;
use rt_geometry::RayKind;
use rt_math::{Interval, Ray, Rgb};
use wave::{DirectLighting, Path, PixelTree};

/// Whitted's integrator (1980): local Phong shading with shadow rays, mirror reflection and refraction.
///
/// It follows many camera rays together, in waves (Laine, Karras and Aila, "Megakernels Considered Harmful: Wavefront Path
/// Tracing on GPUs", 2013): all of them to their first surface, then all shadow rays from there, then one ray that each
/// goes on with, and so forth. The tree of rays of each is walked depth first with a stack of its own, so that depth is
/// limited by `max_depth` and not by the machine's stack, and what a camera ray sees is the same to the bit whatever
/// else is in the wave. Keep one instance per thread: all buffers are reused.
///
/// Rays know which transparent bodies they are inside of ([`InteriorList`]). Where the index of refraction is the same on both
/// sides of a surface, nothing is mirrored by Fresnel's equations and light goes straight on; where nothing else shows the
/// surface either ([`Phong::is_clear`](crate::Phong::is_clear)), the very same ray goes on, and no bounce is counted.
#[derive(Clone, Debug)]
pub struct Whitted {
    max_depth: u32,
    min_contribution: f64,
    needs: Needs,
    /// Media around the camera.
    surroundings: InteriorList,
    /// Rays of the current wave.
    wave: RayQueues<Path>,
    next: RayQueues<Path>,
    samples: Vec<PixelTree>,
    /// Samples whose path has ended in this wave.
    ended: Vec<u32>,
    lights: DirectLighting,
    counts: ShadingCounts,
}

impl Whitted {
    /// Follows up to `max_depth` bounces after the first hit, and none whose weight in the pixel is below
    /// `min_contribution` in all components. Computes only what `needs` names.
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

    /// Radiance that camera rays see: `seen[i]` answers `rays[i]`. Rays beyond the shorter slice are left alone. Infinite
    /// or NaN if the scene is; the caller decides about such samples.
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
        let camera_path = |at| Path { sample: at as u32, depth: 0, passages: 0, weight: Rgb::WHITE, start: 0.0 };
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

    /// Makes room for the samples of so many camera rays.
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

    /// Traces rays of one kind, each for the path of its place.
    fn intersect_and_shade(
        &mut self,
        world: &mut impl Tracer,
        appearance: &Appearance,
        kind: RayKind,
        rays: &[(Ray, Interval)],
        path: impl Fn(usize) -> Path,
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

    /// Fills the next wave with what the samples go on with.
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
