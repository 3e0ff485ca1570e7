//! Bidirectional scattering distribution functions (BSDFs).
//!
//! ```text
//!              z = normal
//!        wo    |    wi           f(wo, wi) = dL(wo) / (L(wi) · |cos θ(wi)| · dω(wi))       unit: 1/sr
//!          \   |   /
//!           \  |  /             radiance towards wo  =  ∫ f(wo, wi) · L(wi) · |cos θ(wi)| dω(wi)
//!            \ | /                                   ≈  f · L · |cos θ(wi)| / pdf,   one sample
//!   __________\|/__________
//!              |\               weight = f · |cos θ| / pdf: factor of the throughput
//!              | \ wi
//! ```
//!
//! All directions are unit vectors that leave the surface, in shading coordinates: the normal is +z, towards the outside
//! of a solid. [`rt_math::Frame`] converts. [`Bsdf`] has three functions. Its models return the first two together, as
//! `eval_with_pdf`:
//!
//! | function | returns | for directions it never scatters to |
//! |---|---|---|
//! | `eval(wo, wi)` | f, without the cosine | black |
//! | `pdf(wo, wi)` | density of `sample` over solid angle | 0 |
//! | `sample(wo, u)` | a direction with its f and density, from three numbers in \[0, 1\] | `None` |
//!
//! `sample` may return `None`: the light is absorbed, and the density integrates to less than 1. The first number chooses
//! a lobe, the other two a direction, so that stratified pairs remain stratified directions.
//!
//! **Delta lobes** are those of mirrors and smooth glass. `eval` and `pdf` leave them out; `sample` marks them by
//! [`BsdfSample::is_delta`]. Their `pdf` is the probability of the choice, and their `value` is divided by the cosine, so
//! that [`BsdfSample::weight`] holds for all. Their MIS weight must be 1.
//!
//! **Radiance and importance.** All functions transport radiance along camera paths: transmission towards `wo` has the
//! factor (n(wo) / n(wi))² (Veach 1997, 5.2). Light tracing uses the adjoint: `eval(wi, wo)` and
//! [`Bsdf::sample_importance`].
//!
//! **Sides.** Opaque models reflect in the same way on both sides. Directions in the plane of the surface (cosines up
//! to 10⁻¹⁰⁰), and directions that are not finite, are absorbed.
//!
//! | model | f | source |
//! |---|---|---|
//! | [`Lambert`] | ρ / π | Lambert 1760 |
//! | [`OrenNayar`] | ρ/π · A · (1 + r·s/t), and multiple scattering | Portsmouth, Kutz, Hill 2025 |
//! | [`PhongLobe`] | ρ · (n + 2)/2π · cosⁿ α | Phong 1975; Lafortune, Willems 1994 |
//! | [`Mirror`], [`ThinGlass`] | delta lobes | Fresnel 1823 |
//! | [`SpecularTransmission`] | a delta lobe | Whitted 1980 |
//! | [`Dielectric`] | F·D·G / (4 cos cos), and Snell's law at each microfacet | Walter et al. 2007 |
//! | [`Conductor`] | F·D·G / (4 cos cos) with a complex index | Cook, Torrance 1982; Heitz 2018 |
//! | [`MetallicRoughness`] | a diffuse base under a dielectric layer, mixed with metal | glTF 2.0, appendix B; Kulla, Conty 2017 |
//! | [`Layered`] | the same with clearcoat, [`Sheen`], and transmission | extensions of glTF 2.0 |
//! | [`Mix`] | Σ weight · f | |

mod albedo_table;
mod bxdf;
mod conductor;
mod dielectric;
mod diffuse_phong;
mod dispersive_dielectric;
mod ggx;
mod glass_lanes;
mod lambert;
mod lane_sample;
mod layered;
mod layered_lanes;
mod metal_lanes;
mod metallic_roughness;
mod metallic_roughness_lanes;
mod mirror;
mod mix;
mod oren_nayar;
mod phong_lobe;
mod sample;
mod schlick;
mod sheen;
mod side;
mod specular_transmission;
#[cfg(test)]
mod tests;
mod thin_glass;

pub use bxdf::Bxdf;
pub use conductor::{ComplexIor, Conductor, conductor_fresnel};
pub use dielectric::Dielectric;
pub(crate) use diffuse_phong::{DiffusePhong, DiffusePhongLanes, MirrorBlock, MirrorLanes, MirrorMix, WeightedPhong};
pub use dispersive_dielectric::DispersiveDielectric;
pub use ggx::Ggx;
pub(crate) use glass_lanes::{GlassBlock, GlassLanes, GlassSample, GlassSurface};
pub use lambert::Lambert;
pub(crate) use lambert::{cosine_hemisphere, cosine_hemisphere_lanes};
pub(crate) use lane_sample::LaneSample;
pub use layered::Layered;
pub(crate) use layered_lanes::{LayeredBlock, LayeredLanes, LayeredParameters};
pub(crate) use metal_lanes::{MetalBlock, MetalLanes};
pub use metallic_roughness::MetallicRoughness;
pub(crate) use metallic_roughness_lanes::{MetallicRoughnessBlock, MetallicRoughnessLanes, MetallicRoughnessLayer};
pub use mirror::Mirror;
pub use mix::{MAX_LOBES, Mix, MixError};
pub use oren_nayar::OrenNayar;
pub use phong_lobe::PhongLobe;
pub use sample::{BsdfSample, Scattering};
pub use sheen::Sheen;
pub use specular_transmission::SpecularTransmission;
pub use thin_glass::ThinGlass;

use crate::wavefront::is_in_range;
use rt_math::{DVec3, Rgb};

/// BSDF of a surface at a point: one [`Bxdf`], a [`Mix`] of several, or [`Layered`].
///
/// Plain data without allocations, computed for each hit of a textured material.
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
    /// One lobe.
    Single(Bxdf),
    /// A weighted sum of lobes.
    Mix(Mix),
    /// A base under clearcoat and sheen.
    Layered(Layered),
}

/// BSDF that is shaded in lanes.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "both are plain data of one hit")]
pub(crate) enum LaneSurface {
    DiffusePhong(DiffusePhong),
    MirrorMix(MirrorMix),
    MetallicRoughness(MetallicRoughnessLayer),
    Layered(LayeredParameters),
    Conductor(Conductor),
    Mirror(Mirror),
    /// Surface of a solid dielectric.
    Glass(GlassSurface),
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

impl From<DiffusePhong> for Bsdf {
    fn from(DiffusePhong { diffuse, highlight }: DiffusePhong) -> Self {
        let OrenNayar { albedo, roughness } = diffuse;
        let diffuse: Bxdf = if roughness > 0.0 { diffuse.into() } else { Lambert { albedo }.into() };
        let Some(WeightedPhong { lobe, weights: [a, b], .. }) = highlight else { return Self::Single(diffuse) };
        // Weights of a mix are valid.
        Mix::new(&[(a, diffuse), (b, lobe.into())]).map_or(Self::Single(diffuse), Self::Mix)
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
        self.eval_with_pdf(wo, wi).0
    }

    /// Density of [`Bsdf::sample`] over solid angle, in 1/sr.
    #[inline]
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.eval_with_pdf(wo, wi).1
    }

    /// Results of [`eval`](Self::eval) and [`pdf`](Self::pdf), which share work.
    #[inline]
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        match self {
            Self::Single(lobe) => lobe.eval_with_pdf(wo, wi),
            Self::Mix(mix) => mix.eval_with_pdf(wo, wi),
            Self::Layered(layered) => layered.eval_with_pdf(wo, wi),
        }
    }

    /// Samples a direction about in proportion to f · |cos θ|, from three numbers in \[0, 1\]. `None` if the light is absorbed.
    #[inline]
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        self.sample_along(wo, u, Rgb::WHITE)
    }

    /// Version of [`Bsdf::sample`] for a path of this throughput. Smooth dispersive glass follows a channel in proportion to it.
    #[inline]
    pub fn sample_along(&self, wo: DVec3, u: [f64; 3], throughput: Rgb) -> Option<BsdfSample> {
        match self {
            Self::Single(lobe) => lobe.sample(wo, u),
            Self::Mix(mix) => mix.sample(wo, u),
            Self::Layered(layered) => layered.sample(wo, u, throughput),
        }
    }

    /// Version of [`Bsdf::sample_along`] for light that arrives from `wo` and is traced on to `wi`: the value is f(wi, wo).
    pub fn sample_importance(&self, wo: DVec3, u: [f64; 3], throughput: Rgb) -> Option<BsdfSample> {
        let sample = self.sample_along(wo, u, throughput)?;
        let value = if sample.is_delta { sample.value * (sample.eta * sample.eta) } else { self.eval(sample.wi, wo) };
        BsdfSample { value, ..sample }.if_finite()
    }

    /// Lobes around a mirrored or refracted direction; `None` if there are none. A diffuse lobe below a layer is kept.
    pub fn without_diffuse(&self) -> Option<Self> {
        match self {
            Self::Single(lobe) => (!lobe.is_diffuse()).then_some(*self),
            Self::Mix(mix) => mix.without_diffuse().map(Self::Mix),
            Self::Layered(_) => Some(*self),
        }
    }

    /// True if it has a diffuse lobe below a layer, which [`without_diffuse`](Self::without_diffuse) keeps.
    pub fn is_diffuse_below_layer(&self) -> bool {
        let is_layered = |lobe: &Bxdf| matches!(lobe, Bxdf::MetallicRoughness(_));
        match self {
            Self::Single(lobe) => is_layered(lobe),
            Self::Mix(mix) => mix.lobes().iter().any(|(_, lobe)| is_layered(lobe)),
            Self::Layered(_) => true,
        }
    }

    /// True if all lobes are delta distributions: `eval` is black everywhere, and lights need not be sampled.
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Single(lobe) => lobe.is_delta(),
            Self::Mix(mix) => mix.lobes().iter().all(|(_, lobe)| lobe.is_delta()),
            Self::Layered(layered) => layered.is_delta(),
        }
    }

    /// The BSDF for lanes: of a rough metallic-roughness or layered surface, a metal, or a mirror. Or a diffuse lobe, a Phong lobe, and a
    /// mirror in this order, of which some may be absent. Its parameters must fit `f32`, and its highlight must not be
    /// too narrow.
    pub(crate) fn as_lane_surface(&self) -> Option<LaneSurface> {
        let lobes = match self {
            Self::Single(Bxdf::MetallicRoughness(surface)) => {
                return MetallicRoughnessLayer::new(surface).map(LaneSurface::MetallicRoughness);
            }
            Self::Single(Bxdf::Conductor(metal)) => {
                return metal.fits_lanes().then_some(LaneSurface::Conductor(*metal));
            }
            Self::Single(Bxdf::Mirror(mirror)) => {
                return is_in_range(mirror.reflectance).then_some(LaneSurface::Mirror(*mirror));
            }
            Self::Single(lobe) => DiffusePhong::diffuse(lobe.as_diffuse()?),
            Self::Mix(mix) => match DiffusePhong::of_mix(mix) {
                Some(lobes) => lobes,
                None => return MirrorMix::of_mix(mix).map(LaneSurface::MirrorMix),
            },
            Self::Layered(layered) => return LayeredParameters::new(layered).map(LaneSurface::Layered),
        };
        lobes.fits_f32().then_some(LaneSurface::DiffusePhong(lobes))
    }

    /// True if [`Bsdf::sample`] uses its first number, which chooses a lobe.
    pub fn uses_component_sample(&self) -> bool {
        match self {
            Self::Single(lobe) => lobe.uses_component_sample(),
            Self::Mix(_) | Self::Layered(_) => true,
        }
    }

    /// True if it transmits light.
    pub fn transmits(&self) -> bool {
        match self {
            Self::Single(lobe) => lobe.transmits(),
            Self::Mix(mix) => mix.lobes().iter().any(|(_, lobe)| lobe.transmits()),
            Self::Layered(layered) => layered.transmits(),
        }
    }
}
