//! Ray queries of integrators.

use crate::light::LightId;
use rt_geometry::{
    InteractionFlags, Plane, RayKind, ShapeHit, Sphere, SurfaceInteraction, interpolate, triangle_point,
};
use rt_math::{DVec3, Interval, Ray, Rgb};

/// Closest hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Ray parameter of the hit.
    pub t: f64,
    /// The surface, in world space.
    pub interaction: SurfaceInteraction,
    /// Index of the object that the surface belongs to; identifies the dielectrics that a ray is inside of.
    pub object: u32,
    /// Index into [`Appearance::materials`](crate::Appearance::materials).
    pub material: u32,
    /// Area light of the surface, if it is one of the sampled lights.
    pub light: Option<LightId>,
}

impl SurfaceHit {
    /// Interval beyond this hit, for a ray that continues as if the surface were absent.
    ///
    /// The ray is unchanged, so that hits behind it have bit-identical parameters. The interval starts beyond the error bound of the
    /// surface, as for a spawned ray: two triangles that share the hit edge are one surface.
    pub fn span_after(&self, ray: &Ray) -> Interval {
        let normal = self.interaction.geometric_normal;
        let way = normal.abs().dot(self.interaction.point_error) / normal.dot(ray.direction).abs();
        let min = if way.is_finite() { self.t + way } else { self.t }.next_up();
        // The interval beyond infinity is empty.
        Interval::new(min, if min > self.t { f64::INFINITY } else { f64::NEG_INFINITY })
    }
}

/// Shape at a hit, whose surface is not computed yet.
pub trait LazySurface {
    /// The surface at a hit of this ray at the parameter `t`.
    fn surface(&self, ray: &Ray, t: f64) -> SurfaceInteraction;
}

/// Closest hit of a ray with a shape, whose surface is not computed yet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LazyHit<T> {
    /// Ray parameter of the hit.
    pub t: f64,
    /// The shape, in world space.
    pub shape: T,
    /// See [`SurfaceHit::object`].
    pub object: u32,
    /// See [`SurfaceHit::material`].
    pub material: u32,
    /// See [`SurfaceHit::light`].
    pub light: Option<LightId>,
}

impl<T: LazySurface> LazyHit<T> {
    /// The hit with its surface.
    pub fn surface(&self, ray: &Ray) -> SurfaceHit {
        let Self { t, ref shape, object, material, light } = *self;
        SurfaceHit { t, interaction: shape.surface(ray, t), object, material, light }
    }
}

/// A sphere without texture coordinates.
impl LazySurface for Sphere {
    fn surface(&self, ray: &Ray, t: f64) -> SurfaceInteraction {
        Self::surface(self, ray, &ShapeHit { t, uv: [0.0; 2] }, InteractionFlags::NONE)
    }
}

/// Point of a triangle without interpolated normals and vertex attributes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrianglePoint {
    /// Vertices, in world space.
    pub vertices: [DVec3; 3],
    /// Barycentric weights of the second and third vertex.
    pub uv: [f64; 2],
    /// Unit normal on the side from which the vertices run counter-clockwise.
    pub normal: DVec3,
    /// Texture coordinates of the vertices; zero where they are not needed.
    pub vertex_uvs: [[f32; 2]; 3],
}

impl LazySurface for TrianglePoint {
    fn surface(&self, _: &Ray, _: f64) -> SurfaceInteraction {
        let Self { vertices: [a, b, c], uv, normal, vertex_uvs } = *self;
        let (point, point_error) = triangle_point([a.into(), b.into(), c.into()], uv);
        let texture = |k: usize| interpolate(vertex_uvs.map(|uv| f64::from(uv[k])), uv);
        SurfaceInteraction::flat(point.into(), point_error.into(), normal, [texture(0), texture(1)])
    }
}

/// An infinite plane, with texture coordinates if they are needed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LazyPlane {
    /// The plane, in world space.
    pub plane: Plane,
    /// True if texture coordinates are needed.
    pub needs_uv: bool,
}

impl LazySurface for LazyPlane {
    fn surface(&self, ray: &Ray, t: f64) -> SurfaceInteraction {
        let needs = InteractionFlags { uv: self.needs_uv, ..InteractionFlags::NONE };
        self.plane.surface(ray, &ShapeHit { t, uv: [0.0; 2] }, needs)
    }
}

/// Closest hit of a ray, with or without its surface.
#[derive(Debug, PartialEq)]
pub enum ClosestHit<'h> {
    /// A hit with its surface.
    Surface(&'h mut SurfaceHit),
    /// A hit on a sphere without texture coordinates.
    Sphere(&'h LazyHit<Sphere>),
    /// A hit on a triangle without interpolated normals and vertex attributes.
    Triangle(&'h LazyHit<TrianglePoint>),
    /// A hit on an infinite plane.
    Plane(&'h LazyHit<LazyPlane>),
}

/// Shapes whose surfaces an integrator may compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LazyShapes {
    /// [`ClosestHit::Sphere`] or [`ClosestHit::Triangle`] instead of [`ClosestHit::Surface`].
    SpheresAndTriangles,
    /// All kinds of [`ClosestHit`].
    All,
}

/// The world of an integrator: it answers ray queries and counts them.
pub trait SceneQueries {
    /// Closest surface along the ray within `span`, with the needed data; `None` for a miss. The ray counts
    /// as one of its `kind`.
    fn closest(&mut self, ray: &Ray, span: Interval, kind: RayKind, needs: InteractionFlags) -> Option<SurfaceHit>;

    /// True if something that casts shadows lies on the ray within `span`.
    fn occluded(&mut self, ray: &Ray, span: Interval) -> bool;

    /// [`closest`](Self::closest) for many rays of one kind: calls `on_hit` with the index of each ray and its hit, in
    /// their order. Override it where many are faster together.
    fn closest_batch(
        &mut self,
        rays: &[(Ray, Interval)],
        kind: RayKind,
        needs: InteractionFlags,
        mut on_hit: impl FnMut(usize, Option<&mut SurfaceHit>),
    ) where
        Self: Sized,
    {
        for (at, (ray, span)) in rays.iter().enumerate() {
            on_hit(at, self.closest(ray, *span, kind, needs).as_mut());
        }
    }

    /// Version of [`closest_batch`](Self::closest_batch) that may leave surfaces of some shapes to the integrator, which computes
    /// several together.
    fn closest_hits(
        &mut self,
        rays: &[(Ray, Interval)],
        kind: RayKind,
        (needs, _): (InteractionFlags, LazyShapes),
        mut on_hit: impl FnMut(usize, Option<ClosestHit<'_>>),
    ) where
        Self: Sized,
    {
        self.closest_batch(rays, kind, needs, |at, hit| on_hit(at, hit.map(ClosestHit::Surface)));
    }

    /// [`occluded`](Self::occluded) for many rays: `blocked[i]` answers `rays[i]`.
    fn occluded_batch(&mut self, rays: &[(Ray, Interval)], blocked: &mut [bool]) {
        for ((ray, span), blocked) in rays.iter().zip(blocked) {
            *blocked = self.occluded(ray, *span);
        }
    }
}

/// A world behind a reference, for which integrators are compiled once. It computes all surfaces itself.
impl SceneQueries for &mut dyn SceneQueries {
    fn closest(&mut self, ray: &Ray, span: Interval, kind: RayKind, needs: InteractionFlags) -> Option<SurfaceHit> {
        (**self).closest(ray, span, kind, needs)
    }

    fn occluded(&mut self, ray: &Ray, span: Interval) -> bool {
        (**self).occluded(ray, span)
    }

    fn occluded_batch(&mut self, rays: &[(Ray, Interval)], blocked: &mut [bool]) {
        (**self).occluded_batch(rays, blocked);
    }
}

/// The world of a test. Integrators are compiled once for all of them.
#[cfg(test)]
pub(crate) fn dynamic(world: &mut impl SceneQueries) -> &mut dyn SceneQueries {
    world
}

/// Result of a camera ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadianceSample {
    /// Radiance towards the camera.
    pub radiance: Rgb,
    /// False if the camera ray left the world, and `radiance` is the background's.
    pub hit: bool,
}

impl RadianceSample {
    /// Black, without a hit.
    pub const MISS: Self = Self { radiance: Rgb::BLACK, hit: false };
}
