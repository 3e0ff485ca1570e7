//! # rt-geometry: chapter 2, ray-object intersection

#![forbid(unsafe_code)]

mod area;
mod axis_box;
mod error;
mod interaction;
mod mesh;
mod mesh_data;
mod placed;
mod plane;
mod shape;
mod sheared_ray;
mod sphere;
mod spheres;
mod triangle;

pub use axis_box::AxisBox;
pub use error::ShapeError;
pub use interaction::{SurfaceInteraction, SurfaceNeeds};
pub use mesh::{MeshError, MeshRepairs, TriangleMesh};
pub use mesh_data::MeshData;
pub use placed::Placed;
pub use plane::Plane;
pub use shape::{Shape, ShapeHit};
pub use sheared_ray::ShearedRay;
pub use sphere::Sphere;
pub use spheres::Spheres;
pub use triangle::Triangle;
