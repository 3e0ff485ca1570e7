//! Eight rays and a plane: the exact kernel in lanes of `f64`.

use rt_geometry::Plane;
use rt_math::DVec3;

use super::f64x8::{F64x8, dot, sub3};
use super::ray_soa::{PacketHit, RaySoa8};
use super::simd::Simd;

/// Hits of eight rays on a plane: those of [`Plane::intersect`], none of them uncertain.
#[inline(always)]
pub(super) fn intersect<S: Simd>(simd: S, plane: &Plane, soa: &RaySoa8<S>) -> PacketHit<S> {
    let of_plane = |v: DVec3| v.to_array().map(|number| F64x8::splat(simd, number));
    let normal = of_plane(plane.normal());
    let to_plane = sub3(simd, of_plane(plane.point()), soa.origin);
    let t = dot(simd, normal, to_plane).div(simd, dot(simd, normal, soa.direction));
    let hit = soa.min.le(simd, t) & t.le(simd, soa.max) & t.lt(simd, F64x8::splat(simd, f64::INFINITY));
    PacketHit { hit, uncertain: 0, t, uv: [F64x8::splat(simd, 0.0); 2] }
}
