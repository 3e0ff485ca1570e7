//! Ready-made geometry: meshes and spheres with their trees, placed once or many times.
//!
//! From the lowest layer to the highest:
//!
//! * `error`, `triangle_mesh`, `user_geometry`, `refit_tree`
//! * `geometry` with its tree; `instances` as primitives of the top level
//! * `ray_queries`: scenes, and queries along a ray; `points`: queries at a point, by `placed_points`; `batches`: queries for many rays
//! * `builder`

mod batches;
mod builder;
mod error;
mod geometry;
mod instances;
mod placed_points;
mod points;
mod ray_queries;
mod refit_tree;
mod triangle_mesh;
mod user_geometry;

pub use batches::HitLists;
pub use builder::{GeometryId, SceneBuilder};
pub use error::{MeshError, SceneError};
pub use geometry::Geometry;
pub use ray_queries::Scene;
pub use triangle_mesh::{TriangleMesh, Vertices};
pub use user_geometry::UserGeometry;
