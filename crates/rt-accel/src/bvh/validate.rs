//! Checks the assumptions of the traversal.

use glam::{DVec3, Vec3A};
use rt_geometry::{Primitives, padded_bounds};
use rt_math::Aabb;

use super::Bvh;
use super::node::Aabb32;
use super::spatial_splits::SplitCell;
use crate::{ValidationError, node_ref::NodeRef, prim_bounds::validate_lists, traversal::MAX_DEPTH};

impl Bvh {
    /// Checks all invariants that do not depend on the primitives. Each node has one parent, no leaf is too deep for
    /// the traversal stack, and boxes contain their children. Leaves list each reference once, and all indices are
    /// valid.
    pub(super) fn check_shape(&self) -> Result<(), ValidationError> {
        let mut n_listed = 0;
        self.for_each_leaf(|leaf, _| {
            // Leaves are consecutive, so that these sums reveal gaps and repetitions.
            if leaf.first as usize != n_listed {
                return Err(ValidationError::Misplaced {
                    primitive: self.indices.get(n_listed).copied().unwrap_or_default(),
                });
            }
            n_listed += leaf.count as usize;
            Ok(())
        })?;
        let count = u64::from(self.bounded) + self.unbounded.len() as u64;
        let is_named = |&&index: &&u32| u64::from(index) < count;
        if let Some(&primitive) = self.indices.iter().chain(&self.unbounded).find(|index| !is_named(index)) {
            return Err(ValidationError::Misplaced { primitive });
        }
        if n_listed != self.indices.len() || count > u64::from(u32::MAX) {
            return Err(ValidationError::Count { built: self.bounded, given: n_listed });
        }
        let is_sorted = self.split_refs.is_sorted_by(|a, b| a.position < b.position);
        if !is_sorted || self.split_refs.last().is_some_and(|piece| piece.position as usize >= self.indices.len()) {
            return Err(ValidationError::Count { built: self.indices.len() as u32, given: self.split_refs.len() });
        }
        Ok(())
    }

    /// Checks the shape and all bounds. Each bounded primitive is in exactly one leaf that contains its padded bounds,
    /// or in several. The cells of these references tile space, and each leaf contains the part of the padded bounds in
    /// its cell.
    pub(super) fn check<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        self.check_shape()?;
        let count = self.bounded as usize + self.unbounded.len();
        validate_lists(primitives, count as u32, &self.unbounded)?;
        let mut is_placed = vec![false; count];
        self.unbounded.iter().for_each(|&primitive| is_placed[primitive as usize] = true);
        let mut split_refs = self.split_refs.iter().peekable();
        let mut cells: Vec<(u32, SplitCell)> = Vec::new();
        self.for_each_leaf(|leaf, bounds| {
            for (position, &primitive) in (leaf.first..).zip(self.leaf(leaf)) {
                let cell = split_refs.next_if(|piece| piece.position == position).map(|piece| piece.cell);
                let own = padded_bounds(primitives, primitive).ok_or(ValidationError::Misplaced { primitive })?;
                if !encloses_part(bounds, &own, &cell.unwrap_or(SplitCell::EVERYWHERE), self.centre) {
                    return Err(ValidationError::Outside { primitive });
                }
                match cell {
                    Some(cell) => cells.push((primitive, cell)),
                    None if is_placed[primitive as usize] => return Err(ValidationError::Misplaced { primitive }),
                    None => is_placed[primitive as usize] = true,
                }
            }
            Ok(())
        })?;
        cells.sort_by_key(|&(primitive, _)| primitive);
        for parts in cells.chunk_by(|a, b| a.0 == b.0) {
            let primitive = parts[0].0;
            if is_placed[primitive as usize] || !tile_space(parts.iter().map(|part| part.1).collect()) {
                return Err(ValidationError::Misplaced { primitive });
            }
            is_placed[primitive as usize] = true;
        }
        match is_placed.iter().position(|placed| !placed) {
            Some(primitive) => Err(ValidationError::Misplaced { primitive: primitive as u32 }),
            None => Ok(()),
        }
    }

    /// Visits the leaves from left to right, with their boxes, and checks the nodes on the way.
    fn for_each_leaf(
        &self,
        mut visit: impl FnMut(NodeRef, &Aabb32) -> Result<(), ValidationError>,
    ) -> Result<(), ValidationError> {
        let everything = Aabb32 { min: Vec3A::NEG_INFINITY, max: Vec3A::INFINITY };
        let mut pending = vec![(self.root, everything, 0)];
        let mut n_visited = 0;
        while let Some((child, bounds, depth)) = pending.pop() {
            if depth > MAX_DEPTH {
                return Err(ValidationError::Depth { depth });
            }
            if child.count > 0 || self.nodes.is_empty() {
                if (child.first as usize).saturating_add(child.count as usize) > self.indices.len() {
                    return Err(ValidationError::Count {
                        built: self.indices.len() as u32,
                        given: child.first as usize,
                    });
                }
                visit(child, &bounds)?;
                continue;
            }
            let number = child.first;
            n_visited += 1;
            let Some(node) = self.nodes.get(number as usize).filter(|_| n_visited <= self.nodes.len()) else {
                return Err(ValidationError::Node { node: number });
            };
            for side in [1, 0] {
                let inner = node.child_box(side);
                // Children come after their parents, which `refit` relies on.
                let is_ahead = node.children[side].count > 0 || node.children[side].first > number;
                if inner.union(bounds) != bounds || !is_ahead {
                    return Err(ValidationError::Node { node: number });
                }
                pending.push((node.children[side], inner, depth + 1));
            }
        }
        Ok(())
    }
}

/// True if every point belongs to exactly one of the cells. Each cell results from planes that cut all of space, or one
/// side of another such plane. So one plane always separates some cells from the others.
fn tile_space(cells: Vec<SplitCell>) -> bool {
    let mut pending = vec![(SplitCell::EVERYWHERE, cells)];
    while let Some((whole, cells)) = pending.pop() {
        if let [cell] = cells[..] {
            if cell == whole {
                continue;
            }
            return false;
        }
        let separates = |axis: usize, plane: f32| {
            cells.iter().all(|cell| cell.max[axis] <= plane || cell.min[axis] >= plane)
                && (whole.min[axis] < plane && plane < whole.max[axis])
        };
        let planes = cells.iter().flat_map(|cell| (0..3).map(|axis| (axis, cell.max[axis])));
        let Some((axis, plane)) = planes.into_iter().find(|&(axis, plane)| separates(axis, plane)) else {
            return false;
        };
        let (left, right) = cells.into_iter().partition(|cell| cell.max[axis] <= plane);
        let [left_whole, right_whole] = whole.cut(axis, plane);
        pending.push((left_whole, left));
        pending.push((right_whole, right));
    }
    true
}

/// True if `outer` contains the part of `aabb − centre` in a cell, without rounding.
fn encloses_part(outer: &Aabb32, aabb: &Aabb, cell: &SplitCell, centre: DVec3) -> bool {
    (0..3).all(|axis| {
        let [lower, upper] = outer.encloses_on(axis, aabb, centre);
        (lower || outer.min[axis] < cell.min[axis]) && (upper || outer.max[axis] > cell.max[axis])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boxes::{Boxes, row};
    use crate::{Accelerator, bvh::node::BvhNode};

    fn damaged(damage: impl FnOnce(&mut Bvh)) -> Result<(), ValidationError> {
        let row = row();
        let mut bvh = Bvh::build(&Boxes(&row)).expect("bounded");
        assert_eq!(bvh.validate(&Boxes(&row)), Ok(()));
        damage(&mut bvh);
        bvh.validate(&Boxes(&row))
    }

    #[test]
    fn damage_is_found() {
        let shrunk = |bvh: &mut Bvh, number: usize| {
            let node = &mut bvh.nodes[number];
            let [left, right] = [0, 1].map(|side| node.child_box(side));
            let smaller = Aabb32 { max: left.max - 0.3, ..left };
            *node = BvhNode::new([smaller, right], node.children);
        };
        assert_eq!(damaged(|bvh| shrunk(bvh, 0)), Err(ValidationError::Node { node: 1 }), "does not contain its child");
        let parent_of_leaf = |bvh: &Bvh| bvh.nodes.iter().position(|node| node.children[0].count > 0).expect("a leaf");
        let verdict = damaged(|bvh| shrunk(bvh, parent_of_leaf(bvh)));
        assert!(matches!(verdict, Err(ValidationError::Outside { .. })), "{verdict:?}");
        let verdict = damaged(|bvh| bvh.indices[1] = bvh.indices[0]);
        assert!(matches!(verdict, Err(ValidationError::Misplaced { .. })), "{verdict:?}");
        let verdict = damaged(|bvh| bvh.nodes[0].children[0] = NodeRef::leaf(0, 0));
        assert!(verdict.is_err(), "a loop: {verdict:?}");
        assert_eq!(
            damaged(|bvh| bvh.nodes[0].children[0] = NodeRef::node(9999)),
            Err(ValidationError::Node { node: 9999 })
        );
        let verdict = damaged(|bvh| bvh.nodes[0].children[1] = NodeRef::leaf(99, 5));
        assert!(verdict.is_err(), "a leaf past the end: {verdict:?}");
        assert_eq!(
            damaged(|bvh| bvh.centre.x += 0.01).map_err(|e| matches!(e, ValidationError::Outside { .. })),
            Err(true)
        );
    }
}
