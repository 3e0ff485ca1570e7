//! Path tracing with next-event estimation and MIS, in stages that read and write structures of arrays.
//!
//! ```text
//!   rays ──> closest hits ──> group by kind ──> draw samples ──> shade in lanes ──> shadow rays ──> occluded? ──> samples
//!    ▲                             │                                  │
//!    │                             └──> shade one by one ─┐           │
//!    └──────────────────── next rays <────────────────────┴───────────┘
//! ```
//!
//! All paths of a wave have had the same number of bounces. Each lane gathers the numbers of its shape and of its BSDF: after the first
//! surface, rays that follow each other hit different primitives. Paths that have ended leave no gaps in the streams. Surfaces
//! in an absorbing medium, and those whose BSDF has no version for lanes, are shaded one by one, with the same streams. So is glass
//! among other dielectrics.

mod clamp;
mod direct_lighting;
mod gathered;
mod inputs;
mod interfaces;
mod lane_bsdf;
mod lane_material;
mod light_samples;
mod lights_behind;
mod path_stream;
mod ray_samples;
mod settings;
mod shade;
mod shade_lanes;
pub(crate) mod transport;
mod wave;

use crate::{InteriorList, RadianceSample, ShadingCounts, ShadingFeatures, StreamQueries, lanes::LaneLevel};
pub use clamp::Clamp;
use inputs::PathInputs;
use lane_material::LaneMaterials;
pub(crate) use path_stream::PrevVertex;
use rt_geometry::RayStream;
use rt_math::{Sampler, Samplers};
pub use settings::{Lighting, PathSettings};
pub use transport::Transport;
use wave::{PathBatch, PathStreams};

/// Unidirectional path tracing with next-event estimation (Kajiya 1986; Veach 1997, 10.2).
///
/// Each vertex samples all delta lights, one area or environment light, and a direction of the BSDF. MIS weights combine the last
/// two by the power heuristic (Veach, Guibas 1995). Russian roulette ends paths by their throughput.
///
/// ```text
///   camera ────● x₁ ─ ─ ─ ─ □ light          L ≈ Lₑ(x₁)  +  w · f L cos / p(light)  +  f cos / p(BSDF) · [ w · Lₑ(x₂) + … ]
///               ╲
///                ● x₂ ─ ─ ─ □
/// ```
///
/// Classical lights and surfaces are as bright as under [`Whitted`](crate::Whitted). The intensity of a light in classical units
/// thus counts π times, and kd is an albedo. Dielectrics nest as they do there. Shadow rays end at any surface that casts a
/// shadow: only BSDF samples find light behind glass. Media of index 1 that absorb attenuate them instead.
///
/// Shading in lanes is in `f32`; positions, hits, densities of lights and sums are `f64`. The radiance of a camera ray is bit-identical
/// in every wave, with every instruction set, and with one lane. Keep one instance per thread: all buffers are reused.
#[derive(Clone, Debug)]
pub struct PathTracer {
    settings: PathSettings,
    features: ShadingFeatures,
    /// Known after the first call.
    materials: Option<LaneMaterials>,
    /// Media around the camera: one list for all paths, or one for each.
    camera_media: Vec<InteriorList>,
    /// Instruction set of lanes; `None` to shade hits one by one.
    lanes: Option<LaneLevel>,
    /// False as long as all rays are at time 0.
    has_time: bool,
    streams: Streams,
}

/// Streams with the numbers for shading.
#[derive(Clone, Debug)]
enum Streams {
    F32(PathStreams<f32>),
    F64(PathStreams<f64>),
}

impl PathTracer {
    /// Integrator with these settings. It computes only these `features`. All calls must be with the same lighting.
    pub fn new(settings: PathSettings, features: ShadingFeatures) -> Self {
        Self {
            settings,
            features,
            materials: None,
            camera_media: Vec::new(),
            lanes: LaneLevel::best(),
            has_time: false,
            streams: Streams::F32(PathStreams::default()),
        }
    }

    /// Shades in SIMD lanes of this level, or with `None` one hit at a time. The result is bit-identical.
    pub fn set_lanes(&mut self, level: Option<LaneLevel>) {
        self.lanes = level;
    }

    /// Shades in `f64` with the same code, one hit at a time.
    #[must_use]
    pub fn in_f64(self) -> Self {
        Self { streams: Streams::F64(PathStreams::default()), ..self }
    }

    /// Sets the media around the camera: one list for all paths, or one for each path of the next call. Without a list, all
    /// paths start in air.
    pub fn set_camera_media(&mut self, camera_media: &[InteriorList]) {
        camera_media.clone_into(&mut self.camera_media);
    }

    /// Work done since the counts were last taken.
    pub fn take_counts(&mut self) -> ShadingCounts {
        core::mem::take(match &mut self.streams {
            Streams::F32(streams) => &mut streams.spawned.counts,
            Streams::F64(streams) => &mut streams.spawned.counts,
        })
    }

    /// Estimates radiance, and consumes the camera rays of a stream: `radiances[i]` is that of ray `i`, whose path draws its numbers
    /// from `samplers[i]`. Does nothing unless `samplers` and `radiances` have an entry for each ray. Non-finite scenes give
    /// non-finite radiance, which the caller handles.
    pub fn radiance_of_stream(
        &mut self,
        world: &mut dyn StreamQueries,
        lighting: Lighting<'_>,
        rays: &mut RayStream,
        mut samplers: &mut [impl Sampler],
        radiances: &mut [RadianceSample],
    ) {
        if radiances.len() == rays.len() && samplers.len() == rays.len() {
            self.trace(world, lighting, rays, &mut samplers, radiances);
        }
    }

    fn trace(
        &mut self,
        world: &mut dyn StreamQueries,
        lighting: Lighting<'_>,
        rays: &mut RayStream,
        samplers: &mut dyn Samplers,
        radiances: &mut [RadianceSample],
    ) {
        let Self { settings, features, materials, camera_media, lanes, has_time, streams } = self;
        *has_time |= rays.has_time();
        if !*has_time {
            // Rays that stages append behind these get no times.
            rays.time.as_mut_slice().fill(0.0);
        }
        let materials = materials.get_or_insert_with(|| LaneMaterials::new(lighting, settings.transport, features));
        let inputs = &PathInputs { settings, features, lighting, materials, has_time: *has_time };
        let batch = PathBatch { rays, samplers, camera_media, radiances };
        match streams {
            Streams::F32(streams) => streams.trace(inputs, *lanes, world, batch),
            Streams::F64(streams) => streams.trace(inputs, None, world, batch),
        }
    }
}

#[cfg(test)]
mod tests;
