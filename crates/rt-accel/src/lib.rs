//! # rt-accel: chapter 6, acceleration structures
//!
//! ```text
//!     closest(ray) = min over all primitives of (t, instance, primitive)      always the same bits
//!
//!     Linear                 UniformGrid               Bvh
//!     ● ● ● ● ● ● ●          ┌──┬──┬──┬──┐             ┌─────────┐┌──────┐
//!     each in turn           │  │● │  │  │             │┌───┐┌──┐││┌────┐│
//!                       ray ─┼──┼─▶│● │● │             ││● ●││ ●││││● ● ││
//!                            └──┴──┴──┴──┘             └┴───┴┴──┴┘└┴────┴┘
//! ```
//!
//! ```
//! use rt_accel::{DVec3, Interval, Ray, Scene, TriangleMesh};
//!
//! let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let scene = Scene::new(TriangleMesh::new(&vertices, &[[0, 1, 2]])?)?;
//! let ray = Ray::new(DVec3::new(0.25, 0.25, 2.0), DVec3::NEG_Z);
//! let hit = scene.closest(&ray, Interval::FORWARD).ok_or("a miss")?;
//! assert_eq!((hit.t, hit.primitive, hit.uv), (2.0, 0, [0.25, 0.25]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! * A [`Scene`] holds meshes and spheres, also placed by transforms ([`SceneBuilder`]). It finds the closest hit, any hit and all
//!   hits of a ray or of a [`RayBatch`], nearest points, and inside or outside.
//! * [`UserGeometry`] takes boxes and a closure, and [`Primitives`] is the interface for primitives of your own. An
//!   [`Accelerator`] over them holds indices and boxes; every query borrows the primitives.
//!
//! | accelerator | build time, relative to `Bvh` | bytes per primitive | choose it for |
//! |---|---|---|---|
//! | [`WideBvh`] | 1 or less | about 60 | many rays: eight boxes per node (Wald et al. 2008) |
//! | [`Bvh`] | 1 | 25 to 45 | half the memory (binned SAH, Wald 2007) |
//! | [`Linear`] | checks and copies | 16 for spheres, 0 for others | up to about ten primitives |
//! | [`UniformGrid`] | 0.1 to 0.25 | 30 to 100 | evenly distributed primitives (Amanatides and Woo 1987) |
//! | [`KdTree`] | 2 to 8 | 45 to 100 | little overlap, seen from within (Wald and Havran 2006) |
//! | [`BspTree`] | 4 to 40 | 110 to 210 | walls at odd angles (Ize, Wald and Parker 2008) |
//! | [`Bih`], [`LazyBih`] | 0.1 to 0.2, or on demand | under 20, 40 to 60 | constant change (Wächter and Keller 2006) |
//! | [`SphereTree`], [`CylinderTree`] | 1, 2 | 15 to 85 | comparing bounding volumes |
//!
//! Ranges are for 10³ to 10⁵ primitives; `docs/COSTS.md` of the repository lists all measurements. The [`guide`] explains each
//! accelerator with images and papers.
//!
//! **All return the results of [`brute_force`], bit for bit**, ties included, for every ray. Edges are decided exactly (Woop,
//! Benthin and Wald 2013, in `f64`), hits are accepted through [`rt_geometry::intersect_primitive`] alone, and culled primitives
//! provably cannot win. The proofs are in the source files.
//!
//! **Owns** accelerators, their builders and queries, and ready-made scenes of meshes and spheres. **Does not own** the shapes and their kernels, which are in `rt-geometry`. No query allocates, locks or fails, except that
//! [`LazyBih`] allocates and locks where it splits a node, and lists of all hits grow. Features: `parallel` (default) builds
//! trees and traces batches on all threads; `large-pages` (default) requests pages of 2 MiB from Linux; `serde`; `all-simd`.

#![deny(unsafe_code)]

mod accelerator;
mod any;
mod axis;
mod batch;
mod bih;
mod binned_sah;
mod boxes;
pub mod brute_force;
mod bsp;
mod bvh;
#[cfg(feature = "serde")]
mod checked_serde;
mod error;
mod frustum;
mod grid;
#[cfg(any(doc, doctest))]
pub mod guide;
mod kd;
mod linear;
mod node_ref;
mod prim_bounds;
mod ray_query;
mod region;
mod region_query;
mod scene;
mod space_partition;
mod stats;
mod top_down;
mod traversal;
mod tree;
mod volume_tree;
pub mod wide;

pub use accelerator::{Accelerator, Refit};
pub use any::{AcceleratorKind, AcceleratorVisitor, AnyAccelerator};
pub use batch::{BatchError, HitBatch, RayBatch, Scalars, Vectors};
pub use bih::{Bih, lazy::LazyBih};
pub use boxes::Boxes;
pub use bsp::BspTree;
pub use bvh::{Bvh, SplitMethod};
pub use error::{BuildError, ValidationError};
pub use frustum::{Frustum, FrustumError};
pub use grid::UniformGrid;
pub use kd::KdTree;
pub use linear::Linear;
pub use ray_query::RayQuery;
pub use region::{Region, SphereRegion};
pub use region_query::{PointHit, RegionQuery};
pub use rt_geometry::{
    BatchKernel, ClosestPoint, Counters, Hit, NoProbe, PrimitiveGeometry, Primitives, Probe, RayCounts, RayKind,
    Sphere, SphereKernel, Spheres,
};
pub use rt_math::{Aabb, DVec3, Interval, Ray, SlabRay, Transform};
pub use scene::{
    Geometry, GeometryId, HitLists, MeshError, Scene, SceneBuilder, SceneError, TriangleMesh, UserGeometry, Vertices,
};
pub use stats::BuildStats;
pub use volume_tree::{BoundingCylinder, BoundingSphere, BoundingVolume, CylinderTree, SphereTree, VolumeTree};
pub use wide::{BuildParams, WideBvh};
