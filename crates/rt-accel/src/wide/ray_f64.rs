//! A ray prepared for exact tests in SIMD lanes.

use rt_math::Ray;

use super::ray::RayF64x4;
use super::simd::Simd;

/// A ray prepared for exact tests.
pub(super) struct RayF64<'r, S: Simd> {
    pub(super) ray: &'r Ray,
    pub(super) lanes: RayF64x4<S>,
    /// Axis of the largest direction component.
    pub(super) axis: usize,
    /// Shear in the first two lanes; equals that of [`WatertightRay`](rt_geometry::WatertightRay).
    pub(super) shear: S::F64x4,
    /// Equals the scale of [`WatertightRay`](rt_geometry::WatertightRay).
    pub(super) scale: f64,
}

impl<'r, S: Simd> RayF64<'r, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, ray: &'r Ray) -> Self {
        let lanes = RayF64x4::new(simd, ray);
        let axis = simd.max_axis(simd.abs_f64(lanes.direction));
        let [_, _, scale, _] = simd.to_f64_array(simd.rotate_axis_last(lanes.inverse, axis));
        let shear = simd.mul_f64(simd.rotate_axis_last(lanes.direction, axis), simd.f64x4([scale; 4]));
        Self { ray, lanes, axis, shear, scale }
    }

    /// Axes in the order x, y, z of the ray's space.
    #[inline(always)]
    pub(super) fn axes(&self) -> [usize; 3] {
        AXES[self.axis & 3]
    }
}

/// Cyclic order of axes by the last; the fourth row is spare, so that two bits index the table.
pub(super) const AXES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];
