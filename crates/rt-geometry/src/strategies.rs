//! Strategies of property tests.

use proptest::prelude::*;
use rt_math::DVec3;

/// Vectors with components from −`range` to `range`.
pub(crate) fn vector(range: f64) -> impl Strategy<Value = DVec3> {
    let side = -range..range;
    (side.clone(), side.clone(), side).prop_map(DVec3::from)
}
