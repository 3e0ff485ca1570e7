//! Layout of leaves of boxes, for primitives of any kind.

use super::block::LeafMut;
use crate::bvh::Aabb32;

/// Lower and upper plane of each axis.
pub(in crate::wide) const BOX_NUMBERS: usize = 6;

pub(super) fn fill(block: &mut LeafMut<'_>, indices: &[u32], own: impl Fn(u32) -> Aabb32) {
    for (lane, &index) in indices.iter().enumerate() {
        let own = own(index);
        for axis in 0..3 {
            block.set(2 * axis, lane, own.min[axis]);
            block.set(2 * axis + 1, lane, own.max[axis]);
        }
    }
}
