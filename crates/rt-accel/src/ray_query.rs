//! Queries along a ray. The only place where accelerators test primitives.

use core::cmp::Ordering;
use core::ops::ControlFlow;
use std::alloc::{Layout, handle_alloc_error};
use std::collections::TryReserveError;

use rt_geometry::{
    Hit, PrimitiveGeometry as Geometry, Primitives, Probe, intersect_primitive, occludes_primitive, padded_bounds,
};
use rt_math::{Interval, Ray, SlabRay};

/// Query along a ray. An [`Accelerator`](crate::Accelerator) passes it primitives to test; the query reports how much
/// of the ray can still matter.
pub trait RayQuery {
    /// Ray of the query.
    fn ray(&self) -> &SlabRay;

    /// Part of the ray that can still matter. `max` may shrink from test to test; `min` is constant.
    fn span(&self) -> Interval;

    /// Tests a primitive. Repeated tests have no effect. `Break` once the result is final.
    fn test_primitive<P: Primitives, S: Probe>(&mut self, primitives: &P, index: u32, probe: &mut S)
    -> ControlFlow<()>;

    /// Tests all primitives of a list.
    #[inline(always)]
    fn test_leaf<P: Primitives, S: Probe>(
        &mut self,
        primitives: &P,
        indices: &[u32],
        probe: &mut S,
    ) -> ControlFlow<()> {
        for &index in indices {
            self.test_primitive(primitives, index, probe)?;
        }
        ControlFlow::Continue(())
    }
}

/// True if all components of the ray are finite. The culling arithmetic is proven for such rays only; other rays are
/// tested against every primitive, so that all accelerators return the same results.
#[inline]
pub(crate) fn is_finite(ray: &Ray) -> bool {
    ray.origin.is_finite() && ray.direction.is_finite()
}

/// Methods `ray` and `span` of a [`RayQuery`] with fields of these names.
macro_rules! ray_and_span {
    () => {
        #[inline(always)]
        fn ray(&self) -> &SlabRay {
            &self.ray
        }

        #[inline(always)]
        fn span(&self) -> Interval {
            self.span
        }
    };
}
pub(crate) use ray_and_span;

/// Closest hit.
pub(crate) struct Closest {
    ray: SlabRay,
    /// Ends at the closest hit, inclusive: an equally near primitive of lower index must still be found.
    span: Interval,
    pub(crate) hit: Option<Hit>,
}

impl Closest {
    #[inline]
    pub(crate) fn new(ray: &Ray, span: Interval) -> Self {
        Self { ray: SlabRay::new(ray), span, hit: None }
    }
}

impl RayQuery for Closest {
    ray_and_span!();

    #[inline(always)]
    fn test_primitive<P: Primitives, S: Probe>(
        &mut self,
        primitives: &P,
        index: u32,
        probe: &mut S,
    ) -> ControlFlow<()> {
        if let Some(hit) = intersect_primitive(primitives, index, &self.ray, self.span, probe)
            && self.hit.is_none_or(|nearest| hit.precedes(&nearest))
        {
            self.span.max = hit.t;
            self.hit = Some(hit);
        }
        ControlFlow::Continue(())
    }
}

/// Any hit. `Break` means that the ray is occluded.
pub(crate) struct AnyHit {
    ray: SlabRay,
    span: Interval,
}

impl AnyHit {
    #[inline]
    pub(crate) fn new(ray: &Ray, span: Interval) -> Self {
        Self { ray: SlabRay::new(ray), span }
    }
}

impl RayQuery for AnyHit {
    ray_and_span!();

    #[inline(always)]
    fn test_primitive<P: Primitives, S: Probe>(
        &mut self,
        primitives: &P,
        index: u32,
        probe: &mut S,
    ) -> ControlFlow<()> {
        if occludes_primitive(primitives, index, &self.ray, self.span, probe) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// Number of hits of one primitive at successive floating-point numbers that tell of a primitive that fills space. It has one hit: the
/// first of them.
const TOO_MANY_IN_A_ROW: usize = 8;

/// Visits the hits of one primitive by rising `t`, until `visit` breaks.
#[inline]
fn for_each_hit<P: Primitives, S: Probe>(
    primitives: &P,
    index: u32,
    ray: &SlabRay,
    mut span: Interval,
    probe: &mut S,
    mut visit: impl FnMut(Hit) -> ControlFlow<()>,
) {
    // Hits in a row, behind the one that was visited.
    let mut waiting = [Hit { t: 0.0, instance: 0, primitive: 0, uv: [0.0; 2] }; TOO_MANY_IN_A_ROW];
    let (mut n_waiting, mut is_first) = (0, true);
    while let Some(hit) = intersect_primitive(primitives, index, ray, span, probe) {
        if !is_first && hit.t == span.min {
            waiting[n_waiting] = hit;
            n_waiting += 1;
            if n_waiting == TOO_MANY_IN_A_ROW {
                return;
            }
        } else {
            let are_visited = waiting[..n_waiting].iter().all(|hit| visit(*hit).is_continue());
            n_waiting = 0;
            // A ray hits a triangle once.
            let is_only_one =
                || matches!(primitives.geometry(index), Geometry::Triangle(_) | Geometry::ExactTriangle(_));
            if !are_visited || visit(hit).is_break() || is_only_one() {
                return;
            }
        }
        is_first = false;
        span.min = hit.t.next_up();
    }
    let _ = waiting[..n_waiting].iter().all(|hit| visit(*hit).is_continue());
}

/// All hits, collected in any order, possibly twice.
pub(crate) struct AllHits<'h> {
    ray: SlabRay,
    span: Interval,
    hits: &'h mut Vec<Hit>,
    /// Set once the list cannot grow.
    error: Option<TryReserveError>,
}

impl<'h> AllHits<'h> {
    pub(crate) fn new(ray: &Ray, span: Interval, hits: &'h mut Vec<Hit>) -> Self {
        hits.clear();
        Self { ray: SlabRay::new(ray), span, hits, error: None }
    }

    /// Sorts the hits and removes duplicates. The list is empty after an error.
    pub(crate) fn try_finish(mut self) -> Result<(), TryReserveError> {
        if let Some(error) = self.error {
            self.hits.clear();
            return Err(error);
        }
        self.remove_duplicates();
        Ok(())
    }

    /// [`try_finish`](Self::try_finish) for queries that return no error.
    pub(crate) fn finish(self) {
        self.try_finish().unwrap_or_else(|_| abort_without_memory());
    }

    /// Sorts the hits as well.
    fn remove_duplicates(&mut self) {
        sort_hits(self.hits);
        self.hits.dedup_by(|a, b| is_same(a, b));
    }

    fn push(&mut self, hit: Hit) -> ControlFlow<()> {
        if self.hits.len() == self.hits.capacity() {
            self.grow()?;
        }
        self.hits.push(hit);
        ControlFlow::Continue(())
    }

    /// Makes room for at least one hit. `Break` without memory.
    #[cold]
    fn grow(&mut self) -> ControlFlow<()> {
        // Not again: a traversal may pass more primitives after a `Break`.
        if self.error.is_some() {
            return ControlFlow::Break(());
        }
        // Grow the list only if duplicates do not fill it.
        self.remove_duplicates();
        match self.hits.try_reserve(1 + self.hits.len() / 2) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.error = Some(error);
                ControlFlow::Break(())
            }
        }
    }
}

/// Ends the process, as any list does that grows without memory.
pub(crate) fn abort_without_memory() -> ! {
    handle_alloc_error(Layout::new::<Hit>())
}

/// Sorts hits by `t`, ties by instance and primitive.
pub(crate) fn sort_hits(hits: &mut [Hit]) {
    hits.sort_unstable_by(|a, b| {
        if a.precedes(b) {
            Ordering::Less
        } else if b.precedes(a) {
            Ordering::Greater
        } else {
            Ordering::Equal
        }
    });
}

/// True if both records are of one hit.
pub(crate) fn is_same(a: &Hit, b: &Hit) -> bool {
    (a.t, a.instance, a.primitive) == (b.t, b.instance, b.primitive)
}

impl RayQuery for AllHits<'_> {
    ray_and_span!();

    fn test_primitive<P: Primitives, S: Probe>(
        &mut self,
        primitives: &P,
        index: u32,
        probe: &mut S,
    ) -> ControlFlow<()> {
        let (ray, span) = (self.ray, self.span);
        let mut flow = ControlFlow::Continue(());
        for_each_hit(primitives, index, &ray, span, probe, |hit| {
            flow = self.push(hit);
            flow
        });
        flow
    }
}

/// The first hits, up to the length of a slice.
pub(crate) struct FirstHits<'h> {
    ray: SlabRay,
    /// Ends at the last hit once the slice is full, inclusive.
    span: Interval,
    /// The first `found` elements are set, in order.
    hits: &'h mut [Option<Hit>],
    pub(crate) found: usize,
}

impl<'h> FirstHits<'h> {
    pub(crate) fn new(ray: &Ray, span: Interval, hits: &'h mut [Option<Hit>]) -> Self {
        hits.fill(None);
        Self { ray: SlabRay::new(ray), span, hits, found: 0 }
    }

    /// Inserts a hit in order. `Break` if neither this hit nor a later one fits.
    fn insert(&mut self, hit: Hit) -> ControlFlow<()> {
        let filled = &self.hits[..self.found];
        let place = filled.partition_point(|known| known.is_some_and(|known| known.precedes(&hit)));
        if place == self.hits.len() {
            return ControlFlow::Break(());
        }
        if self.hits[place].is_some_and(|known| is_same(&known, &hit)) {
            return ControlFlow::Continue(());
        }
        self.found = (self.found + 1).min(self.hits.len());
        self.hits[place..self.found].rotate_right(1);
        self.hits[place] = Some(hit);
        if let Some(Some(last)) = self.hits.last() {
            self.span.max = last.t;
        }
        ControlFlow::Continue(())
    }
}

impl RayQuery for FirstHits<'_> {
    ray_and_span!();

    fn test_primitive<P: Primitives, S: Probe>(
        &mut self,
        primitives: &P,
        index: u32,
        probe: &mut S,
    ) -> ControlFlow<()> {
        if self.hits.is_empty() {
            return ControlFlow::Break(());
        }
        let (ray, span) = (self.ray, self.span);
        for_each_hit(primitives, index, &ray, span, probe, |hit| self.insert(hit));
        ControlFlow::Continue(())
    }
}

/// Primitives whose padded bounds the ray passes.
pub(crate) struct Candidates<F> {
    ray: SlabRay,
    span: Interval,
    visit: F,
}

impl<F: FnMut(u32, Interval) -> ControlFlow<(), f64>> Candidates<F> {
    pub(crate) fn new(ray: &Ray, span: Interval, visit: F) -> Self {
        Self { ray: SlabRay::new(ray), span, visit }
    }
}

impl<F: FnMut(u32, Interval) -> ControlFlow<(), f64>> RayQuery for Candidates<F> {
    ray_and_span!();

    fn test_primitive<P: Primitives, S: Probe>(
        &mut self,
        primitives: &P,
        index: u32,
        probe: &mut S,
    ) -> ControlFlow<()> {
        probe.test();
        let inside = match padded_bounds(primitives, index) {
            Some(own) => own.clip(&self.ray, self.span),
            None => Some(self.span),
        };
        if let Some(inside) = inside {
            let limit = (self.visit)(index, inside)?;
            // A NaN keeps the limit.
            if limit < self.span.max {
                self.span.max = limit;
            }
        }
        ControlFlow::Continue(())
    }
}
