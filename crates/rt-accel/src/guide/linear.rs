//! Brute force: every ray is tested against every primitive.
//!
//! **The idea** is that there is none. The right image is the reference of all others: the same cost for every ray.
#![doc = include_str!("figures/linear.html")]
//!
//! **Build**: bounds are checked as in all accelerators, so that invalid input is rejected by all. Spheres are copied
//! as four numbers of single precision each; no other data is stored.
//!
//! **Traversal**: primitive 0, 1, 2, ... The closest hit requires all tests; any-hit queries end at the first hit.
//!
//! # Eight spheres at a time
//!
//! Projected along the ray a sphere is a disc, and the ray a point. Two directions across the ray, `u` and `w`, are
//! coordinates of that plane, and the ray misses if
//!
//! ```text
//!     (u·c − u·o)² + (w·c − w·o)²  >  r²        c: centre, r: radius, o: origin of the ray
//! ```
//!
//! These are eight multiplications and additions, for eight spheres at once and in `f32`. The stored squares of radii
//! are enlarged by a thousandth, which exceeds all rounding unless a sphere is much smaller than the list. Then a
//! margin for the ray covers it. Remaining candidates are tested in `f64` by rising index, so that results, tests and
//! hits are those of brute force. Some hits of shadow rays are certain without an exact test. Other primitives, up to
//! 16 spheres, and extreme rays and lists are tested one by one.
//!
//! # Eight rays at a time
//!
//! Streams test each of up to 16 primitives ([`SmallSet`](crate::wide::SmallSet)) with eight rays at a time. Lanes are
//! `f64`, and operations are those of the exact kernel. No data is prepared, and only grazing rays need another
//! test. This applies to spheres, triangles, quadrilaterals and planes with a [`PacketKernel`](crate::PacketKernel). Padded
//! bounds of other primitives are tested with eight rays at a time, and their kernels ray by ray. Accelerators among the
//! primitives are tested with many rays at once.
//!
//! # What "the same answer" means
//!
//! Each primitive has *padded bounds*: its bounds, slightly widened. A ray hits the primitive if it passes them in the
//! slab test **and** the kernel reports a hit. The parameter of the hit is at least that of the entry into the bounds.
//! The closest hit is the smallest (t, instance, index). [`brute_force`](crate::brute_force) computes just this, by
//! [`intersect_primitive`](rt_geometry::intersect_primitive), one primitive after the other.
//!
//! Any accelerator returns identical results if it
//!
//! 1. accepts hits by that rule only,
//! 2. culls a primitive only if the ray misses something that contains its padded bounds, in floating-point arithmetic,
//! and
//! 3. culls only what begins *strictly* after the closest hit so far, so that equal parameters are compared by index.
//!
//! The slab test consists of subtractions, products, minima and maxima, each of them monotone when rounded. So a larger
//! box is never entered later than a box inside it. That proves the second point for boxes; the pages of other
//! accelerators give their proofs.
//!
//! **Cost**: n tests, no nodes, O(n) for each ray. A test takes a few nanoseconds, and about a quarter of one for
//! spheres; 16 bytes for each sphere.
//!
//! **Choose it** for up to about ten primitives, or sixteen spheres in streams. [`brute_force`](crate::brute_force) is
//! the reference in tests.
//!
//! **Paper**: Appel, "Some techniques for shading machine renderings of solids", 1968, cast rays in this manner.
