//! Which acceleration structure, and why.

use rt_accel::{AnyStructure, BuildError, StructureKind};
use rt_math::Primitives;
use rt_scene_io::Accel;

/// Up to this many primitives, asking each is faster than walking a tree.
pub(crate) const FEW: usize = 8;

/// Builds what `accel` asks for, or for `Auto` what fits the primitives.
pub(crate) fn build<P: Primitives>(accel: Accel, primitives: &P) -> Result<AnyStructure, BuildError> {
    AnyStructure::build(choose(accel, primitives).0, primitives)
}

/// What `accel` asks for, and the rule that applied, for people.
pub(crate) fn choose<P: Primitives>(accel: Accel, primitives: &P) -> (StructureKind, String) {
    let asked = |kind| (kind, "as asked".to_owned());
    match accel {
        Accel::Linear => asked(StructureKind::Linear),
        Accel::Grid => asked(StructureKind::Grid),
        Accel::Bvh => asked(StructureKind::Bvh),
        Accel::Kd => asked(StructureKind::Kd),
        Accel::Bsp => asked(StructureKind::Bsp),
        Accel::Bih => asked(StructureKind::Bih),
        Accel::BihLazy => asked(StructureKind::BihLazy),
        Accel::Auto if primitives.len() <= FEW => {
            (StructureKind::Linear, "few primitives: asking each is faster than walking a tree".to_owned())
        }
        Accel::Auto => (StructureKind::Bvh, "many primitives".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_geometry::Spheres;

    #[test]
    fn every_structure_can_be_asked_for_by_its_name() {
        let named = |accel: &Accel| choose(*accel, &Spheres::new(Vec::new())).0.name();
        for accel in Accel::ALL.iter().filter(|accel| **accel != Accel::Auto) {
            assert_eq!(named(accel), accel.name());
        }
        assert_eq!(Accel::ALL.len(), StructureKind::ALL.len() + 1);
    }
}
