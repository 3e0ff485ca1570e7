//! Walks: the near side of each cut first, back to the far side that was put off.

use core::ops::ControlFlow;

use glam::DVec3;
use rt_geometry::{Primitives, Probe};
use rt_math::Interval;

use super::{Cut, Node, Partition};
use crate::{RayQuery, RegionQuery, bounded_depth::Stack, ray_query::is_finite};

impl<C: Cut> Partition<C> {
    pub(crate) fn walk<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        query.offer_all(primitives, &self.unbounded, probe)?;
        let slab_ray = *query.ray();
        if is_finite(&slab_ray.ray) {
            let Some(inside) = self.bounds.clip(&slab_ray, query.span()) else { return ControlFlow::Continue(()) };
            if let Some(ray) = C::prepare(&slab_ray, &self.bounds, inside) {
                return self.descend(primitives, query, &ray, inside, probe);
            }
        }
        (0..self.primitives).try_for_each(|index| query.offer(primitives, index, probe))
    }

    fn descend<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        ray: &C::Ray,
        mut inside: Interval,
        probe: &mut S,
    ) -> ControlFlow<()> {
        let mut stack = Stack::new((inside, 0));
        let mut number = 0;
        loop {
            match self.nodes.get(number as usize) {
                Some(Node::Split { cut, above }) => {
                    probe.node();
                    let crossing = cut.crossing(ray);
                    let (near, far) = if crossing.from_above { (*above, number + 1) } else { (number + 1, *above) };
                    let (mut near_inside, mut far_inside) = (inside, inside);
                    // A NaN fails both comparisons and keeps the old value.
                    if crossing.near_max < inside.max {
                        near_inside.max = crossing.near_max;
                    }
                    if crossing.far_min > inside.min {
                        far_inside.min = crossing.far_min;
                    }
                    let visits_far = far_inside.min <= far_inside.max;
                    if near_inside.min <= near_inside.max {
                        stack.push_if(visits_far, (far_inside, far));
                        (number, inside) = (near, near_inside);
                        continue;
                    } else if visits_far {
                        (number, inside) = (far, far_inside);
                        continue;
                    }
                }
                Some(&Node::Leaf { first, count }) => {
                    query.offer_all(primitives, self.leaf(first, count), probe)?;
                }
                None => {}
            }
            (inside, number) = loop {
                let Some((mut inside, number)) = stack.pop() else { return ControlFlow::Continue(()) };
                let limit = query.span().max;
                // Strictly: an equally near primitive of lower index must still be found.
                if inside.min <= limit {
                    inside.max = inside.max.min(limit);
                    break (inside, number);
                }
            };
        }
    }

    pub(crate) fn search<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        query.offer_all(&self.unbounded)?;
        if !query.bounds().overlaps(&self.bounds) {
            return ControlFlow::Continue(());
        }
        let focus = query.focus();
        // Splits whose other side was put off, and that side.
        let mut stack = Stack::new((0, 0, 0));
        let mut number = 0;
        loop {
            match self.nodes.get(number as usize) {
                Some(Node::Split { cut, above }) => {
                    let children = [number + 1, *above];
                    let near = usize::from(cut.is_above(focus));
                    let wanted = cut.sides(&query.bounds());
                    if wanted[near] {
                        stack.push_if(wanted[near ^ 1], (number, near ^ 1, children[near ^ 1]));
                        number = children[near];
                        continue;
                    } else if wanted[near ^ 1] {
                        number = children[near ^ 1];
                        continue;
                    }
                }
                Some(&Node::Leaf { first, count }) => {
                    for &index in self.leaf(first, count) {
                        query.offer(index, |point| self.owner(point) == number)?;
                    }
                }
                None => {}
            }
            number = loop {
                let Some((split, side, child)) = stack.pop() else { return ControlFlow::Continue(()) };
                // The query may have become more particular since.
                let is_wanted = match self.nodes.get(split as usize) {
                    Some(Node::Split { cut, .. }) => cut.sides(&query.bounds())[side],
                    _ => false,
                };
                if is_wanted {
                    break child;
                }
            };
        }
    }

    /// Number of the leaf that owns a point.
    fn owner(&self, point: DVec3) -> u32 {
        let mut number = 0;
        while let Some(Node::Split { cut, above }) = self.nodes.get(number as usize) {
            number = if cut.is_above(point) { *above } else { number + 1 };
        }
        number
    }
}
