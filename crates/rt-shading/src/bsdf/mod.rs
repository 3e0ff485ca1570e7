//! How a surface scatters light: bidirectional scattering distribution functions (BSDFs).
//!
//! ```text
//!              z = normal
//!        wo    |    wi           f(wo, wi) = dL(wo) / (L(wi) · |cos θ(wi)| · dω(wi))       unit: 1/sr
//!          \   |   /
//!           \  |  /             radiance towards wo  =  ∫ f(wo, wi) · L(wi) · |cos θ(wi)| dω(wi)
//!            \ | /                                   ≈  f · L · |cos θ(wi)| / pdf,   one sample
//!   __________\|/__________
//!              |\               weight = f · |cos θ| / pdf: what a path carries on
//!              | \ wi
//! ```
//!
//! All directions are unit vectors that leave the surface, in shading coordinates: the normal is +z, towards the outside
//! of a body. [`rt_math::Frame`] leads there and back. Each model has three functions that agree with each other:
//!
//! | function | gives | of directions it never scatters to |
//! |---|---|---|
//! | `eval(wo, wi)` | f, without the cosine | black |
//! | `pdf(wo, wi)` | density over solid angle with which `sample` finds `wi` | 0 |
//! | `sample(wo, u)` | a direction with its f and density, from three numbers in \[0, 1\] | `None` |
//!
//! `sample` may fail: then the light is absorbed, and the density integrates to as much less than 1. The first number
//! chooses among kinds of scattering, the other two a direction, so that well-spread pairs stay well-spread directions.
//!
//! **Perfect mirrors** and smooth glass scatter into single directions. `eval` and `pdf` know nothing of these; `sample`
//! marks them by [`BsdfSample::is_delta`]. Their `pdf` is the probability of the choice and their `value` is divided by the
//! cosine, so that [`BsdfSample::weight`] holds for all, but multiple importance sampling must give them the whole weight.
//!
//! **Radiance and importance.** All functions are those of paths from the camera: radiance that enters a medium of the
//! index n is squeezed by n² (Veach 1997, 5.2), so transmission towards `wo` holds the factor (n(wo) / n(wi))². Light that
//! is traced the other way is scattered by the adjoint: `eval(wi, wo)`, and [`Bsdf::sample_importance`].
//!
//! **Sides.** Opaque models reflect on both sides alike. Directions in the surface itself, of which the cosine is 0 (up
//! to 10⁻¹⁰⁰), and such that are not finite, scatter nothing.
//!
//! | model | f | source |
//! |---|---|---|
//! | [`Lambert`] | ρ / π | Lambert 1760 |
//! | [`OrenNayar`] | ρ/π · A · (1 + r·s/t) and what bounces between the grooves | Portsmouth, Kutz, Hill 2025 |
//! | [`PhongLobe`] | ρ · (n + 2)/2π · cosⁿ α | Phong 1975; Lafortune, Willems 1994 |
//! | [`Mirror`], [`ThinGlass`] | single directions | Fresnel 1823 |
//! | [`Refraction`] | a single direction | Whitted 1980 |
//! | [`Dielectric`] | F·D·G / (4 cos cos), and Snell's law at each facet | Walter et al. 2007 |
//! | [`Conductor`] | F·D·G / (4 cos cos) with a complex index | Cook, Torrance 1982; Heitz 2018 |
//! | [`MetallicRoughness`] | a diffuse base under a layer of dielectric, mixed with metal | glTF 2.0, appendix B; Kulla, Conty 2017 |
//! | [`Layered`] | the same under a coat, a [`Sheen`], and as a pane | extensions of glTF 2.0 |
//! | [`Mix`] | Σ weight · f | |

mod bxdf;
mod conductor;
mod dielectric;
mod ggx;
mod lambert;
mod layer;
mod layered;
mod metallic_roughness;
mod mirror;
mod mix;
mod oren_nayar;
mod phong;
mod prism;
mod refraction;
mod sheen;
mod side;
#[cfg(test)]
mod tests;
mod thin_glass;

pub use bxdf::Bxdf;
pub use conductor::{ComplexIor, Conductor, conductor_fresnel};
pub use dielectric::Dielectric;
pub use ggx::Ggx;
pub use lambert::Lambert;
pub(crate) use lambert::cosine_hemisphere;
pub use layered::Layered;
pub use metallic_roughness::{Coupling, MetallicRoughness};
pub use mirror::Mirror;
pub use mix::{MAX_LOBES, Mix, MixError};
pub use oren_nayar::OrenNayar;
pub use phong::PhongLobe;
pub use prism::DispersiveDielectric;
pub use refraction::Refraction;
pub use sheen::Sheen;
pub use thin_glass::ThinGlass;

use rt_math::{DVec3, Rgb};

/// On which side of the surface light goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scattering {
    /// On the side that it came from.
    Reflection,
    /// On the other side.
    Transmission,
}

/// A direction that a BSDF chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Where to look for light: a unit vector that leaves the surface.
    pub wi: DVec3,
    /// f(wo, wi), without the cosine, in 1/sr; for a single direction the share of the light divided by |cos θ(wi)|.
    pub value: Rgb,
    /// Density over solid angle, in 1/sr, as `pdf` gives it; for a single direction the probability of its choice.
    pub pdf: f64,
    /// On which side `wi` is.
    pub kind: Scattering,
    /// True if `wi` is a single direction, of which `eval` and `pdf` know nothing.
    pub is_delta: bool,
    /// True if a lobe chose `wi` that spreads light evenly, and not one around a mirrored or refracted direction.
    pub is_diffuse: bool,
    /// Index of refraction on the side of `wi` divided by that on the side of `wo`: 1 but for transmission into another
    /// medium. Russian roulette must not take the squeezing of radiance by 1/`eta`² for a loss.
    pub eta: f64,
}

impl BsdfSample {
    /// f · |cos θ(wi)| / pdf: by how much the radiance from `wi` counts towards `wo`.
    pub fn weight(&self) -> Rgb {
        self.value * (self.wi.z.abs() / self.pdf)
    }

    /// The sample, unless rounding took it out of what numbers can hold.
    fn if_finite(self) -> Option<Self> {
        let is_sound = side::is_valid(self.wi) && self.pdf > 0.0 && self.pdf.is_finite();
        (is_sound && self.value.is_finite()).then_some(self)
    }
}

/// Scattering function of a surface at a point: one [`Bxdf`], or a [`Mix`] of several.
///
/// Plain data without allocations, made anew for each hit where textures ask for it.
///
/// ```
/// use rt_math::{DVec3, Rgb};
/// use rt_shading::bsdf::{Bsdf, Lambert};
///
/// let bsdf = Bsdf::from(Lambert { albedo: Rgb::gray(0.5) });
/// let sample = bsdf.sample(DVec3::new(0.6, 0.0, 0.8), [0.5, 0.2, 0.7]).expect("a diffuse surface scatters always");
/// assert_eq!(sample.value, bsdf.eval(DVec3::new(0.6, 0.0, 0.8), sample.wi));
/// assert!((sample.weight().r - 0.5).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "a hit allocates nothing, and a surface holds one of either")]
pub enum Bsdf {
    /// One model.
    Single(Bxdf),
    /// Several models at once.
    Mix(Mix),
    /// A base under layers.
    Layered(Layered),
}

impl<T: Into<Bxdf>> From<T> for Bsdf {
    fn from(model: T) -> Self {
        Self::Single(model.into())
    }
}

impl From<Layered> for Bsdf {
    fn from(layered: Layered) -> Self {
        Self::Layered(layered)
    }
}

impl From<Mix> for Bsdf {
    fn from(mix: Mix) -> Self {
        Self::Mix(mix)
    }
}

impl Bsdf {
    /// f(wo, wi), without the cosine, in 1/sr.
    #[inline]
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        match self {
            Self::Single(lobe) => lobe.eval(wo, wi),
            Self::Mix(mix) => mix.eval(wo, wi),
            Self::Layered(layered) => layered.eval(wo, wi),
        }
    }

    /// Density over solid angle with which [`Bsdf::sample`] finds `wi`.
    #[inline]
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        match self {
            Self::Single(lobe) => lobe.pdf(wo, wi),
            Self::Mix(mix) => mix.pdf(wo, wi),
            Self::Layered(layered) => layered.pdf(wo, wi),
        }
    }

    /// [`eval`](Self::eval) and [`pdf`](Self::pdf), which have much in common, at once.
    #[inline]
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        match self {
            Self::Single(lobe) => lobe.eval_with_pdf(wo, wi),
            Self::Mix(mix) => mix.eval_with_pdf(wo, wi),
            Self::Layered(layered) => (layered.eval(wo, wi), layered.pdf(wo, wi)),
        }
    }

    /// A direction about in proportion to f · |cos θ|, from three numbers in \[0, 1\]; `None` if the light is absorbed.
    #[inline]
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        match self {
            Self::Single(lobe) => lobe.sample(wo, u),
            Self::Mix(mix) => mix.sample(wo, u),
            Self::Layered(layered) => layered.sample(wo, u),
        }
    }

    /// As [`Bsdf::sample`], for light that arrives from `wo` and is traced on to `wi`: the value is f(wi, wo).
    pub fn sample_importance(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let sample = self.sample(wo, u)?;
        let value = if sample.is_delta { sample.value * (sample.eta * sample.eta) } else { self.eval(sample.wi, wo) };
        BsdfSample { value, ..sample }.if_finite()
    }

    /// The lobes that send light on about a mirrored or refracted direction; `None` if there are none. A model that is diffuse
    /// under a layer counts as one of these.
    pub fn without_diffuse(&self) -> Option<Self> {
        match self {
            Self::Single(lobe) => (!lobe.is_diffuse()).then_some(*self),
            Self::Mix(mix) => mix.without_diffuse().map(Self::Mix),
            Self::Layered(_) => Some(*self),
        }
    }

    /// True if it has a diffuse part under a layer, which [`without_diffuse`](Self::without_diffuse) keeps.
    pub fn is_diffuse_below_layer(&self) -> bool {
        let is_layered = |lobe: &Bxdf| matches!(lobe, Bxdf::MetallicRoughness(_));
        match self {
            Self::Single(lobe) => is_layered(lobe),
            Self::Mix(mix) => mix.lobes().iter().any(|(_, lobe)| is_layered(lobe)),
            Self::Layered(_) => true,
        }
    }

    /// True if all light goes into single directions: `eval` is black everywhere, and no light that is sampled by itself
    /// can be seen in the surface.
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Single(lobe) => lobe.is_delta(),
            Self::Mix(mix) => mix.lobes().iter().all(|(_, lobe)| lobe.is_delta()),
            Self::Layered(layered) => layered.is_delta(),
        }
    }

    /// True if the first number of [`Bsdf::sample`] matters, which chooses among kinds of scattering.
    pub fn uses_component_sample(&self) -> bool {
        match self {
            Self::Single(lobe) => lobe.uses_component_sample(),
            Self::Mix(_) | Self::Layered(_) => true,
        }
    }

    /// True if light may pass to the other side.
    pub fn transmits(&self) -> bool {
        match self {
            Self::Single(lobe) => lobe.transmits(),
            Self::Mix(mix) => mix.lobes().iter().any(|(_, lobe)| lobe.transmits()),
            Self::Layered(layered) => layered.transmits(),
        }
    }
}
