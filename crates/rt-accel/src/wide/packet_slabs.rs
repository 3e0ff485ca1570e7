//! Slab tests of eight rays with one box.

use super::f64x8::F64x8;
use super::node::Row;
use super::ray::SlabCoeffs;
use super::simd::Simd;

/// Sides of boxes that eight rays enter by.
#[derive(Clone, Copy)]
pub(super) struct PacketSides {
    /// By axis: row of the planes that are near for the first ray.
    near_row: [Row; 3],
    /// By axis: a bit for each ray for which they are far.
    flipped: [u32; 3],
}

impl PacketSides {
    #[inline(always)]
    pub(super) fn of<S: Simd>(simd: S, direction: [F64x8<S>; 3]) -> Self {
        let (x, y, z) = (direction[0].signs(simd), direction[1].signs(simd), direction[2].signs(simd));
        Self {
            near_row: Row::near([x as usize, y as usize, z as usize]),
            flipped: [unlike_first(x), unlike_first(y), unlike_first(z)],
        }
    }
}

/// Lanes whose bit differs from that of the first.
#[inline(always)]
const fn unlike_first(bits: u32) -> u32 {
    if bits & 1 == 0 { bits } else { 0xff & !bits }
}

/// Slab coefficients of eight rays.
#[derive(Clone, Copy)]
pub(super) struct PacketSlabs<S: Simd> {
    scale: [S::F32x8; 3],
    near_shift: [S::F32x8; 3],
    far_shift: [S::F32x8; 3],
    sides: PacketSides,
    min: S::F32x8,
}

impl<S: Simd> PacketSlabs<S> {
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        q: [F64x8<S>; 3],
        inverse: [F64x8<S>; 3],
        steepest: F64x8<S>,
        size: f64,
        sides: PacketSides,
        min: S::F32x8,
    ) -> Self {
        let zero = simd.splat(0.0);
        let mut this = Self { scale: [zero; 3], near_shift: [zero; 3], far_shift: [zero; 3], sides, min };
        let [steepest_low, steepest_high] = steepest.halves(simd);
        for axis in 0..3 {
            let ([q_low, q_high], [inverse_low, inverse_high]) = (q[axis].halves(simd), inverse[axis].halves(simd));
            let low = SlabCoeffs::new(simd, q_low, inverse_low, steepest_low, size);
            let high = SlabCoeffs::new(simd, q_high, inverse_high, steepest_high, size);
            this.scale[axis] = simd.concat_to_f32(low.scale, high.scale);
            this.near_shift[axis] = simd.concat_to_f32(low.near_shift, high.near_shift);
            this.far_shift[axis] = simd.concat_to_f32(low.far_shift, high.far_shift);
        }
        this
    }

    /// True if all rays are in the same octant.
    #[inline(always)]
    pub(super) fn is_same_octant(&self) -> bool {
        let [x, y, z] = self.sides.flipped;
        x | y | z == 0
    }

    /// Entry into and exit from one box, whose planes `plane` returns by row; equals
    /// [`RayF32::cross`](super::ray::RayF32::cross) bit for bit. `SAME_OCTANT` requires [`is_same_octant`](Self::is_same_octant).
    #[inline(always)]
    pub(super) fn cross<const SAME_OCTANT: bool>(
        &self,
        simd: S,
        plane: impl Fn(Row) -> S::F32x8,
        t_max: S::F32x8,
    ) -> [S::F32x8; 2] {
        let [x, y, z] = self.sides.near_row;
        let mut near = [plane(x), plane(y), plane(z)];
        let mut far = [plane(x.opposite()), plane(y.opposite()), plane(z.opposite())];
        if !SAME_OCTANT {
            for axis in 0..3 {
                let (one, other) = (near[axis], far[axis]);
                near[axis] = simd.select(self.sides.flipped[axis], other, one);
                far[axis] = simd.select(self.sides.flipped[axis], one, other);
            }
        }
        let enter_x = simd.mul_add(near[0], self.scale[0], self.near_shift[0]);
        let enter_y = simd.mul_add(near[1], self.scale[1], self.near_shift[1]);
        let enter_z = simd.mul_add(near[2], self.scale[2], self.near_shift[2]);
        let leave_x = simd.mul_add(far[0], self.scale[0], self.far_shift[0]);
        let leave_y = simd.mul_add(far[1], self.scale[1], self.far_shift[1]);
        let leave_z = simd.mul_add(far[2], self.scale[2], self.far_shift[2]);
        let enter = simd.max(simd.max(enter_x, enter_y), simd.max(enter_z, self.min));
        let leave = simd.min(simd.min(leave_x, leave_y), simd.min(leave_z, t_max));
        [enter, leave]
    }
}
