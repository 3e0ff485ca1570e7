//! Ray queries of integrators.

use crate::light::LightId;
use rt_geometry::{InteractionFlags, RayKind, ShapeHit, Sphere, SurfaceInteraction, triangle_point};
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

/// Closest hit of a ray with a sphere, whose surface is not computed yet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereHit {
    /// Ray parameter of the hit.
    pub t: f64,
    /// The sphere, in world space.
    pub sphere: Sphere,
    /// See [`SurfaceHit::object`].
    pub object: u32,
    /// See [`SurfaceHit::material`].
    pub material: u32,
    /// See [`SurfaceHit::light`].
    pub light: Option<LightId>,
}

impl SphereHit {
    /// The surface, without texture coordinates.
    pub fn surface(&self, ray: &Ray) -> SurfaceHit {
        let Self { t, sphere, object, material, light } = *self;
        let interaction = sphere.surface(ray, &ShapeHit { t, uv: [0.0; 2] }, InteractionFlags::NONE);
        SurfaceHit { t, interaction, object, material, light }
    }
}

/// Closest hit of a ray with a triangle without vertex attributes, whose surface is not computed yet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Ray parameter of the hit.
    pub t: f64,
    /// Vertices, in world space.
    pub vertices: [DVec3; 3],
    /// Barycentric weights of the second and third vertex.
    pub uv: [f64; 2],
    /// Unit normal on the side from which the vertices run counter-clockwise.
    pub normal: DVec3,
    /// See [`SurfaceHit::object`].
    pub object: u32,
    /// See [`SurfaceHit::material`].
    pub material: u32,
    /// See [`SurfaceHit::light`].
    pub light: Option<LightId>,
}

impl TriangleHit {
    /// The surface, without texture coordinates.
    pub fn surface(&self) -> SurfaceHit {
        let Self { t, vertices: [a, b, c], uv, normal, object, material, light } = *self;
        let (point, point_error) = triangle_point([a.into(), b.into(), c.into()], uv);
        let interaction = SurfaceInteraction::flat(point.into(), point_error.into(), normal, [0.0; 2]);
        SurfaceHit { t, interaction, object, material, light }
    }
}

/// Closest hit of a ray, with or without its surface.
#[derive(Debug, PartialEq)]
pub enum ClosestHit<'h> {
    /// A hit with its surface.
    Surface(&'h mut SurfaceHit),
    /// A hit on a sphere without texture coordinates.
    Sphere(&'h SphereHit),
    /// A hit on a triangle without texture coordinates, interpolated normals and other vertex attributes.
    Triangle(&'h TriangleHit),
}

/// Shapes whose surfaces an integrator may compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LazyShape {
    /// [`ClosestHit::Sphere`] instead of [`ClosestHit::Surface`].
    Sphere,
    /// [`ClosestHit::Sphere`] or [`ClosestHit::Triangle`] instead of [`ClosestHit::Surface`].
    SphereOrTriangle,
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
        (needs, _): (InteractionFlags, LazyShape),
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
