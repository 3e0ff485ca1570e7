//! A ray prepared for traversal.

use rt_math::{Interval, Ray};

use crate::wide::WideBvh;
use crate::wide::filter::LeafTest;
use crate::wide::ray::RayF32;
use crate::wide::ray_f64::RayF64;
use crate::wide::simd::Simd;
use crate::wide::t_range::FilterTRange;

/// A ray prepared for the boxes of nodes and the primitives of leaves.
pub(in crate::wide) struct TravRay<'r, S: Simd, F> {
    pub(in crate::wide) ray: RayF64<'r, S>,
    pub(in crate::wide) boxes: RayF32,
    pub(in crate::wide) min: f32,
    pub(in crate::wide) leaf_test: F,
}

impl<'r, S: Simd, F: LeafTest> TravRay<'r, S, F> {
    /// `None` where the proofs of the filters do not apply.
    #[inline(always)]
    pub(in crate::wide) fn new(simd: S, tree: &WideBvh, ray: &'r Ray, span: Interval) -> Option<Self> {
        let ray = RayF64::new(simd, ray);
        let boxes = RayF32::new(simd, &ray.lanes, span, tree.centre, tree.size)?;
        let span = FilterTRange::new(simd, span);
        Some(Self { min: span.min(), leaf_test: F::new(simd, &ray, &boxes, span, tree), ray, boxes })
    }
}
