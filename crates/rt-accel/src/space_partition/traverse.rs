//! Traversal along rays and through regions.

use core::ops::ControlFlow;

use glam::DVec3;
use rt_geometry::{Primitives, Probe};
use rt_math::Interval;

use super::{BspPartition, PartitionNode, SplitPlane};
use crate::traversal::{Descent, traverse};
use crate::{RayQuery, RegionQuery, ray_query::is_finite};

impl<C: SplitPlane> BspPartition<C> {
    pub(crate) fn traverse_ray<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        query.test_leaf(primitives, &self.unbounded, probe)?;
        let slab_ray = *query.ray();
        if is_finite(&slab_ray.ray) {
            let Some(inside) = self.bounds.clip(&slab_ray, query.span()) else { return ControlFlow::Continue(()) };
            if let Some(ray) = C::prepare(&slab_ray, &self.bounds, inside) {
                return self.traverse_bounded(primitives, query, &ray, inside, probe);
            }
        }
        (0..self.primitives).try_for_each(|index| query.test_primitive(primitives, index, probe))
    }

    fn traverse_bounded<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        ray: &C::Ray,
        inside: Interval,
        probe: &mut S,
    ) -> ControlFlow<()> {
        traverse(
            query,
            (inside, 0),
            |query, (inside, index)| {
                ControlFlow::Continue(match self.nodes.get(index as usize) {
                    Some(PartitionNode::Split { plane, above }) => {
                        probe.node();
                        let hit = plane.plane_hit(ray);
                        let (near, far) = if hit.from_above { (*above, index + 1) } else { (index + 1, *above) };
                        let (mut near_inside, mut far_inside) = (inside, inside);
                        // A NaN fails both comparisons and keeps the old value.
                        if hit.near_max < inside.max {
                            near_inside.max = hit.near_max;
                        }
                        if hit.far_min > inside.min {
                            far_inside.min = hit.far_min;
                        }
                        let [visits_near, visits_far] = [near_inside, far_inside].map(|part| part.min <= part.max);
                        Descent::in_order((near_inside, near), visits_near, (far_inside, far), visits_far)
                    }
                    Some(&PartitionNode::Leaf { first, count }) => {
                        query.test_leaf(primitives, self.leaf(first, count), probe)?;
                        None
                    }
                    None => None,
                })
            },
            |query, (inside, index)| {
                let limit = query.span().max;
                // Inclusive: an equally near primitive of lower index must still be found.
                (inside.min <= limit).then(|| (Interval::new(inside.min, inside.max.min(limit)), index))
            },
        )
    }

    pub(crate) fn traverse_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        query.test_leaf(&self.unbounded)?;
        if !query.bounds().overlaps(&self.bounds) {
            return ControlFlow::Continue(());
        }
        let query_point = query.query_point();
        // Split, side and child.
        let root = (0, 0, 0);
        traverse(
            query,
            root,
            |query, (_, _, index)| {
                ControlFlow::Continue(match self.nodes.get(index as usize) {
                    Some(PartitionNode::Split { plane, above }) => {
                        let children = [index + 1, *above];
                        let near = usize::from(plane.is_above(query_point));
                        let overlaps = plane.classify(&query.bounds());
                        let entry = |side: usize| (index, side, children[side]);
                        Descent::in_order(entry(near), overlaps[near], entry(near ^ 1), overlaps[near ^ 1])
                    }
                    Some(&PartitionNode::Leaf { first, count }) => {
                        for &primitive in self.leaf(first, count) {
                            query.test_primitive(primitive, |point| self.owner(point) == index)?;
                        }
                        None
                    }
                    None => None,
                })
            },
            // The bounds of the query may have shrunk.
            |query, entry| match self.nodes.get(entry.0 as usize) {
                Some(PartitionNode::Split { plane, .. }) => plane.classify(&query.bounds())[entry.1].then_some(entry),
                _ => None,
            },
        )
    }

    /// Index of the leaf that owns a point.
    fn owner(&self, point: DVec3) -> u32 {
        let mut number = 0;
        while let Some(PartitionNode::Split { plane, above }) = self.nodes.get(number as usize) {
            number = if plane.is_above(point) { *above } else { number + 1 };
        }
        number
    }
}
