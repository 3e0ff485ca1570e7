//! Configuration of a build, and merging of primitives that are cheaper in one leaf than in two, before and during the top-down build.
//!
//! Neighbours in the list are mostly neighbours in space, as the halves of quadrilaterals are. Merging them first
//! leaves little more than half of the references, and the tree is about as good.

use super::binning::{Axes, NormalizedArea};
use super::collapse::{Costs, leaf_cost};
use super::leaf_policy::LeafPolicy;
use super::params::{BuildParams, Quality};
use super::prim_ref::PrimRef;
use crate::bvh::Aabb32;

/// Configuration of a build.
#[derive(Clone, Copy, Debug)]
pub(super) struct BuildConfig {
    pub(super) unit: NormalizedArea,
    pub(super) axes: Axes,
    pub(super) leaf_policy: LeafPolicy,
    /// True if neighbours in the list are merged before the build.
    pub(super) pairs: bool,
    pub(super) max_leaf: usize,
}

impl BuildConfig {
    /// Configuration for primitives within this box.
    pub(super) fn new(extent: &Aabb32, params: &BuildParams) -> Self {
        let (axes, leaf_policy) = match params.quality {
            Quality::Low => (Axes::Widest, LeafPolicy::GREEDY),
            Quality::Medium => (Axes::All, LeafPolicy::LOOSE),
            Quality::High => (Axes::All, LeafPolicy::STRICT),
        };
        let pairs = params.quality != Quality::High;
        Self { unit: NormalizedArea::new(extent), axes, leaf_policy, pairs, max_leaf: params.leaf_limit() }
    }

    /// Appends a reference, or merges it with the last one if it follows that and two leaves would cost no less.
    #[inline(always)]
    pub(super) fn push(&self, references: &mut Vec<PrimRef>, next: PrimRef) {
        let last = references.last_mut().filter(|_| self.pairs);
        match last.and_then(|last| Some((self.try_pair(last, &next)?, last))) {
            Some((pair, last)) => *last = pair,
            None => references.push(next),
        }
    }

    #[inline(always)]
    fn try_pair(&self, a: &PrimRef, b: &PrimRef) -> Option<PrimRef> {
        let both = a.bounds().union(b.bounds());
        let apart = self.leaf_cost(a) + self.leaf_cost(b);
        let pays = leaf_cost(self.unit.area(&both), 2) <= apart;
        let (a_run, b_run) = (a.run(), b.run());
        let follows = (a_run.count, b_run.count) == (1, 1) && b_run.first.checked_sub(a_run.first) == Some(1);
        (pays && follows && self.max_leaf > 1).then(|| a.merge(&both))
    }

    /// Cost of a leaf, if a split of the range would not reduce it enough.
    pub(super) fn leaf(&self, references: &[PrimRef], area: f32) -> Option<Costs> {
        if references.len() > self.leaf_policy.few {
            return None;
        }
        let count = references.iter().map(|reference| reference.run().count).sum();
        let apart: f32 = references.iter().map(|reference| self.leaf_cost(reference)).sum();
        let limit = if references.len() > 2 { self.leaf_policy.limit * apart } else { apart };
        let is_leaf = references.len() == 1 || count as usize <= self.max_leaf && leaf_cost(area, count) <= limit;
        is_leaf.then(|| Costs::leaf(area, count))
    }

    fn leaf_cost(&self, reference: &PrimRef) -> f32 {
        leaf_cost(self.unit.area(&reference.bounds()), reference.run().count)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;
    use crate::wide::build::prim_ref::PrimRange;

    fn at(x: f32, index: u32) -> PrimRef {
        PrimRef::new(Aabb32 { min: Vec3A::new(x, 0.0, 0.0), max: Vec3A::new(x + 1.0, 1.0, 0.0) }, index)
    }

    fn paired(references: Vec<PrimRef>, max_leaf: usize) -> Vec<PrimRange> {
        let unit = NormalizedArea::new(&Aabb32 { min: Vec3A::ZERO, max: Vec3A::splat(10.0) });
        let config = BuildConfig { unit, axes: Axes::All, leaf_policy: LeafPolicy::STRICT, pairs: true, max_leaf };
        let mut list = Vec::new();
        references.into_iter().for_each(|reference| config.push(&mut list, reference));
        list.iter().map(PrimRef::run).collect()
    }

    #[test]
    fn neighbours_become_pairs() {
        // 0 and 1 are halves of a square. Two adjacent squares cost 2 · 0.8 together and 2 · 0.7 apart. 3 and 5
        // coincide but are not consecutive, and 6 is alone.
        let references = vec![at(0.0, 0), at(0.0, 1), at(1.0, 2), at(2.0, 3), at(2.0, 5), at(9.0, 6)];
        let runs = paired(references, 8);
        let expected = [(0, 2), (2, 1), (3, 1), (5, 1), (6, 1)];
        assert_eq!(runs, expected.map(|(first, count)| PrimRange { first, count }));
    }

    #[test]
    fn sets_become_leaves_as_hastily_as_they_may() {
        let unit = NormalizedArea::new(&Aabb32 { min: Vec3A::ZERO, max: Vec3A::splat(10.0) });
        let is_leaf = |leaf_policy, set: &[PrimRef]| {
            let config = BuildConfig { unit, axes: Axes::All, leaf_policy, pairs: false, max_leaf: 8 };
            let extent = crate::wide::build::top_down::PrimInfo::of(set);
            config.leaf(set, unit.area(&extent.bounds)).is_some()
        };
        let row = |count: u32, step: f32| -> Vec<_> { (0..count).map(|i| at(step * i as f32, i)).collect() };
        let hastes = [LeafPolicy::STRICT, LeafPolicy::LOOSE, LeafPolicy::GREEDY];
        // A leaf of n squares that cover l of them costs l · (0.6 + 0.1n), and n leaves of one cost 0.7n.
        for (set, expected) in [
            (row(1, 0.0), [true; 3]),
            (row(2, 0.0), [true; 3]),
            (row(2, 1.0), [false; 3]),
            (row(3, 0.0), [true; 3]),
            // 2.7 of 2.1.
            (row(3, 1.0), [false, true, true]),
            // 4.5 of 2.1.
            (row(3, 2.0), [false, false, true]),
            // 1.1 of 3.5, but five exceed the strict maximum.
            (row(5, 0.0), [false, true, true]),
            (row(9, 0.0), [false; 3]),
        ] {
            assert_eq!(hastes.map(|leaf_policy| is_leaf(leaf_policy, &set)), expected, "{set:?}");
        }
        let point = |index| PrimRef::new(Aabb32 { min: Vec3A::ONE, max: Vec3A::ONE }, index);
        let points: Vec<_> = (0..4).map(point).collect();
        assert_eq!(hastes.map(|leaf_policy| is_leaf(leaf_policy, &points)), [true; 3], "without area");
    }

    #[test]
    fn pairs_overlap_enough() {
        // 1.5 · 0.8 together, and 2 · 0.7 apart.
        assert_eq!(paired(vec![at(0.0, 0), at(0.5, 1)], 8), [PrimRange { first: 0, count: 2 }]);
        assert_eq!(paired(vec![at(0.0, 0), at(0.5, 1)], 1).len(), 2, "no leaf may hold two");
    }
}
