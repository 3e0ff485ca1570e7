//! Geometry of a scene for tools that trace single rays.

use rt_accel::Accelerator as _;
use rt_geometry::InteractionFlags;
use rt_math::{Interval, Ray};
use rt_scene_io::Scene;
use rt_shading::SurfaceHit;

use crate::{
    MemoryPrediction, RenderError, RenderSpace,
    accel_choice::AccelOptions,
    flatten::flatten,
    instance::{Aggregate, BottomLevel},
    work_probe::WorkProbe,
};

/// Geometry of a scene at time 0 with its acceleration structures, for tools that trace single rays.
///
/// [`RenderPlan`](crate::RenderPlan) renders images.
#[derive(Debug)]
pub struct SceneGeometry {
    top: Aggregate,
    levels: BottomLevel,
}

impl SceneGeometry {
    /// Builds the acceleration structures in render space.
    ///
    /// # Errors
    /// If an index is out of range, groups contain themselves or have too many objects, or an acceleration structure cannot be built.
    pub fn build(scene: &Scene, space: RenderSpace) -> Result<Self, RenderError> {
        MemoryPrediction::of_scene(scene, None)?;
        let (top, levels) = flatten(scene, AccelOptions::default(), space.render_from_world(), true, Some(0.0))?;
        Ok(Self { top, levels })
    }

    /// Closest hit of a ray in render space, without texture coordinates.
    pub fn closest_hit(&self, ray: &Ray) -> Option<SurfaceHit> {
        let instances = self.top.set(&self.levels);
        let hit = self.top.accelerator.closest(&instances, ray, Interval::FORWARD, &mut WorkProbe::default())?;
        instances.surface(ray, &hit, InteractionFlags::NONE)
    }
}
