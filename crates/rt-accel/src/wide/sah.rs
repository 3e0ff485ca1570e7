//! What a tree is expected to cost.

use super::build::{LEAF, NODE, PRIMITIVE};
use super::node::Node;
use crate::bvh::NodeBox;

/// Expected cost of a ray that meets the box around all, where visiting a node is 1 (MacDonald and Booth 1990): by the
/// ratio of the areas, it meets the others. `None` if that box has no area.
pub(super) fn sah_cost(nodes: &[Node]) -> Option<f64> {
    let around = nodes.first()?.children().fold(NodeBox::EMPTY, |all, (bounds, _)| all.union(bounds));
    let mut sum = around.half_area() * f64::from(NODE);
    for (bounds, child) in nodes.iter().flat_map(Node::children) {
        let leaf = f64::from(LEAF) + f64::from(PRIMITIVE) * child.count() as f64;
        sum += bounds.half_area() * if child.is_node() { f64::from(NODE) } else { leaf };
    }
    // An empty box has an infinite area.
    let area = around.half_area();
    (area > 0.0 && area < f64::INFINITY).then(|| sum / area)
}
