//! Leaves of spheres: distance of the ray from the centre, in `f32` with an error margin.
//!
//! # Why the filter is conservative
//!
//! Let `v = 2⁻²⁴`, and let `X` be the sum of the maximum coordinates of the origin and of the leaf. Both are relative
//! to the centre of the tree. Centre and origin are rounded and subtracted, to within `4v·X` on each axis. The
//! direction, its square, the projection and the remaining perpendicular add some `20v·X`. So the distance `l` of the
//! ray from the centre is computed to within `δ = 64v·X`. This also covers the rounding of the radius `r`, which is
//! part of the maximum coordinate. A ray hits if `l < r − δ` and misses if `l > r + δ`. For a hit, `r² − l²` is off by
//! at most `4(r + δ)·δ` and the projection by `24v·X`, which bounds the `t` of the first root.
//!
//! Other primitives have spheres around their padded bounds. They are missed where that sphere is missed within the
//! span, and never certainly hit.

use super::leaf_test::{HitBounds, LeafTest};
use crate::wide::WideBvh;
use crate::wide::f64x8::{F64x8, relative};
use crate::wide::frustum::BundleFrustum;
use crate::wide::leaf::{Lane, LeafView, SPHERE_HEADER, SPHERE_NUMBERS};
use crate::wide::ray::{RayF32, max_lane, round_up};
use crate::wide::ray_f64::RayF64;
use crate::wide::ray_packet::RayPacket;
use crate::wide::simd::Simd;
use crate::wide::t_range::{FilterTRange, SpanLanes};

/// `δ/X`
const MARGIN: f32 = 64.0 / (1 << 24) as f32;

/// For smaller `δ` squares may vanish, and only a miss of the outer square is certain.
const MIN_MARGIN: f32 = 1.0 / (1u64 << 50) as f32;

/// Distance of the ray from centres, with three results.
#[derive(Clone, Copy)]
pub(in crate::wide) struct SphereTest {
    origin: [f32; 4],
    direction: [f32; 4],
    /// Reciprocal length of the direction.
    inverse_length: f32,
    /// Maximum coordinate of the origin.
    reach: f32,
    span: FilterTRange,
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: [S::F32x8; 3], b: [S::F32x8; 3]) -> S::F32x8 {
    simd.mul_add(a[2], b[2], simd.mul_add(a[1], b[1], simd.mul(a[0], b[0])))
}

/// Square root, 0 for a negative number.
#[inline(always)]
fn root<S: Simd>(simd: S, x: S::F32x8) -> S::F32x8 {
    simd.sqrt(simd.max(x, simd.splat(0.0)))
}

/// Spheres of a leaf in lanes.
struct SphereLanes<S: Simd> {
    centre: [S::F32x8; 3],
    /// Negative for bounding spheres of other primitives.
    radius: S::F32x8,
    max_coordinate: f32,
}

/// One ray in all lanes, or eight rays.
pub(in crate::wide) struct SphereRays<S: Simd> {
    origin: [S::F32x8; 3],
    direction: [S::F32x8; 3],
    inverse_length: S::F32x8,
    reach: S::F32x8,
    span: SpanLanes<S>,
}

impl<S: Simd> SphereRays<S> {
    #[inline(always)]
    fn test(&self, simd: S, spheres: &SphereLanes<S>, t_max: S::F32x8, mask: u32) -> HitBounds<S> {
        let margin = simd.mul(simd.add(self.reach, simd.splat(spheres.max_coordinate)), simd.splat(MARGIN));
        let to_centre = [
            simd.sub(spheres.centre[0], self.origin[0]),
            simd.sub(spheres.centre[1], self.origin[1]),
            simd.sub(spheres.centre[2], self.origin[2]),
        ];
        let radius = simd.abs(spheres.radius);
        let along = dot(simd, to_centre, self.direction);
        let across = [
            simd.neg_mul_add(along, self.direction[0], to_centre[0]),
            simd.neg_mul_add(along, self.direction[1], to_centre[1]),
            simd.neg_mul_add(along, self.direction[2], to_centre[2]),
        ];
        let distance_squared = dot(simd, across, across);
        let outer = simd.add(radius, margin);
        let possible = simd.le(distance_squared, simd.mul(outer, outer)) & mask;
        if possible == 0 {
            return HitBounds { possible, certain: 0, t_min: along, t_max: along };
        }

        let inner = simd.sub(spheres.radius, margin);
        let is_tiny = simd.lt(margin, simd.splat(MIN_MARGIN));
        let inside =
            simd.le(distance_squared, simd.mul(inner, simd.sub(inner, margin))) & simd.le(margin, inner) & !is_tiny;
        let half_chord_squared = simd.mul_sub(radius, radius, distance_squared);
        let slack = simd.mul(outer, simd.mul(simd.splat(4.25), margin));
        let longest = simd.add(root(simd, simd.add(half_chord_squared, slack)), margin);
        let shortest = simd.sub(root(simd, simd.sub(half_chord_squared, slack)), margin);
        let to_t = self.inverse_length;
        // One or two roundings of the largest number.
        let rounding = simd.mul(simd.mul(margin, to_t), simd.splat(0.125));
        let near = simd.sub(simd.mul(simd.sub(along, longest), to_t), rounding);
        let far = simd.add(simd.mul(simd.sub(along, shortest), to_t), rounding);
        let last = simd.add(simd.mul(simd.add(along, longest), to_t), rounding);

        let is_not_behind = simd.le(self.span.min[0], last);
        let is_not_after = simd.le(near, t_max);
        let is_in_front = simd.le(self.span.min[1], near);
        let is_in_time = simd.le(far, self.span.max);
        let possible = possible & (is_tiny | (is_not_behind & is_not_after));
        HitBounds { possible, certain: inside & possible & is_in_front & is_in_time, t_min: near, t_max: far }
    }
}

impl LeafTest for SphereTest {
    const HEADER: usize = SPHERE_HEADER;
    const NUMBERS: usize = SPHERE_NUMBERS;

    #[inline(always)]
    fn new<S: Simd>(simd: S, ray: &RayF64<'_, S>, _: &RayF32, span: FilterTRange, tree: &WideBvh) -> Self {
        let centre = simd.f64x4([tree.centre.x, tree.centre.y, tree.centre.z, 0.0]);
        let origin = simd.sub_f64(ray.lanes.origin, centre);
        let [x, y, z, _] = simd.to_f64_array(simd.mul_f64(ray.lanes.direction, ray.lanes.direction));
        let inverse_length = 1.0 / (x + y + z).sqrt();
        let unit = simd.mul_f64(ray.lanes.direction, simd.f64x4([inverse_length; 4]));
        Self {
            origin: simd.to_f32(origin),
            direction: simd.to_f32(unit),
            inverse_length: inverse_length as f32,
            reach: round_up(max_lane(simd, simd.abs_f64(origin))),
            span,
        }
    }

    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, leaf: LeafView<'_>, t_max: f32) -> HitBounds<S> {
        let n = leaf.count;
        // SAFETY: these are the header and the four numbers of spheres.
        let spheres = unsafe {
            SphereLanes {
                centre: [
                    leaf.lanes(simd, SPHERE_HEADER),
                    leaf.lanes(simd, SPHERE_HEADER + n),
                    leaf.lanes(simd, SPHERE_HEADER + 2 * n),
                ],
                radius: leaf.lanes(simd, SPHERE_HEADER + 3 * n),
                max_coordinate: leaf.number(0),
            }
        };
        let [x, y, z, _] = self.origin;
        let [dx, dy, dz, _] = self.direction;
        let ray = SphereRays {
            origin: [simd.splat(x), simd.splat(y), simd.splat(z)],
            direction: [simd.splat(dx), simd.splat(dy), simd.splat(dz)],
            inverse_length: simd.splat(self.inverse_length),
            reach: simd.splat(self.reach),
            span: self.span.splat(simd),
        };
        ray.test(simd, &spheres, simd.splat(t_max), leaf.mask())
    }

    type Packet<S: Simd> = SphereRays<S>;

    #[inline(always)]
    fn packet<S: Simd>(simd: S, rays: &RayPacket<S>, tree: &WideBvh) -> SphereRays<S> {
        let origin = relative(simd, rays.soa.origin, tree.centre);
        let [x, y, z] = rays.soa.direction;
        let length_squared = x.mul(simd, x).add(simd, y.mul(simd, y)).add(simd, z.mul(simd, z));
        let inverse_length = F64x8::splat(simd, 1.0).div(simd, length_squared.sqrt(simd));
        SphereRays {
            origin: [origin[0].to_f32(simd), origin[1].to_f32(simd), origin[2].to_f32(simd)],
            direction: [
                x.mul(simd, inverse_length).to_f32(simd),
                y.mul(simd, inverse_length).to_f32(simd),
                z.mul(simd, inverse_length).to_f32(simd),
            ],
            inverse_length: inverse_length.to_f32(simd),
            reach: RayPacket::reach(simd, origin),
            span: rays.span,
        }
    }

    #[inline(always)]
    fn test_packet<S: Simd>(
        simd: S,
        rays: &SphereRays<S>,
        leaf: LeafView<'_>,
        lane: Lane,
        t_max: S::F32x8,
    ) -> HitBounds<S> {
        let (n, first) = (leaf.count, SPHERE_HEADER + lane.index());
        // SAFETY: these are the header and the four numbers of a sphere, whose lane is less than 8.
        let sphere = unsafe {
            SphereLanes {
                centre: [
                    simd.splat(leaf.number(first)),
                    simd.splat(leaf.number(first + n)),
                    simd.splat(leaf.number(first + 2 * n)),
                ],
                radius: simd.splat(leaf.number(first + 3 * n)),
                max_coordinate: leaf.number(0),
            }
        };
        rays.test(simd, &sphere, t_max, 0xff)
    }

    const IS_SPHERE: bool = true;

    #[inline(always)]
    fn cull_by_frustum<S: Simd>(simd: S, frustum: &BundleFrustum<S>, leaf: LeafView<'_>) -> u32 {
        let n = leaf.count;
        // SAFETY: the header, and the last of four numbers.
        let (max_coordinate, radius) = unsafe { (leaf.number(0), leaf.lanes(simd, SPHERE_HEADER + 3 * n)) };
        let margin = simd.splat(frustum.margin(max_coordinate));
        let radius = simd.add(simd.abs(radius), margin);
        let (hit, _) = frustum.intersect_boxes(simd, |row| {
            let row = row.index();
            // SAFETY: half a row is an axis, and the numbers of the three axes come first.
            let centre = unsafe { leaf.lanes(simd, SPHERE_HEADER + row / 2 * n) };
            if row & 1 == 0 { simd.sub(centre, radius) } else { simd.add(centre, radius) }
        });
        hit & leaf.mask()
    }
}
