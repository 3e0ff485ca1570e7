//! Checks what the walks and their proofs rest on.

use glam::Vec3A;
use rt_geometry::{Primitives, padded_bounds};

use super::WideBvh;
use super::leaf::{LeafWriter, MAX_LEAF};
use super::node::Child;
use crate::bvh::{Cell, NodeBox, encloses};
use crate::{ValidationError, bounded_depth::MAX_DEPTH, own_boxes::validate_lists};

impl WideBvh {
    /// Checks all that can be checked without the primitives: every node has one parent, which comes before it, no leaf
    /// is too deep for the stack of a walk, boxes contain those below, leaves lie where they can be read, and lists name
    /// primitives, each once.
    pub(super) fn validate_shape(&self) -> Result<(), ValidationError> {
        // Before anything is allocated or added up, as a saved tree may state any number.
        if u64::from(self.bounded) > self.leaves.most_primitives() {
            return Err(ValidationError::Count { built: self.bounded, given: self.unbounded.len() });
        }
        let count = u64::from(self.bounded) + self.unbounded.len() as u64;
        if count > u64::from(u32::MAX) {
            return Err(ValidationError::Count { built: self.bounded, given: self.unbounded.len() });
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

    /// Checks the shape, that every own box lies within the box of its leaf, and what filters are told about it.
    pub(super) fn validate_primitives<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        self.validate_shape()?;
        validate_lists(primitives, self.bounded + self.unbounded.len() as u32, &self.unbounded)?;
        let filling = LeafWriter { primitives, centre: self.centre, kind: self.leaves.kind };
        self.for_each_leaf(|leaf, bounds| {
            for &primitive in self.leaves.indices(leaf) {
                let own = padded_bounds(primitives, primitive).ok_or(ValidationError::Misplaced { primitive })?;
                if !encloses(bounds, &own, &Cell::EVERYWHERE, self.centre) {
                    return Err(ValidationError::Outside { primitive });
                }
            }
            if !self.leaves.fits(leaf, &filling) {
                let primitive = self.leaves.indices(leaf).first().copied().unwrap_or_default();
                return Err(ValidationError::Outside { primitive });
            }
            Ok(())
        })
    }

    /// Visits the leaves with their boxes, and checks the nodes on the way.
    fn for_each_leaf(
        &self,
        mut visit: impl FnMut(Child, &NodeBox) -> Result<(), ValidationError>,
    ) -> Result<(), ValidationError> {
        let everything = NodeBox { min: Vec3A::NEG_INFINITY, max: Vec3A::INFINITY };
        // A root that is something else would leave nodes behind that nobody has checked.
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
            // Filters must not be able to pass what nobody has checked.
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

#[cfg(test)]
mod tests {
    use rt_geometry::{Hit, Primitives};
    use rt_math::{Aabb, DVec3, Interval, Ray};

    use super::*;

    /// Unit boxes in a row.
    struct Row(u32);

    impl Primitives for Row {
        fn len(&self) -> usize {
            self.0 as usize
        }

        fn bounds(&self, index: u32) -> Option<Aabb> {
            let low = DVec3::X * (3.0 * f64::from(index));
            Some(Aabb::new(low, low + DVec3::ONE))
        }

        fn intersect(&self, _: u32, _: &Ray, _: Interval) -> Option<Hit> {
            None
        }
    }

    #[test]
    fn a_root_that_is_a_leaf_is_refused() {
        let mut tree = WideBvh::build(&Row(3)).expect("three boxes");
        let leaf = tree.leaves().next().expect("a leaf");
        tree.root = leaf;
        assert_eq!(tree.validate_shape(), Err(ValidationError::Node { node: 0 }));
    }

    /// The list of what is named would take 4 GiB, and on 32 bits its length wraps.
    #[test]
    fn more_primitives_than_leaves_have_room_for_are_refused() {
        let mut tree = WideBvh::build(&Row(3)).expect("three boxes");
        tree.bounded = u32::MAX;
        tree.unbounded = vec![0];
        assert_eq!(tree.validate_shape(), Err(ValidationError::Count { built: u32::MAX, given: 1 }));
    }

    #[test]
    fn lanes_that_nobody_has_checked_cannot_be_passed() {
        let tree = WideBvh::build_with(&Row(3), &super::super::BuildParams { max_leaf: 1, ..Default::default() });
        let tree = tree.expect("three boxes");
        assert_eq!(tree.validate_shape(), Ok(()));
        let lane = (0..8).find(|&lane| tree.nodes[0].child_box(lane).is_none()).expect("three of eight lanes");
        for [low, high] in [[f32::NAN, f32::NAN], [0.0, f32::NAN], [1.0, 0.999_999_9]] {
            let mut damaged = tree.clone();
            (damaged.nodes[0].planes[0][lane], damaged.nodes[0].planes[1][lane]) = (low, high);
            assert_eq!(damaged.validate_shape(), Err(ValidationError::Node { node: 0 }), "{low} to {high}");
        }
    }
}
