//! Checks what the proof of the traversal rests on.

use glam::{DVec3, Vec3A};
use rt_geometry::{Primitives, padded_bounds};
use rt_math::Aabb;

use super::Bvh;
use super::node::{Child, NodeBox};
use super::spatial::Cell;
use crate::{ValidationError, bounded_depth::MAX_DEPTH, own_boxes::validate_lists};

impl Bvh {
    /// Checks all that can be checked without the primitives: every node has one parent, no leaf is too deep for the
    /// stack of a walk, boxes contain those below, leaves list each reference once, and lists name primitives.
    pub(super) fn check_shape(&self) -> Result<(), ValidationError> {
        let mut n_listed = 0;
        self.for_each_leaf(|leaf, _| {
            // Leaves follow one another, so that these sums show gaps and repetitions.
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
        let is_sorted = self.pieces.is_sorted_by(|a, b| a.position < b.position);
        if !is_sorted || self.pieces.last().is_some_and(|piece| piece.position as usize >= self.indices.len()) {
            return Err(ValidationError::Count { built: self.indices.len() as u32, given: self.pieces.len() });
        }
        Ok(())
    }

    /// Checks the shape, and that boxes contain what they are around: every bounded primitive is in exactly one leaf
    /// inside of which its own box lies, or in several that each contain its part of a tiling of space.
    pub(super) fn check<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        self.check_shape()?;
        let count = self.bounded as usize + self.unbounded.len();
        validate_lists(primitives, count as u32, &self.unbounded)?;
        let mut is_placed = vec![false; count];
        self.unbounded.iter().for_each(|&primitive| is_placed[primitive as usize] = true);
        let mut pieces = self.pieces.iter().peekable();
        let mut cells: Vec<(u32, Cell)> = Vec::new();
        self.for_each_leaf(|leaf, bounds| {
            for (position, &primitive) in (leaf.first..).zip(self.leaf(leaf)) {
                let cell = pieces.next_if(|piece| piece.position == position).map(|piece| piece.cell);
                let own = padded_bounds(primitives, primitive).ok_or(ValidationError::Misplaced { primitive })?;
                if !encloses(bounds, &own, &cell.unwrap_or(Cell::EVERYWHERE), self.centre) {
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
        mut visit: impl FnMut(Child, &NodeBox) -> Result<(), ValidationError>,
    ) -> Result<(), ValidationError> {
        let everything = NodeBox { min: Vec3A::NEG_INFINITY, max: Vec3A::INFINITY };
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

/// True if every point belongs to exactly one of the cells. They come from planes that cut all of space, or all of
/// what one side of another such plane leaves, so there is always one that separates some from the others.
fn tile_space(cells: Vec<Cell>) -> bool {
    let mut pending = vec![(Cell::EVERYWHERE, cells)];
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
pub(crate) fn encloses(outer: &NodeBox, aabb: &Aabb, cell: &Cell, centre: DVec3) -> bool {
    (0..3).all(|axis| {
        (is_at_most(outer.min[axis], aabb.min[axis], centre[axis]) || outer.min[axis] < cell.min[axis])
            && (is_at_most(-outer.max[axis], -aabb.max[axis], -centre[axis]) || outer.max[axis] > cell.max[axis])
    })
}

/// `plane ≤ b − c` for the real numbers: the rounded difference decides, or where it is equal, its error.
fn is_at_most(plane: f32, b: f64, c: f64) -> bool {
    let difference = b - c;
    // Knuth's exact error of a difference (TAOCP 2, 4.2.2, theorem B).
    let c_part = b - difference;
    let error = (b - (difference + c_part)) + (c_part - c);
    let plane = f64::from(plane);
    plane < difference || (plane == difference && error >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AcceleratorQueries, bvh::node::Node};
    use rt_geometry::Hit;
    use rt_math::{Interval, Ray};

    struct Row;

    impl Primitives for Row {
        fn len(&self) -> usize {
            100
        }
        fn bounds(&self, index: u32) -> Option<Aabb> {
            Some(Aabb::new(DVec3::X * f64::from(index), DVec3::X * f64::from(index) + 0.5))
        }
        fn intersect(&self, _: u32, _: &Ray, _: Interval) -> Option<Hit> {
            None
        }
    }

    fn damaged(damage: impl FnOnce(&mut Bvh)) -> Result<(), ValidationError> {
        let mut bvh = Bvh::build(&Row).expect("bounded");
        assert_eq!(bvh.validate(&Row), Ok(()));
        damage(&mut bvh);
        bvh.validate(&Row)
    }

    #[test]
    fn damage_is_found() {
        let shrunk = |bvh: &mut Bvh, number: usize| {
            let node = &mut bvh.nodes[number];
            let [left, right] = [0, 1].map(|side| node.child_box(side));
            let smaller = NodeBox { max: left.max - 0.3, ..left };
            *node = Node::new([smaller, right], node.children);
        };
        assert_eq!(damaged(|bvh| shrunk(bvh, 0)), Err(ValidationError::Node { node: 1 }), "does not contain its child");
        let parent_of_leaf = |bvh: &Bvh| bvh.nodes.iter().position(|node| node.children[0].count > 0).expect("a leaf");
        let verdict = damaged(|bvh| shrunk(bvh, parent_of_leaf(bvh)));
        assert!(matches!(verdict, Err(ValidationError::Outside { .. })), "{verdict:?}");
        let verdict = damaged(|bvh| bvh.indices[1] = bvh.indices[0]);
        assert!(matches!(verdict, Err(ValidationError::Misplaced { .. })), "{verdict:?}");
        let verdict = damaged(|bvh| bvh.nodes[0].children[0] = Child::leaf(0, 0));
        assert!(verdict.is_err(), "a loop: {verdict:?}");
        assert_eq!(
            damaged(|bvh| bvh.nodes[0].children[0] = Child::node(9999)),
            Err(ValidationError::Node { node: 9999 })
        );
        let verdict = damaged(|bvh| bvh.nodes[0].children[1] = Child::leaf(99, 5));
        assert!(verdict.is_err(), "a leaf past the end: {verdict:?}");
        assert_eq!(
            damaged(|bvh| bvh.centre.x += 0.01).map_err(|e| matches!(e, ValidationError::Outside { .. })),
            Err(true)
        );
    }

    #[test]
    fn containment_is_decided_without_rounding() {
        // 1 − 2⁻⁶⁰ rounds to 1; the real number is below it.
        let tiny = 1.0 / (1u64 << 60) as f64;
        assert!(!is_at_most(1.0, 1.0, tiny));
        assert!(is_at_most(1.0, 1.0, -tiny) && is_at_most(1.0, 1.0, 0.0));
        assert!(!is_at_most(1.0, f64::NAN, 0.0));
    }
}
