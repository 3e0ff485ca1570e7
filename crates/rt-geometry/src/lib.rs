//! # rt-geometry: chapter 2, ray-object intersection

#![forbid(unsafe_code)]

mod axis_box;
mod error;
mod interaction;
mod mesh;
mod plane;
mod shape;
mod sphere;
mod triangle;

pub use axis_box::AxisBox;
pub use error::ShapeError;
pub use interaction::{SurfaceInteraction, SurfaceNeeds};
pub use mesh::{MeshData, MeshError, MeshRepairs, TriangleMesh};
pub use plane::Plane;
pub use shape::{Shape, ShapeHit};
pub use sphere::Sphere;
pub use triangle::Triangle;
