//! Points, normals and squares of checkerboards where rays hit one primitive, in lanes.

use crate::{lane_set::LaneSet, stream_queries::StreamShape};
use rt_geometry::{HitStream, RayStream, interpolate, plane_point, plane_uv, sphere_point, triangle_point};
use rt_math::{DVec3, Mask, Real, Vector3};

/// Hits of several rays on one primitive.
pub(super) struct HitPoints<L: LaneSet> {
    pub(super) point: Vector3<L::D>,
    pub(super) error: Vector3<L::D>,
    /// Unit normals on the outside.
    pub(super) outside: Vector3<L::D>,
    /// Directions of the rays, of any length.
    pub(super) direction: Vector3<L::D>,
    origin: Vector3<L::D>,
    pub(super) t: L::D,
}

impl<L: LaneSet> HitPoints<L> {
    /// Hits of the rays from index `at` on.
    #[inline(always)]
    pub(super) fn new(lanes: L, shape: &StreamShape<'_>, rays: &RayStream, hits: &HitStream, at: usize) -> Self {
        let origin = lanes.load_point(&rays.origin, at);
        let direction = lanes.load_point(&rays.direction, at);
        let t = lanes.load_f64(hits.t.vector(at));
        let (point, error, outside) = match shape {
            StreamShape::Sphere(sphere) => {
                let (centre, radius) = (lanes.splat_point(sphere.centre()), lanes.splat_f64(sphere.radius()));
                let (mut outside, has_normal) = ((origin - centre) + direction * t).try_normalize();
                if !has_normal.all() {
                    // The point on a tiny sphere is rounded to its centre.
                    let (towards_viewer, _) = (-direction).try_normalize();
                    outside = Vector3::select(has_normal, outside, towards_viewer);
                }
                let (point, error) = sphere_point(centre, radius, outside);
                (point, error, outside)
            }
            StreamShape::Plane(plane) => {
                let outside = lanes.splat_point(plane.normal());
                let (point, error) = plane_point(lanes.splat_point(plane.point()), outside, origin + direction * t);
                (point, error, outside)
            }
            StreamShape::Triangle { vertices: [a, b, c], normal } => {
                let corners = [lanes.splat_point(*a), lanes.splat_point(*b), lanes.splat_point(*c)];
                let (point, error) = triangle_point(corners, Self::uv_of_triangle(lanes, hits, at));
                (point, error, lanes.splat_point(*normal))
            }
        };
        Self { point, error, outside, direction, origin, t }
    }

    #[inline(always)]
    fn uv_of_triangle(lanes: L, hits: &HitStream, at: usize) -> [L::D; 2] {
        let [u, v] = &hits.uv;
        [lanes.load_f64(u.vector(at)), lanes.load_f64(v.vector(at))]
    }

    /// Lanes on an odd square of a checkerboard with this side.
    #[inline(always)]
    pub(super) fn odd_squares(
        &self,
        lanes: L,
        (shape, vertex_uvs): (&StreamShape<'_>, impl FnOnce() -> [[f32; 2]; 3]),
        (hits, at): (&HitStream, usize),
        side: f64,
    ) -> u8 {
        let [u, v] = match shape {
            StreamShape::Sphere(_) => return 0,
            StreamShape::Plane(plane) => {
                let (point, normal) = (lanes.splat_point(plane.point()), lanes.splat_point(plane.normal()));
                plane_uv(point, normal, [self.origin, self.direction], self.t)
            }
            StreamShape::Triangle { .. } => {
                let [a, b, c] = vertex_uvs();
                let weights = Self::uv_of_triangle(lanes, hits, at);
                let corner = |x: f32| lanes.splat_f64(f64::from(x));
                [
                    interpolate([corner(a[0]), corner(b[0]), corner(c[0])], weights),
                    interpolate([corner(a[1]), corner(b[1]), corner(c[1])], weights),
                ]
            }
        };
        let side = lanes.splat_f64(side);
        let half = (lanes.floor_f64(u / side) + lanes.floor_f64(v / side)) * 0.5;
        !lanes.bits_f64((half - lanes.floor_f64(half)).eq(lanes.splat_f64(0.0)))
    }

    /// Point of a lane with its error bound, and its normal on the outside.
    pub(super) fn get(&self, lanes: L, lane: usize) -> [DVec3; 3] {
        [self.point, self.error, self.outside].map(|v| DVec3::from(lanes.store_point(v).map(|numbers| numbers[lane])))
    }
}
