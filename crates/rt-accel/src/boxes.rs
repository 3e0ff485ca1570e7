//! Boxes as primitives.

use rt_geometry::{Hit, PrimitiveGeometry, Primitives};
use rt_math::{Aabb, Interval, Ray, SlabRay};

/// Axis-aligned boxes as primitives: for callers with boxes only, or with objects that are tested in a callback of
/// [`visit_candidates`](crate::Accelerator::visit_candidates) or
/// [`visit_overlapping`](crate::Accelerator::visit_overlapping).
///
/// A ray that starts in a box hits it at its origin. Rays miss a box that does not exist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boxes<'b>(pub &'b [Aabb]);

impl Primitives for Boxes<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.0.get(index as usize).copied()
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        let inside = self.0.get(index as usize)?.clip(&SlabRay::new(ray), span)?;
        Some(Hit { t: inside.min, instance: 0, primitive: index, uv: [0.0; 2] })
    }

    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        self.0.get(index as usize).map_or(PrimitiveGeometry::Opaque, |aabb| PrimitiveGeometry::Box(*aabb))
    }
}

/// Row of 100 boxes, 0.5 wide and 1 apart.
#[cfg(test)]
pub(crate) fn row() -> Vec<Aabb> {
    let corners = (0..100).map(|index| glam::DVec3::X * f64::from(index));
    corners.map(|corner| Aabb::new(corner, corner + 0.5)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Accelerator as _, AcceleratorKind, AnyAccelerator, NoProbe};

    #[test]
    fn a_box_is_among_all_hits_of_a_ray_once() {
        let boxes =
            [Aabb::new(glam::DVec3::ZERO, glam::DVec3::ONE), Aabb::new(glam::DVec3::NEG_ONE, glam::DVec3::splat(-0.5))];
        for &kind in AcceleratorKind::ALL {
            let accelerator = AnyAccelerator::build(kind, &Boxes(&boxes)).expect("a tree");
            for (z, t) in [(3.0, 2.0), (0.5, 0.0)] {
                let ray = Ray::new(glam::DVec3::new(0.5, 0.5, z), glam::DVec3::NEG_Z);
                let mut hits = Vec::new();
                accelerator.all_hits(&Boxes(&boxes), &ray, Interval::FORWARD, &mut hits, &mut NoProbe);
                let found: Vec<_> = hits.iter().map(|hit| (hit.primitive, hit.t)).collect();
                assert_eq!(found, [(0, t)], "{kind:?}");
            }
        }
    }

    #[test]
    fn boxes_that_do_not_exist_are_missed() {
        let boxes = row();
        let (all, few) = (Boxes(&boxes), Boxes(&boxes[..3]));
        let ray = Ray::new(glam::DVec3::new(200.0, 0.25, 0.25), glam::DVec3::NEG_X);
        assert_eq!((few.bounds(9), few.intersect(9, &ray, Interval::FORWARD)), (None, None));
        assert_eq!(few.geometry(9), PrimitiveGeometry::Opaque);
        for &kind in AcceleratorKind::ALL {
            let accelerator = AnyAccelerator::build(kind, &all).expect("a tree");
            let hit = accelerator.closest(&few, &ray, Interval::FORWARD, &mut NoProbe);
            assert_eq!(hit.map(|hit| hit.primitive), Some(2), "{kind:?}");
        }
    }
}
