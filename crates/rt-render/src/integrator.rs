//! Integrators: functions from camera rays to radiance.

use rt_scene_io::{Integrator, RenderSettings};
use rt_shading::{AmbientOcclusion, AovIntegrator, Clamp, PathSettings, Transport};

/// Integrator of a plan with its parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) enum IntegratorState {
    /// Whitted ray tracing.
    Whitted,
    /// Path tracing: `path`, `path-reference`, `path-caustics`, `direct` and `distributed`.
    Path(PathSettings),
    AmbientOcclusion(AmbientOcclusion),
    /// Geometry of the first hit.
    Aov(AovIntegrator),
    /// Work of the acceleration structure.
    Cost,
}

impl IntegratorState {
    /// Integrator of the settings. `depth_range` is that of the scene along the view axis.
    pub(crate) fn new(settings: &RenderSettings, depth_range: [f64; 2], has_unsampled_emitters: bool) -> Self {
        let path = |max_depth, transport| {
            let clamp = settings.clamp.and_then(Clamp::new).unwrap_or_default();
            Self::Path(PathSettings { max_depth, rr_start_depth: settings.rr_start_depth, transport, clamp })
        };
        match settings.integrator {
            Integrator::Whitted => Self::Whitted,
            Integrator::Distributed if has_unsampled_emitters => path(settings.depth, Transport::SpecularWithEmitters),
            Integrator::Distributed => path(settings.depth, Transport::Specular),
            Integrator::Path | Integrator::PathReference => path(settings.depth, Transport::Full),
            Integrator::Caustics => path(settings.depth, Transport::NonCaustic),
            Integrator::Direct => path(0, Transport::Full),
            Integrator::AmbientOcclusion => {
                Self::AmbientOcclusion(AmbientOcclusion { reach: settings.occlusion_distance })
            }
            Integrator::Normals => Self::Aov(AovIntegrator::Normals),
            Integrator::Depth => {
                let [near, far] = depth_range;
                Self::Aov(AovIntegrator::Depth { near, far })
            }
            Integrator::Uv => Self::Aov(AovIntegrator::Uv),
            Integrator::Cost => Self::Cost,
        }
    }

    /// True if it takes random numbers after those of the camera ray.
    pub(crate) const fn uses_samplers(&self) -> bool {
        matches!(self, Self::Path(_) | Self::AmbientOcclusion(_))
    }

    /// Parameters of path tracing; paths of length zero for other integrators.
    pub(crate) const fn path_settings(&self) -> PathSettings {
        match self {
            Self::Path(settings) => *settings,
            _ => PathSettings { max_depth: 0, rr_start_depth: 0, transport: Transport::Full, clamp: Clamp::NONE },
        }
    }
}
