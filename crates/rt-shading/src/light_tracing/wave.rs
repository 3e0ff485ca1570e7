//! State of light paths between vertices, and of connections to the camera.

use super::light_rays::{LightRayStream, LightRays};
use crate::{
    Lighting, PathSettings, ShadingCounts, ShadingFeatures, SurfaceHit, hit_context::HitContext,
    medium_tracker::MediumTracker,
};
use rt_math::{DVec2, Ray, Rgb};

/// Paths of a wave, and the rays that their vertices spawn.
#[derive(Clone, Debug)]
pub(super) struct LightPaths<S> {
    pub(super) settings: PathSettings,
    pub(super) features: ShadingFeatures,
    pub(super) paths: Vec<LightPath<S>>,
    pub(super) connections: Vec<Connection>,
    /// Rays of the next wave.
    pub(super) next: LightRays,
    /// Rays from surfaces to the camera.
    pub(super) to_camera: LightRayStream,
    pub(super) counts: ShadingCounts,
}

impl<S> LightPaths<S> {
    pub(super) fn new(settings: PathSettings, features: ShadingFeatures) -> Self {
        Self {
            settings,
            features,
            paths: Vec::new(),
            connections: Vec::new(),
            next: LightRays::default(),
            to_camera: LightRayStream::default(),
            counts: ShadingCounts::default(),
        }
    }

    /// Removes all paths.
    pub(super) fn clear(&mut self) {
        self.paths.clear();
        self.connections.clear();
        self.next.clear();
        self.to_camera.rays.clear();
    }
}

#[derive(Clone, Debug)]
pub(super) struct LightPath<S> {
    pub(super) sampler: S,
    pub(super) medium_tracker: MediumTracker,
    /// Power at the light.
    pub(super) power: Rgb,
    /// Throughput (β): fraction of the power that remains.
    pub(super) throughput: Rgb,
    /// Number of surfaces that have scattered it.
    pub(super) bounces: u32,
    /// True if it has only been transmitted, by objects that cast no shadow: light samples pass them.
    pub(super) is_passed_by_light: bool,
    /// Path length from a light without falloff, world units; `None` after the first non-specular surface.
    pub(super) no_falloff_distance: Option<f64>,
}

/// Connection of a vertex to the camera.
#[derive(Clone, Debug)]
pub(super) struct Connection {
    pub(super) medium_tracker: MediumTracker,
    pub(super) raster: DVec2,
    /// Contribution if the connection is unoccluded.
    pub(super) light: Rgb,
}

impl Connection {
    /// Contribution after absorption along the ray.
    pub(super) fn arriving(&mut self, lighting: Lighting<'_>, features: &ShadingFeatures, ray: &Ray) -> Rgb {
        if features.absorption {
            let materials = &lighting.appearance.materials;
            self.medium_tracker.absorb(materials, None, 1.0, ray.direction.length(), &mut self.light);
        }
        self.light
    }

    /// Start of the ray's interval behind a null interface; `None` if the surface occludes the connection.
    pub(super) fn skip_interface(
        &mut self,
        lighting: Lighting<'_>,
        features: &ShadingFeatures,
        ray: &Ray,
        hit: &SurfaceHit,
        counts: &mut ShadingCounts,
    ) -> Option<f64> {
        let materials = &lighting.appearance.materials;
        let context = HitContext::new(features, materials, ray, hit)?;
        let interface = context.interface(&mut self.medium_tracker.interior, materials, hit.medium_entry());
        if context.is_visible(interface.as_ref()) {
            return None;
        }
        self.medium_tracker.skip_interface(interface.as_ref(), hit, context.length, &mut self.light, counts);
        // Camera paths end here as well.
        (!self.medium_tracker.null_limit_exceeded()).then(|| hit.span_after(ray).min)
    }
}
