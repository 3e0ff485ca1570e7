//! A guide to the structures: what each is made of, how it is walked, what it costs, and when to choose it.
//!
//! | page | structures |
//! |---|---|
//! | [`linear`] | brute force, and what it means that all others equal it |
//! | [`grid`] | cells of equal size |
//! | [`bvh`] | a tree of boxes |
//! | [`wide`] | a tree of boxes, eight at a time |
//! | [`volumes`] | trees of spheres and of cylinders |
//! | [`kd`] | a tree of planes along the axes |
//! | [`bsp`] | a tree of planes of any direction |
//! | [`bih`] | a tree of pairs of planes, built at once or where rays go |
//! | [`choosing_an_accelerator`] | which one to take |
//!
//! # The pictures
//!
//! Each page shows two, both made by this project's own renderer. The left one is a table with thirteen spheres of
//! three sizes and the parts that the structure has made of them; colours tell the depth: black is the whole, then
//! blue, green, orange, red, and violet. The right one is what a camera ray costs on 820 spheres of a sphereflake:
//! nodes and tests together, on a logarithmic scale that is black for 1, blue for 6, red for 32, yellow for 181, and
//! white for 1024 or more.
//!
//! # The numbers
//!
//! Nodes and tests of a ray are counted by [`Counters`](crate::Counters) and are the same on every machine. A *node*
//! is a step from one node or cell to the next, a *test* is a primitive that is offered to a ray, whether its own box
//! lets it pass or not. Pages name four scenes:
//!
//! * *mound*: 100,000 overlapping spheres of similar size in half a ball, evenly spread;
//! * *balls*: a sphereflake of 66,430 spheres, very uneven;
//! * *rock*: a closed mesh of 81,920 small triangles;
//! * *stadium*: such a rock in the middle of a stadium a thousand times its size.
//!
//! Diffuse rays start on surfaces in directions that have nothing in common. The file `docs/COSTS.md` of the repository
//! has more scenes, sizes and kinds of rays, and times.

pub mod bih;
pub mod bsp;
pub mod bvh;
pub mod choosing_an_accelerator;
pub mod grid;
pub mod kd;
pub mod linear;
pub mod volumes;
pub mod wide;
