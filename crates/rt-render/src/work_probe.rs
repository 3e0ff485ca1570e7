//! Statistics of accelerators, counted if they matter.

use rt_geometry::{Counters, Probe, RayCounts, RayKind};

/// Probe of an accelerator whose work may matter or not, as known at run time. Integrators are compiled once, and not for each kind of
/// probe. If the work does not matter, accelerators may leave some of it uncounted.
#[derive(Debug, Default)]
pub(crate) struct WorkProbe {
    counters: Counters,
    counts_work: bool,
}

impl WorkProbe {
    /// A probe that counts all work if it matters.
    pub(crate) fn new(counts_work: bool) -> Self {
        Self { counters: Counters::default(), counts_work }
    }

    /// The work if it matters, with the given ray counts.
    pub(crate) fn counters(&self, rays: RayCounts) -> Counters {
        if self.counts_work { self.counters } else { Counters::from(rays) }
    }
}

impl Probe for WorkProbe {
    #[inline]
    fn counts_work(&self) -> bool {
        self.counts_work
    }

    #[inline]
    fn ray(&mut self, kind: RayKind) {
        self.counters.ray(kind);
    }

    #[inline]
    fn node(&mut self) {
        self.counters.node();
    }

    #[inline]
    fn test(&mut self) {
        self.counters.test();
    }

    #[inline]
    fn hit(&mut self) {
        self.counters.hit();
    }

    #[inline]
    fn work(&mut self, nodes: u64, tests: u64, hits: u64) {
        self.counters.work(nodes, tests, hits);
    }
}
