//! Validation of the invariants that traversal and its proofs rely on.

use glam::Vec3A;
use rt_geometry::{Primitives, padded_bounds};

use super::WideBvh;
use super::leaf::{LeafKind, LeafWriter, MAX_LEAF};
use super::node::Child;
use super::triangle_list::TriangleList;
use crate::bvh::Aabb32;
use crate::{ValidationError, prim_bounds::validate_lists, traversal::MAX_DEPTH};

impl WideBvh {
    /// Checks all invariants that do not depend on the primitives. Every node has one parent, which precedes it; the
    /// depth fits the traversal stack; boxes contain those of their children. Leaves lie within the memory, and list
    /// each primitive once.
    pub(super) fn validate_shape(&self) -> Result<(), ValidationError> {
        // Before anything is allocated or summed, as a saved tree may contain any number.
        if u64::from(self.bounded) > self.leaves.most_primitives() {
            return Err(ValidationError::Count { built: self.bounded, given: self.unbounded.len() });
        }
        let count = u64::from(self.bounded) + self.unbounded.len() as u64;
        if count > u64::from(u32::MAX) {
            return Err(ValidationError::Count { built: self.bounded, given: self.unbounded.len() });
        }
        // Streams take the leaves of a tree with a list for exact triangles.
        let is_list_whole = |list: &TriangleList| {
            self.unbounded.is_empty() && self.leaves.kind == LeafKind::Watertight && list.is_whole(count as usize)
        };
        if !self.list.as_ref().is_none_or(is_list_whole) {
            return Err(ValidationError::List);
        }
        let mut is_listed = vec![false; self.bounded as usize + self.unbounded.len()];
        let mut list = |primitive: u32| match is_listed.get_mut(primitive as usize) {
            Some(listed) if !*listed => {
                *listed = true;
                Ok(())
            }
            _ => Err(ValidationError::Misplaced { primitive }),
        };
        self.unbounded.iter().try_for_each(|&primitive| list(primitive))?;
        self.for_each_leaf(|leaf, _| self.leaves.indices(leaf).iter().try_for_each(|&primitive| list(primitive)))?;
        match is_listed.iter().position(|listed| !listed) {
            Some(primitive) => Err(ValidationError::Misplaced { primitive: primitive as u32 }),
            None => Ok(()),
        }
    }

    /// Validates the shape, and that boxes and leaves match the primitives.
    pub(super) fn validate_primitives<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        self.validate_shape()?;
        validate_lists(primitives, self.bounded + self.unbounded.len() as u32, &self.unbounded)?;
        let filling = LeafWriter { primitives, centre: self.centre, kind: self.leaves.kind };
        self.for_each_leaf(|leaf, bounds| {
            for &primitive in self.leaves.indices(leaf).iter() {
                let own = padded_bounds(primitives, primitive).ok_or(ValidationError::Misplaced { primitive })?;
                if !bounds.encloses(&own, self.centre) {
                    return Err(ValidationError::Outside { primitive });
                }
            }
            if !self.leaves.fits(leaf, &filling) {
                let primitive = self.leaves.indices(leaf).first().copied().unwrap_or_default();
                return Err(ValidationError::Outside { primitive });
            }
            Ok(())
        })?;
        let list = TriangleList::of(primitives, self.leaves.kind, self.centre, self.size);
        if self.list == list { Ok(()) } else { Err(ValidationError::List) }
    }

    /// Visits all leaves with their boxes, and validates the nodes.
    fn for_each_leaf(
        &self,
        mut visit: impl FnMut(Child, &Aabb32) -> Result<(), ValidationError>,
    ) -> Result<(), ValidationError> {
        let everything = Aabb32 { min: Vec3A::NEG_INFINITY, max: Vec3A::INFINITY };
        // With another root, nodes would remain unvalidated.
        if self.root != Child::node(0) {
            return Err(ValidationError::Node { node: 0 });
        }
        let mut pending = vec![(self.root, everything, 0)];
        let mut n_visited = 0;
        while let Some((child, bounds, depth)) = pending.pop() {
            if depth > MAX_DEPTH {
                return Err(ValidationError::Depth { depth });
            }
            if !child.is_node() {
                if !self.leaves.contain(child) || child.count() > MAX_LEAF {
                    return Err(ValidationError::Count { built: self.bounded, given: child.number() });
                }
                visit(child, &bounds)?;
                continue;
            }
            let number = child.number();
            n_visited += 1;
            let bad = ValidationError::Node { node: number as u32 };
            let Some(node) = self.nodes.get(number).filter(|_| n_visited <= self.nodes.len()) else {
                return Err(bad);
            };
            // Filters must never hit an unvalidated child.
            if !node.is_empty_elsewhere() {
                return Err(bad);
            }
            for (inner, child) in node.children() {
                let is_ahead = !child.is_node() || child.number() > number;
                let is_within_size = inner.max_abs() <= self.size;
                if inner.union(bounds) != bounds || !is_ahead || !is_within_size {
                    return Err(bad);
                }
                pending.push((child, inner, depth + 1));
            }
        }
        Ok(())
    }
}

#[cfg(feature = "serde")]
crate::checked_serde::impl_checked_serde!(WideBvh, WideBvh::validate_shape);

#[cfg(test)]
mod tests {
    use rt_math::Vec3;

    use super::*;
    use crate::boxes::row;
    use crate::wide::facets::Facets;
    use crate::{Boxes, wide::BuildParams};

    fn tree_of_three_boxes(params: &BuildParams) -> WideBvh {
        WideBvh::build_with(&Boxes(&row()[..3]), params).expect("three boxes")
    }

    #[test]
    fn a_root_that_is_a_leaf_is_refused() {
        let mut tree = tree_of_three_boxes(&BuildParams::default());
        let leaf = tree.leaves().next().expect("a leaf");
        tree.root = leaf;
        assert_eq!(tree.validate_shape(), Err(ValidationError::Node { node: 0 }));
    }

    /// The list of primitives would take 4 GiB, and on 32 bits its length wraps.
    #[test]
    fn more_primitives_than_leaves_have_room_for_are_refused() {
        let mut tree = tree_of_three_boxes(&BuildParams::default());
        tree.bounded = u32::MAX;
        tree.unbounded = vec![0];
        assert_eq!(tree.validate_shape(), Err(ValidationError::Count { built: u32::MAX, given: 1 }));
    }

    #[test]
    fn lanes_without_a_check_cannot_be_passed() {
        let tree = tree_of_three_boxes(&BuildParams { max_leaf: 1, ..BuildParams::default() });
        assert_eq!(tree.validate_shape(), Ok(()));
        let lane = (0..8).find(|&lane| tree.nodes[0].child_box(lane).is_none()).expect("three of eight lanes");
        for [low, high] in [[f32::NAN, f32::NAN], [0.0, f32::NAN], [1.0, 0.999_999_9]] {
            let mut damaged = tree.clone();
            (damaged.nodes[0].planes[0][lane], damaged.nodes[0].planes[1][lane]) = (low, high);
            assert_eq!(damaged.validate_shape(), Err(ValidationError::Node { node: 0 }), "{low} to {high}");
        }
    }

    /// Parallel triangles.
    fn facets(count: u32) -> Facets {
        let facet = |index| [Vec3::ZERO, Vec3::X, Vec3::Y].map(|vertex| vertex + Vec3::Z * index as f32);
        Facets((0..count).map(facet).collect())
    }

    /// Streams would read leaves of another kind, or test primitives that do not exist.
    #[test]
    fn lists_that_do_not_fit_the_tree_are_refused() {
        let tree = WideBvh::build(&facets(5)).expect("five triangles");
        assert!(tree.list.is_some() && tree.validate_primitives(&facets(5)).is_ok());
        let of = |count: u32| WideBvh::build(&facets(count)).expect("triangles").list;
        assert_eq!(of(65), None);

        let more = WideBvh { list: of(6), ..tree.clone() };
        assert_eq!(more.validate_shape(), Err(ValidationError::List));
        let boxes = WideBvh { list: of(3), ..tree_of_three_boxes(&BuildParams::default()) };
        assert_eq!(boxes.validate_shape(), Err(ValidationError::List));
        let fewer = WideBvh { list: of(4), ..tree.clone() };
        assert_eq!(fewer.validate_shape(), Ok(()));
        assert_eq!(fewer.validate_primitives(&facets(5)), Err(ValidationError::List));
        let none = WideBvh { list: None, ..tree };
        assert_eq!(none.validate_primitives(&facets(5)), Err(ValidationError::List));
    }
}
