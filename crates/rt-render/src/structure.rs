//! Which acceleration structure.

use rt_accel::{AnyStructure, BuildError, StructureKind};
use rt_math::Primitives;
use rt_scene_io::Accel;

/// Up to this many primitives, asking each is faster than walking a tree.
const FEW: usize = 8;

/// Builds what `accel` asks for; `Auto` is brute force for a few primitives and a hierarchy otherwise.
pub(crate) fn build<P: Primitives>(accel: Accel, primitives: &P) -> Result<AnyStructure, BuildError> {
    let kind = match accel {
        Accel::Linear => StructureKind::Linear,
        Accel::Grid => StructureKind::Grid,
        Accel::Bvh => StructureKind::Bvh,
        Accel::Auto if primitives.len() <= FEW => StructureKind::Linear,
        Accel::Auto => StructureKind::Bvh,
    };
    AnyStructure::build(kind, primitives)
}
