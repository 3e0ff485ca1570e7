//! The kd-tree: space cut by planes along the axes.
//!
//! **The idea**: cut the space, not the set of primitives. A plane at a right angle to an axis divides the box around
//! everything in two, further planes divide the parts. A ray passes the leaves in strict order, so that the first hit
//! found is almost always the first there is.
#![doc = include_str!("figures/kd.html")]
//!
//! On the left, parts never overlap, and planes lie at the faces of things. What a plane cuts in two is listed on both
//! sides.
//!
//! **Build**: the surface area heuristic at all faces of own boxes, or at 32 bins of them where there are many, with a
//! bonus for cutting off empty space. Planes lie just beside a face and not in it, where they would leave the box on
//! both sides. The number of references is bounded by 16 per primitive, and no leaf is deeper than 60.
//!
//! **Walk**: a plane divides the part of the ray within a node in two; go down the near one, put the far one off. End
//! if the best hit lies strictly before the next leaf.
//!
//! **Why it equals brute force**: the parameter of a plane is the same subtraction and product as in the slab test,
//! with the same widening at the far end. Where a ray passes an own box, it passes one of the leaves that list it.
//! Hits beyond the leaf at hand are kept, since they might be rounded to the wrong side of a plane.
//!
//! # Cost
//!
//! | | mound | balls | rock | stadium |
//! |---|---|---|---|---|
//! | nodes + tests of a primary ray | 12 + 3 | 14 + 2 | 16 + 4 | 35 + 7 |
//! | nodes + tests of a diffuse ray | 27 + 12 | 32 + 9 | 39 + 16 | 33 + 10 |
//!
//! About 45 to 100 bytes per primitive; builds take 2 to 8 times as long as those of boxes. Lectures say that a kd-tree
//! visits the fewest nodes of all trees. A node of it is one plane, and one of [`bvh`](super::bvh) is two boxes, so that
//! ours visits more nodes on nearly all scenes, at less cost each: on *mound* and on gear wheels its rays are the faster
//! ones, on *rock* the slower ones.
//!
//! **Choose it** where primitives overlap little, such as rooms and buildings seen from within, and never move: there
//! is no refit, only another build. Where many primitives overlap, each is tested in several leaves.
//!
//! **Papers**: Bentley, "Multidimensional binary search trees used for associative searching", 1975; Havran,
//! "Heuristic ray shooting algorithms", 2000; Wald and Havran, "On building fast kd-trees for ray tracing, and on
//! doing that in O(N log N)", 2006.
