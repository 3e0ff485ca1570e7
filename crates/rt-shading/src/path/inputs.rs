//! Inputs of the stages that shade paths.

use super::{
    lane_material::LaneMaterials,
    settings::{Lighting, PathSettings},
    transport::Transport,
};
use crate::ShadingFeatures;

/// Inputs of all shading stages of a batch.
#[derive(Clone, Copy)]
pub(super) struct PathInputs<'a> {
    pub(super) settings: &'a PathSettings,
    pub(super) features: &'a ShadingFeatures,
    pub(super) lighting: Lighting<'a>,
    pub(super) materials: &'a LaneMaterials,
    /// False if all rays are at time 0.
    pub(super) has_time: bool,
}

impl PathInputs<'_> {
    /// True if the emission of the next surface or the background may contribute.
    pub(super) fn scene_emits(&self) -> bool {
        self.features.emission || !self.lighting.appearance.background.is_black()
    }

    /// True if Russian roulette is played at the surfaces of a wave.
    pub(super) fn plays_roulette(&self, bounces: u32) -> bool {
        bounces >= self.settings.rr_start_depth
    }

    /// True if directions of diffuse lobes are sampled only below layers.
    pub(super) fn follows_specular_only(&self) -> bool {
        self.settings.transport == Transport::Specular
    }

    /// True if ambient light stands for the background at a surface of this kind.
    pub(super) fn has_ambient_light(&self, is_diffuse_below_layer: bool) -> bool {
        let Lighting { appearance, lights, .. } = &self.lighting;
        let follows_background = is_diffuse_below_layer || lights.environment().is_some();
        let gathers_background = !appearance.background.is_black() && follows_background;
        self.follows_specular_only() && self.features.ambient && !gathers_background
    }
}
