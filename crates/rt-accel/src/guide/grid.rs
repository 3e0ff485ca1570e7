//! The uniform grid: cells of equal size.
//!
//! **The idea**: cut the box around everything into equal cells, and note in each which primitives are in it. A ray
//! asks those of the cells that it passes, in order, and stops soon after the first hit.
#![doc = include_str!("figures/grid.html")]
//!
//! On the left, only cells that are not empty are drawn: large spheres are in many, and several small ones share one.
//!
//! **Build**: count the primitives of each cell, add the counts up, put the references in their places. There are some
//! six nearly cubical cells for each primitive ([`UniformGrid::build`](crate::UniformGrid::build)), or as many as the
//! caller says ([`with_resolution`](crate::UniformGrid::with_resolution)). O(n), and the fastest build that sorts
//! anything.
//!
//! **Walk**: a ray crosses planes of three families, and the nearest crossing leads to the next cell. The parameter of
//! a crossing is computed from the number of its plane, never by adding steps: sums drift away from the planes, after
//! 10⁵ steps by whole cells in `f32`.
//!
//! **Why it equals brute force**: a primitive is listed in every cell that its own box touches, and crossings are the
//! same subtractions and products as those of the slab test. Where a ray is inside the own box it is therefore in a
//! cell that lists the primitive. Hits outside of the cell at hand are kept, not thrown away, and the walk ends when
//! the next cell begins strictly after the best.
//!
//! # Cost
//!
//! | | mound | balls | rock | stadium |
//! |---|---|---|---|---|
//! | nodes + tests of a primary ray | 12 + 5 | 24 + 7 | 20 + 9 | 2 + 48,000 |
//! | nodes + tests of a diffuse ray | 12 + 16 | 23 + 24 | 23 + 31 | 50 + 32,000 |
//!
//! About 30 to 100 bytes per primitive. A ray that crosses everything passes O(∛n) cells. The stadium shows how a grid
//! fails: the whole rock fits into a few cells, all of whose triangles are asked. On the right, rays that pass the
//! large spheres by are dear, since there are cells everywhere and most are empty.
//!
//! **Choose it** where primitives are of similar size and evenly spread: atoms, particles, grains. There a ray takes
//! as little time as in the best tree, and a build a tenth. Never where few primitives are far away from many.
//!
//! **Papers**: Fujimoto, Tanaka and Iwata, "ARTS: Accelerated Ray-Tracing System", 1986; Amanatides and Woo, "A Fast
//! Voxel Traversal Algorithm for Ray Tracing", 1987; Haines named the teapot in the stadium in 1988.
