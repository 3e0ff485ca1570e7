//! What can be asked about a part of space: which primitives are in it, and which is nearest.

use core::ops::ControlFlow;

use glam::DVec3;
use rt_geometry::{ClosestPoint, Primitives, padded_bounds};
use rt_math::Aabb;

use crate::Region;

/// A question about a part of space. An [`Accelerator`](crate::Accelerator) offers it primitives, and it says which boxes
/// are worth looking into.
pub trait RegionQuery {
    /// A box around all that can still matter. It may shrink from offer to offer if `test_primitive` ignores its `is_owner`.
    fn bounds(&self) -> Aabb;

    /// Where it is best to begin. May be NaN where that is nowhere in particular.
    fn query_point(&self) -> DVec3;

    /// How far off a box is; the smaller, the sooner it should be looked into. `None` if nothing in it can matter.
    /// Monotone: a box within another is no nearer. A structure that keeps primitives in several places must not leave
    /// out by this what overlaps the `bounds`.
    fn distance_to(&self, aabb: &Aabb) -> Option<f64>;

    /// Takes a primitive into account. A structure that keeps it in several places may offer it from each: `is_owner` says
    /// of a point whether it belongs to the place that offers, and is true of exactly one of them. `Break` once nothing
    /// can change the answer.
    fn test_primitive(&mut self, index: u32, is_owner: impl FnOnce(DVec3) -> bool) -> ControlFlow<()>;

    /// Offers all that are listed, from the only place that lists them.
    #[inline]
    fn test_leaf(&mut self, indices: &[u32]) -> ControlFlow<()> {
        for &index in indices {
            self.test_primitive(index, |_| true)?;
        }
        ControlFlow::Continue(())
    }
}

/// Which primitives have boxes that overlap a region?
pub(crate) struct Overlapping<'p, P, R, F> {
    primitives: &'p P,
    region: R,
    visit: F,
}

impl<'p, P, R, F> Overlapping<'p, P, R, F> {
    pub(crate) fn new(primitives: &'p P, region: R, visit: F) -> Self {
        Self { primitives, region, visit }
    }
}

impl<P: Primitives, R: Region, F: FnMut(u32) -> ControlFlow<()>> RegionQuery for Overlapping<'_, P, R, F> {
    fn bounds(&self) -> Aabb {
        self.region.bounds()
    }

    fn query_point(&self) -> DVec3 {
        self.region.bounds().centre()
    }

    fn distance_to(&self, aabb: &Aabb) -> Option<f64> {
        self.region.overlaps(aabb).then_some(0.0)
    }

    fn test_primitive(&mut self, index: u32, is_owner: impl FnOnce(DVec3) -> bool) -> ControlFlow<()> {
        let overlaps = match self.primitives.bounds(index) {
            // The least corner of what the box has in common with the region's belongs to one place only.
            Some(bounds) => self.region.overlaps(&bounds) && is_owner(bounds.min.max(self.region.bounds().min)),
            None => true,
        };
        if overlaps { (self.visit)(index) } else { ControlFlow::Continue(()) }
    }
}

/// The answer to a nearest-point query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointHit {
    /// The nearest point of any primitive.
    pub point: DVec3,
    /// How far away it is.
    pub distance: f64,
    /// Whose point it is; the lower index where several are equally near.
    pub primitive: u32,
}

/// Which primitive comes nearest to a point?
pub(crate) struct Nearest<'p, P> {
    primitives: &'p P,
    point: DVec3,
    /// The square of the radius, later of the distance found. What is equally near must still be found.
    limit: f64,
    found: Option<(u32, DVec3)>,
}

impl<'p, P: ClosestPoint> Nearest<'p, P> {
    pub(crate) fn new(primitives: &'p P, point: DVec3, radius: f64) -> Self {
        let limit = if radius >= 0.0 { radius * radius } else { f64::NAN };
        Self { primitives, point, limit, found: None }
    }

    pub(crate) fn finish(self) -> Option<PointHit> {
        let (primitive, point) = self.found?;
        Some(PointHit { point, distance: self.limit.sqrt(), primitive })
    }
}

impl<P: ClosestPoint> RegionQuery for Nearest<'_, P> {
    fn bounds(&self) -> Aabb {
        // Half a rounding error more than the root is enough for squares to compare alike.
        let radius = self.limit.sqrt().next_up();
        crate::SphereRegion { centre: self.point, radius }.bounds()
    }

    fn query_point(&self) -> DVec3 {
        self.point
    }

    fn distance_to(&self, aabb: &Aabb) -> Option<f64> {
        let distance = aabb.distance_squared(self.point);
        (distance <= self.limit).then_some(distance)
    }

    fn test_primitive(&mut self, index: u32, _owns: impl FnOnce(DVec3) -> bool) -> ControlFlow<()> {
        let Some(point) = self.primitives.nearest_point(index, self.point) else { return ControlFlow::Continue(()) };
        // As for hits: nothing is nearer than its own box, so that every box around that is looked into in time.
        let own = padded_bounds(self.primitives, index).map_or(0.0, |own| own.distance_squared(self.point));
        let distance = point.distance_squared(self.point).max(own);
        let wins =
            distance < self.limit || (distance == self.limit && self.found.is_none_or(|(nearest, _)| index < nearest));
        if wins {
            self.limit = distance;
            self.found = Some((index, point));
        }
        ControlFlow::Continue(())
    }
}
