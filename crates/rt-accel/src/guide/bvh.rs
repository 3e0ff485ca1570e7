//! The bounding volume hierarchy: a tree of boxes.
//!
//! **The idea**: put a box around everything, divide what is in it into two sets, put a box around each, and so on. A
//! ray that misses a box misses all that is in it.
#![doc = include_str!("figures/bvh.html")]
//!
//! On the left, blue boxes are the two sides of the first cut; boxes may overlap, and each primitive is in one leaf.
//! The heap of small spheres gets a part of the tree to itself. On the right, only rays close to many small spheres
//! are dear.
//!
//! **Build**: from the root down. The *surface area heuristic* guesses the cost of a cut: a random ray that meets a
//! box meets a box inside it with the ratio of their areas as the probability. Centres are sorted into 16 bins on each
//! axis, and the border between two bins with the least area times number of primitives is taken. [`SplitMethod`]
//! offers medians, which are built faster, and spatial splits, which may list large primitives twice. Both sides of
//! large sets are built at the same time; the tree is the same on any number of threads.
//!
//! **Walk**: look at the boxes of both children, go to the one that is entered first, and put the other off. When it
//! comes back to one that is entered strictly after the best hit so far, it passes it over. The list of what was put
//! off is a small array: no leaf is deeper than 60.
//!
//! **Why it equals brute force**: every box contains the own boxes below it, and the slab test of a larger box is
//! never entered later ([`linear`](super::linear)). Nodes keep boxes as `f32`, rounded outwards, in a cache line of 64
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
//! **Choose it** for everything of which you do not know better. It does not mind what size primitives are and where
//! they are, answers nearest points and overlaps as well as rays, and follows motion: [`Refit`](crate::Refit) fits the
//! boxes and keeps the tree.
//!
//! **Papers**: Rubin and Whitted, "A 3-dimensional representation for fast rendering of complex scenes", 1980;
//! Goldsmith and Salmon, "Automatic creation of object hierarchies for ray tracing", 1987; MacDonald and Booth,
//! "Heuristics for ray tracing using space subdivision", 1990; Wald, "On fast construction of SAH-based bounding
//! volume hierarchies", 2007.
//!
//! [`SplitMethod`]: crate::SplitMethod
