//! Brute force: every ray asks every primitive.
//!
//! **The idea** is that there is none. [`Linear`](crate::Linear) is the definition of the right answer, and on the
//! right it is what all other structures are compared with: the same cost for every ray, whatever it meets.
#![doc = include_str!("figures/linear.html")]
//!
//! **Build**: bounds are checked as in all structures, so that they refuse the same input. Nothing is stored.
//!
//! **Walk**: primitive 0, 1, 2, ... For the first hit all are asked; whether anything is hit is known at the first
//! that is.
//!
//! # What "the same answer" means
//!
//! For each primitive there is an *own box*: its bounds, a little widened. A ray hits the primitive if the slab test
//! lets it pass that box **and** the kernel reports a hit; the parameter of the hit is not less than that of the entry
//! into the box. The winner is the least (t, instance, index). [`Linear`](crate::Linear) does just this, in
//! [`decide`](rt_math::decide).
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
//! **Cost**: n tests, no nodes, O(n) for each ray, no memory. A test takes a few nanoseconds, because memory is read in
//! order.
//!
//! **Choose it** for up to about ten primitives, for which nothing is faster, and as the truth in tests.
//!
//! **Paper**: Appel, "Some techniques for shading machine renderings of solids", 1968, cast rays in this manner.
