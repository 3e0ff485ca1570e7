//! A pane of glass without thickness.

use super::{BsdfSample, Scattering, mirror, side::Side};
use crate::optics;
use rt_math::{DVec3, Rgb, transcendental};

/// A thin dielectric, such as a window or soap film. Light leaves where it enters, straight on or mirrored.
///
/// All inter-reflections of the two parallel interfaces are summed.
///
/// ```text
/// per polarisation, with τ = transmittance^(1 / cos θ inside):
/// R = F + (1 − F)² F τ² / (1 − F² τ²)        T = (1 − F)² τ / (1 − F² τ²)        clear glass: R = 2F / (1 + F) = 1 − T
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinGlass {
    /// Index of refraction of the glass divided by that around it, positive and finite; otherwise all light is absorbed.
    pub ior: f64,
    /// Transmittance of one crossing at normal incidence, per channel in \[0, 1\], to which it is clamped; NaN counts as 0.
    /// Beer's law gives that of other angles.
    pub transmittance: Rgb,
}

impl ThinGlass {
    /// Implements [`super::Bsdf::eval_with_pdf`]: black and 0.
    pub fn eval_with_pdf(&self, _: DVec3, _: DVec3) -> (Rgb, f64) {
        (Rgb::BLACK, 0.0)
    }

    /// Implements [`super::Bsdf::sample`].
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (wo, side) = Side::of(wo, u)?;
        if !(self.ior > 0.0 && self.ior.is_finite()) {
            return None;
        }
        let (reflected, transmitted) = self.shares(wo.z);
        let (r, t) = (reflected.max_component(), transmitted.max_component());
        let chance = r / (r + t);
        if u[0] < chance {
            return mirror::reflection(wo, side, reflected, chance);
        }
        BsdfSample {
            kind: Scattering::Transmission,
            is_delta: true,
            ..BsdfSample::new(side.restore(-wo), transmitted / wo.z, 1.0 - chance)
        }
        .if_finite()
    }

    /// Reflectance and transmittance for unpolarised light at a cosine.
    pub fn shares(&self, cos: f64) -> (Rgb, Rgb) {
        if self.ior == 1.0 {
            return (Rgb::BLACK, self.transmittance.map(|once| absorbed(once, cos)));
        }
        let sin2 = (1.0 - cos) * (1.0 + cos) / (self.ior * self.ior);
        let cos_inside = (1.0 - sin2).max(0.0).sqrt();
        let polarised = optics::polarised_fresnel(cos, 1.0 / self.ior);
        let mean = |share: fn(f64, f64) -> f64| {
            self.transmittance.map(|once| {
                let tau = absorbed(once, cos_inside);
                0.5 * (share(polarised[0], tau) + share(polarised[1], tau))
            })
        };
        (mean(reflected), mean(transmitted))
    }
}

/// Transmittance of one crossing at an angle, where `once` is that at normal incidence.
fn absorbed(once: f64, cos_inside: f64) -> f64 {
    if once >= 1.0 {
        1.0
    } else if once > 0.0 && cos_inside > 0.0 {
        transcendental::pow(once, 1.0 / cos_inside)
    } else {
        0.0
    }
}

fn reflected(fresnel: f64, tau: f64) -> f64 {
    let again = fresnel * tau;
    if fresnel >= 1.0 { 1.0 } else { fresnel + (1.0 - fresnel) * (1.0 - fresnel) * again * tau / (1.0 - again * again) }
}

fn transmitted(fresnel: f64, tau: f64) -> f64 {
    let again = fresnel * tau;
    if fresnel >= 1.0 { 0.0 } else { (1.0 - fresnel) * (1.0 - fresnel) * tau / (1.0 - again * again) }
}
