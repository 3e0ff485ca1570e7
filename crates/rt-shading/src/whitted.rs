//! Classical recursive ray tracing, in stages that read and write structures of arrays.
//!
//! ```text
//!   rays ──> closest hits ──> shade in lanes, or one by one ──> shadow rays ──> occluded? ──> samples
//!    ▲                                   │
//!    └───────── mirrored, refracted <────┘
//! ```
//!
//! Eight rays that follow each other in a stream are shaded together, if they hit the same primitive, or spheres and triangles of
//! one material. So the numbers of the material are the same in all lanes. Surfaces and materials without a version for lanes are
//! shaded one by one, with the same streams.

mod counts;
mod hit_group;
mod inputs;
mod interfaces;
mod lane_phong;
mod ray_tree_path;
mod secondary_rays;
mod shade;
mod shade_lanes;
mod streams;
mod wave;

use crate::{
    Appearance, InteriorList, RadianceSample, SceneQueries, ShadingFeatures,
    lanes::LaneLevel,
    stream_queries::{SingleQueries, StreamQueries},
};
pub use counts::ShadingCounts;
use inputs::{RayTreeInputs, Settings};
use lane_phong::LanePhongs;
use rt_geometry::RayStream;
use rt_math::{Interval, Ray};
use wave::{RayTreeBatch, RayTreeStreams};

/// Whitted's integrator (1980): local Phong shading with shadow rays, mirror reflection and refraction.
///
/// Waves hold many camera rays (Laine, Karras and Aila, "Megakernels Considered Harmful: Wavefront Path Tracing on GPUs", 2013).
/// A wave traces their rays after the same number of surfaces to their closest hits, then all shadow rays from there.
///
/// `max_depth` and `min_contribution` limit the ray tree of a camera ray, not the stack of the thread. Shading in lanes is in `f32`;
/// positions, hits and sums are `f64`. The radiance of a camera ray is bit-identical in every wave, with every instruction set, and with
/// one lane. Keep one instance per thread: all buffers are reused.
///
/// Rays carry the list of dielectrics that they are inside of ([`InteriorList`]). At equal indices of refraction on both sides of a
/// surface, Fresnel reflection is 0 and light is not deflected. If nothing else makes the surface visible
/// ([`Phong::is_clear`](crate::Phong::is_clear)), the same ray continues, and no bounce is counted.
#[derive(Clone, Debug)]
pub struct Whitted {
    settings: Settings,
    /// Known after the first call.
    phongs: Option<LanePhongs>,
    /// Media around the camera: one list for all rays, or one for each.
    camera_media: Vec<InteriorList>,
    /// Instruction set of lanes; `None` to shade hits one by one.
    lanes: Option<LaneLevel>,
    /// False as long as all rays are at time 0.
    has_time: bool,
    /// True to shade in `f64`.
    is_f64: bool,
    in_f32: RayTreeStreams<f32>,
    in_f64: RayTreeStreams<f64>,
}

impl Whitted {
    /// Integrator of up to `max_depth` bounces after the first hit. Rays whose throughput in the pixel is below
    /// `min_contribution` in all components are not traced. It computes only these `features`. All calls must be with
    /// the same appearance.
    pub fn new(max_depth: u32, min_contribution: f64, features: ShadingFeatures) -> Self {
        Self {
            settings: Settings { max_depth, min_contribution, features },
            phongs: None,
            camera_media: Vec::new(),
            lanes: LaneLevel::best(),
            has_time: false,
            is_f64: false,
            in_f32: RayTreeStreams::default(),
            in_f64: RayTreeStreams::default(),
        }
    }

    /// Shades in SIMD lanes of this level, or with `None` one hit at a time. The result is bit-identical.
    pub const fn set_lanes(&mut self, level: Option<LaneLevel>) {
        self.lanes = level;
    }

    /// Shades in `f64` with the same code, one hit at a time.
    #[must_use]
    pub fn in_f64(self) -> Self {
        Self { is_f64: true, ..self }
    }

    /// Sets the media around the camera: one list for all rays, or one for each ray of the next call. Without a list, all rays start
    /// in air.
    pub fn set_camera_media(&mut self, camera_media: &[InteriorList]) {
        camera_media.clone_into(&mut self.camera_media);
    }

    /// Work done so far.
    pub fn counts(&self) -> ShadingCounts {
        let mut counts = self.in_f32.spawned.counts;
        counts += self.in_f64.spawned.counts;
        counts
    }

    /// Work done since the counts were last taken.
    pub fn take_counts(&mut self) -> ShadingCounts {
        let counts = self.counts();
        (self.in_f32.spawned.counts, self.in_f64.spawned.counts) = Default::default();
        counts
    }

    /// Radiance of one camera ray, shaded in `f64` and without lanes. Reference for tests, and entry for worlds without streams.
    pub fn radiance(&mut self, world: &mut dyn SceneQueries, appearance: &Appearance, ray: &Ray) -> RadianceSample {
        let (mut rays, mut radiances) = (RayStream::default(), [RadianceSample::MISS]);
        rays.push(ray, Interval::FORWARD);
        let is_f64 = core::mem::replace(&mut self.is_f64, true);
        self.radiance_of_stream(&mut SingleQueries::new(world), appearance, &mut rays, &mut radiances);
        self.is_f64 = is_f64;
        radiances[0]
    }

    /// Computes radiance, and consumes the camera rays of a stream: `radiances[i]` is that of ray `i`. Does nothing unless `radiances`
    /// has an entry for each ray. Non-finite scenes give non-finite radiance, which the caller handles.
    pub fn radiance_of_stream(
        &mut self,
        world: &mut dyn StreamQueries,
        appearance: &Appearance,
        rays: &mut RayStream,
        radiances: &mut [RadianceSample],
    ) {
        if radiances.len() != rays.len() {
            return;
        }
        self.has_time |= rays.has_time();
        if !self.has_time {
            // Rays that stages append behind these get no times.
            rays.time.as_mut_slice().fill(0.0);
        }
        let Self { settings, phongs, camera_media, lanes, has_time, is_f64, in_f32, in_f64 } = self;
        let phongs = phongs.get_or_insert_with(|| LanePhongs::new(appearance, &settings.features));
        let inputs = &RayTreeInputs { settings, appearance, phongs, has_time: *has_time };
        let batch = RayTreeBatch { rays, camera_media, radiances };
        if *is_f64 {
            in_f64.trace(inputs, None, world, batch);
        } else {
            in_f32.trace(inputs, *lanes, world, batch);
        }
    }
}

#[cfg(test)]
mod tests;
