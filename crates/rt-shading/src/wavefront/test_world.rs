//! A world of shapes for tests of integrators of streams.

use crate::{
    LaneLevel, RadianceSample, ShadingCounts, StreamPrimitive, StreamQueries, StreamShape, StreamTriangle, SurfaceHit,
    light::LightId, scene_queries::SceneQueries,
};
use core::{fmt::Debug, ops::Range};
use rt_geometry::{
    Hit, HitStream, InteractionFlags, Plane, RayKind, RayStream, STREAM_CAPACITY, ShapeHit, Sphere, SurfaceInteraction,
    WatertightRay, interpolate, smooth_point, triangle_point,
};
use rt_math::{DVec3, Interval, Ray, random};

pub(crate) enum TestShape {
    Sphere(Sphere),
    Plane(Plane),
    Triangle(StreamTriangle, [[f32; 2]; 3]),
}

pub(crate) struct TestPrimitive {
    pub(crate) shape: TestShape,
    pub(crate) material: u32,
    pub(crate) light: Option<LightId>,
}

/// Primitives. Rays are tested against one after the other.
pub(crate) struct ShapeWorld(pub(crate) Vec<TestPrimitive>);

pub(crate) fn number(key: u64, at: u64) -> f64 {
    random::unit(random::hash(&[key, at]))
}

pub(crate) fn vector(key: u64, at: u64) -> DVec3 {
    DVec3::new(number(key, at), number(key, at + 1), number(key, at + 2)) * 2.0 - 1.0
}

impl TestShape {
    /// Triangle without texture coordinates and interpolated normals.
    pub(crate) fn triangle(vertices: [DVec3; 3]) -> Self {
        let normal = (vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]).normalize();
        Self::Triangle(StreamTriangle { vertices, normal, vertex_normals: None }, [[0.0; 2]; 3])
    }
}

impl ShapeWorld {
    /// Spheres and triangles of random materials around the origin, above a floor, in units of `scale`. The material beyond the last of
    /// `n_materials` is missing.
    pub(crate) fn new(n_materials: u32, scale: f64) -> Self {
        let primitive = |shape, material| TestPrimitive { shape, material, light: None };
        let material = |key: u64| (number(key, 20) * f64::from(n_materials + 1)) as u32;
        let spheres = (0..60).map(|key| {
            let sphere = Sphere::new(vector(key, 0) * 3.0 * scale, (0.1 + 0.4 * number(key, 4)) * scale);
            primitive(TestShape::Sphere(sphere.expect("a sphere")), material(key))
        });
        let triangles = (60..90).map(|key| {
            let centre = vector(key, 0) * 3.0;
            let mut shape = TestShape::triangle([3, 6, 9].map(|at| (centre + vector(key, at)) * scale));
            if let TestShape::Triangle(_, vertex_uvs) = &mut shape {
                *vertex_uvs = [12, 14, 16].map(|at| [number(key, at) as f32 * 3.0, number(key, at + 1) as f32 * 3.0]);
            }
            primitive(shape, material(key))
        });
        let floor = Plane::new(DVec3::new(0.1, -3.0, 0.2) * scale, DVec3::new(0.1, 1.0, 0.0)).expect("a plane");
        let floor = primitive(TestShape::Plane(floor), n_materials.saturating_sub(1).min(13));
        Self(spheres.chain(triangles).chain([floor]).collect())
    }

    /// Version in which every second triangle has interpolated normals, some of which face away from the viewer.
    pub(crate) fn with_shading_normals(mut self) -> Self {
        for (at, primitive) in self.0.iter_mut().enumerate().step_by(2) {
            if let TestShape::Triangle(StreamTriangle { normal, vertex_normals, .. }, _) = &mut primitive.shape {
                let tilted = |key: u64| (*normal + vector(at as u64, key)).normalize().as_vec3();
                *vertex_normals = Some([60, 63, 66].map(tilted));
            }
        }
        self
    }

    fn hit(&self, ray: &Ray, span: Interval) -> Option<Hit> {
        let watertight = WatertightRay::new(ray);
        let hits = self.0.iter().enumerate().filter_map(|(at, primitive)| {
            let hit = match &primitive.shape {
                TestShape::Sphere(sphere) => sphere.intersect(ray, span),
                TestShape::Plane(plane) => plane.intersect(ray, span),
                TestShape::Triangle(triangle, _) => watertight.intersect(triangle.vertices, span),
            };
            hit.map(|hit| Hit { t: hit.t, instance: 0, primitive: at as u32, uv: hit.uv })
        });
        hits.min_by(|a, b| a.t.total_cmp(&b.t))
    }
}

impl ShapeWorld {
    fn surface_of(&self, ray: &Ray, hit: Hit) -> SurfaceHit {
        let Hit { t, primitive, uv, .. } = hit;
        let TestPrimitive { shape, material, light } = &self.0[primitive as usize];
        let shape_hit = ShapeHit { t, uv: [0.0; 2] };
        let interaction = match shape {
            TestShape::Sphere(sphere) => sphere.surface(ray, &shape_hit, InteractionFlags::NONE),
            TestShape::Plane(plane) => plane.surface(ray, &shape_hit, InteractionFlags::ALL),
            TestShape::Triangle(triangle, vertex_uvs) => {
                let StreamTriangle { vertices, normal, vertex_normals } = *triangle;
                let corners = vertices.map(Into::into);
                let (point, error) = triangle_point(corners, uv);
                let of_vertices = |k: usize| interpolate(vertex_uvs.map(|uv| f64::from(uv[k])), uv);
                let mut surface =
                    SurfaceInteraction::flat(point.into(), error.into(), normal, [of_vertices(0), of_vertices(1)]);
                if let Some(normals) = vertex_normals {
                    let normals = normals.map(|n| n.as_dvec3().into());
                    let smooth = smooth_point((point, normal.into()), corners, normals, uv, ray.direction.into());
                    (surface.shading_normal, surface.shadow_point) = (smooth.normal.into(), smooth.shadow_point.into());
                }
                surface
            }
        };
        SurfaceHit { light: *light, ..SurfaceHit::new(t, interaction, primitive, *material) }
    }
}

impl SceneQueries for ShapeWorld {
    fn closest(&mut self, ray: &Ray, span: Interval, _: RayKind, _: InteractionFlags) -> Option<SurfaceHit> {
        Some(self.surface_of(ray, self.hit(ray, span)?))
    }

    fn occluded(&mut self, ray: &Ray, span: Interval) -> bool {
        self.hit(ray, span).is_some()
    }
}

impl StreamQueries for ShapeWorld {
    fn closest_stream(&mut self, rays: &RayStream, _: RayKind, hits: &mut HitStream) {
        for at in 0..rays.len() {
            let (ray, span) = rays.get(at);
            hits.set(at, self.hit(&ray, span).as_ref());
        }
    }

    fn occluded_stream(&mut self, rays: &RayStream, occluded: &mut [bool]) {
        for (at, occluded) in occluded.iter_mut().enumerate() {
            let (ray, span) = rays.get(at);
            *occluded = self.occluded(&ray, span);
        }
    }

    fn primitive(&self, hits: &HitStream, at: usize) -> Option<StreamPrimitive<'_>> {
        let index = hits.get(at)?.primitive;
        let TestPrimitive { shape, material, light } = self.0.get(index as usize)?;
        let shape = match shape {
            TestShape::Sphere(sphere) => StreamShape::Sphere(sphere),
            TestShape::Plane(plane) => StreamShape::Plane(plane),
            TestShape::Triangle(triangle, _) => StreamShape::Triangle(triangle),
        };
        Some(StreamPrimitive { shape, object: index, material: *material, light: *light, casts_shadow: true })
    }

    fn surface(&self, ray: &Ray, hits: &HitStream, at: usize, _: InteractionFlags) -> Option<SurfaceHit> {
        Some(self.surface_of(ray, hits.get(at)?))
    }

    fn vertex_uvs(&self, hits: &HitStream, at: usize) -> [[f32; 2]; 3] {
        match self.0[hits.primitive.get(at) as usize].shape {
            TestShape::Triangle(_, vertex_uvs) => vertex_uvs,
            _ => [[0.0; 2]; 3],
        }
    }
}

pub(crate) fn camera_rays(count: u32, scale: f64) -> Vec<(Ray, Interval)> {
    let ray = |at: u32| {
        let eye = DVec3::new(0.3, 1.0, 7.0);
        // Groups of rays are close together, as those of a pixel are.
        let aim = vector(1000 + u64::from(at / 5), 0) * 3.0 + vector(u64::from(at), 40) * 0.02;
        Ray::new(eye * scale, aim - eye)
    };
    (0..count).map(|at| (ray(at), Interval::FORWARD)).collect()
}

/// Radiance of rays that are traced in streams as large as possible. `trace` gets the range of the rays of each.
pub(crate) fn in_streams(
    rays: &[(Ray, Interval)],
    mut trace: impl FnMut(Range<usize>, &mut RayStream, &mut [RadianceSample]),
) -> Vec<RadianceSample> {
    let mut seen = vec![RadianceSample::MISS; rays.len()];
    for (number, (rays, seen)) in rays.chunks(STREAM_CAPACITY).zip(seen.chunks_mut(STREAM_CAPACITY)).enumerate() {
        let (first, mut stream) = (number * STREAM_CAPACITY, RayStream::default());
        rays.iter().for_each(|(ray, span)| stream.push(ray, *span));
        trace(first..first + rays.len(), &mut stream, seen);
    }
    seen
}

/// Asserts that what rays see is bit-identical.
pub(crate) fn assert_same_bits(a: &[RadianceSample], b: &[RadianceSample], context: &str) {
    assert_eq!(a.len(), b.len(), "{context}");
    let bits = |seen: &RadianceSample| (seen.radiance.to_array().map(f64::to_bits), seen.hit);
    for (at, (a, b)) in a.iter().zip(b).enumerate() {
        assert!(bits(a) == bits(b), "ray {at} of {context}: {a:?}, {b:?}");
    }
}

/// Radiance of rays, and the work of shading.
pub(crate) type Rendered = (Vec<RadianceSample>, ShadingCounts);

/// Asserts that hits one by one and in lanes of all levels have the same radiance, bit for bit, and the same counts. Returns them.
pub(crate) fn assert_same_at_all_levels(
    mut rendered: impl FnMut(Option<LaneLevel>) -> Rendered,
    context: &str,
) -> Rendered {
    let one = rendered(None);
    if LaneLevel::best().is_none() {
        println!("skipped: this processor lacks AVX2");
    }
    for level in [LaneLevel::avx2(), LaneLevel::best()].into_iter().flatten() {
        let lanes = rendered(Some(level));
        assert_eq!(one.1.without_lanes(), lanes.1.without_lanes(), "{level:?}, {context}");
        assert_same_bits(&one.0, &lanes.0, &format!("{level:?}, {context}"));
    }
    one
}

/// Asserts that the radiance of at most so many rays differs by more than `bound`.
pub(crate) fn assert_close(a: &[RadianceSample], b: &[RadianceSample], bound: f64, most: usize, context: impl Debug) {
    let differing = differing(a, b, bound);
    assert!(a.len() == b.len() && differing.len() <= most, "{context:?}: {differing:?}");
}

/// Shares of rays whose radiance differs by more than each bound.
pub(crate) fn shares_of_differences(a: &[RadianceSample], b: &[RadianceSample], bounds: [f64; 2]) -> [f64; 2] {
    bounds.map(|bound| differing(a, b, bound).len() as f64 / a.len() as f64)
}

/// Rays whose radiance differs by more than `bound`, or that hit in one of the cases only.
fn differing(a: &[RadianceSample], b: &[RadianceSample], bound: f64) -> Vec<String> {
    let differs = |a: &RadianceSample, b: &RadianceSample| !(a.hit == b.hit && difference(a, b) <= bound);
    let rays = a.iter().zip(b).enumerate().filter(|(_, (a, b))| differs(a, b));
    rays.map(|(at, (a, b))| format!("ray {at}: {a:?}, {b:?}")).collect()
}

/// Largest difference of a component, relative to the radiance.
fn difference(a: &RadianceSample, b: &RadianceSample) -> f64 {
    let size = a.radiance.max_component().max(b.radiance.max_component()).max(1e-3);
    (a.radiance - b.radiance).to_array().iter().fold(0.0, |max: f64, c| max.max(c.abs())) / size
}
