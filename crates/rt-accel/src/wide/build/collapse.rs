//! Collapse of the binary tree into wide nodes of minimum expected cost, by dynamic programming. See Ylitie, Karras and
//! Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017, section 4.1.
//!
//! ```text
//!     C(n, 1) = min(leaf(n), area(n) · NODE + D(n, 8))
//!     C(n, k) = min(D(n, k), C(n, k − 1))                  for k from 2 to 7
//!     D(n, k) = min over j of C(left, j) + C(right, k − j)
//! ```
//!
//! `C(n, k)` is the minimum cost of the subtree of the binary node `n` as at most `k` children of a wide node.
//! `leaf(n)` is `area(n) · (LEAF + PRIMITIVE · count)` where the references fit into a leaf, and otherwise infinite.

/// Children of a wide node.
pub(super) const WIDTH: usize = 8;

/// Cost of a node visit, the unit of costs.
pub(in crate::wide) const NODE: f32 = 1.0;

/// Cost of a leaf visit: a test of eight primitives at once.
pub(in crate::wide) const LEAF: f32 = 0.6;

/// Cost of a primitive in a leaf, for memory traffic.
pub(in crate::wide) const PRIMITIVE: f32 = 0.1;

/// Costs of a subtree of the binary tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Costs {
    /// C(n, k) for k from 1 to 8, not increasing in k. The last repeats the one before.
    of: [f32; WIDTH],
    count: u32,
}

/// Best collapse of a binary node: four bits for each number of children from 1 to 7, lowest first.
///
/// The bits are the number of children from the left side. 0 means that one child fewer costs no more or, for one
/// child, a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CollapsePlan(u32);

/// Role of a binary node in a wide node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChildSlot {
    Leaf,
    /// A wide node, with this many children from the left side.
    Node(usize),
    /// No child itself; its sides provide these numbers of children.
    Open([usize; 2]),
}

impl CollapsePlan {
    pub(in crate::wide) const LEAF: Self = Self(0);

    fn at(self, k: usize) -> usize {
        (self.0 >> (4 * (k - 1)) & 15) as usize
    }

    /// Role with up to `k` children, for k from 1 to 7.
    pub(super) fn share(self, mut k: usize) -> ChildSlot {
        while k > 1 && self.at(k) == 0 {
            k -= 1;
        }
        match (k, self.at(k)) {
            (1, 0) => ChildSlot::Leaf,
            (1, left) => ChildSlot::Node(left),
            (_, left) => ChildSlot::Open([left, k - left]),
        }
    }
}

impl Costs {
    pub(super) const NONE: Self = Self { of: [0.0; WIDTH], count: 0 };

    pub(super) fn leaf(area: f32, count: u32) -> Self {
        Self { of: [leaf_cost(area, count); WIDTH], count }
    }

    /// Minimum cost as one child.
    pub(super) fn as_one(&self) -> f32 {
        self.of[0]
    }

    /// Costs of the parent, of this area, of two nodes.
    pub(super) fn above(area: f32, [left, right]: [&Self; 2], max_leaf: usize) -> (Self, CollapsePlan) {
        // Row k − 2 is D(n, k) for k from 2 to 8. Infinity pads rows where the right side would get no child.
        let mut padded = [f32::INFINITY; 2 * WIDTH];
        padded[WIDTH..].copy_from_slice(&right.of);
        let (mut best, mut from_left) = ([f32::INFINITY; WIDTH], [1u32; WIDTH]);
        for j in 1..WIDTH {
            let left = left.of[j - 1];
            let right = &padded[WIDTH + 1 - j..][..WIDTH];
            for row in 0..WIDTH {
                let cost = left + right[row];
                let is_less = cost < best[row];
                best[row] = if is_less { cost } else { best[row] };
                from_left[row] = if is_less { j as u32 } else { from_left[row] };
            }
        }
        let count = left.count + right.count;
        let inner = area * NODE + best[WIDTH - 2];
        let leaf = if count as usize <= max_leaf { leaf_cost(area, count) } else { f32::INFINITY };
        let is_leaf = count as usize <= max_leaf && !(inner < leaf);
        let mut plan = if is_leaf { 0 } else { from_left[WIDTH - 2] };
        let mut of = [if is_leaf { leaf } else { inner }; WIDTH];
        for k in 2..WIDTH {
            let is_less = best[k - 2] < of[k - 2];
            of[k - 1] = if is_less { best[k - 2] } else { of[k - 2] };
            plan |= if is_less { from_left[k - 2] << (4 * (k - 1)) } else { 0 };
        }
        of[WIDTH - 1] = of[WIDTH - 2];
        (Self { of, count }, CollapsePlan(plan))
    }
}

pub(super) fn leaf_cost(area: f32, count: u32) -> f32 {
    area * (LEAF + PRIMITIVE * count as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_distant_primitives_are_better_apart() {
        let side = Costs::leaf(0.01, 1);
        let (costs, plan) = Costs::above(1.0, [&side; 2], 8);
        // A leaf of both is 1 · (0.6 + 0.2), and a leaf of each is 0.01 · 0.7.
        assert!((costs.of[0] - 0.8).abs() < 1e-6 && (costs.of[1] - 0.014).abs() < 1e-6);
        assert_eq!(
            (plan.share(1), plan.share(2), plan.share(7)),
            (ChildSlot::Leaf, ChildSlot::Open([1, 1]), ChildSlot::Open([1, 1]))
        );
    }

    #[test]
    fn a_leaf_is_never_too_large() {
        let side = Costs::leaf(1.0, 4);
        let (costs, plan) = Costs::above(1.0, [&side; 2], 7);
        assert_eq!(plan.share(1), ChildSlot::Node(1));
        assert!((costs.of[0] - 3.0).abs() < 1e-6);
        assert_eq!(Costs::above(1.0, [&side; 2], 8).1.share(1), ChildSlot::Leaf);
    }

    #[test]
    fn eight_leaves_make_one_node() {
        let pair = |left: &Costs, right: &Costs| Costs::above(1.0, [left, right], 1).0;
        let [one, mut all] = [Costs::leaf(0.01, 1); 2];
        for _ in 0..6 {
            all = pair(&all, &one);
        }
        let (costs, plan) = Costs::above(1.0, [&one, &all], 1);
        assert_eq!(plan.share(1), ChildSlot::Node(1));
        assert!((costs.of[0] - (1.0 + 8.0 * 0.01 * 0.7)).abs() < 1e-6, "{:?}", costs.of);
    }

    #[test]
    fn costs_that_are_no_numbers_still_plan() {
        let side = Costs::leaf(f32::NAN, 8);
        assert_eq!(Costs::above(f32::NAN, [&side; 2], 8).1.share(1), ChildSlot::Node(1));
    }
}
