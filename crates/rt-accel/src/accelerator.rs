//! The contract of acceleration structures.

use rt_geometry::{Hit, Primitives, Probe};
use rt_math::{Interval, Ray};

/// Finds hits without asking every primitive. A structure holds indices and boxes only and borrows the primitives
/// for each query.
///
/// Every implementation gives **the same bits** as asking each primitive in turn: it culls only by boxes that contain
/// the primitives' own boxes, accepts hits through [`intersect_primitive`](rt_geometry::intersect_primitive) alone, and equal `t` goes to the lower
/// (instance, primitive).
pub trait Accelerator: Sync {
    /// The first hit within `span`, or `None`.
    fn closest<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S)
    -> Option<Hit>;

    /// True if anything blocks the ray within `span`. May stop at any blocker.
    fn occluded<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool;

    /// [`closest`](Self::closest) for many rays: `hits[i]` answers `rays[i]`. Rays beyond the shorter slice are left
    /// alone. The results are those of single queries, bit for bit.
    fn closest_batch<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        hits: &mut [Option<Hit>],
        probe: &mut S,
    ) {
        for ((ray, span), hit) in rays.iter().zip(hits) {
            *hit = self.closest(primitives, ray, *span, probe);
        }
    }

    /// [`occluded`](Self::occluded) for many rays, with the results of single queries.
    fn occluded_batch<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        blocked: &mut [bool],
        probe: &mut S,
    ) {
        for ((ray, span), blocked) in rays.iter().zip(blocked) {
            *blocked = self.occluded(primitives, ray, *span, probe);
        }
    }
}
