//! What every structure can do beyond [`Accelerator`].

use core::ops::ControlFlow;

use crate::{Accelerator, BuildStats, PointHit, RayQuery, Region, RegionQuery, ValidationError};
use glam::DVec3;
use rt_geometry::{ClosestPoint, Hit, Primitives, Probe};
use rt_math::{Aabb, Interval, Ray};

use crate::ray_query::{All, Candidates, First};
use crate::region_query::{Nearest, Overlapping};

/// An acceleration structure with all its queries.
///
/// A structure has two walks: [`walk`](Self::walk) along a ray, and [`search`](Self::search) through a part of space.
/// All queries are made of these, and answer alike for every structure, bit for bit. None allocates, but for the
/// growth of a list that the caller hands in; one with room for twice the hits never grows.
///
/// Every query must be given the primitives that the structure was built over.
pub trait AcceleratorQueries: Accelerator {
    /// Offers the query, roughly in the order of the ray, every primitive that can matter to it: at least all whose
    /// own boxes the ray passes within what the query's span is at that time. `Break` if the query broke off.
    fn walk<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()>;

    /// Offers the query, roughly from near to far, every primitive that can matter to it: at least all whose boxes
    /// overlap what the query's bounds are at that time and are within its reach. `Break` if the query broke off.
    fn search<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()>;

    /// Bytes held, on the heap and off it.
    fn memory(&self) -> usize;

    /// Size and shape.
    fn build_stats(&self) -> BuildStats;

    /// Checks that the structure fits the primitives, and all that its walks rely on.
    ///
    /// # Errors
    ///
    /// The first [`ValidationError`] found.
    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError>;

    /// Visits a box around every node and leaf, or cell that is not empty, with its depth: for pictures.
    fn for_each_box(&self, visit: impl FnMut(Aabb, u32));

    /// All hits within `span`, in order of (t, instance, primitive), each once; `hits` is cleared first. A primitive
    /// that is met several times, as a sphere is, reports each time. A `Primitives` over structures of its own reports
    /// one hit of each at the same `t`.
    fn all_hits<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        hits: &mut Vec<Hit>,
        probe: &mut S,
    ) {
        let mut query = All::new(ray, span, hits);
        let _ = self.walk(primitives, &mut query, probe);
        query.finish();
    }

    /// The first hits within `span`, as many as there is room for, in the order of [`all_hits`](Self::all_hits); the
    /// rest of `hits` is `None`. Returns their number. Stops where no earlier hit can follow, so that a few hits cost
    /// little more than one (Gribble, Naveros and Kerzner, "Multi-Hit Ray Traversal", JCGT 3(1), 2014).
    fn first_hits<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        hits: &mut [Option<Hit>],
        probe: &mut S,
    ) -> usize {
        let mut query = First::new(ray, span, hits);
        let _ = self.walk(primitives, &mut query, probe);
        query.found
    }

    /// Visits every primitive whose own box the ray passes, roughly in order, with the part of the ray inside, until
    /// `visit` breaks. What it returns otherwise shortens the span: return the `t` of a hit, or ∞. Only the boxes of
    /// the primitives are looked at, never their kernels; [`Boxes`](crate::Boxes) makes primitives of boxes alone.
    ///
    /// Structures that divide space may visit a primitive several times.
    fn visit_candidates<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        visit: impl FnMut(u32, Interval) -> ControlFlow<(), f64>,
        probe: &mut S,
    ) {
        let _ = self.walk(primitives, &mut Candidates::new(ray, span, visit), probe);
    }

    /// Visits every primitive whose bounds overlap a region, once each and in no promised order, until `visit` breaks.
    /// Unbounded primitives overlap everything.
    fn visit_overlapping<P: Primitives>(
        &self,
        primitives: &P,
        region: &impl Region,
        visit: impl FnMut(u32) -> ControlFlow<()>,
    ) {
        let _ = self.search(&mut Overlapping::new(primitives, region, visit));
    }

    /// Visits every pair of primitives whose bounds overlap, once each with the lower index first, by rising lower
    /// index, until `visit` breaks: the broad phase of collision detection.
    fn visit_overlapping_pairs<P: Primitives>(
        &self,
        primitives: &P,
        mut visit: impl FnMut(u32, u32) -> ControlFlow<()>,
    ) {
        const EVERYWHERE: Aabb = Aabb::new(DVec3::NEG_INFINITY, DVec3::INFINITY);
        let mut flow = ControlFlow::Continue(());
        for lower in 0..primitives.len() as u32 {
            let around = primitives.bounds(lower).unwrap_or(EVERYWHERE);
            self.visit_overlapping(primitives, &around, |other| {
                if other > lower {
                    flow = visit(lower, other);
                }
                flow
            });
            if flow.is_break() {
                return;
            }
        }
    }

    /// The nearest point of any primitive within `radius` (inclusively), which may be infinite; `None` if there is
    /// none, and for NaN.
    fn nearest_point<P: ClosestPoint>(&self, primitives: &P, point: DVec3, radius: f64) -> Option<PointHit> {
        let mut query = Nearest::new(primitives, point, radius);
        let _ = self.search(&mut query);
        query.finish()
    }
}

/// A structure that can follow its primitives when they move. Those that divide space are built anew instead.
pub trait Refit: AcceleratorQueries {
    /// Fits all boxes to the primitives as they are now, and keeps the tree: faster than building, and as right, but
    /// the farther primitives have moved apart, the slower the queries. O(n).
    ///
    /// # Errors
    ///
    /// As building, and if the number of primitives or which of them are unbounded has changed. The structure is
    /// then as it was.
    fn refit<P: Primitives>(&mut self, primitives: &P) -> Result<(), crate::BuildError>;
}

/// Implements [`Accelerator`] by the walk of a structure.
macro_rules! accelerator_by_walk {
    ($structure:ty $(, $($parameter:ident: $bound:path),+)?) => {
        impl $(<$($parameter: $bound),+>)? crate::Accelerator for $structure {
            fn closest<P: rt_geometry::Primitives, S: rt_geometry::Probe>(
                &self,
                primitives: &P,
                ray: &rt_math::Ray,
                span: rt_math::Interval,
                probe: &mut S,
            ) -> Option<rt_geometry::Hit> {
                let mut query = $crate::ray_query::Closest::new(ray, span);
                let _ = $crate::AcceleratorQueries::walk(self, primitives, &mut query, probe);
                query.hit
            }

            fn occluded<P: rt_geometry::Primitives, S: rt_geometry::Probe>(
                &self,
                primitives: &P,
                ray: &rt_math::Ray,
                span: rt_math::Interval,
                probe: &mut S,
            ) -> bool {
                $crate::AcceleratorQueries::walk(self, primitives, &mut $crate::ray_query::Any::new(ray, span), probe).is_break()
            }
        }
    };
}

pub(crate) use accelerator_by_walk;
