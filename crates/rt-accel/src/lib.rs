//! # rt-accel: acceleration structures
//!
//! Closest hits, any hits, all hits and nearest points of triangle meshes, spheres and your own primitives, exact in `f64`.
//!
//! ```
//! use rt_accel::{DVec3, Interval, Ray, Scene, TriangleMesh}; // after `cargo add rt-accel --path crates/rt-accel`
//!
//! let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let scene = Scene::new(TriangleMesh::new(&vertices, &[[0, 1, 2]])?)?;
//! let ray = Ray::new(DVec3::new(0.25, 0.25, 2.0), DVec3::NEG_Z);
//! let hit = scene.closest(&ray, Interval::FORWARD).ok_or("a miss")?;
//! assert_eq!((hit.t, hit.primitive, hit.uv), (2.0, 0, [0.25, 0.25]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Scene`] traces single rays and [`RayBatch`]es; [`SceneBuilder`] places its meshes and spheres by transforms.
//! [`UserGeometry`] takes boxes and a closure, [`Primitives`] is a trait for your own, and these accelerators hold them:
//!
//! | accelerator | choose it for | paper |
//! |---|---|---|
//! | [`WideBvh`] | many rays: eight boxes per node | Wald, Benthin and Boulos 2008 |
//! | [`Bvh`] | less memory (0.5 to 0.9 of it) | Wald 2007 |
//! | [`Linear`] | up to about ten primitives | |
//! | [`UniformGrid`] | evenly distributed primitives | Amanatides and Woo 1987 |
//! | [`KdTree`] | little overlap, seen from within | Wald and Havran 2006 |
//! | [`BspTree`] | walls at odd angles | Ize, Wald and Parker 2008 |
//! | [`Bih`], [`LazyBih`] | constant change | Wächter and Keller 2006 |
//! | [`SphereTree`], [`CylinderTree`] | comparing bounding volumes | |
//!
//! **All return the results of [`brute_force`], bit for bit**, ties included. Edges are decided exactly (Woop, Benthin and Wald
//! 2013, in `f64`), and culled primitives provably cannot win. The [`guide`] explains each with images, proofs and costs.
//!
//! **Owns** accelerators, their builders and queries, and scenes of meshes and spheres. **Does not own** the shapes and their
//! kernels, which are in `rt-geometry`. Features: `parallel` (default) builds large trees and traces batches on all threads;
//! `large-pages` (default) requests pages of 2 MiB from Linux; `serde`; `all-simd`. Queries of accelerators neither fail,
//! allocate nor lock, except that [`LazyBih`] allocates and locks where it splits a node. Lists of all hits grow, and instances keep
//! memory for streams in each thread. Queries of a [`Scene`] may allocate; batches fail if the lengths of their arrays differ, or
//! without memory.

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
mod erased;
mod error;
mod frustum;
mod grid;
#[cfg(any(doc, doctest))]
pub mod guide;
mod kd;
mod linear;
mod node_ref;
mod parallel_for;
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
    ClosestPoint, Counters, Hit, HitStream, MAX_COORDINATE, NoProbe, PacketKernel, PrimitiveGeometry, Primitives,
    Probe, RayCounts, RayKind, RayStream, STREAM_CAPACITY, ShapeError, ShapeHit, Sphere, SphereKernel, Spheres,
    StreamBuffers, WatertightRay, intersect_primitive, occludes_primitive, padded_bounds, with_local_rays,
    with_stream_buffers,
};
pub use rt_math::{Aabb, DMat3, DQuat, DVec3, Interval, Ray, SlabRay, Transform, TransformError, Vec3};
pub use scene::{
    Geometry, GeometryId, HitLists, MeshError, Scene, SceneBuilder, SceneError, TriangleMesh, UserGeometry, Vertices,
};
pub use stats::BuildStats;
pub use volume_tree::{BoundingCylinder, BoundingSphere, BoundingVolume, CylinderTree, SphereTree, VolumeTree};
pub use wide::{BuildParams, WideBvh};
