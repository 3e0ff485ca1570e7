//! The size and shape of a structure.

/// What a builder made. Times are the caller's to take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
}
