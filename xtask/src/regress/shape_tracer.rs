//! Integrators on a few shapes, without a plan: each shape has the material and the object of its index.

use rt_geometry::{Hit, InteractionFlags, NoProbe, Primitives, RayKind, intersect_primitive};
use rt_math::{Interval, Ray, SlabRay};
use rt_shading::{SceneQueries, SurfaceHit, light::LightId};
use rt_tests::ShapeSet;

/// Shapes and all closest-hit rays that were traced.
#[derive(Debug, Default)]
pub(super) struct ShapeTracer {
    pub set: ShapeSet,
    /// Index of the shape that is the first light.
    pub light: Option<u32>,
    pub rays: Vec<Ray>,
}

impl SceneQueries for ShapeTracer {
    fn closest(&mut self, ray: &Ray, span: Interval, _: RayKind, needs: InteractionFlags) -> Option<SurfaceHit> {
        self.rays.push(*ray);
        let slab = SlabRay::new(ray);
        let hits =
            (0..self.set.len() as u32).filter_map(|i| intersect_primitive(&self.set, i, &slab, span, &mut NoProbe));
        let hit: Hit = hits.reduce(|best, hit| if hit.precedes(&best) { hit } else { best })?;
        let (interaction, object) = (self.set.surface(ray, &hit, needs)?, hit.primitive);
        let light = (self.light == Some(object)).then_some(LightId { index: 0, triangle: None });
        Some(SurfaceHit { t: hit.t, interaction, object, material: object, light, casts_shadow: true })
    }

    fn occluded(&mut self, ray: &Ray, span: Interval) -> bool {
        let slab = SlabRay::new(ray);
        (0..self.set.len() as u32).any(|i| intersect_primitive(&self.set, i, &slab, span, &mut NoProbe).is_some())
    }
}
