//! Exact intersection with triangles of leaves, three numbers at a time, bit-identical to [`intersect_triangle`].

use rt_geometry::{Hit, WatertightRay, intersect_triangle};
use rt_math::{BOUNDS_PADDING, DVec3, FAR_FACTOR, Interval, Ray, SlabRay};

use super::leaf::{Lane, LeafView, coordinates, corner};
use super::ray::{RayF64x4, max_lane};
use super::ray_f64::RayF64;
use super::simd::Simd;

#[inline(always)]
fn all<S: Simd>(simd: S, x: f64) -> S::F64x4 {
    simd.f64x4([x; 4])
}

#[inline(always)]
fn to_f64<S: Simd>(simd: S, [x, y, z]: [f32; 3]) -> S::F64x4 {
    simd.to_f64([x, y, z, 0.0])
}

/// A triangle of a leaf, and its index.
#[derive(Clone, Copy)]
pub(super) struct LeafTriangle<'a> {
    leaf: LeafView<'a>,
    lane: Lane,
    index: u32,
}

impl<'a> LeafTriangle<'a> {
    /// # Safety
    ///
    /// The leaf must be one of triangles.
    #[inline(always)]
    pub(super) const unsafe fn new(leaf: LeafView<'a>, lane: Lane, index: u32) -> Self {
        Self { leaf, lane, index }
    }

    #[inline(always)]
    fn corner<const VERTEX: usize>(self) -> [f32; 3] {
        const { assert!(VERTEX < 3) };
        // SAFETY: the leaf is one of triangles, as the caller of the constructor guarantees.
        unsafe { corner(self.leaf, self.lane, VERTEX) }
    }

    /// Closest hit within the span. Skips all rejections where the hit is `CERTAIN`.
    #[inline(always)]
    pub(super) fn hit<S: Simd, const CERTAIN: bool>(
        self,
        simd: S,
        exact: &RayF64<'_, S>,
        span: Interval,
    ) -> Option<Hit> {
        let edges = self.edge_functions(simd, exact);
        // Areas of a certain hit are far from 0, and accurate.
        if !CERTAIN && !edges.is_certain {
            return self.intersect_scalar(exact.ray, span);
        }
        let [u, v, w] = edges.areas;
        let outside = ((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0));
        let determinant = u + v + w;
        if !CERTAIN && (outside | (determinant == 0.0)) {
            return None;
        }
        let quotients = simd.div_f64(simd.f64x4([edges.weighted, v, w, 1.0]), all(simd, determinant));
        let [t, v, w, _] = simd.to_f64_array(quotients);
        if !CERTAIN {
            if (determinant.abs() <= edges.min_determinant) | (t.abs() <= edges.origin_side_bound) {
                return self.intersect_scalar(exact.ray, span);
            }
            if !(span.contains(t) & t.is_finite()) {
                return None;
            }
        }
        let Interval { min: enter, max: leave } = self.clip(simd, &exact.lanes, span);
        if !CERTAIN && enter > leave {
            return None;
        }
        Some(Hit { t: if enter > t { enter } else { t }, instance: 0, primitive: self.index, uv: [v, w] })
    }

    /// Scalar fallback for uncertain signs.
    #[cold]
    #[inline(never)]
    fn intersect_scalar(self, ray: &Ray, span: Interval) -> Option<Hit> {
        let position = |[x, y, z]: [f32; 3]| DVec3::new(f64::from(x), f64::from(y), f64::from(z));
        let vertices = [position(self.corner::<0>()), position(self.corner::<1>()), position(self.corner::<2>())];
        let slab_ray = SlabRay::new(ray);
        intersect_triangle(vertices, self.index, &slab_ray, &WatertightRay::new(ray), span)
    }

    #[inline(always)]
    fn edge_functions<S: Simd>(self, simd: S, exact: &RayF64<'_, S>) -> EdgeFunctions {
        let [x_axis, y_axis, z_axis] = exact.axes();
        let ([shear_x, shear_y, ..], scale) = (simd.to_f64_array(exact.shear), exact.scale);
        let [origin_x, origin_y, origin_z, _] =
            simd.to_f64_array(simd.rotate_axis_last(exact.lanes.origin, exact.axis));
        // SAFETY: the leaf is one of triangles, as the caller of the constructor guarantees, and `axes` are each less than 3.
        let [x, y, z] = unsafe {
            [
                coordinates(self.leaf, self.lane, x_axis),
                coordinates(self.leaf, self.lane, y_axis),
                coordinates(self.leaf, self.lane, z_axis),
            ]
        };
        let (x, y, z) = (to_f64(simd, x), to_f64(simd, y), to_f64(simd, z));
        let x = simd.sub_f64(x, all(simd, origin_x));
        let y = simd.sub_f64(y, all(simd, origin_y));
        let z = simd.sub_f64(z, all(simd, origin_z));
        let x = simd.sub_f64(x, simd.mul_f64(all(simd, shear_x), z));
        let y = simd.sub_f64(y, simd.mul_f64(all(simd, shear_y), z));
        let across = max_lane(simd, simd.max_f64(simd.abs_f64(x), simd.abs_f64(y)));
        let edge_error = WatertightRay::edge_error(across, max_lane(simd, simd.abs_f64(z)));
        let depths = simd.mul_f64(z, all(simd, scale));

        let minuends = simd.mul_f64(simd.zxy(x), simd.yzx(y));
        let subtrahends = simd.mul_f64(simd.zxy(y), simd.yzx(x));
        let areas = simd.sub_f64(minuends, subtrahends);
        let doubt = simd.sub_f64(all(simd, edge_error), simd.abs_f64(areas));
        let [u, v, w, _] = simd.to_f64_array(areas);
        let [ua, vb, wc, _] = simd.to_f64_array(simd.mul_f64(areas, depths));
        let [a, b, c, _] = simd.to_f64_array(simd.abs_f64(depths));
        EdgeFunctions {
            areas: [u, v, w],
            weighted: ua + vb + wc,
            is_certain: simd.signs(doubt) & 7 == 7,
            min_determinant: edge_error * WatertightRay::MIN_DETERMINANT,
            origin_side_bound: WatertightRay::ORIGIN_SIDE_BOUND * (a + b + c),
        }
    }

    /// Part of the span inside the padded bounds; empty for a miss.
    #[inline(always)]
    fn clip<S: Simd>(self, simd: S, ray: &RayF64x4<S>, span: Interval) -> Interval {
        let a = to_f64(simd, self.corner::<0>());
        let b = to_f64(simd, self.corner::<1>());
        let c = to_f64(simd, self.corner::<2>());
        let min = simd.min_f64(simd.min_f64(a, b), c);
        let max = simd.max_f64(simd.max_f64(a, b), c);
        let size = max_lane(simd, simd.max_f64(simd.abs_f64(min), simd.abs_f64(max)));
        let pad = all(simd, size * BOUNDS_PADDING);
        let (min, max) = (simd.sub_f64(min, pad), simd.add_f64(max, pad));
        let near = simd.sub_f64(simd.select_by_sign(ray.inverse, min, max), ray.origin);
        let far = simd.sub_f64(simd.select_by_sign(ray.inverse, max, min), ray.origin);
        // A NaN is no constraint.
        let enter = simd.max_f64(simd.mul_f64(near, ray.inverse), all(simd, span.min));
        let t_far = simd.mul_f64(simd.mul_f64(far, ray.inverse), all(simd, FAR_FACTOR));
        let leave = simd.min_f64(t_far, all(simd, span.max));
        let negated = simd.sub_f64(all(simd, 0.0), leave);
        Interval { min: max_lane(simd, enter), max: -max_lane(simd, negated) }
    }
}

/// Edge functions of a triangle in the space of the ray.
struct EdgeFunctions {
    /// Twice the areas between the ray and the edges.
    areas: [f64; 3],
    /// Sum of the areas times the depths of the opposite vertices.
    weighted: f64,
    /// True if the signs of the areas are exact.
    is_certain: bool,
    /// Up to this sum of the areas, the weights may be too inaccurate.
    min_determinant: f64,
    /// Up to this `t`, rounding may change the side of the triangle that the ray starts on.
    origin_side_bound: f64,
}
