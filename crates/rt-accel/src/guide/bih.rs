//! The bounding interval hierarchy: a tree of pairs of planes.
//!
//! **The idea**: divide primitives in two sets as a tree of boxes does, but remember only two planes at right angles
//! to one axis: where the lower set ends, and where the upper one begins. They may overlap or leave a gap.
#![doc = include_str!("figures/bih.html")]
//!
//! On the left, the blue planes are those of the first cut, and overlap by half a sphere. Where nothing has been cut
//! yet, parts reach to the walls of the whole, far beyond what is in them.
//!
//! **Build**: halve the cell of a node across its longest side, and sort primitives by where their centres are. That is
//! all: no areas, no bins. The planes lie on a regular grid over the whole scene.
//!
//! **Walk**: a ray is clipped by the plane of each side that it goes down, the near one first.
//!
//! **Why it equals brute force**: a side is a box that is infinite but for one face. It contains the own boxes below,
//! and clipping uses the operations of the slab test, which are monotone ([`linear`](super::linear)).
//!
//! # Built where rays go
//!
//! [`LazyBih`](crate::LazyBih) splits a node when a ray first comes to it. These are the parts after one ray, which
//! fell on the large sphere on the left: the other side is still to be cut. On the right all rays have arrived, at the
//! cost of the full tree.
#![doc = include_str!("figures/bih-lazy.html")]
//!
//! Whoever comes first splits a node, others wait for it; what comes out depends on the node alone. So the tree, its
//! answers and its counters do not depend on the order of rays or on the number of threads.
//!
//! # Cost
//!
//! | | mound | balls | rock | stadium |
//! |---|---|---|---|---|
//! | nodes + tests of a primary ray | 15 + 12 | 40 + 27 | 24 + 21 | 63 + 61 |
//! | nodes + tests of a diffuse ray | 32 + 22 | 79 + 47 | 47 + 41 | 47 + 46 |
//!
//! Under 20 bytes per primitive, and a tenth to a fifth of the build of [`bvh`](super::bvh), for 1.5 to 5 times its
//! nodes and tests. Lazy trees begin with 56 bytes per primitive, for the boxes of all, and end with 40 to 60.
//!
//! **Choose it** for scenes that change with every picture and are seen by few rays, and the lazy one where only a
//! small part of a large scene is seen. Where much is seen, building at once takes less time in all.
//!
//! **Paper**: Wächter and Keller, "Instant Ray Tracing: The Bounding Interval Hierarchy", 2006.
