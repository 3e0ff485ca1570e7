//! Ray queries on structures of arrays, and the primitives that integrators shade in lanes.

use crate::{SceneQueries, SurfaceHit, light::LightId};
use rt_geometry::{HitStream, InteractionFlags, Plane, RayKind, RayStream, Sphere, TriangleMesh};
use rt_math::{DVec3, Interval, Ray, Vec3};

/// Hit primitive whose surface an integrator computes in lanes.
#[derive(Clone, Copy, Debug)]
pub struct StreamPrimitive<'w> {
    /// The shape, in world space.
    pub shape: StreamShape<'w>,
    /// See [`SurfaceHit::object`](crate::SurfaceHit::object).
    pub object: u32,
    /// Index into [`Appearance::materials`](crate::Appearance::materials).
    pub material: u32,
    /// See [`SurfaceHit::light`](crate::SurfaceHit::light).
    pub light: Option<LightId>,
    /// See [`SurfaceHit::casts_shadow`](crate::SurfaceHit::casts_shadow).
    pub casts_shadow: bool,
}

/// Shape of a [`StreamPrimitive`].
#[derive(Clone, Copy, Debug)]
pub enum StreamShape<'w> {
    /// A sphere. Texture coordinates are 0.
    Sphere(&'w Sphere),
    /// An infinite plane.
    Plane(&'w Plane),
    /// A polygon in this plane. Texture coordinates are 0.
    Polygon(&'w Plane),
    /// A triangle.
    Triangle(&'w StreamTriangle),
    /// The triangle of this index of a mesh.
    MeshTriangle(&'w TriangleMesh, u32),
}

impl StreamShape<'_> {
    /// True if the ray leaves the solid that this is the surface of, at a hit with the parameter `t`, up to rounding.
    pub(crate) fn is_left_by(&self, ray: &Ray, t: f64) -> bool {
        let outside = match *self {
            StreamShape::Sphere(sphere) => ray.at(t) - sphere.centre(),
            StreamShape::Plane(plane) | StreamShape::Polygon(plane) => plane.normal(),
            StreamShape::Triangle(triangle) => triangle.normal,
            StreamShape::MeshTriangle(mesh, index) => {
                let [a, b, c] = mesh.vertices(index).unwrap_or_default();
                (b - a).cross(c - a)
            }
        };
        ray.direction.dot(outside) > 0.0
    }
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

/// Queries for streams of rays.
pub trait StreamQueries {
    /// Closest hits of rays of one kind: the entry `i` of `hits` is that of ray `i`.
    fn closest_stream(&mut self, rays: &RayStream, kind: RayKind, hits: &mut HitStream);

    /// True in `occluded[i]` if something that casts shadows lies on ray `i`, within its interval.
    fn occluded_stream(&mut self, rays: &RayStream, occluded: &mut [bool]);

    /// The primitive that a ray has hit; `None` for one of any other shape, and for a miss.
    fn primitive(&self, hits: &HitStream, at: usize) -> Option<StreamPrimitive<'_>>;

    /// True if all hits are on such primitives, and no texture is on a sphere or polygon.
    fn has_only_primitives(&self) -> bool {
        false
    }

    /// The surface that a ray has hit, with the needed data; `None` for a miss. The ray is that of the hit.
    fn surface(&self, ray: &Ray, hits: &HitStream, at: usize, needs: InteractionFlags) -> Option<SurfaceHit>;

    /// Texture coordinates of the vertices of a hit triangle; zeros if there are none.
    fn vertex_uvs(&self, hits: &HitStream, at: usize) -> [[f32; 2]; 3];
}

/// Streams of a world that answers queries one by one, and computes all surfaces itself.
pub struct SingleQueries<'w> {
    world: &'w mut dyn SceneQueries,
    hits: Vec<SurfaceHit>,
}

impl<'w> SingleQueries<'w> {
    /// The streams of a world.
    pub const fn new(world: &'w mut dyn SceneQueries) -> Self {
        Self { world, hits: Vec::new() }
    }
}

impl SceneQueries for SingleQueries<'_> {
    fn closest(&mut self, ray: &Ray, span: Interval, kind: RayKind, needs: InteractionFlags) -> Option<SurfaceHit> {
        self.world.closest(ray, span, kind, needs)
    }

    fn occluded(&mut self, ray: &Ray, span: Interval) -> bool {
        self.world.occluded(ray, span)
    }
}

impl StreamQueries for SingleQueries<'_> {
    fn closest_stream(&mut self, rays: &RayStream, kind: RayKind, hits: &mut HitStream) {
        self.hits.clear();
        for at in 0..rays.len() {
            let (ray, span) = rays.get(at);
            let hit = self.world.closest(&ray, span, kind, InteractionFlags::ALL);
            let primitive = self.hits.len() as u32;
            let of_hit = |hit: &SurfaceHit| rt_geometry::Hit { t: hit.t, instance: 0, primitive, uv: [0.0; 2] };
            hits.set(at, hit.as_ref().map(of_hit).as_ref());
            self.hits.extend(hit);
        }
    }

    fn occluded_stream(&mut self, rays: &RayStream, occluded: &mut [bool]) {
        for (at, occluded) in occluded.iter_mut().enumerate() {
            let (ray, span) = rays.get(at);
            *occluded = self.world.occluded(&ray, span);
        }
    }

    fn primitive(&self, _: &HitStream, _: usize) -> Option<StreamPrimitive<'_>> {
        None
    }

    fn surface(&self, _: &Ray, hits: &HitStream, at: usize, _: InteractionFlags) -> Option<SurfaceHit> {
        self.hits.get(hits.get(at)?.primitive as usize).copied()
    }

    fn vertex_uvs(&self, _: &HitStream, _: usize) -> [[f32; 2]; 3] {
        [[0.0; 2]; 3]
    }
}
