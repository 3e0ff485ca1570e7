//! Boxes as primitives.

use rt_geometry::{Hit, PrimitiveGeometry, Primitives};
use rt_math::{Aabb, Interval, Ray, SlabRay};

/// Axis-aligned boxes as primitives: for callers with boxes only, or with objects that are tested in a callback of
/// [`visit_candidates`](crate::Accelerator::visit_candidates) or
/// [`visit_overlapping`](crate::Accelerator::visit_overlapping).
///
/// A ray that starts in a box hits it at its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boxes<'b>(pub &'b [Aabb]);

impl Primitives for Boxes<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        Some(self.0[index as usize])
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        let inside = self.0[index as usize].clip(&SlabRay::new(ray), span)?;
        Some(Hit { t: inside.min, instance: 0, primitive: index, uv: [0.0; 2] })
    }

    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        PrimitiveGeometry::Box(self.0[index as usize])
    }
}

/// Row of 100 boxes, 0.5 wide and 1 apart.
#[cfg(test)]
pub(crate) fn row() -> Vec<Aabb> {
    let corners = (0..100).map(|index| glam::DVec3::X * f64::from(index));
    corners.map(|corner| Aabb::new(corner, corner + 0.5)).collect()
}
