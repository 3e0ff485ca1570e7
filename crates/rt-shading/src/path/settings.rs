//! Settings and lighting of path integrators.

use super::{clamp::Clamp, transport::Transport};
use crate::{Appearance, BsdfCache, light::LightSet};

/// Parameters of path tracing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSettings {
    /// Maximum bounces after the first surface: 0 for emission and direct light.
    pub max_depth: u32,
    /// Bounces before Russian roulette starts.
    pub rr_start_depth: u32,
    /// Light transport beyond the first surface.
    pub transport: Transport,
    /// Bound on contributions of indirect light; none by default.
    pub clamp: Clamp,
}

/// Materials and lights for an integrator.
#[derive(Clone, Copy, Debug)]
pub struct Lighting<'a> {
    /// Materials, textures and the background.
    pub appearance: &'a Appearance,
    /// All lights.
    pub lights: &'a LightSet,
    /// BSDFs of uniform materials of this appearance, or `default()`.
    pub bsdfs: &'a BsdfCache,
}
