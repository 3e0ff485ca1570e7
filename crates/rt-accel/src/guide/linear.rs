//! Brute force: every ray asks every primitive.
//!
//! **The idea** is that there is none. On the right is what all other structures are compared with: the same cost for every
//! ray, whatever it meets.
#![doc = include_str!("figures/linear.html")]
//!
//! **Build**: bounds are checked as in all structures, so that they refuse the same input. Spheres are copied, as four numbers
//! of single precision side by side; nothing else is stored.
//!
//! **Walk**: primitive 0, 1, 2, ... For the first hit all are asked; whether anything is hit is known at the first
//! that is.
//!
//! # Eight spheres at a time
//!
//! Seen along the ray a sphere is a disc, and the ray a point. Two directions across the ray, `u` and `w`, make coordinates
//! of that plane, and the ray misses
//!
//! ```text
//!     (u·c − u·o)² + (w·c − w·o)²  >  r²        c: centre, r: radius, o: origin of the ray
//! ```
//!
//! That is eight multiplications and additions, for eight spheres at once and in `f32`. The squares of radii are kept
//! enlarged by a thousandth, which is more than rounding can do to all this unless a sphere is much smaller than the list;
//! then a margin for the ray takes care of it. What is left is decided in `f64` by rising index, so that answers, tests and
//! hits are those of brute force. Of shadow rays some hits are beyond doubt, and not decided at all. What is no sphere,
//! up to 16 spheres, and rays and lists out of all proportion are tested one by one.
//!
//! # Eight rays at a time
//!
//! Up to 16 primitives are a [`SmallSet`](crate::wide::SmallSet): batches ask each of them for eight rays at a time, in lanes of
//! `f64` with the operations of the one kernel, so that there is nothing to prepare and, but for rays that graze, nothing left
//! to decide. This goes for spheres and triangles that say so ([`BatchKernel`](crate::BatchKernel)); others are asked ray by ray, but
//! for structures, of which many rays are asked at once.
//!
//! # What "the same answer" means
//!
//! For each primitive there is an *own box*: its bounds, a little widened. A ray hits the primitive if the slab test
//! lets it pass that box **and** the kernel reports a hit; the parameter of the hit is not less than that of the entry
//! into the box. The winner is the least (t, instance, index). [`brute_force`](crate::brute_force) does just
//! this, in [`intersect_primitive`](rt_math::decide), one primitive after the other.
//!
//! Any structure answers the same, to the last bit, if it
//!
//! 1. decides about a primitive by that rule and by no other,
//! 2. passes over a primitive only if something that contains its own box is missed, in floating-point numbers and not
//!    only on paper, and
//! 3. leaves out what begins *strictly* after the best hit so far, so that equal parameters are still compared by index.
//!
//! The slab test is made of subtractions, products, minima and maxima, each of them monotone when rounded: a larger
//! box is never entered later than a box inside it. That proves the second point for boxes; the pages of other
//! structures say what proves it there.
//!
//! **Cost**: n tests, no nodes, O(n) for each ray. A test takes a few nanoseconds, and of spheres about a quarter of one; 16
//! bytes for each sphere.
//!
//! **Choose it** for up to about ten primitives, or sixteen spheres asked in batches, for which nothing is faster. The truth
//! in tests is [`brute_force`](crate::brute_force).
//!
//! **Paper**: Appel, "Some techniques for shading machine renderings of solids", 1968, cast rays in this manner.
