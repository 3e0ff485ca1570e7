//! Dielectric interface.

use super::{
    BsdfSample, Ggx, Scattering, mirror,
    side::{Side, flip, seen_from},
};
use crate::optics;
use rt_math::{DVec3, Rgb};

/// Smooth or rough interface of a dielectric: Fresnel's equations and Snell's law at microfacets of [`Ggx`].
///
/// Source: Walter et al., "Microfacet models for refraction through rough surfaces", 2007, equations 20 and 21.
///
/// ```text
/// η = n(wi side) / n(wo side)
///
/// reflection     F·D·G₂ / (4 cos cos)                              m = wo + wi,    normalised
/// transmission   |wo·m| |wi·m| / (cos cos) · (1 − F)·D·G / (wo·m + η wi·m)²        m = ±(wo + η wi)
/// ```
///
/// G is G₁(wo)·G₁(wi) for transmission. f transports radiance: f(wo, wi) · η² = f(wi, wo). Multiple scattering between
/// microfacets is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index of refraction below the surface divided by that above, positive and finite; otherwise all light is absorbed.
    pub ior: f64,
    /// Roughness in \[0, 1\], as in [`Ggx::from_roughness`].
    pub roughness: f64,
    /// Factor of reflected light, per channel in \[0, 1\]; 1 if physically based.
    pub reflectance: Rgb,
    /// Factor of transmitted light, per channel in \[0, 1\]; 1 if physically based.
    pub transmittance: Rgb,
}

/// Interface relative to the side of `wo`.
struct Interface {
    /// Index of refraction behind, divided by that in front.
    eta: f64,
    reflectance: Rgb,
    transmittance: Rgb,
}

impl Dielectric {
    /// An interface without colour.
    pub fn clear(ior: f64, roughness: f64) -> Self {
        Self { ior, roughness, reflectance: Rgb::WHITE, transmittance: Rgb::WHITE }
    }

    /// True if all lobes are delta distributions.
    ///
    /// Rough interfaces between media of nearly equal index count: they deflect light by less than a millionth of a radian.
    pub fn is_smooth(&self) -> bool {
        self.facets().is_none()
    }

    /// Implements [`super::Bsdf::eval_with_pdf`].
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        let scattered = || {
            let (interface, facets) = self.interface(wo).zip(self.facets())?;
            let (wo, wi) = seen_from(wo, wi)?;
            Some(interface.value_with_pdf(facets, wo, wi, interface.half_vector(wo, wi)?))
        };
        scattered().unwrap_or((Rgb::BLACK, 0.0))
    }

    /// Implements [`super::Bsdf::sample`].
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let interface = self.interface(wo)?;
        let (wo, side) = Side::of(wo, u)?;
        let Some(facets) = self.facets() else {
            return interface.sample_smooth(wo, side, u[0]);
        };
        let m = facets.sample(wo, [u[1], u[2]]);
        let (wi, kind, eta) = if u[0] < interface.chance_of_reflection(wo.dot(m)) {
            (optics::reflect(-wo, m), Scattering::Reflection, 1.0)
        } else {
            (optics::refract(-wo, m, 1.0 / interface.eta)?, Scattering::Transmission, interface.eta)
        };
        let is_on_side = if kind == Scattering::Reflection { wi.z > 0.0 } else { wi.z < 0.0 };
        if !is_on_side {
            return None;
        }
        let (value, pdf) = interface.value_with_pdf(facets, wo, wi, m);
        BsdfSample { kind, eta, ..BsdfSample::new(side.restore(wi), value, pdf) }.if_finite()
    }

    fn facets(&self) -> Option<Ggx> {
        let ior_difference = (self.ior - 1.0).abs().min(1.0);
        Ggx::from_roughness(self.roughness).filter(|facets| facets.alpha() * ior_difference >= Ggx::MIN_ALPHA)
    }

    fn interface(&self, wo: DVec3) -> Option<Interface> {
        let eta = if wo.z > 0.0 { self.ior } else { 1.0 / self.ior };
        let is_sound = eta > 0.0 && eta.is_finite();
        is_sound.then_some(Interface { eta, reflectance: self.reflectance, transmittance: self.transmittance })
    }
}

impl Interface {
    /// Reflectance of a microfacet; 0 between media of the same index.
    fn fresnel(&self, cos: f64) -> f64 {
        if self.eta == 1.0 { 0.0 } else { optics::fresnel(cos, 1.0 / self.eta) }
    }

    /// Probability with which `sample` reflects at a microfacet: the reflected part of the scattered light.
    fn chance_of_reflection(&self, cos: f64) -> f64 {
        let fresnel = self.fresnel(cos);
        let reflected = fresnel * self.reflectance.max_component();
        let transmitted = (1.0 - fresnel) * self.transmittance.max_component();
        if reflected + transmitted > 0.0 { reflected / (reflected + transmitted) } else { fresnel }
    }

    fn sample_smooth(&self, wo: DVec3, side: Side, u: f64) -> Option<BsdfSample> {
        let (fresnel, chance) = (self.fresnel(wo.z), self.chance_of_reflection(wo.z));
        if u < chance {
            return mirror::reflection(wo, side, self.reflectance * fresnel, chance);
        }
        // Index-matched interfaces keep all bits of the direction.
        let wi = if self.eta == 1.0 { -wo } else { optics::refract(-wo, DVec3::Z, 1.0 / self.eta)? };
        BsdfSample {
            kind: Scattering::Transmission,
            is_delta: true,
            eta: self.eta,
            ..BsdfSample::new(
                side.restore(wi),
                self.transmittance * ((1.0 - fresnel) / (self.eta * self.eta * wi.z.abs())),
                1.0 - chance,
            )
        }
        .if_finite()
    }

    /// Upward normal of microfacets that transmit from `wi` to `wo`, which is above. `None` if they face away from either.
    fn half_vector(&self, wo: DVec3, wi: DVec3) -> Option<DVec3> {
        if wi.z > 0.0 {
            return (wo + wi).try_normalize();
        }
        let m = (wo + wi * self.eta).try_normalize()?;
        let m = if m.z < 0.0 { -m } else { m };
        (wo.dot(m) > 0.0 && wi.dot(m) < 0.0).then_some(m)
    }

    /// Value and density for two directions, with the upward normal `m` of the microfacets that scatter between them.
    fn value_with_pdf(&self, facets: Ggx, wo: DVec3, wi: DVec3, m: DVec3) -> (Rgb, f64) {
        let (cos_o, cos_i) = (wo.dot(m), wi.dot(m));
        let (fresnel, chance) = (self.fresnel(cos_o), self.chance_of_reflection(cos_o));
        if wi.z > 0.0 {
            let value = self.reflectance * (fresnel * facets.reflection(wo, wi, m));
            return (value, chance * facets.reflection_pdf(wo, m));
        }
        let (below, stretch) = (flip(wi), cos_o + self.eta * cos_i);
        // G₁ / cos stays finite where both are 0.
        let seen = 4.0 / ((wo.z + facets.stretched_length(wo)) * (below.z + facets.stretched_length(below)));
        let transmitted = cos_o * cos_i.abs() * facets.d(m) * seen / (stretch * stretch);
        let jacobian = self.eta * self.eta * cos_i.abs() / (stretch * stretch);
        (self.transmittance * ((1.0 - fresnel) * transmitted), (1.0 - chance) * facets.pdf(wo, m) * jacobian)
    }
}
