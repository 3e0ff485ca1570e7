//! The uniform grid: cells of equal size.
//!
//! **The idea**: divide the bounds of the scene into equal cells with lists of primitives. A ray tests the primitives
//! of the cells on its path, in order, and stops soon after the first hit.
#![doc = include_str!("figures/grid.html")]
//!
//! The left image shows non-empty cells only: large spheres are in many, and several small ones share one.
//!
//! **Build**: a counting sort of references by cell. There are about six nearly cubical cells per primitive
//! ([`UniformGrid::build`](crate::UniformGrid::build)), or a given number
//! ([`with_resolution`](crate::UniformGrid::with_resolution)). O(n), and among the fastest
//! builds.
//!
//! **Traversal**: a ray crosses planes of three families, and the nearest plane leads to the next cell. Parameters are
//! computed from the index of the plane, never accumulated: sums drift away from the planes, after 10⁵ steps by whole
//! cells in `f32`.
//!
//! **Why it equals brute force**: a primitive is listed in every cell that its padded bounds touch. Intersections with
//! planes are the same subtractions and products as those of the slab test. Where a ray is inside the padded bounds it
//! is therefore in a cell that lists the primitive. Hits outside the current cell are kept, and the traversal ends when
//! the next cell begins strictly after the closest hit.
//!
//! # Cost
//!
//! | | mound | balls | rock | stadium |
//! |---|---|---|---|---|
//! | nodes + tests of a primary ray | 12 + 5 | 24 + 7 | 20 + 9 | 2 + 48,000 |
//! | nodes + tests of a diffuse ray | 12 + 16 | 23 + 24 | 23 + 31 | 50 + 32,000 |
//!
//! About 30 to 100 bytes per primitive. A ray across the scene passes O(∛n) cells. The stadium shows the limits of a
//! grid: the whole rock fits into a few cells, and all their triangles are tested. In the right image, rays past the
//! large spheres are expensive, since cells are everywhere and most are empty.
//!
//! **Choose it** for evenly distributed primitives of similar size: atoms, particles, grains. There a ray
//! takes up to 2.2 times as long as in the best tree, and a build a quarter of that of [`bvh`](super::bvh). Avoid it for scenes with a few primitives far away from many.
//!
//! **Papers**: Fujimoto, Tanaka and Iwata, "ARTS: Accelerated Ray-Tracing System", 1986. Amanatides and Woo, "A Fast
//! Voxel Traversal Algorithm for Ray Tracing", 1987; Haines named the teapot in the stadium in 1988.
