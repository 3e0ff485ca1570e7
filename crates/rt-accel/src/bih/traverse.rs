//! Traversal of both hierarchies: of stored nodes, and of nodes that are split on the way.

use core::ops::ControlFlow;

use rt_geometry::{Primitives, Probe};
use rt_math::Aabb;

use super::planes::{Planes, TRange};
use crate::traversal::{Descent, traverse, traverse_by_distance};
use crate::{RayQuery, RegionQuery, ray_query::is_finite};

/// Node or leaf behind a reference of type `N`.
pub(super) enum BihNode<'h, N> {
    Leaf(&'h [u32]),
    Inner(&'h Planes, [N; 2]),
}

/// Tree of [`Planes`].
pub(super) trait Hierarchy<'h>: Copy {
    /// Reference to a node or leaf.
    type Node: Copy;

    /// Bounds of all bounded primitives.
    fn bounds(self) -> &'h Aabb;

    fn unbounded(self) -> &'h [u32];

    /// Number of primitives, bounded or not.
    fn primitives(self) -> u32;

    fn root(self) -> Self::Node;

    fn resolve(self, node: Self::Node) -> BihNode<'h, Self::Node>;
}

pub(super) fn traverse_ray<'h, H: Hierarchy<'h>, P: Primitives, Q: RayQuery, S: Probe>(
    hierarchy: H,
    primitives: &P,
    query: &mut Q,
    probe: &mut S,
) -> ControlFlow<()> {
    if !is_finite(&query.ray().ray) {
        return (0..hierarchy.primitives()).try_for_each(|index| query.test_primitive(primitives, index, probe));
    }
    query.test_leaf(primitives, hierarchy.unbounded(), probe)?;
    let ray = *query.ray();
    let Some(inside) = hierarchy.bounds().clip(&ray, query.span()) else { return ControlFlow::Continue(()) };
    traverse(
        query,
        (hierarchy.root(), TRange { enter: inside.min, leave: inside.max }),
        |query, (node, range)| {
            ControlFlow::Continue(match hierarchy.resolve(node) {
                BihNode::Leaf(indices) => {
                    query.test_leaf(primitives, indices, probe)?;
                    None
                }
                BihNode::Inner(planes, children) => {
                    probe.node();
                    let near = planes.near(&ray);
                    let [first, second] = [near, near ^ 1].map(|side| (children[side], planes.clip(&ray, side, range)));
                    let limit = query.span().max;
                    let [visits_first, visits_second] = [first.1, second.1].map(|range| range.may_contain_hit(limit));
                    Descent::in_order(first, visits_first, second, visits_second)
                }
            })
        },
        |query, entry| entry.1.may_contain_hit(query.span().max).then_some(entry),
    )
}

impl TRange {
    /// True if hits in the range may be no later than `limit`. Inclusive: an equally near primitive of lower index must
    /// still be found.
    #[inline(always)]
    fn may_contain_hit(&self, limit: f64) -> bool {
        (self.enter <= self.leave) & (self.enter <= limit)
    }
}

pub(super) fn traverse_region<'h, H: Hierarchy<'h>, Q: RegionQuery>(hierarchy: H, query: &mut Q) -> ControlFlow<()> {
    query.test_leaf(hierarchy.unbounded())?;
    let bounds = *hierarchy.bounds();
    if query.distance_to(&bounds).is_none() {
        return ControlFlow::Continue(());
    }
    traverse_by_distance(
        query,
        (hierarchy.root(), bounds),
        |query, (node, bounds)| {
            ControlFlow::Continue(match hierarchy.resolve(node) {
                BihNode::Leaf(indices) => {
                    query.test_leaf(indices)?;
                    None
                }
                BihNode::Inner(planes, children) => Some([0, 1].map(|side| (children[side], planes.cut(side, bounds)))),
            })
        },
        |query, bounds| query.distance_to(bounds),
    )
}
