//! A guide to the accelerators: idea, build, traversal, proof, cost, and recommended use of each.
//!
//! | page | accelerators |
//! |---|---|
//! | [`linear`] | brute force, and the equality of all others with it |
//! | [`grid`] | cells of equal size |
//! | [`bvh`] | a tree of boxes |
//! | [`wide`] | a tree of boxes, eight at a time |
//! | [`volumes`] | trees of spheres and of cylinders |
//! | [`kd`] | a tree of planes along the axes |
//! | [`bsp`] | a tree of planes of any direction |
//! | [`bih`] | a tree of pairs of planes, built at once or on demand |
//! | [`choosing_an_accelerator`] | recommendations |
//!
//! # The images
//!
//! Each page shows two images, both rendered by this project. The left one is a table with thirteen spheres of three
//! sizes and the parts of the accelerator. Colours show the depth: black is the whole, then blue, green, orange, red,
//! and violet. The right one is the cost of camera rays on 820 spheres of a sphereflake: nodes and tests together, on a
//! logarithmic scale. Black is 1, blue 6, red 32, yellow 181, and white 1024 or more.
//!
//! # The numbers
//!
//! Nodes and tests of a ray are counted by [`Counters`](crate::Counters) and are the same on every machine. A *node* is
//! a visited node or cell, a *test* is a tested primitive, hit or not. Pages refer to four scenes:
//!
//! * *mound*: 100,000 overlapping spheres of similar size in half a sphere, evenly distributed;
//! * *balls*: a sphereflake of 66,430 spheres, very uneven;
//! * *rock*: a closed mesh of 81,920 small triangles;
//! * *stadium*: such a rock in the middle of a stadium a thousand times its size.
//!
//! Diffuse rays start on surfaces in incoherent directions. The file `docs/COSTS.md` of the repository has more scenes,
//! sizes and kinds of rays, and times.

pub mod bih;
pub mod bsp;
pub mod bvh;
pub mod choosing_an_accelerator;
pub mod grid;
pub mod kd;
pub mod linear;
pub mod volumes;
pub mod wide;
