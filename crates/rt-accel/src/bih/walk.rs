//! Walks, the same for both hierarchies: one has its nodes in a list, the other makes them on the way.

use core::ops::ControlFlow;

use rt_geometry::{Primitives, Probe};
use rt_math::Aabb;

use super::planes::{Planes, Stretch};
use crate::{RayQuery, RegionQuery, bounded_depth::Stack, ray_query::is_finite};

/// What a way leads to.
pub(super) enum Step<'h, W> {
    Leaf(&'h [u32]),
    Node(&'h Planes, [W; 2]),
}

/// A hierarchy over some primitives, as its walks see it.
pub(super) trait Hierarchy<'h>: Copy {
    /// How a node or leaf is referred to.
    type Way: Copy;

    /// Around all bounded primitives.
    fn bounds(self) -> &'h Aabb;

    fn unbounded(self) -> &'h [u32];

    /// The number of all primitives.
    fn primitives(self) -> u32;

    fn root(self) -> Self::Way;

    fn follow(self, way: Self::Way) -> Step<'h, Self::Way>;
}

pub(super) fn walk<'h, H: Hierarchy<'h>, P: Primitives, Q: RayQuery, S: Probe>(
    hierarchy: H,
    primitives: &P,
    query: &mut Q,
    probe: &mut S,
) -> ControlFlow<()> {
    if !is_finite(&query.ray().ray) {
        return (0..hierarchy.primitives()).try_for_each(|index| query.offer(primitives, index, probe));
    }
    query.offer_all(primitives, hierarchy.unbounded(), probe)?;
    let ray = *query.ray();
    let Some(inside) = hierarchy.bounds().clip(&ray, query.span()) else { return ControlFlow::Continue(()) };
    let mut stretch = Stretch { enter: inside.min, leave: inside.max };
    let mut way = hierarchy.root();
    let mut stack = Stack::new((way, stretch));
    loop {
        match hierarchy.follow(way) {
            Step::Leaf(indices) => query.offer_all(primitives, indices, probe)?,
            Step::Node(planes, ways) => {
                probe.node();
                let near = planes.near(&ray);
                let [first, second] = [near, near ^ 1].map(|side| planes.clip(&ray, side, stretch));
                let limit = query.span().max;
                if first.is_worth(limit) {
                    stack.push_if(second.is_worth(limit), (ways[near ^ 1], second));
                    (way, stretch) = (ways[near], first);
                    continue;
                }
                if second.is_worth(limit) {
                    (way, stretch) = (ways[near ^ 1], second);
                    continue;
                }
            }
        }
        (way, stretch) = loop {
            let Some(next) = stack.pop() else { return ControlFlow::Continue(()) };
            if next.1.is_worth(query.span().max) {
                break next;
            }
        };
    }
}

impl Stretch {
    /// True if there may be hits in it that are no later than `limit`. Inclusively: an equally near primitive of lower
    /// index must still be found.
    #[inline(always)]
    fn is_worth(&self, limit: f64) -> bool {
        (self.enter <= self.leave) & (self.enter <= limit)
    }
}

pub(super) fn search<'h, H: Hierarchy<'h>, Q: RegionQuery>(hierarchy: H, query: &mut Q) -> ControlFlow<()> {
    query.offer_all(hierarchy.unbounded())?;
    let (mut way, mut bounds) = (hierarchy.root(), *hierarchy.bounds());
    if query.reach(&bounds).is_none() {
        return ControlFlow::Continue(());
    }
    let mut stack = Stack::new((way, bounds));
    loop {
        match hierarchy.follow(way) {
            Step::Leaf(indices) => query.offer_all(indices)?,
            Step::Node(planes, ways) => {
                let boxes = [0, 1].map(|side| planes.cut(side, bounds));
                let reach = boxes.map(|aabb| query.reach(&aabb));
                let near = match reach {
                    [Some(left), Some(right)] => Some(usize::from(right < left)),
                    [left, right] => left.map(|_| 0).or(right.map(|_| 1)),
                };
                if let Some(near) = near {
                    stack.push_if(reach[near ^ 1].is_some(), (ways[near ^ 1], boxes[near ^ 1]));
                    (way, bounds) = (ways[near], boxes[near]);
                    continue;
                }
            }
        }
        (way, bounds) = loop {
            let Some(next) = stack.pop() else { return ControlFlow::Continue(()) };
            // The query may have become more particular since.
            if query.reach(&next.1).is_some() {
                break next;
            }
        };
    }
}
