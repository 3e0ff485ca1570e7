//! List of all lobes.

use super::{
    BsdfSample, Conductor, Dielectric, Lambert, MetallicRoughness, Mirror, OrenNayar, PhongLobe, SpecularTransmission,
    ThinGlass,
};
use rt_math::{DVec3, Rgb};

/// Defines [`Bxdf`] by a list of variants: the conversions to it, and the dispatch to each lobe.
macro_rules! lobes {
    ($($(#[$doc:meta])* $name:ident($model:ty),)*) => {
        /// One lobe, or a set of lobes that is sampled together.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Bxdf {
            $($(#[$doc])* $name($model),)*
        }

        $(impl From<$model> for Bxdf {
            fn from(model: $model) -> Self {
                Self::$name(model)
            }
        })*

        impl Bxdf {
            /// Implements [`super::Bsdf::eval_with_pdf`].
            #[inline]
            pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
                match self {
                    $(Self::$name(model) => model.eval_with_pdf(wo, wi),)*
                }
            }

            /// Implements [`super::Bsdf::sample`].
            #[inline]
            pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
                match self {
                    $(Self::$name(model) => model.sample(wo, u),)*
                }
            }
        }
    };
}

lobes! {
    /// Lambertian reflection.
    Lambert(Lambert),
    /// Rough diffuse reflection.
    OrenNayar(OrenNayar),
    /// Lobe by a power of the cosine.
    Phong(PhongLobe),
    /// A perfect mirror.
    Mirror(Mirror),
    /// Interface of a dielectric, smooth or rough.
    Dielectric(Dielectric),
    /// Metal with a complex index of refraction, smooth or rough.
    Conductor(Conductor),
    /// Metallic-roughness model of glTF.
    MetallicRoughness(MetallicRoughness),
    /// A pane of glass without thickness.
    ThinGlass(ThinGlass),
    /// Specular transmission with a constant transmittance.
    SpecularTransmission(SpecularTransmission),
}

impl Bxdf {
    /// True if all lobes are delta distributions.
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Mirror(_) | Self::ThinGlass(_) | Self::SpecularTransmission(_) => true,
            Self::Dielectric(dielectric) => dielectric.is_smooth(),
            Self::Conductor(conductor) => conductor.is_smooth(),
            Self::Lambert(_) | Self::OrenNayar(_) | Self::Phong(_) | Self::MetallicRoughness(_) => false,
        }
    }

    /// True if [`sample`](Self::sample) uses its first number.
    pub fn uses_component_sample(&self) -> bool {
        matches!(self, Self::Dielectric(_) | Self::MetallicRoughness(_) | Self::ThinGlass(_))
    }

    /// True for a diffuse lobe.
    pub fn is_diffuse(&self) -> bool {
        matches!(self, Self::Lambert(_) | Self::OrenNayar(_))
    }

    pub(crate) const fn as_diffuse(&self) -> Option<OrenNayar> {
        match *self {
            Self::Lambert(Lambert { albedo }) => Some(OrenNayar { albedo, roughness: 0.0 }),
            Self::OrenNayar(oren_nayar) => Some(oren_nayar),
            _ => None,
        }
    }

    /// True if it transmits light.
    pub fn transmits(&self) -> bool {
        matches!(self, Self::Dielectric(_) | Self::ThinGlass(_) | Self::SpecularTransmission(_))
    }

    /// Approximate albedo, by which lobes of a mix are chosen.
    pub(super) fn strength(&self) -> f64 {
        match self {
            Self::Lambert(lambert) => lambert.albedo.max_component(),
            Self::OrenNayar(oren_nayar) => oren_nayar.albedo.max_component(),
            Self::Phong(phong) => phong.reflectance.max_component(),
            Self::Mirror(mirror) => mirror.reflectance.max_component(),
            Self::SpecularTransmission(lobe) => lobe.transmittance.max_component(),
            Self::Dielectric(_) | Self::Conductor(_) | Self::MetallicRoughness(_) | Self::ThinGlass(_) => 1.0,
        }
    }
}
