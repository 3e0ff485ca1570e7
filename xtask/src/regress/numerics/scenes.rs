//! Accelerators that several chapters need.

use rt_accel::{Accelerator, AcceleratorKind, AnyAccelerator};
use rt_geometry::{Hit, Primitives};

use super::Fallible;

/// One validated accelerator of each kind, brute force first.
pub(super) fn all_accelerators<P: Primitives>(primitives: &P) -> Fallible<Vec<AnyAccelerator>> {
    let build = |&kind: &AcceleratorKind| {
        let accelerator = AnyAccelerator::build(kind, primitives)?;
        accelerator.validate(primitives).map_err(|violation| format!("{}: {violation}", kind.name()))?;
        Ok(accelerator)
    };
    AcceleratorKind::ALL.iter().map(build).collect()
}

/// Parts of a hit that must be bit-identical.
pub(super) fn key(hit: Option<Hit>) -> Option<[u64; 5]> {
    hit.map(|Hit { t, instance, primitive, uv }| {
        [t.to_bits(), instance.into(), primitive.into(), uv[0].to_bits(), uv[1].to_bits()]
    })
}
