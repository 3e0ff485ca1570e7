//! Spheres without a tree, in the order of their indices: eight at a time are tested in `f32`.

mod block;
mod list;
mod projected_ray;

pub(crate) use list::SphereList;
