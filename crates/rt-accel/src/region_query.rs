//! Queries in a region: overlapping primitives, and the nearest point.

use core::ops::ControlFlow;

use glam::DVec3;
use rt_geometry::{ClosestPoint, Primitives, padded_bounds};
use rt_math::Aabb;

use crate::Region;

/// Query in a region. An [`Accelerator`](crate::Accelerator) passes it primitives to test; the query reports the boxes
/// that can still matter.
pub trait RegionQuery {
    /// Bounds of the region that can still contain results. They may shrink from test to test if `test_primitive`
    /// ignores `is_owner`.
    fn bounds(&self) -> Aabb;

    /// Point to start from. May be NaN.
    fn query_point(&self) -> DVec3;

    /// Distance of a box, by which boxes are visited in rising order; `None` if it can contain no result. Monotone: a
    /// box within another is no nearer. An accelerator that lists primitives several times must not cull boxes that
    /// overlap `bounds` by this.
    fn distance_to(&self, aabb: &Aabb) -> Option<f64>;

    /// Tests a primitive. An accelerator that lists it in several cells may test it in each. `is_owner` is true for a
    /// point if the current cell owns it, and exactly one cell owns a point. `Break` once the result is final.
    fn test_primitive(&mut self, index: u32, is_owner: impl FnOnce(DVec3) -> bool) -> ControlFlow<()>;

    /// Tests all primitives of a list that are listed nowhere else.
    #[inline]
    fn test_leaf(&mut self, indices: &[u32]) -> ControlFlow<()> {
        for &index in indices {
            self.test_primitive(index, |_| true)?;
        }
        ControlFlow::Continue(())
    }
}

/// Primitives whose bounds overlap a region.
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
            // The minimum corner of the intersection of both boxes is owned by exactly one cell.
            Some(bounds) => self.region.overlaps(&bounds) && is_owner(bounds.min.max(self.region.bounds().min)),
            None => true,
        };
        if overlaps { (self.visit)(index) } else { ControlFlow::Continue(()) }
    }
}

/// Result of a nearest-point query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointHit {
    /// The nearest point of any primitive.
    pub point: DVec3,
    /// Distance from the query point.
    pub distance: f64,
    /// Index of the instance; 0 without instances.
    pub instance: u32,
    /// Primitive of the point; the lowest index on a tie.
    pub primitive: u32,
}

/// Largest number whose rounded root is no more than `radius`. The root of a squared distance is reported as the distance.
fn largest_square(radius: f64) -> f64 {
    // The root of the rounded square is the radius, unless digits underflow. An infinite square is that of all large distances.
    let mut square = radius * radius;
    while square.is_finite() && square.sqrt() > radius {
        square = square.next_down();
    }
    while square.is_finite() && square.next_up().sqrt() <= radius {
        square = square.next_up();
    }
    square
}

/// The primitive nearest to a point.
pub(crate) struct Nearest<'p, P> {
    primitives: &'p P,
    point: DVec3,
    /// Largest squared distance within the radius, later the smallest found. Inclusive: an equally near primitive must still be
    /// found.
    limit: f64,
    found: Option<(u32, DVec3)>,
}

impl<'p, P: ClosestPoint> Nearest<'p, P> {
    pub(crate) fn new(primitives: &'p P, point: DVec3, radius: f64) -> Self {
        let limit = if radius >= 0.0 && point.is_finite() { largest_square(radius) } else { f64::NAN };
        Self { primitives, point, limit, found: None }
    }

    pub(crate) fn finish(self) -> Option<PointHit> {
        let (primitive, point) = self.found?;
        Some(PointHit { point, distance: self.limit.sqrt(), instance: 0, primitive })
    }
}

impl<P: ClosestPoint> RegionQuery for Nearest<'_, P> {
    fn bounds(&self) -> Aabb {
        // The square of a root that is half a rounding error larger is no less than the limit.
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
        if point.is_nan() {
            return ControlFlow::Continue(());
        }
        // No point counts as nearer than the padded bounds, so that no box around them is culled too early.
        let own = padded_bounds(self.primitives, index).map_or(0.0, |own| own.distance_squared(self.point));
        let distance = point.distance_squared(self.point).max(own);
        // An infinite square is of no distance that is known.
        let is_tie = || distance.is_finite() && self.found.is_none_or(|(nearest, _)| index < nearest);
        let wins = distance < self.limit || (distance == self.limit && is_tie());
        if wins {
            self.limit = distance;
            self.found = Some((index, point));
        }
        ControlFlow::Continue(())
    }
}
