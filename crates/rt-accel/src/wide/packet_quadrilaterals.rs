//! Intersection of eight rays with a convex quadrilateral: the operations of [`Polygon::intersect`](rt_geometry::Polygon::intersect) in
//! lanes of `f64`, with the same bits.
//!
//! The scalar test resolves
//!
//! * sides of edges whose sign rounding may have changed,
//! * rays that do not pass all edges on the same side, and
//! * hits that depend on the padded bounds.

use rt_geometry::Plane;
use rt_math::DVec3;

use super::f64x8::{F64x8, max_abs};
use super::packet_planes;
use super::packet_triangles::{RaySpaceVertex, Shear, area, edge_error};
use super::ray_soa::{INNER_PAD, PacketHit, RaySoa8};
use super::simd::Simd;

/// Intersects the rays of a mask with a quadrilateral within their spans. All must be in the safe range. `by_axis` has a bit for each ray
/// with its largest direction component along an axis. Results of other rays are meaningless.
#[inline(always)]
pub(super) fn intersect<S: Simd>(
    simd: S,
    (plane, corners): (&Plane, &[DVec3; 4]),
    rays: &RaySoa8<S>,
    by_axis: [u32; 3],
    mask: u32,
) -> PacketHit<S> {
    let hits = packet_planes::intersect(simd, plane, rays);
    let possible = mask & hits.hit;
    let mut inside = 0;
    for (axis, along) in by_axis.into_iter().enumerate() {
        if possible & along != 0 {
            inside |= along & inside_all_edges(simd, corners, rays, axis);
        }
    }
    let [a, b, c, d] = corners;
    let (low, high) = (a.min(*b).min(c.min(*d)), a.max(*b).max(c.max(*d)));
    let pad = low.abs().max(high.abs()).max_element() * INNER_PAD;
    let (low, high) = (F64x8::splat3(simd, low), F64x8::splat3(simd, high));
    let [enter, leave] = rays.cross_box(simd, low, high, F64x8::splat(simd, pad));
    let hit = possible & inside & enter.le(simd, hits.t) & hits.t.le(simd, leave);
    PacketHit { hit, uncertain: possible & !hit, ..hits }
}

/// A bit for each ray that certainly passes all edges on the same side. Directions must be largest along `axis`.
#[inline(always)]
fn inside_all_edges<S: Simd>(simd: S, corners: &[DVec3; 4], rays: &RaySoa8<S>, axis: usize) -> u32 {
    let shear = Shear::new(simd, [(axis + 1) % 3, (axis + 2) % 3, axis % 3], rays);
    let a: RaySpaceVertex<S> = shear.in_ray_space(simd, rays, corners[0]);
    let b = shear.in_ray_space(simd, rays, corners[1]);
    let c = shear.in_ray_space(simd, rays, corners[2]);
    let d = shear.in_ray_space(simd, rays, corners[3]);
    let sides = [area(simd, &a, &b), area(simd, &b, &c), area(simd, &c, &d), area(simd, &d, &a)];
    let [of_x, of_y] = [[a.x, b.x, c.x, d.x], [a.y, b.y, c.y, d.y]];
    let across = max_of_four(simd, of_x).max(simd, max_of_four(simd, of_y));

    let error = edge_error(simd, across, max_of_four(simd, [a.z, b.z, c.z, d.z]));
    let min = sides[0].min(simd, sides[1]).min(simd, sides[2].min(simd, sides[3]));
    let max = sides[0].max(simd, sides[1]).max(simd, sides[2].max(simd, sides[3]));
    error.lt(simd, min) | max.lt(simd, F64x8::splat(simd, 0.0).sub(simd, error))
}

/// Maximum of the magnitudes of four numbers.
#[inline(always)]
fn max_of_four<S: Simd>(simd: S, [a, b, c, d]: [F64x8<S>; 4]) -> F64x8<S> {
    max_abs(simd, [a, b, c]).max(simd, d.abs(simd))
}
