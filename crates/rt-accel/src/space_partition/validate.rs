//! Checks the assumptions of the traversal.

use rt_geometry::{Primitives, padded_bounds};

use super::node::check_order;
use super::{BspPartition, PartitionNode, SplitPlane};
use crate::{ValidationError, prim_bounds::validate_lists};

impl<C: SplitPlane> BspPartition<C> {
    pub(crate) fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        self.check()?;
        validate_lists(primitives, self.primitives, &self.unbounded)?;
        for primitive in 0..self.primitives {
            let Some(own) = padded_bounds(primitives, primitive) else { continue };
            if !self.bounds.encloses(&own) {
                return Err(ValidationError::Outside { primitive });
            }
            let mut pending = vec![0];
            while let Some(number) = pending.pop() {
                match self.nodes[number as usize] {
                    PartitionNode::Split { plane, above } => {
                        let children = [number + 1, above];
                        pending.extend((0..2).filter(|&side| plane.classify(&own)[side]).map(|side| children[side]));
                    }
                    PartitionNode::Leaf { first, count } => {
                        if self.leaf(first, count).binary_search(&primitive).is_err() {
                            return Err(ValidationError::Misplaced { primitive });
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Checks all invariants that do not depend on the primitives: traversals end, and all primitive indices are valid.
    pub(crate) fn check(&self) -> Result<(), ValidationError> {
        check_order(&self.nodes, self.indices.len())?;
        for (number, node) in (0..).zip(&self.nodes) {
            if let PartitionNode::Split { plane, .. } = node
                && !plane.is_valid()
            {
                return Err(ValidationError::Node { node: number });
            }
        }
        match self.indices.iter().chain(&self.unbounded).find(|&&index| index >= self.primitives) {
            Some(&primitive) => Err(ValidationError::Misplaced { primitive }),
            None => Ok(()),
        }
    }
}

#[cfg(feature = "serde")]
crate::checked_serde::impl_checked_serde!(BspPartition<C>, BspPartition::check, C: SplitPlane);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boxes::{Boxes, row};
    use crate::{BspTree, KdTree, traversal::MAX_DEPTH};

    fn damage_is_found<C: SplitPlane>(good: &BspPartition<C>) {
        let row = row();
        assert_eq!(good.validate(&Boxes(&row)), Ok(()));
        let verdict = |damage: &dyn Fn(&mut BspPartition<C>)| {
            let mut tree = good.clone();
            damage(&mut tree);
            tree.validate(&Boxes(&row))
        };
        let is_misplaced = |verdict| matches!(verdict, Err(ValidationError::Misplaced { .. }));
        let root = |tree: &mut BspPartition<C>, number: u32| match &mut tree.nodes[0] {
            PartitionNode::Split { above, .. } => *above = number,
            PartitionNode::Leaf { .. } => panic!("a leaf of all"),
        };
        assert!(is_misplaced(verdict(&|tree| tree.indices[1] = tree.indices[0])), "one is listed twice");
        assert!(is_misplaced(verdict(&|tree| tree.indices[0] = 100)), "one that is not there");
        assert!(is_misplaced(verdict(&|tree| tree.unbounded.push(3))), "one that is bounded");
        assert!(matches!(verdict(&|tree| root(tree, 0)), Err(ValidationError::Node { .. })), "a loop");
        assert!(
            matches!(verdict(&|tree| root(tree, 9999)), Err(ValidationError::Node { .. })),
            "a node that is not there"
        );
        assert!(verdict(&|tree| _ = tree.nodes.pop()).is_err(), "a node lost");
        assert!(verdict(&|tree| _ = tree.indices.pop()).is_err(), "a reference lost");
        assert_eq!(verdict(&|tree| tree.primitives = 99), Err(ValidationError::Misplaced { primitive: 99 }));
        assert_eq!(verdict(&|tree| tree.bounds.max.x -= 1.0), Err(ValidationError::Outside { primitive: 99 }));
        let comb = |tree: &mut BspPartition<C>| {
            let PartitionNode::Split { plane, .. } = tree.nodes[0] else { return };
            let depth = MAX_DEPTH + 1;
            tree.nodes = (0..depth).map(|level| PartitionNode::Split { plane, above: 2 * depth - level }).collect();
            tree.nodes.extend((0..=depth).map(|_| PartitionNode::Leaf { first: 0, count: 0 }));
            tree.indices.clear();
        };
        assert_eq!(verdict(&comb), Err(ValidationError::Depth { depth: MAX_DEPTH + 1 }));
        // Two leaves of different primitives, exchanged.
        let exchanged = verdict(&|tree| {
            let last = tree.indices.len() - 1;
            tree.indices.swap(0, last);
        });
        assert!(is_misplaced(exchanged), "{exchanged:?}");
    }

    #[test]
    fn damage_to_trees_of_both_kinds_is_found() {
        damage_is_found(&KdTree::build(&Boxes(&row())).expect("boxes").0);
        damage_is_found(&BspTree::build(&Boxes(&row())).expect("boxes").0);
    }

    #[test]
    fn cuts_that_are_no_planes_are_found() {
        let mut tree = KdTree::build(&Boxes(&row())).expect("boxes").0;
        let PartitionNode::Split { plane, .. } = &mut tree.nodes[0] else { panic!("a leaf of all") };
        plane.position = f64::NAN;
        assert_eq!(tree.validate(&Boxes(&row())), Err(ValidationError::Node { node: 0 }));
        let mut tree = BspTree::build(&Boxes(&row())).expect("boxes").0;
        let PartitionNode::Split { plane, .. } = &mut tree.nodes[0] else { panic!("a leaf of all") };
        plane.normal *= 2.0;
        assert_eq!(tree.validate(&Boxes(&row())), Err(ValidationError::Node { node: 0 }));
    }

    #[cfg(feature = "serde")]
    #[test]
    fn what_is_loaded_is_what_was_saved_or_refused() {
        let kd = KdTree::build(&Boxes(&row())).expect("boxes");
        let bsp = BspTree::build(&Boxes(&row())).expect("boxes");
        let empty = KdTree::build(&Boxes(&[])).expect("nothing");
        let text = serde_json::to_string(&(&kd, &bsp, &empty)).expect("plain data");
        assert_eq!(
            serde_json::from_str::<(KdTree, BspTree, KdTree)>(&text).expect("what was saved"),
            (kd.clone(), bsp, empty)
        );
        let mut damaged = kd;
        damaged.0.indices[5] = 100;
        let text = serde_json::to_string(&damaged).expect("plain data");
        let error = serde_json::from_str::<KdTree>(&text).expect_err("a primitive that is not there");
        assert!(error.to_string().contains("primitive 100"), "{error}");
    }
}
