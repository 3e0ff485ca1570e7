//! Acceleration structures and their queries.

use core::ops::ControlFlow;

use glam::DVec3;
use rt_geometry::{ClosestPoint, Hit, HitStream, Primitives, Probe, RayStream};
use rt_math::{Aabb, Interval, Ray};

use crate::error::{BuildError, ValidationError};
use crate::ray_query::{AllHits, AnyHit, Candidates, Closest, FirstHits, RayQuery};
use crate::region::Region;
use crate::region_query::{Nearest, Overlapping, PointHit, RegionQuery};
use crate::stats::BuildStats;

/// Acceleration structure over primitives.
///
/// It holds indices and boxes only and borrows the primitives for each query. Every query must be given the primitives
/// that the accelerator was built over.
///
/// Every implementation returns **the same bits** as a test of each primitive. It culls only by boxes that contain the
/// primitives' padded bounds, and accepts hits through [`intersect_primitive`](rt_geometry::intersect_primitive) only.
/// Ties in `t` resolve to the lower (instance, primitive).
///
/// All queries are built on two traversals: [`traverse_ray`](Self::traverse_ray) along a ray, and
/// [`traverse_region`](Self::traverse_region) through a part of space. None allocates, except for the growth of a list
/// of hits that the caller passes in. A list with capacity for twice the hits never grows. Streams of rays through instances may keep memory
/// in each thread ([`with_stream_buffers`](rt_geometry::with_stream_buffers)).
pub trait Accelerator: Sync {
    /// Tests the primitives that can matter to the query, roughly in the order of the ray. These are at least those
    /// whose padded bounds the ray passes within the current span of the query. `Break` if the query ended early.
    fn traverse_ray<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()>;

    /// Tests the primitives that can matter to the query, roughly from near to far. These are at least those whose
    /// bounds overlap the current bounds of the query, at a distance that it does not cull. `Break` if the query ended
    /// early.
    fn traverse_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()>;

    /// Memory in bytes, including `size_of::<Self>()`.
    fn memory(&self) -> usize;

    /// Size and shape.
    fn build_stats(&self) -> BuildStats;

    /// Checks that the accelerator fits the primitives, and all assumptions of the traversals.
    ///
    /// # Errors
    ///
    /// The first [`ValidationError`] found.
    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError>;

    /// Visits the bounds of all nodes and leaves, or of non-empty cells, with their depth.
    fn for_each_box(&self, visit: impl FnMut(Aabb, u32));

    /// The closest hit within `span`.
    fn closest<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        let mut query = Closest::new(ray, span);
        let _ = self.traverse_ray(primitives, &mut query, probe);
        query.hit
    }

    /// True if any primitive occludes the ray within `span`. Ends at any occluder.
    fn occluded<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        self.traverse_ray(primitives, &mut AnyHit::new(ray, span), probe).is_break()
    }

    /// [`closest`](Self::closest) for the rays of a stream, with identical results. Put rays that start and run next to each other in
    /// successive places.
    ///
    /// ```
    /// use rt_accel::{Aabb, Accelerator, Boxes, Bvh, DVec3, HitStream, Interval, NoProbe, Ray, RayStream};
    ///
    /// let boxes = [0.0, 2.0].map(|x| Aabb::new(DVec3::new(x, 0.0, 0.0), DVec3::new(x + 1.0, 1.0, 1.0)));
    /// let tree = Bvh::build(&Boxes(&boxes))?;
    /// let mut rays = RayStream::default();
    /// for x in [0.5, 1.5, 2.5] {
    ///     rays.push(&Ray::new(DVec3::new(x, 0.5, -1.0), DVec3::Z), Interval::FORWARD);
    /// }
    /// let mut hits = HitStream::default();
    /// tree.closest_stream(&Boxes(&boxes), &rays, &mut hits, &mut NoProbe);
    /// let primitives = [0, 1, 2].map(|at| hits.get(at).map(|hit| hit.primitive));
    /// assert_eq!(primitives, [Some(0), None, Some(1)]);
    /// # Ok::<(), rt_accel::BuildError>(())
    /// ```
    fn closest_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        hits: &mut HitStream,
        probe: &mut S,
    ) {
        closest_one_by_one(self, primitives, rays, hits, probe);
    }

    /// [`occluded`](Self::occluded) for the rays of a stream, with identical results. Drops results beyond the slice, and
    /// leaves entries beyond the stream as they are.
    fn occluded_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        occluded: &mut [bool],
        probe: &mut S,
    ) {
        occluded_one_by_one(self, primitives, rays, occluded, probe);
    }

    /// All hits within `span`, each once, in order of (t, instance, primitive); clears `hits` first. A primitive with
    /// several intersections, such as a sphere, reports each. One that fills space, with hits at eight or more successive
    /// numbers, reports the first. `Primitives` over accelerators of their own report one
    /// hit of each at the same `t`.
    fn all_hits<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        hits: &mut Vec<Hit>,
        probe: &mut S,
    ) {
        let mut query = AllHits::new(ray, span, hits);
        let _ = self.traverse_ray(primitives, &mut query, probe);
        query.finish();
    }

    /// The first `hits.len()` of [`all_hits`](Self::all_hits); sets the rest of `hits` to `None`. Returns the number of
    /// hits. Ends where no earlier hit can follow (Gribble, Naveros and Kerzner, "Multi-Hit Ray Traversal", JCGT 3(1),
    /// 2014).
    fn first_hits<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        hits: &mut [Option<Hit>],
        probe: &mut S,
    ) -> usize {
        let mut query = FirstHits::new(ray, span, hits);
        let _ = self.traverse_ray(primitives, &mut query, probe);
        query.found
    }

    /// Visits the primitives whose padded bounds the ray passes, roughly in order, with the part of the ray inside,
    /// until `visit` breaks. Its value shortens the span: return the `t` of a hit, or ∞. Tests the bounds only, never
    /// the kernels of the primitives; [`Boxes`](crate::Boxes) are primitives without kernels.
    ///
    /// Accelerators that divide space may visit a primitive several times.
    fn visit_candidates<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        visit: impl FnMut(u32, Interval) -> ControlFlow<(), f64>,
        probe: &mut S,
    ) {
        let _ = self.traverse_ray(primitives, &mut Candidates::new(ray, span, visit), probe);
    }

    /// Visits each primitive whose bounds overlap a region once, in unspecified order, until `visit` breaks.
    /// Unbounded primitives overlap every region.
    fn visit_overlapping<P: Primitives>(
        &self,
        primitives: &P,
        region: &impl Region,
        visit: impl FnMut(u32) -> ControlFlow<()>,
    ) {
        let _ = self.traverse_region(&mut Overlapping::new(primitives, region, visit));
    }

    /// Visits each pair of primitives whose bounds overlap once, the lower index first, by rising lower index, until
    /// `visit` breaks. This is the broad phase of collision detection.
    fn visit_overlapping_pairs<P: Primitives>(
        &self,
        primitives: &P,
        mut visit: impl FnMut(u32, u32) -> ControlFlow<()>,
    ) {
        const EVERYWHERE: Aabb = Aabb::new(DVec3::NEG_INFINITY, DVec3::INFINITY);
        let mut flow = ControlFlow::Continue(());
        for lower in 0..primitives.len() as u32 {
            let bounds = primitives.bounds(lower).unwrap_or(EVERYWHERE);
            self.visit_overlapping(primitives, &bounds, |other| {
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

    /// The nearest point of any primitive within `radius`, inclusive and possibly infinite. `None` without one, and for
    /// NaN. Primitives so far away that the square of their distance overflows do not count.
    fn nearest_point<P: ClosestPoint>(&self, primitives: &P, point: DVec3, radius: f64) -> Option<PointHit> {
        let mut query = Nearest::new(primitives, point, radius);
        let _ = self.traverse_region(&mut query);
        query.finish()
    }
}

/// [`closest_stream`](Accelerator::closest_stream) by single queries.
pub(crate) fn closest_one_by_one<A: Accelerator + ?Sized, P: Primitives, S: Probe>(
    accelerator: &A,
    primitives: &P,
    rays: &RayStream,
    hits: &mut HitStream,
    probe: &mut S,
) {
    for at in 0..rays.len() {
        let (ray, span) = rays.get(at);
        hits.set(at, accelerator.closest(primitives, &ray, span, probe).as_ref());
    }
}

/// [`occluded_stream`](Accelerator::occluded_stream) by single queries.
pub(crate) fn occluded_one_by_one<A: Accelerator + ?Sized, P: Primitives, S: Probe>(
    accelerator: &A,
    primitives: &P,
    rays: &RayStream,
    occluded: &mut [bool],
    probe: &mut S,
) {
    for (at, occluded) in occluded.iter_mut().enumerate().take(rays.len()) {
        let (ray, span) = rays.get(at);
        *occluded = accelerator.occluded(primitives, &ray, span, probe);
    }
}

/// Accelerator that can follow moving primitives. Accelerators that divide space are rebuilt instead.
pub trait Refit: Accelerator {
    /// Fits all bounds to the current primitives and keeps the topology. Faster than building, with the same results,
    /// but queries slow down as primitives move apart. O(n).
    ///
    /// # Errors
    ///
    /// Those of building, and a change in the number of primitives or in the set of unbounded ones. The accelerator is
    /// unchanged then.
    fn refit<P: Primitives>(&mut self, primitives: &P) -> Result<(), BuildError>;
}
