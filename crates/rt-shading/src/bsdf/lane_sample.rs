//! Sampled directions in lanes.

use crate::lane_set::LaneSet;
use rt_math::Vector3;

/// Directions sampled from lobes of one kind. Those below the surface are not valid, nor those whose numbers are not finite.
pub(crate) struct LaneSample<L: LaneSet> {
    /// In the shading frame.
    pub(crate) wi: Vector3<L::D>,
    /// BSDF times cosine divided by density.
    pub(crate) weight: Vector3<L::D>,
    /// Density; of a delta lobe any positive number.
    pub(crate) pdf: L::D,
    /// Lanes that have sampled a direction.
    pub(crate) valid: u8,
    /// Lanes that have sampled a diffuse lobe.
    pub(crate) diffuse: u8,
    /// Lanes that have sampled a delta lobe.
    pub(crate) delta: u8,
}
