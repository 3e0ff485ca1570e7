//! Expected cost of traversal.

use super::build::{LEAF, NODE, PRIMITIVE};
use super::node::WideNode;
use crate::bvh::Aabb32;

/// Surface area heuristic (MacDonald and Booth 1990): the expected cost of a ray that hits the root's box, in node
/// visits. `None` if that box has no area.
pub(super) fn sah_cost(nodes: &[WideNode]) -> Option<f64> {
    let around = nodes.first()?.children().fold(Aabb32::EMPTY, |all, (bounds, _)| all.union(bounds));
    let mut sum = around.half_area() * f64::from(NODE);
    for (bounds, child) in nodes.iter().flat_map(WideNode::children) {
        let leaf = f64::from(LEAF) + f64::from(PRIMITIVE) * child.count() as f64;
        sum += bounds.half_area() * if child.is_node() { f64::from(NODE) } else { leaf };
    }
    // An empty box has an infinite area.
    let area = around.half_area();
    (area > 0.0 && area < f64::INFINITY).then(|| sum / area)
}
