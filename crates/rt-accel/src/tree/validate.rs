//! Validation, statistics and refitting of trees.

use core::ops::Range;

use rt_geometry::{Primitives, padded_bounds};
use rt_math::Aabb;

use super::Tree;
use crate::node_ref::NodeRef;
use crate::prim_bounds::{PrimBounds, validate_lists};
use crate::{BuildError, BuildStats, ValidationError, traversal::MAX_DEPTH};

/// Ranges of the primitive indices below each node.
pub(crate) struct LeafRanges(Vec<Range<usize>>);

impl LeafRanges {
    pub(crate) fn below(&self, child: NodeRef) -> Range<usize> {
        if child.count == 0 {
            self.0[child.first as usize].clone()
        } else {
            child.first as usize..child.first as usize + child.count as usize
        }
    }
}

impl<C> Tree<C> {
    pub(crate) fn leaf_ranges(&self) -> LeafRanges {
        let mut leaf_ranges = LeafRanges(vec![0..0; self.nodes.len()]);
        for (number, node) in self.nodes.iter().enumerate().rev() {
            let [left, right] = node.children.map(|child| leaf_ranges.below(child));
            leaf_ranges.0[number] = left.start..right.end;
        }
        leaf_ranges
    }

    /// Visits all nodes and leaves depth first. `step` computes the state of a child from that of its parent.
    pub(crate) fn for_each_child<T: Copy>(
        &self,
        root: T,
        step: impl Fn(&C, usize, T) -> T,
        mut visit: impl FnMut(NodeRef, T, u32),
    ) {
        let mut pending = vec![(self.root, root, 0)];
        while let Some((child, carried, depth)) = pending.pop() {
            visit(child, carried, depth);
            let Some(node) = self.nodes.get(child.first as usize).filter(|_| child.count == 0) else { continue };
            for side in [1, 0] {
                pending.push((node.children[side], step(&node.payload, side, carried), depth + 1));
            }
        }
    }

    pub(crate) fn stats(&self) -> BuildStats {
        let mut max_depth = 0;
        self.for_each_child((), |_, _, ()| (), |_, (), depth| max_depth = max_depth.max(depth));
        BuildStats {
            primitives: self.primitives() as usize,
            unbounded: self.unbounded.len(),
            nodes: self.nodes.len(),
            leaves: if self.indices.is_empty() { 0 } else { self.nodes.len() + 1 },
            max_depth: max_depth as usize,
            references: self.indices.len(),
            sah_cost: None,
        }
    }

    /// Checks order and depth of nodes and leaves, and that each primitive is listed once.
    pub(crate) fn check_shape(&self) -> Result<(), ValidationError> {
        let (mut n_nodes, mut n_placed) = (0, 0);
        let mut pending = vec![(self.root, 0, 0)];
        while let Some((child, depth, parent)) = pending.pop() {
            if depth > MAX_DEPTH {
                return Err(ValidationError::Depth { depth });
            }
            let expected = if child.count == 0 { n_nodes } else { n_placed };
            if child.first as usize != expected {
                return Err(ValidationError::Node { node: parent });
            }
            if child.count > 0 {
                n_placed += child.count as usize;
            } else if let Some(node) = self.nodes.get(n_nodes) {
                n_nodes += 1;
                pending.extend([1, 0].map(|side| (node.children[side], depth + 1, child.first)));
            } else if !self.indices.is_empty() || depth > 0 {
                return Err(ValidationError::Node { node: child.first });
            }
        }
        if n_nodes != self.nodes.len() || n_placed != self.indices.len() {
            return Err(ValidationError::Node { node: n_nodes as u32 });
        }
        self.check_indices()
    }

    /// Checks that each primitive is listed once.
    fn check_indices(&self) -> Result<(), ValidationError> {
        let mut is_listed = vec![false; self.indices.len() + self.unbounded.len()];
        for &primitive in self.indices.iter().chain(&self.unbounded) {
            match is_listed.get_mut(primitive as usize) {
                Some(listed) if !*listed => *listed = true,
                _ => return Err(ValidationError::Misplaced { primitive }),
            }
        }
        Ok(())
    }

    /// Checks shape and lists, and that `encloses` holds for each side of each node and the padded bounds of all
    /// primitives below.
    pub(crate) fn validate<P: Primitives>(
        &self,
        primitives: &P,
        encloses: impl Fn(&C, usize, &Aabb) -> bool,
    ) -> Result<(), ValidationError> {
        self.check_shape()?;
        validate_lists(primitives, self.primitives(), &self.unbounded)?;
        let own =
            |&primitive: &u32| padded_bounds(primitives, primitive).ok_or(ValidationError::Misplaced { primitive });
        let boxes = self.indices.iter().map(own).collect::<Result<Vec<_>, _>>()?;
        let leaf_ranges = self.leaf_ranges();
        for node in &self.nodes {
            for side in 0..2 {
                let run = leaf_ranges.below(node.children[side]);
                if let Some(outside) = run.clone().find(|&place| !encloses(&node.payload, side, &boxes[place])) {
                    return Err(ValidationError::Outside { primitive: self.indices[outside] });
                }
            }
        }
        Ok(())
    }

    /// Recomputes the payload of every node by `fit`, from the current padded bounds on both sides. Returns these.
    pub(crate) fn refit<P: Primitives>(
        &mut self,
        primitives: &P,
        fit: impl Fn(&C, [&[Aabb]; 2]) -> C,
    ) -> Result<PrimBounds, BuildError> {
        let boxes = PrimBounds::collect(primitives)?;
        validate_lists(primitives, self.primitives(), &self.unbounded).map_err(BuildError::Changed)?;
        let mut by_index = vec![Aabb::EMPTY; self.primitives() as usize];
        for &(index, own) in &boxes.bounded {
            by_index[index as usize] = own;
        }
        let in_order: Vec<_> = self.indices.iter().map(|&index| by_index[index as usize]).collect();
        let leaf_ranges = self.leaf_ranges();
        for node in &mut self.nodes {
            node.payload = fit(&node.payload, node.children.map(|child| &in_order[leaf_ranges.below(child)]));
        }
        Ok(boxes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::binned_sah::bounds_of;
    use crate::top_down::SliceSplit;
    use crate::{Accelerator, Bih, tree::PayloadNode};
    use glam::DVec3;
    use rt_geometry::Hit;
    use rt_math::{Interval, Ray};

    struct Row(f64);

    impl Primitives for Row {
        fn len(&self) -> usize {
            101
        }
        fn bounds(&self, index: u32) -> Option<Aabb> {
            let corner = DVec3::X * f64::from(index);
            (index != 100).then_some(Aabb::new(corner, corner + self.0))
        }
        fn intersect(&self, _: u32, _: &Ray, _: Interval) -> Option<Hit> {
            None
        }
    }

    /// Splits at the middle down to four primitives; the payload is the bounds of both sides.
    fn tree() -> Tree<[Aabb; 2]> {
        let boxes = PrimBounds::collect(&Row(0.5)).expect("boxes");
        Tree::build(boxes, (), |items, (), _| {
            let middle = items.len() / 2;
            let payload = [bounds_of(&items[..middle]), bounds_of(&items[middle..])];
            (items.len() > 4).then_some(SliceSplit { middle, payload, states: [(); 2] })
        })
    }

    fn verdict(tree: &Tree<[Aabb; 2]>, row: &Row) -> Result<(), ValidationError> {
        tree.validate(row, |boxes, side, own| boxes[side].encloses(own))
    }

    fn damaged(damage: impl FnOnce(&mut Tree<[Aabb; 2]>)) -> Result<(), ValidationError> {
        let mut tree = tree();
        assert_eq!(verdict(&tree, &Row(0.5)), Ok(()));
        damage(&mut tree);
        verdict(&tree, &Row(0.5))
    }

    #[test]
    fn damage_is_found() {
        let reaches_out = damaged(|tree| tree.nodes[0].payload[1].max.x -= 0.1);
        assert_eq!(reaches_out, Err(ValidationError::Outside { primitive: 99 }));
        assert_eq!(damaged(|tree| tree.indices[1] = 0), Err(ValidationError::Misplaced { primitive: 0 }));
        assert_eq!(damaged(|tree| tree.indices[1] = 4000), Err(ValidationError::Misplaced { primitive: 4000 }));
        let fewer = ValidationError::Count { built: 100, given: 101 };
        assert_eq!(damaged(|tree| tree.unbounded.clear()), Err(fewer));
        let is_node = |verdict: Result<(), ValidationError>| matches!(verdict, Err(ValidationError::Node { .. }));
        assert!(is_node(damaged(|tree| tree.nodes[0].children[0] = NodeRef::node(0))), "a loop");
        assert!(is_node(damaged(|tree| tree.nodes[0].children[1] = NodeRef::node(9999))), "a node past the end");
        assert!(is_node(damaged(|tree| tree.nodes[0].children.swap(0, 1))), "out of order");
        assert!(is_node(damaged(|tree| tree.root = NodeRef::leaf(0, 100))), "nodes that nothing leads to");
        assert!(is_node(damaged(|tree| tree.root = NodeRef::leaf(0, u32::MAX))), "a leaf past the end");
        assert!(is_node(damaged(|tree| tree.nodes.clear())), "no nodes");
        assert!(is_node(damaged(|tree| tree.nodes.truncate(10))), "nodes are missing");
    }

    #[test]
    fn trees_deeper_than_the_stack_are_refused() {
        let boxes = [Aabb::new(DVec3::splat(-1e9), DVec3::splat(1e9)); 2];
        let mut tree = tree();
        tree.root = NodeRef::node(0);
        // Each node has one primitive on its left side and all others on its right.
        tree.nodes = (0..99)
            .map(|i| {
                let right = if i == 98 { NodeRef::leaf(99, 1) } else { NodeRef::node(i + 1) };
                PayloadNode { payload: boxes, children: [NodeRef::leaf(i, 1), right] }
            })
            .collect();
        assert_eq!(verdict(&tree, &Row(0.5)), Err(ValidationError::Depth { depth: 61 }));
    }

    #[test]
    fn other_primitives_are_noticed_and_fitted_to() {
        let mut tree = tree();
        assert!(matches!(verdict(&tree, &Row(0.6)), Err(ValidationError::Outside { .. })));
        let union = |boxes: &[Aabb]| boxes.iter().copied().fold(Aabb::EMPTY, Aabb::union);
        assert!(tree.refit(&Row(0.6), |_, sides| sides.map(union)).is_ok());
        assert_eq!(verdict(&tree, &Row(0.6)), Ok(()));
        assert_eq!(tree.stats().max_depth, 5);
        let mut bih = Bih::build(&Row(0.5)).expect("bounded");
        assert!(bih.validate(&Row(0.6)).is_err());
        assert_eq!(crate::Refit::refit(&mut bih, &Row(0.6)), Ok(()));
        assert_eq!(bih.validate(&Row(0.6)), Ok(()));
    }
}
