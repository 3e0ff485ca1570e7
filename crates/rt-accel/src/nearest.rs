//! The state of a query, and the only place where structures touch primitives.

use rt_math::{Hit, Interval, Primitives, Probe, Ray, SlabRay, decide, decide_occluded};

/// The nearest hit so far and what is left of the span in front of it.
pub(crate) struct Nearest {
    pub(crate) ray: SlabRay,
    /// Ends at the nearest hit, inclusively: an equally near primitive of lower index must still be found.
    pub(crate) span: Interval,
    pub(crate) hit: Option<Hit>,
}

impl Nearest {
    #[inline]
    pub(crate) fn new(ray: &Ray, span: Interval) -> Self {
        Self { ray: SlabRay::new(ray), span, hit: None }
    }

    /// Tests one primitive. Offering it again changes nothing.
    #[inline(always)]
    pub(crate) fn offer<P: Primitives, S: Probe>(&mut self, primitives: &P, index: u32, probe: &mut S) {
        if let Some(hit) = decide(primitives, index, &self.ray, self.span, probe)
            && self.hit.is_none_or(|nearest| hit.precedes(&nearest))
        {
            self.span.max = hit.t;
            self.hit = Some(hit);
        }
    }

    #[inline(always)]
    pub(crate) fn offer_all<P: Primitives, S: Probe>(&mut self, primitives: &P, indices: &[u32], probe: &mut S) {
        for &index in indices {
            self.offer(primitives, index, probe);
        }
    }
}

/// True if any of the listed primitives blocks the ray.
#[inline(always)]
pub(crate) fn any_blocks<P: Primitives, S: Probe>(
    primitives: &P,
    indices: &[u32],
    ray: &SlabRay,
    span: Interval,
    probe: &mut S,
) -> bool {
    indices.iter().any(|&index| decide_occluded(primitives, index, ray, span, probe))
}

/// True if all numbers of the ray are finite. The arithmetic that culls is proven for such rays only; others are
/// answered by exhaustion, which keeps the results of all structures equal.
#[inline]
pub(crate) fn is_finite(ray: &Ray) -> bool {
    ray.origin.is_finite() && ray.direction.is_finite()
}
