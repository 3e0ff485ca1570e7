//! Acceleration structures that give the bits of brute force.

#![forbid(unsafe_code)]

mod bvh;
mod error;
mod grid;
mod linear;
mod nearest;
mod own_boxes;
mod stats;

pub use bvh::Bvh;
pub use error::{BuildError, Violation};
pub use grid::UniformGrid;
pub use linear::Linear;
pub use rt_math::{
    Aabb, Accelerator, Counters, DVec3, Hit, Interval, LeafLayout, NoProbe, Primitives, Probe, Ray, RayCounts, RayKind,
};
pub use stats::BuildStats;
