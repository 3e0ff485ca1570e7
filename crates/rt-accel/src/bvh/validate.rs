//! Checks what the proof of the traversal rests on.

use glam::DVec3;
use rt_math::{Aabb, Primitives, own_box};

use super::Bvh;
use super::node::{Child, NodeBox};
use super::split::MAX_DEPTH;
use crate::Violation;
use crate::own_boxes::validate_lists;

impl Bvh {
    /// Checks that the tree fits the primitives: every bounded one is in exactly one leaf, all boxes above it contain
    /// its own box, and no leaf is too deep for the traversal stack. O(n).
    ///
    /// # Errors
    ///
    /// The first [`Violation`] found.
    pub fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), Violation> {
        let count = self.indices.len() + self.unbounded.len();
        validate_lists(primitives, count as u32, &self.unbounded)?;
        let mut is_placed = vec![false; count];
        let everything = NodeBox { min: glam::Vec3A::NEG_INFINITY, max: glam::Vec3A::INFINITY };
        let mut pending = vec![(self.root, everything, 0)];
        let mut n_visited = 0;
        while let Some((child, bounds, depth)) = pending.pop() {
            if depth > MAX_DEPTH {
                return Err(Violation::Depth { depth });
            }
            if child.count > 0 || self.nodes.is_empty() {
                self.validate_leaf(primitives, child, &bounds, &mut is_placed)?;
                continue;
            }
            let number = child.first;
            n_visited += 1;
            let Some(node) = self.nodes.get(number as usize).filter(|_| n_visited <= self.nodes.len()) else {
                return Err(Violation::Node { node: number });
            };
            for side in 0..2 {
                let inner = node.child_box(side);
                if inner.union(bounds) != bounds {
                    return Err(Violation::Node { node: number });
                }
                pending.push((node.children[side], inner, depth + 1));
            }
        }
        for &primitive in &self.unbounded {
            is_placed[primitive as usize] = true;
        }
        match is_placed.iter().position(|placed| !placed) {
            Some(primitive) => Err(Violation::Misplaced { primitive: primitive as u32 }),
            None => Ok(()),
        }
    }

    fn validate_leaf<P: Primitives>(
        &self,
        primitives: &P,
        leaf: Child,
        bounds: &NodeBox,
        is_placed: &mut [bool],
    ) -> Result<(), Violation> {
        let run = leaf.first as usize..leaf.first as usize + leaf.count as usize;
        for &primitive in self.indices.get(run).unwrap_or_default() {
            match is_placed.get_mut(primitive as usize) {
                Some(placed) if !*placed => *placed = true,
                _ => return Err(Violation::Misplaced { primitive }),
            }
            let Some(own) = own_box(primitives, primitive) else {
                return Err(Violation::Misplaced { primitive });
            };
            if !encloses(bounds, &own, self.centre) {
                return Err(Violation::Outside { primitive });
            }
        }
        Ok(())
    }
}

/// True if `outer` contains `aabb − centre`, without rounding.
fn encloses(outer: &NodeBox, aabb: &Aabb, centre: DVec3) -> bool {
    (0..3).all(|axis| {
        is_at_most(outer.min[axis], aabb.min[axis], centre[axis])
            && is_at_most(-outer.max[axis], -aabb.max[axis], -centre[axis])
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
