//! The size and shape of a structure.

/// What a builder made. Times are the caller's to take.
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
    /// Expected cost of a ray that meets the box around all, by the surface area heuristic (MacDonald and Booth 1990):
    /// visiting a node is 1, and a leaf costs what its builder takes it for, so that only trees of the same kind can be
    /// compared. `None` for structures that are not built by it, and where there is no area.
    pub sah_cost: Option<f64>,
}
