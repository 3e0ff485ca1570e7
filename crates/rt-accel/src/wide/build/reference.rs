//! A primitive while the tree grows over it.

use glam::{Vec3A, Vec4};

use crate::bvh::NodeBox;

/// A box and the index of the primitive in it, in 32 bytes.
///
/// The fourth lane of each corner holds half of the index, in the mantissa of a number from 1 to 2: one that arithmetic
/// on the whole corner cannot turn into a denormal number or a NaN, which slow down some processors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference {
    min: Vec4,
    max: Vec4,
}

const ONE: u32 = 1.0f32.to_bits();

impl Reference {
    /// The box must not be empty. Zeros lose their sign, so that the least of several is the same in any order.
    #[inline(always)]
    pub(crate) fn new(bounds: NodeBox, index: u32) -> Self {
        let tagged = |corner: Vec3A, half: u32| (corner + Vec3A::ZERO).extend(f32::from_bits(ONE | half));
        Self { min: tagged(bounds.min, index & 0xffff), max: tagged(bounds.max, index >> 16) }
    }

    #[inline(always)]
    pub(crate) fn bounds(&self) -> NodeBox {
        NodeBox { min: Vec3A::from_vec4(self.min), max: Vec3A::from_vec4(self.max) }
    }

    #[inline(always)]
    pub(crate) fn index(&self) -> u32 {
        let half = |corner: Vec4| corner.w.to_bits() & 0xffff;
        half(self.min) | half(self.max) << 16
    }

    /// Twice the centre of the box, which orders references just as well.
    #[inline(always)]
    pub(super) fn centroid(&self) -> Vec3A {
        Vec3A::from_vec4(self.min + self.max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_index_survives() {
        for index in [0, 1, 0xffff, 0x1_0000, 0xdead_beef, u32::MAX] {
            let bounds = NodeBox { min: Vec3A::splat(-1.5), max: Vec3A::new(0.25, f32::INFINITY, 1e-45) };
            let reference = Reference::new(bounds, index);
            assert_eq!((reference.bounds(), reference.index()), (bounds, index));
        }
        assert_eq!(size_of::<Reference>(), 32);
    }

    #[test]
    fn zeros_have_one_sign() {
        let reference = Reference::new(NodeBox { min: Vec3A::splat(-0.0), max: Vec3A::ZERO }, 0);
        assert_eq!(reference.bounds().min.x.to_bits(), 0);
    }
}
