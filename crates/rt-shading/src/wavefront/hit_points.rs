//! Points, normals and texture coordinates where rays hit primitives, in lanes.

use super::gathered_shapes::GatheredShapes;
use crate::{lane_set::LaneSet, lanes::each_lane};
use rt_geometry::{
    HitStream, Plane, RayStream, SmoothPoint, Sphere, SurfaceInteraction, interpolate, plane_point, plane_uv,
    smooth_point, sphere_point, triangle_point, unit_normal, unit_normal_lanes,
};
use rt_math::{DVec3, Mask, Vector3};

/// Hits of several rays.
pub(crate) struct HitPoints<L: LaneSet> {
    pub(crate) point: Vector3<L::D>,
    pub(crate) error: Vector3<L::D>,
    /// Unit normals on the outside.
    pub(crate) outside: Vector3<L::D>,
    /// Directions of the rays, of any length.
    pub(crate) direction: Vector3<L::D>,
    origin: Vector3<L::D>,
    pub(crate) t: L::D,
}

impl<L: LaneSet> HitPoints<L> {
    /// Hits on a sphere of the rays from index `at` on.
    #[inline(always)]
    pub(crate) fn on_sphere(lanes: L, sphere: &Sphere, (rays, hits): (&RayStream, &HitStream), at: usize) -> Self {
        let ray = &RayLanes::new(lanes, rays, hits, at);
        ray.hit(ray.on_sphere(lanes.splat_point(sphere.centre()), lanes.splat_f64(sphere.radius())))
    }

    /// Hits on a plane of the rays from index `at` on.
    #[inline(always)]
    pub(crate) fn on_plane(lanes: L, plane: &Plane, (rays, hits): (&RayStream, &HitStream), at: usize) -> Self {
        let ray = &RayLanes::new(lanes, rays, hits, at);
        ray.hit(ray.on_plane([plane.point(), plane.normal()].map(|p| lanes.splat_point(p))))
    }

    /// Hits on gathered shapes of the rays from index `at` on.
    #[inline(always)]
    pub(crate) fn on_shapes(lanes: L, shapes: &GatheredShapes, rays: &RayStream, hits: &HitStream, at: usize) -> Self {
        let ray = &RayLanes::new(lanes, rays, hits, at);
        let &GatheredShapes { spheres, planes, meshes, surfaces, corners: [ref a, ref b, ref c], ref normal, .. } =
            shapes;
        let (a, mut normal) = (lanes.load_coordinates(a), lanes.load_coordinates(normal));
        let corners = [a, lanes.load_coordinates(b), lanes.load_coordinates(c)];
        if meshes != 0 {
            let normal_of_mesh = normals_of_triangles(lanes, corners, meshes);
            normal = Vector3::select(lanes.mask_f64(meshes), normal_of_mesh, normal);
        }
        let (point, error) = triangle_point(corners, Self::uv_of_triangle(lanes, hits, at));
        let mut surface = [point, error, normal];
        if spheres != 0 {
            surface = replaced(lanes, surface, spheres, ray.on_sphere(a, normal.x));
        }
        if planes != 0 {
            surface = replaced(lanes, surface, planes, ray.on_plane([a, normal]));
        }
        if surfaces != 0 {
            surface = replaced(lanes, surface, surfaces, [a, corners[1], normal]);
        }
        ray.hit(surface)
    }

    /// Interpolated normals and lifted points, as on [`on_shapes`](Self::on_shapes). Those of flat triangles are not valid.
    #[inline(always)]
    pub(crate) fn smooth(
        &self,
        lanes: L,
        GatheredShapes { surfaces, corners: [a, b, c], vertex_normals: [d, e, f], .. }: &GatheredShapes,
        (hits, at): (&HitStream, usize),
    ) -> SmoothPoint<L::D> {
        let corners = [lanes.load_coordinates(a), lanes.load_coordinates(b), lanes.load_coordinates(c)];
        let normals = [lanes.load_coordinates(d), lanes.load_coordinates(e), lanes.load_coordinates(f)];
        let uv = Self::uv_of_triangle(lanes, hits, at);
        let mut smooth = smooth_point((self.point, self.outside), corners, normals, uv, self.direction);
        if *surfaces != 0 {
            let is_known = lanes.mask_f64(*surfaces);
            smooth.normal = Vector3::select(is_known, normals[0], smooth.normal);
            smooth.shadow_point = Vector3::select(is_known, corners[2], smooth.shadow_point);
            smooth.is_valid = smooth.is_valid | is_known;
        }
        smooth
    }

    #[inline(always)]
    fn uv_of_triangle(lanes: L, hits: &HitStream, at: usize) -> [L::D; 2] {
        let [u, v] = &hits.uv;
        [lanes.load_f64(u.vector(at)), lanes.load_f64(v.vector(at))]
    }

    /// Texture coordinates on a plane.
    #[inline(always)]
    pub(crate) fn uv_on_plane(&self, lanes: L, plane: &Plane) -> [L::D; 2] {
        let [point, normal] = [plane.point(), plane.normal()].map(|p| lanes.splat_point(p));
        plane_uv(point, normal, [self.origin, self.direction], self.t)
    }

    /// Texture coordinates on gathered triangles, those of whose vertices are known.
    #[inline(always)]
    pub(crate) fn uv_on_triangles(lanes: L, shapes: &GatheredShapes, hits: &HitStream, at: usize) -> [L::D; 2] {
        let weights = Self::uv_of_triangle(lanes, hits, at);
        let [[a, b, c], [d, e, f]] = &shapes.vertex_uvs;
        [
            interpolate([lanes.load_f64(a), lanes.load_f64(b), lanes.load_f64(c)], weights),
            interpolate([lanes.load_f64(d), lanes.load_f64(e), lanes.load_f64(f)], weights),
        ]
    }

    /// Surface of a lane, without texture coordinates and interpolated normal.
    #[inline(never)]
    pub(crate) fn surface(&self, lanes: L, lane: usize) -> SurfaceInteraction {
        let [point, error, normal] = self.get(lanes, lane);
        SurfaceInteraction::flat(point, error, normal, [0.0; 2])
    }

    /// Point of a lane with its error bound, and its normal on the outside.
    pub(crate) fn get(&self, lanes: L, lane: usize) -> [DVec3; 3] {
        [self.point, self.error, self.outside].map(|v| DVec3::from(lanes.store_point(v).map(|numbers| numbers[lane])))
    }
}

/// Surfaces, with others in the lanes of a mask.
#[inline(always)]
fn replaced<L: LaneSet>(lanes: L, surfaces: Surfaces<L>, mask: u8, others: Surfaces<L>) -> Surfaces<L> {
    let (mask, [point, error, outside], [other_point, other_error, other_outside]) =
        (lanes.mask_f64(mask), surfaces, others);
    [
        Vector3::select(mask, other_point, point),
        Vector3::select(mask, other_error, error),
        Vector3::select(mask, other_outside, outside),
    ]
}

#[inline(always)]
fn normals_of_triangles<L: LaneSet>(lanes: L, corners: [Vector3<L::D>; 3], mask: u8) -> Vector3<L::D> {
    let (normals, is_valid) = unit_normal_lanes(corners);
    let slivers = mask & !lanes.bits_f64(is_valid);
    if slivers == 0 { normals } else { normals_of_slivers(lanes, corners, normals, slivers) }
}

/// Replaces the normals of some lanes.
#[inline(never)]
fn normals_of_slivers<L: LaneSet>(
    lanes: L,
    [a, b, c]: [Vector3<L::D>; 3],
    normals: Vector3<L::D>,
    slivers: u8,
) -> Vector3<L::D> {
    let (corners, mut normals) = ([a, b, c].map(|p| lanes.store_point(p)), lanes.store_point(normals));
    for lane in each_lane(slivers) {
        let normal = unit_normal(corners.map(|corner| corner.map(|numbers| numbers[lane]).into()));
        for (numbers, coordinate) in normals.iter_mut().zip(normal.to_array()) {
            numbers[lane] = coordinate;
        }
    }
    lanes.load_coordinates(&normals)
}

/// Rays with the parameters of their hits.
struct RayLanes<L: LaneSet> {
    origin: Vector3<L::D>,
    direction: Vector3<L::D>,
    t: L::D,
}

/// Points, their error bounds, and unit normals on the outside.
type Surfaces<L> = [Vector3<<L as LaneSet>::D>; 3];

impl<L: LaneSet> RayLanes<L> {
    #[inline(always)]
    fn new(lanes: L, rays: &RayStream, hits: &HitStream, at: usize) -> Self {
        Self {
            origin: lanes.load_point(&rays.origin, at),
            direction: lanes.load_point(&rays.direction, at),
            t: lanes.load_f64(hits.t.vector(at)),
        }
    }

    #[inline(always)]
    fn on_sphere(&self, centre: Vector3<L::D>, radius: L::D) -> Surfaces<L> {
        let &Self { origin, direction, t } = self;
        let (mut outside, has_normal) = ((origin - centre) + direction * t).try_normalize();
        if !has_normal.all() {
            // The point on a tiny sphere is rounded to its centre.
            let (towards_viewer, _) = (-direction).try_normalize();
            outside = Vector3::select(has_normal, outside, towards_viewer);
        }
        let (point, error) = sphere_point(centre, radius, outside);
        [point, error, outside]
    }

    /// On planes through points with unit normals.
    #[inline(always)]
    fn on_plane(&self, [point, normal]: [Vector3<L::D>; 2]) -> Surfaces<L> {
        let (point, error) = plane_point(point, normal, self.origin + self.direction * self.t);
        [point, error, normal]
    }

    #[inline(always)]
    fn hit(&self, [point, error, outside]: Surfaces<L>) -> HitPoints<L> {
        let &Self { origin, direction, t } = self;
        HitPoints { point, error, outside, direction, origin, t }
    }
}
