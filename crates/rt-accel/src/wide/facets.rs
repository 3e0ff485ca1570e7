//! Triangles as primitives of tests.

use glam::Vec3;
use rt_geometry::{Hit, PrimitiveGeometry, Primitives, WatertightRay};
use rt_math::{Aabb, Interval, Ray};

/// Triangles in `f32`, one by one.
pub(super) struct Facets(pub(super) Vec<[Vec3; 3]>);

impl Primitives for Facets {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        Some(Aabb::from_points(self.0[index as usize].map(|v| v.as_dvec3())))
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        let hit = WatertightRay::new(ray).intersect(self.0[index as usize].map(|v| v.as_dvec3()), span)?;
        Some(Hit { t: hit.t, instance: 0, primitive: index, uv: hit.uv })
    }

    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        PrimitiveGeometry::ExactTriangle(self.0[index as usize])
    }
}
