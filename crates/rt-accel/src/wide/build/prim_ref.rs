//! Reference to a primitive during the build.

use glam::{Vec3A, Vec4};

use crate::bvh::Aabb32;

/// Bounds of one or two primitives in 32 bytes.
///
/// The fourth lane of each corner holds half of the first index, in the mantissa of a number from 1 to 2. Arithmetic on
/// the whole corner cannot turn it into a denormal number or a NaN, which are slow on some processors.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct PrimRef {
    min: [f32; 4],
    max: [f32; 4],
}

/// Consecutive primitives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PrimRange {
    pub(super) first: u32,
    /// 1 or 2.
    pub(super) count: u32,
}

const ONE: u32 = 1.0f32.to_bits();

/// Flag of two primitives.
const PAIR: u32 = 1 << 16;

impl PrimRef {
    pub(super) const NONE: Self = Self { min: [0.0; 4], max: [0.0; 4] };

    /// The box must not be empty. Zeros lose their sign, so that minima do not depend on the order.
    #[inline(always)]
    pub(super) fn new(bounds: Aabb32, index: u32) -> Self {
        let tagged = |corner: Vec3A, half: u32| (corner + Vec3A::ZERO).extend(f32::from_bits(ONE | half)).to_array();
        Self { min: tagged(bounds.min, index & 0xffff), max: tagged(bounds.max, index >> 16) }
    }

    /// Merges two consecutive primitives in one box.
    #[inline(always)]
    pub(super) fn merge(&self, bounds: &Aabb32) -> Self {
        let tagged = |corner: Vec3A, tag: u32| corner.extend(f32::from_bits(tag)).to_array();
        Self { min: tagged(bounds.min, self.min[3].to_bits() | PAIR), max: tagged(bounds.max, self.max[3].to_bits()) }
    }

    #[inline(always)]
    pub(super) fn bounds(&self) -> Aabb32 {
        Aabb32 { min: Vec3A::from_vec4(Vec4::from_array(self.min)), max: Vec3A::from_vec4(Vec4::from_array(self.max)) }
    }

    /// Index of the first primitive.
    #[inline(always)]
    pub(super) fn index(&self) -> u32 {
        let half = |corner: [f32; 4]| corner[3].to_bits() & 0xffff;
        half(self.min) | half(self.max) << 16
    }

    #[inline(always)]
    pub(super) fn run(&self) -> PrimRange {
        PrimRange { first: self.index(), count: 1 + u32::from(self.min[3].to_bits() & PAIR != 0) }
    }

    /// Twice the centre of the box, for sorting.
    #[inline(always)]
    pub(super) fn centroid(&self) -> Vec3A {
        Vec3A::from_vec4(Vec4::from_array(self.min) + Vec4::from_array(self.max))
    }

    #[inline(always)]
    pub(super) fn centroid_on(&self, axis: usize) -> f32 {
        self.min[axis] + self.max[axis]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_index_survives() {
        for index in [0, 1, 0xffff, 0x1_0000, 0xdead_beef, u32::MAX] {
            let bounds = Aabb32 { min: Vec3A::splat(-1.5), max: Vec3A::new(0.25, f32::INFINITY, 1e-45) };
            let reference = PrimRef::new(bounds, index);
            assert_eq!((reference.bounds(), reference.index()), (bounds, index));
        }
        assert_eq!(size_of::<PrimRef>(), 32);
    }

    #[test]
    fn zeros_have_one_sign() {
        let reference = PrimRef::new(Aabb32 { min: Vec3A::splat(-0.0), max: Vec3A::ZERO }, 0);
        assert_eq!(reference.bounds().min.x.to_bits(), 0);
    }
}
