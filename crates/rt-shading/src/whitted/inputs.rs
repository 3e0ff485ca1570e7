//! Inputs of the stages that shade ray trees.

use super::lane_phong::LanePhongs;
use crate::{Appearance, ShadingFeatures};
use rt_math::Rgb;

/// Settings, the same for all waves.
#[derive(Clone, Debug)]
pub(super) struct Settings {
    pub(super) max_depth: u32,
    pub(super) min_contribution: f64,
    pub(super) features: ShadingFeatures,
}

/// Inputs of all shading stages of a batch.
pub(super) struct RayTreeInputs<'a> {
    pub(super) settings: &'a Settings,
    pub(super) appearance: &'a Appearance,
    pub(super) phongs: &'a LanePhongs,
    /// False if all rays are at time 0.
    pub(super) has_time: bool,
}

impl RayTreeInputs<'_> {
    /// False for a throughput that is invisible in the pixel.
    pub(super) fn is_significant(&self, throughput: Rgb) -> bool {
        !(throughput.is_black() || throughput.max_component() < self.settings.min_contribution)
    }
}
