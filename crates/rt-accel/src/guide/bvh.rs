//! The bounding volume hierarchy: a tree of boxes.
//!
//! **The idea**: enclose the scene in a box, divide its primitives into two sets, enclose each in a box, and so on. A
//! ray that misses a box misses its contents.
#![doc = include_str!("figures/bvh.html")]
//!
//! In the left image, blue boxes are the two sides of the first split; boxes may overlap, and each primitive is in one
//! leaf. The heap of small spheres has its own subtree. In the right image, only rays close to many small spheres are
//! expensive.
//!
//! **Build**: top-down. The *surface area heuristic* estimates the cost of a split. A random ray that hits a box hits a
//! box inside it with the ratio of their areas as the probability. Centres are sorted into 16 bins on each axis, and
//! the border between two bins with the smallest area times number of primitives is selected. [`SplitMethod`] also has
//! medians, which build faster, and spatial splits, which may list large primitives twice. Both sides of large sets are
//! built in parallel; the tree is the same on any number of threads.
//!
//! **Traversal**: test the boxes of both children, visit the one that is entered first, and push the other. Popped
//! nodes that are entered strictly after the closest hit so far are skipped. The stack is a small array: no leaf is
//! deeper than 60.
//!
//! **Why it equals brute force**: every box contains the padded bounds below it, and the slab test never enters a
//! larger box later ([`linear`](super::linear)). Nodes keep boxes as `f32`, rounded outwards, in a cache line of 64
//! bytes for both children; the arithmetic is `f64`.
//!
//! # Cost
//!
//! | | mound | balls | rock | stadium |
//! |---|---|---|---|---|
//! | nodes + tests of a primary ray | 9 + 2 | 8 + 1 | 9 + 2 | 19 + 4 |
//! | nodes + tests of a diffuse ray | 24 + 6 | 24 + 3 | 23 + 6 | 19 + 6 |
//!
//! About 25 to 45 bytes per primitive, O(n log n) to build, O(log n) nodes for a ray. One node is two boxes.
//!
//! **Choose it** by default where memory matters. Sizes and positions of primitives hardly affect it. It supports
//! nearest points and overlaps as well as rays. It follows motion: [`Refit`](crate::Refit) fits the boxes and keeps the
//! tree.
//!
//! **Papers**: Rubin and Whitted, "A 3-dimensional representation for fast rendering of complex scenes", 1980.
//! Goldsmith and Salmon, "Automatic creation of object hierarchies for ray tracing", 1987. MacDonald and Booth,
//! "Heuristics for ray tracing using space subdivision", 1990; Wald, "On fast construction of SAH-based bounding volume
//! hierarchies", 2007.
//!
//! [`SplitMethod`]: crate::SplitMethod
