//! Ray queries on structures of arrays, for integrators that shade in lanes.

use crate::{SceneQueries, light::LightId};
use rt_geometry::{HitStream, Plane, RayKind, RayStream, Sphere};
use rt_math::{DVec3, Vec3};

/// Primitive of a world whose primitives are spheres, planes, polygons and triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreamPrimitive<'w> {
    /// The shape, in world space.
    pub shape: StreamShape<'w>,
    /// See [`SurfaceHit::object`](crate::SurfaceHit::object).
    pub object: u32,
    /// Index into [`Appearance::materials`](crate::Appearance::materials).
    pub material: u32,
    /// See [`SurfaceHit::light`](crate::SurfaceHit::light).
    pub light: Option<LightId>,
}

/// Shape of a [`StreamPrimitive`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StreamShape<'w> {
    /// A sphere. Texture coordinates are 0.
    Sphere(&'w Sphere),
    /// An infinite plane.
    Plane(&'w Plane),
    /// A polygon in this plane. Texture coordinates are 0.
    Polygon(&'w Plane),
    /// A triangle.
    Triangle(&'w StreamTriangle),
}

/// Triangle of a [`StreamShape`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreamTriangle {
    /// World space.
    pub vertices: [DVec3; 3],
    /// Unit normal of the front.
    pub normal: DVec3,
    /// Unit normals of the vertices, if they are interpolated.
    pub vertex_normals: Option<[Vec3; 3]>,
}

/// Queries for streams of rays. All rays are at time 0.
pub trait StreamQueries: SceneQueries {
    /// Closest hits of rays of one kind: the entry `i` of `hits` is that of ray `i`.
    fn closest_stream(&mut self, rays: &RayStream, kind: RayKind, hits: &mut HitStream);

    /// Version of [`occluded_batch`](SceneQueries::occluded_batch) for a stream.
    fn occluded_stream(&mut self, rays: &RayStream, blocked: &mut [bool]);

    /// A primitive by its index in hits; `None` if there is none.
    fn primitive(&self, index: u32) -> Option<StreamPrimitive<'_>>;

    /// Texture coordinates of the vertices of a triangle; zeros if there are none.
    fn vertex_uvs(&self, index: u32) -> [[f32; 2]; 3];
}
