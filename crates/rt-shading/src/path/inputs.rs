//! Inputs of the stages that shade paths.

use super::{
    lane_material::LaneMaterials,
    settings::{Lighting, PathSettings},
    transport::Transport,
};
use crate::{Material, ShadingFeatures};

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

impl<'a> PathInputs<'a> {
    /// Features and materials, for the media along rays.
    pub(super) fn scene(&self) -> (&'a ShadingFeatures, &'a [Material]) {
        (self.features, &self.lighting.appearance.materials)
    }

    /// True if the emission of the next surface or the background may contribute.
    pub(super) fn scene_emits(&self) -> bool {
        self.features.emission || !self.lighting.appearance.background.is_black()
    }

    /// True if Russian roulette ends paths at the surfaces of a wave.
    pub(super) fn uses_russian_roulette(&self, bounces: u32) -> bool {
        bounces >= self.settings.rr_start_depth
    }

    /// True if directions of diffuse lobes are sampled only below layers.
    pub(super) fn follows_specular_only(&self) -> bool {
        self.settings.transport == Transport::Specular
    }

    /// True if a path that a diffuse lobe continues ends after the emission of the next surface.
    pub(super) fn ends_behind_diffuse(&self) -> bool {
        matches!(self.settings.transport, Transport::Specular | Transport::SpecularWithEmitters)
    }

    /// True if light of the background reaches diffuse surfaces of this kind.
    pub(super) fn gathers_background(&self, is_diffuse_below_layer: bool) -> bool {
        is_diffuse_below_layer || self.lighting.lights.environment().is_some()
    }

    /// True if ambient light stands for the background at a surface of this kind.
    pub(super) fn has_ambient_light(&self, is_diffuse_below_layer: bool) -> bool {
        let has_background = !self.lighting.appearance.background.is_black();
        let gathers_background = has_background && self.gathers_background(is_diffuse_below_layer);
        self.ends_behind_diffuse() && self.features.ambient && !gathers_background
    }
}
