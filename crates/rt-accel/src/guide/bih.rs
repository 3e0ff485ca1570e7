//! The bounding interval hierarchy: a tree of pairs of planes.
//!
//! **The idea**: divide primitives in two sets as a tree of boxes does. Store only two planes at right angles to one
//! axis: the end of the lower set and the beginning of the upper one. They may overlap or leave a gap.
#![doc = include_str!("figures/bih.html")]
//!
//! In the left image, the blue planes are those of the first split, and overlap by half a sphere. Without further
//! planes, parts extend to the bounds of the scene, far beyond their contents.
//!
//! **Build**: halve the cell of a node across its longest side, and sort primitives by their centres, without areas or
//! bins. The planes lie on a regular grid over the whole scene.
//!
//! **Traversal**: a ray is clipped by the plane of each visited side, the near side first.
//!
//! **Why it equals brute force**: a side is a box that is infinite but for one face. It contains the padded bounds
//! below, and clipping uses the operations of the slab test, which are monotone ([`linear`](super::linear)).
//!
//! # Built where rays go
//!
//! [`LazyBih`](crate::LazyBih) splits a node at the first visit. The left image shows the parts after one ray, which
//! hit the large sphere on the left: the other side is not split yet. The right image shows the cost of the full tree
//! after all rays.
#![doc = include_str!("figures/bih-lazy.html")]
//!
//! The first thread splits a node while others wait; the result depends on the node alone. So the tree, the results and
//! the counters are independent of the order of rays and of the number of threads.
//!
//! # Cost
//!
//! | | mound | balls | rock | stadium |
//! |---|---|---|---|---|
//! | nodes + tests of a primary ray | 15 + 12 | 40 + 27 | 24 + 21 | 63 + 61 |
//! | nodes + tests of a diffuse ray | 32 + 22 | 79 + 47 | 47 + 41 | 47 + 46 |
//!
//! Under 20 bytes per primitive, and a fifth to a third of the build of [`bvh`](super::bvh), for 1.5 to 5 times its
//! nodes and tests. Lazy trees begin with 56 bytes per primitive, for the boxes of all, and end with 40 to 60.
//!
//! **Choose it** for scenes that change with every image and have few rays. Choose the lazy one where only a small part
//! of a large scene is visible. Where much is visible, building at once takes less time in total.
//!
//! **Paper**: Wächter and Keller, "Instant Ray Tracing: The Bounding Interval Hierarchy", 2006.
