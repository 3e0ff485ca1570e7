//! # rt-accel: chapter 6, acceleration accelerators
//!
//! ```text
//!     closest(ray) = min over all primitives of (t, instance, primitive)      always the same bits
//!
//!     Linear                 UniformGrid               Bvh
//!     ● ● ● ● ● ● ●          ┌──┬──┬──┬──┐             ┌─────────┐┌──────┐
//!     each in turn           │  │● │  │  │             │┌───┐┌──┐││┌────┐│
//!                            ├──┼──┼──┼──┤             ││● ●││ ●││││● ● ││
//!                       ray ─┼──┼─▶│● │● │             │└───┘└──┘││└────┘│
//!                            └──┴──┴──┴──┘             └─────────┘└──────┘
//! ```
//!
//! | accelerator | build | bytes per primitive | ray, n primitives | choose it for |
//! |---|---|---|---|---|
//! | [`Linear`] | O(n), checks and copies | 16 for spheres, 0 for others | n tests, eight spheres or eight rays at once | up to about ten primitives |
//! | [`UniformGrid`] | O(n), a tenth to a quarter of `Bvh` | 30 to 100 | O(∛n) cells | primitives of similar size, evenly distributed; frequent rebuilds |
//! | [`WideBvh`] | O(n log n), as `Bvh` or less | about 60 | O(log n) nodes of eight boxes | rendering, and other workloads of many rays |
//! | [`Bvh`] | O(n log n) | 25 to 45 | O(log n) nodes | everything else, in half the memory |
//! | [`SphereTree`] | O(n log n), as `Bvh` | 15 to 50 | O(log n) nodes, 1.4 to 2.7 times the work of `Bvh` | comparing shapes of volumes |
//! | [`CylinderTree`] | O(n log n), twice `Bvh` | 45 to 85 | O(log n) nodes, 1.1 to 1.2 times the work of `Bvh` | comparing shapes of volumes |
//! | [`KdTree`] | O(n log n), 2 to 8 times `Bvh` | 45 to 100 | O(log n) nodes | primitives that overlap little, seen from within; queries of regions |
//! | [`BspTree`] | O(n log n), 2 to 5 times `KdTree` | 110 to 210 | O(log n) nodes | walls at odd angles with empty space between them |
//! | [`Bih`] | O(n log n), a tenth to a fifth of `Bvh` | under 20 | O(log n) nodes, 1.5 to 5 times the work of `Bvh` | scenes that change constantly |
//! | [`LazyBih`] | O(n), the rest on demand | 56 before, 40 to 60 after | as `Bih` | first images of scenes of which little is visible |
//!
//! Ranges are for 10³ to 10⁵ primitives; `docs/COSTS.md` of the repository lists all measurements. The [`guide`]
//! explains each accelerator with images.
//!
//! **All return the results of [`brute_force`], bit for bit**, ties included, for every ray. Hits are accepted through
//! [`rt_geometry::intersect_primitive`] alone, and culled primitives provably cannot win. The proofs are in the source
//! files. The tests check them with rays through vertices, edges and corners, along walls, and one rounding step off
//! these. Primitives without bounds, such as infinite planes, are tested against every ray.
//!
//! **Owns** the accelerators, their builders and traversals. **Does not own** shapes: an accelerator holds indices and
//! boxes, and borrows the caller's [`Primitives`] for each query. No query allocates, locks or fails, except that
//! [`LazyBih`] allocates and locks where it splits a node.
//!
//! Types of `rt-math` in the public interface are re-exported, so that a program only has to depend on this crate. With
//! the feature `parallel` (default), trees are built on all threads; with `large-pages` (default), Linux is requested
//! to use 2 MiB pages for large trees. Neither changes results.
//!
//! # Tracing your own primitives
//!
//! ```
//! use rt_accel::{Aabb, Accelerator, Bvh, DVec3, Hit, Interval, NoProbe, Primitives, Ray};
//!
//! /// Squares of side 2 that face the z axis.
//! struct Tiles(Vec<DVec3>);
//!
//! impl Primitives for Tiles {
//!     fn len(&self) -> usize {
//!         self.0.len()
//!     }
//!     fn bounds(&self, index: u32) -> Option<Aabb> {
//!         let reach = DVec3::new(1.0, 1.0, 0.0);
//!         Some(Aabb::new(self.0[index as usize] - reach, self.0[index as usize] + reach))
//!     }
//!     fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
//!         let centre = self.0[index as usize];
//!         let t = (centre.z - ray.origin.z) / ray.direction.z;
//!         let offset = (ray.at(t) - centre).abs();
//!         (span.contains(t) && offset.x <= 1.0 && offset.y <= 1.0)
//!             .then_some(Hit { t, instance: 0, primitive: index, uv: [0.0; 2] })
//!     }
//! }
//!
//! let tiles = Tiles((0..1000).map(|i| DVec3::new(f64::from(i % 10), 0.0, f64::from(i))).collect());
//! let bvh = Bvh::build(&tiles)?;
//! let ray = Ray::new(DVec3::new(9.5, 0.0, -1.0), DVec3::Z);
//! let hit = bvh.closest(&tiles, &ray, Interval::FORWARD, &mut NoProbe);
//! assert_eq!(hit.map(|hit| (hit.t, hit.primitive)), Some((10.0, 9)));
//! assert!(!bvh.occluded(&tiles, &ray, Interval::new(0.0, 9.9), &mut NoProbe));
//! # Ok::<(), rt_accel::BuildError>(())
//! ```

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
