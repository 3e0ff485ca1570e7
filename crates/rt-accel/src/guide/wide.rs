//! The wide hierarchy: a tree of boxes with eight children per node.
//!
//! **The idea**: processors compute eight numbers of single precision as fast as one. A node holds eight boxes, which
//! one SIMD test intersects. The tree has a third of the depth, and a third of the waits for memory.
#![doc = include_str!("figures/bvh8.html")]
//!
//! In the left image, blue boxes are the children of the root. In the right image, a node counts once, although it has
//! eight boxes.
//!
//! **Build**: a binary tree by the surface area heuristic, collapsed to nodes of eight with the smallest expected cost,
//! by dynamic programming. [`Quality`](crate::wide::Quality) limits the time: *low* bins one axis, *medium* all, and
//! then reinserts the largest subtrees where they cost least. *high* does so with subtrees of all sizes. The tree is
//! the same on any number of threads. Large trees use large pages of memory where available.
//!
//! **Traversal**: sort the entered boxes, visit the nearest and push the others. Leaves hold copies of plain numbers,
//! [`PrimitiveGeometry`](crate::PrimitiveGeometry): eight triangles, spheres or boxes are tested at a time as well. The
//! result is a certain miss, a certain hit, or uncertain. Certain hits end shadow queries at once, and otherwise bound
//! the closest hit; the rest is tested in `f64`, about once per ray. Where at most a quarter of all primitives are
//! something else, leaves are of spheres, with bounding spheres of the others.
//!
//! **Streams**: [`closest_stream`](crate::Accelerator::closest_stream) takes up to 256 rays as a structure of arrays. Eight
//! coherent rays are traced as a packet. Their directions differ from that of the first by at
//! most an eighth of its largest component. Each box, and each triangle or sphere, is then tested with all eight. One or two remaining rays
//! are traced alone. In trees of 256 spheres and more, up to 64 rays of one octant are culled together first by a
//! common frustum. Tests of [`PrimitiveGeometry::ExactSphere`](crate::PrimitiveGeometry::ExactSphere) are exact for the
//! whole packet, and so are certain hits of one triangle. Incoherent rays are interleaved in trees of more than 8 MiB:
//! sixteen are in flight, and while one waits for its next node, others proceed. Three to seven rays at the end of a
//! stream share a packet as well. A primitive that is an accelerator itself
//! ([`PacketKernel::Instance`](crate::PacketKernel::Instance)) is tested with more than two rays of a packet together.
//! Put coherent rays next to each other.
//!
//! **Small trees** have at most 64 triangles. Incoherent rays of a stream are tested with all of them, eight rays at a time.
//! The filter leaves three candidates for each ray. The triangle that a ray starts on is skipped if the ray
//! certainly leaves it. The nearest of the others is intersected exactly, for eight rays and triangles together. Few rays
//! are left for the nodes. Queries that count their work use the tree.
//!
//! **Why it equals brute force**: the `f32` arithmetic errs outwards. A box is entered no later and left no earlier
//! than any padded bounds in it. Tests of triangles and spheres have margins for all rounding. The proofs are at the
//! top of the files. The closest hit is selected as in brute force, so that AVX-512, AVX2 and the portable instructions
//! ([`SimdLevel`](crate::wide::SimdLevel)) return the same bits. Extreme rays and trees are traversed in `f64`
//! altogether.
//!
//! # Cost
//!
//! About 60 bytes per triangle, O(n log n) to build, O(log n) nodes for a ray. A camera ray takes some four to six
//! nodes and four to five tests in a room of 57 thousand triangles.
//!
//! **Choose it** for rendering, also of moving scenes ([`Refit`](crate::Refit)). Choose [`Bvh`](crate::Bvh) where
//! memory matters more than time.
//!
//! **Papers**: Ernst and Greiner, "Multi bounding volume hierarchies", 2008. Wald, Benthin and Boulos, "Getting rid of
//! packets", 2008. Meister and Bittner, "Parallel reinsertion for bounding volume hierarchy optimization", 2018.
//! Ylitie, Karras and Laine, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs", 2017.
