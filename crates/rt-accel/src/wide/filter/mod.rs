//! Conservative `f32` tests of leaves.

mod boxes;
mod leaf_test;
mod spheres;
mod triangles;

pub(super) use boxes::BoxTest;
pub(super) use leaf_test::LeafTest;
pub(super) use spheres::SphereTest;
pub(super) use triangles::TriangleTest;
