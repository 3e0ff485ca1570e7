//! Tests of spawned rays and of shared edges, in one program.

mod grazing_triangles;
mod shared_edges;
mod spawned_rays;
mod watertight_triangles;
