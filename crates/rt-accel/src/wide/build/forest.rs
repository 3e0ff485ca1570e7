//! Grows a tree over many references, on one thread or on several, with the same result.

use super::binary::{BinaryTree, Content};
use super::collapse::{Costs, Plan};
use super::grow::{Rules, Set};

/// Sets of at most this size are one task: their references and nodes stay in the cache of one core.
const TASK: usize = 4096;

/// Trees that are linked to each other.
#[derive(Debug)]
pub(super) struct Forest {
    /// The first is the one to start from.
    pub(super) trees: Vec<BinaryTree>,
}

/// The upper part of a tree.
enum Upper {
    Inner(Box<[Upper; 2]>, crate::bvh::NodeBox),
    Task(crate::bvh::NodeBox, BinaryTree, Costs),
}

impl Forest {
    /// Grows the trees over a set that is not empty.
    pub(super) fn grow(set: Set<'_>, rules: &Rules) -> Self {
        let mut forest = Self { trees: vec![BinaryTree::default()] };
        forest.gather(upper(set, rules), rules);
        forest
    }

    fn gather(&mut self, upper: Upper, rules: &Rules) -> (u32, Costs) {
        match upper {
            Upper::Task(bounds, tree, costs) => {
                let link = Content::Link(self.trees.len() as u32);
                self.trees.push(tree);
                (self.trees[0].push(&bounds, link, Plan::LEAF), costs)
            }
            Upper::Inner(children, bounds) => {
                let [left, right] = *children;
                let (left, left_costs) = self.gather(left, rules);
                let (right, right_costs) = self.gather(right, rules);
                self.trees[0].join(&bounds, [left, right], [&left_costs, &right_costs], rules)
            }
        }
    }
}

fn upper(set: Set<'_>, rules: &Rules) -> Upper {
    let bounds = set.extent.bounds;
    if set.references.len() <= TASK {
        let mut tree = BinaryTree::default();
        let (_, costs) = tree.grow(set, rules);
        return Upper::Task(bounds, tree, costs);
    }
    let [left, right] = set.split(rules);
    let (left, right) = join(|| upper(left, rules), || upper(right, rules));
    Upper::Inner(Box::new([left, right]), bounds)
}

#[cfg(feature = "parallel")]
use rayon::join;

#[cfg(not(feature = "parallel"))]
fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    (a(), b())
}
