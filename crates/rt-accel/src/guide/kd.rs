//! The kd-tree: space cut by planes along the axes.
//!
//! **The idea**: divide space, not the set of primitives. An axis-aligned plane divides the bounds of the scene in two,
//! further planes divide the parts. A ray visits the leaves in strict order, so that the first hit found is almost
//! always the closest.
#![doc = include_str!("figures/kd.html")]
//!
//! In the left image, parts never overlap, and planes lie at the faces of objects. Primitives on both sides of a plane
//! are listed on both.
//!
//! **Build**: the surface area heuristic at all faces of padded bounds, with a bonus for cutting off empty space. In
//! large sets, only faces at the ends of 32 bins are evaluated. Planes lie next to a face and not in it, where they
//! would leave the box on both sides. The number of references is bounded by 16 per primitive, and no leaf is deeper
//! than 60.
//!
//! **Traversal**: a plane divides the part of the ray within a node in two; visit the near side, push the far one. End
//! if the closest hit lies strictly before the next leaf.
//!
//! **Why it equals brute force**: the parameter of a plane is the same subtraction and product as in the slab test. The
//! widening at the far end is the same, too. Where a ray passes padded bounds, it passes one of the leaves that list
//! them. Hits beyond the current leaf are kept, since rounding may put them on the wrong side of a plane.
//!
//! # Cost
//!
//! | | mound | balls | rock | stadium |
//! |---|---|---|---|---|
//! | nodes + tests of a primary ray | 12 + 3 | 14 + 2 | 16 + 4 | 35 + 7 |
//! | nodes + tests of a diffuse ray | 27 + 12 | 32 + 9 | 39 + 16 | 33 + 10 |
//!
//! About 45 to 100 bytes per primitive; builds take 3 to 8 times as long as those of [`bvh`](super::bvh). A node is one
//! plane here and two boxes there. So this tree visits more nodes on nearly all scenes, at less cost each. It is faster
//! on *mound* and on gear wheels, and slower on *rock*.
//!
//! **Choose it** where primitives overlap little, such as rooms and buildings seen from within, and never move: there
//! is no refit. Where many primitives overlap, each is tested in several leaves.
//!
//! **Papers**: Bentley, "Multidimensional binary search trees used for associative searching", 1975. Havran, "Heuristic
//! ray shooting algorithms", 2000; Wald and Havran, "On building fast kd-trees for ray tracing, and on doing that in
//! O(N log N)", 2006.
