//! Effect of clamping indirect light.

use rt_shading::{Clamp, PathSettings};

use crate::{RenderPlan, Rendering, Statistics, integrator::IntegratorState};

/// Effect of a bound on contributions of indirect light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clamping {
    /// The bound, in units of radiance.
    pub bound: f64,
    /// Contributions that were scaled down to it.
    pub contributions: u64,
    /// Fraction of the light of the image that clamping removed: the mean bias of its brightness.
    pub lost_share: f64,
}

impl RenderPlan<'_> {
    /// Bound on contributions of indirect light, if the integrator computes any and the scene sets a bound.
    pub fn clamp(&self) -> Option<f64> {
        match &self.integrator {
            IntegratorState::Path(PathSettings { max_depth: 1.., clamp, .. }) => clamp.bound(),
            _ => None,
        }
    }

    /// Effect of the bound on indirect light, if there is one.
    pub fn clamping(&self, rendering: &Rendering) -> Option<Clamping> {
        let bound = self.clamp()?;
        let Statistics { shading, samples, .. } = &rendering.statistics;
        let lost = Clamp::new(bound)?.lost(shading) / (*samples).max(1) as f64;
        let pixels = rendering.film.pixels();
        let sum: f64 = pixels.iter().flatten().map(|&value| f64::from(value)).sum();
        let mean = sum / (3.0 * pixels.len().max(1) as f64);
        let lost_share = if lost > 0.0 { lost / (lost + mean.max(0.0)) } else { 0.0 };
        Some(Clamping { bound, contributions: shading.clamped, lost_share })
    }
}
