//! Size and shape of an accelerator.

/// Size and shape of an accelerator. Build times are left to the caller.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BuildStats {
    /// Primitives, bounded or not.
    pub primitives: usize,
    /// Primitives without bounds, which every ray is tested against.
    pub unbounded: usize,
    /// Inner nodes of a tree, or cells of a grid; 0 for a list.
    pub nodes: usize,
    /// Leaves of a tree, or occupied cells of a grid.
    pub leaves: usize,
    /// Depth of the deepest leaf; a root that is a leaf has depth 0.
    pub max_depth: usize,
    /// References to primitives in all leaves or cells: the number of bounded primitives for a tree, more for a grid.
    pub references: usize,
    /// Expected cost of a ray that hits the bounds of the scene, in visits of a node. An estimate by the surface area
    /// heuristic (MacDonald and Booth 1990). Costs of leaves depend on the builder, so that only trees of one kind are
    /// comparable. `None` for accelerators without the heuristic, and for scenes without area.
    pub sah_cost: Option<f64>,
}
