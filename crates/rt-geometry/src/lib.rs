//! # rt-geometry: ray-object intersection
//!
//! ```text
//!                .  -  -  .             Ray-sphere intersection in three steps, the cheapest first:
//!             .'      h      '.          with f = o − c:
//!   o ───────●───────┬────────●──▶ d    1. sphere behind the ray?      f·d > 0 and the origin outside
//!     ╲    t₀        │L       t₁        2. ray misses?                 L > r
//!        ╲   .       │        .         3. else half chord h:          h² = (r − L)(r + L)
//!       f   ╲ '.     c      .'
//!                '  -  -  '             [`SphereKernel`] avoids cancellation.
//! ```
//!
//! A hit has two stages. [`Shape::intersect`] returns the small [`ShapeHit`]: the ray parameter `t` and parameters on
//! the surface. [`Shape::surface`] computes the full [`SurfaceInteraction`], once, for the closest hit: point, normals,
//! texture coordinates, and a **bound on the rounding error of the point**. By that bound the origins of spawned rays
//! are offset ([`SurfaceInteraction::spawn_ray`]). They never hit their own surface by rounding, at any scale of the
//! scene, without an epsilon to tune.
//!
//! **Owns** the shapes ([`Sphere`], [`Cuboid`], [`Plane`], [`Triangle`], [`Polygon`], [`CappedQuadric`],
//! [`InfiniteQuadric`], [`Disk`], [`Rectangle`], [`Torus`]) and their enum [`Shape`]. It also owns shapes under affine
//! maps ([`TransformedShape`]), meshes ([`MeshData`], [`TriangleMesh`]), sets ([`Primitives`], [`Spheres`]),
//! intersection tests in `f64`, and the geometry of a hit. **Does not own** accelerators that find the closest of many hits (rt-accel),
//! materials and light (rt-shading), or files (rt-scene-io).
//!
//! All tests are total: a ray that misses, has a NaN or has no direction gives `None`. Inside and outside are exact,
//! without tolerances; the triangle test is watertight ([`WatertightRay`]).
//!
//! ```
//! use rt_geometry::{TransformedShape, Shape, Sphere, InteractionFlags};
//! use rt_math::{DVec3, Interval, Ray, Transform};
//!
//! // A unit sphere, twice as high as wide, four units ahead.
//! let sphere = Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)?);
//! let stretch = Transform::scale(DVec3::new(1.0, 2.0, 1.0))?;
//! let egg = TransformedShape::new(sphere, Transform::translate(DVec3::new(0.0, 0.0, -4.0)).compose(&stretch));
//!
//! let ray = Ray::new(DVec3::ZERO, DVec3::NEG_Z);
//! let hit = egg.intersect(&ray, Interval::FORWARD).ok_or("a miss")?;
//! let surface = egg.surface(&ray, &hit, InteractionFlags::ALL);
//! assert_eq!((hit.t, surface.point, surface.geometric_normal), (3.0, DVec3::new(0.0, 0.0, -3.0), DVec3::Z));
//!
//! // A mirrored ray starts just off the surface and does not hit it again.
//! let mirrored = surface.spawn_ray(DVec3::new(0.0, 1e-3, 1.0), ray.time);
//! assert_eq!(egg.intersect(&mirrored, Interval::FORWARD), None);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod area;
mod bracketed_root;
mod capped_quadric;
mod closest_point;
mod cuboid;
mod disk;
mod error;
mod exact_edges;
mod hit;
mod infinite_quadric;
mod interaction;
mod intersect;
mod mesh;
mod mesh_data;
mod mesh_faces;
mod mesh_repair;
mod nearest;
mod plane;
mod polygon;
mod primitives;
mod probe;
mod quadric_side;
mod ray_stream;
mod rectangle;
mod shape;
mod smooth_triangle;
mod sphere;
mod sphere_kernel;
mod spheres;
#[cfg(test)]
mod strategies;
mod stream_buffers;
mod torus;
mod transformed_shape;
mod triangle;
mod triangulator;
mod watertight_triangle;

pub use area::{unit_normal, unit_normal_lanes};
pub use capped_quadric::CappedQuadric;
pub use closest_point::ClosestPoint;
pub use cuboid::Cuboid;
pub use disk::Disk;
pub use error::{MAX_COORDINATE, ShapeError};
pub use hit::{Hit, ShapeHit};
pub use infinite_quadric::InfiniteQuadric;
pub use interaction::{InteractionFlags, ShadowRays, SurfaceInteraction, VertexAttributes, offset_point};
pub use intersect::{
    intersect_primitive, intersect_primitive_stream, intersect_primitive_uncounted, intersect_triangle,
    occludes_primitive, occludes_primitive_stream, occludes_primitive_uncounted, padded_bounds,
};
pub use mesh::TriangleMesh;
pub use mesh_data::MeshData;
pub use mesh_faces::{fan, strip};
pub use mesh_repair::{MeshError, MeshRepairs};
pub use nearest::nearest_on_triangle;
pub use plane::{Plane, plane_point, plane_uv};
pub use polygon::{InsideRule, Polygon, PolygonError};
pub use primitives::{PacketKernel, PrimitiveGeometry, Primitives};
pub use probe::{Counters, NoProbe, Probe, RayCounts, RayKind, RayStats};
pub use ray_stream::{HitStream, RayStream, STREAM_CAPACITY, StreamArray};
pub use rectangle::Rectangle;
pub use shape::Shape;
pub use smooth_triangle::{SmoothPoint, smooth_point};
pub use sphere::{Sphere, sphere_point};
pub use sphere_kernel::SphereKernel;
pub use spheres::Spheres;
pub use stream_buffers::{StreamBuffers, with_local_rays, with_stream_buffers};
pub use torus::Torus;
pub use transformed_shape::TransformedShape;
pub use triangle::{Triangle, interpolate, is_on_triangle, triangle_point};
pub use triangulator::Face;
pub use watertight_triangle::WatertightRay;
