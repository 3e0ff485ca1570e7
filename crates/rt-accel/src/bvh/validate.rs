//! Checks what the proof of the traversal rests on.

use glam::DVec3;
use rt_math::{Aabb, Primitives, own_box};

use super::Bvh;
use super::node::{Child, NodeBox};
use crate::Violation;
use crate::bounded_depth::MAX_DEPTH;
use crate::own_boxes::validate_lists;

impl Bvh {
    /// Every bounded primitive is in exactly one leaf, all boxes above it contain its own box, and no leaf is too deep
    /// for the traversal stack.
    pub(super) fn check<P: Primitives>(&self, primitives: &P) -> Result<(), Violation> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Structure;
    use crate::bvh::node::Node;
    use rt_math::{Hit, Interval, Ray};

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

    fn damaged(damage: impl FnOnce(&mut Bvh)) -> Result<(), Violation> {
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
        assert_eq!(damaged(|bvh| shrunk(bvh, 0)), Err(Violation::Node { node: 1 }), "does not contain its child");
        let parent_of_leaf = |bvh: &Bvh| bvh.nodes.iter().position(|node| node.children[0].count > 0).expect("a leaf");
        let verdict = damaged(|bvh| shrunk(bvh, parent_of_leaf(bvh)));
        assert!(matches!(verdict, Err(Violation::Outside { .. })), "{verdict:?}");
        let verdict = damaged(|bvh| bvh.indices[1] = bvh.indices[0]);
        assert!(matches!(verdict, Err(Violation::Misplaced { .. })), "{verdict:?}");
        let verdict = damaged(|bvh| bvh.nodes[0].children[0] = Child::leaf(0, 0));
        assert!(verdict.is_err(), "a loop: {verdict:?}");
        assert_eq!(damaged(|bvh| bvh.nodes[0].children[0] = Child::node(9999)), Err(Violation::Node { node: 9999 }));
        let verdict = damaged(|bvh| bvh.nodes[0].children[1] = Child::leaf(99, 5));
        assert!(verdict.is_err(), "a leaf past the end: {verdict:?}");
        assert_eq!(damaged(|bvh| bvh.centre.x += 0.01).map_err(|e| matches!(e, Violation::Outside { .. })), Err(true));
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
