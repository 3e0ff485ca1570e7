//! The wide hierarchy: a tree of boxes with eight children to a node.
//!
//! **The idea**: processors compute eight numbers of single precision as fast as one. A node holds eight boxes side by
//! side, and one pass says which of them a ray enters, and when. The tree is a third as deep, so a ray waits a third as
//! often for memory.
#![doc = include_str!("figures/wide.html")]
//!
//! On the left, blue boxes are the children of the root. On the right, a node counts once, though it is eight boxes.
//!
//! **Build**: a binary tree by the surface area heuristic first, from which the nodes of eight are taken that make the
//! expected cost least, by dynamic programming. [`Quality`](crate::wide::Quality) says how much time it may take: *low*
//! looks at one axis, *medium* at all, and then takes the largest subtrees out and puts them back where they cost least;
//! *high* does so with subtrees of all sizes. The tree is the same on any number of threads. Large trees are kept in large
//! pages of memory where the system has them.
//!
//! **Walk**: sort what is entered, go to the nearest and put the others off. Leaves hold copies of plain numbers,
//! [`PrimitiveGeometry`](crate::PrimitiveGeometry): eight triangles, spheres or boxes are tested at a time as well. The answer is one of
//! three: missed for certain, hit for certain, or in doubt. What is hit for certain ends the search for shadows at once,
//! and otherwise bounds where the first hit can be; the rest is decided in `f64`, about once for a ray. Where at most a quarter
//! of all primitives are something else, leaves are of spheres, with balls around the others.
//!
//! **Batches**: `closest_batch` sends eight rays as a packet where they go about the same way, each within an eighth of the
//! steepest component of the first one: each box, and each triangle or sphere, is then tested with all eight. Where one or
//! two are left, each goes on alone. In trees of 256 spheres and more up to 64 rays that pass boxes through the same sides
//! are looked at together first: what none of them can meet, none of their packets is asked about. Whether and where a packet meets spheres that are
//! [`PrimitiveGeometry::ExactSphere`](crate::PrimitiveGeometry::Round) is decided for all its rays side by side as well, and where
//! triangles are hit for certain, for those that hit the same one. Rays that do not agree
//! go side by side through trees of more than 8 MiB: sixteen are under way, and while one waits for its next node, others go
//! on. Three to seven rays at the end of a batch share a packet as well. A primitive that is a structure itself
//! ([`BatchKernel::Instance`](crate::BatchKernel::Instance)), an instance, is asked for all rays of a packet together that may meet it, if
//! these are more than two. Put rays that go the same way next to each other.
//!
//! **Why it equals brute force**: the `f32` arithmetic errs outwards. A box is entered no later and left no earlier than
//! any own box in it, and tests of triangles and spheres have margins for all that can be rounded; the proofs stand atop
//! the files that compute. Whoever is first is decided as brute force decides, so that AVX-512, AVX2 and the portable
//! instructions ([`SimdLevel`](crate::wide::SimdLevel)) give the same bits. Rays and trees whose numbers are out of
//! proportion are walked in `f64` altogether.
//!
//! # Cost
//!
//! About 60 bytes per triangle, O(n log n) to build, O(log n) nodes for a ray; a ray of the kind that cameras send takes
//! some four to six nodes and four to five tests in a room of 57 thousand triangles.
//!
//! **Choose it** for rendering, also of what moves ([`Refit`](crate::Refit)). Choose [`Bvh`](crate::Bvh) where memory matters
//! more than time.
//!
//! **Papers**: Ernst and Greiner, "Multi bounding volume hierarchies", 2008; Wald, Benthin and Boulos, "Getting rid of
//! packets", 2008; Meister and Bittner, "Parallel reinsertion for bounding volume hierarchy optimization", 2018; Ylitie,
//! Karras and Laine, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs", 2017.
