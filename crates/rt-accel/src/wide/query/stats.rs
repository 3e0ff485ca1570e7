//! Counters of traversal.

use core::ops::AddAssign;

use rt_geometry::Probe;

/// Counters that are not yet added to the caller's statistics.
#[derive(Default)]
pub(crate) struct TraversalStats {
    pub(in crate::wide) nodes: u64,
    pub(in crate::wide) tests: u64,
    pub(in crate::wide) hits: u64,
}

impl TraversalStats {
    #[inline(always)]
    pub(in crate::wide) fn add_to<S: Probe>(self, probe: &mut S) {
        probe.work(self.nodes, self.tests, self.hits);
    }
}

impl AddAssign for TraversalStats {
    #[inline(always)]
    fn add_assign(&mut self, Self { nodes, tests, hits }: Self) {
        self.nodes += nodes;
        self.tests += tests;
        self.hits += hits;
    }
}
