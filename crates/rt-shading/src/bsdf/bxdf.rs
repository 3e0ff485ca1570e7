//! The one list of models.

use super::{
    BsdfSample, Conductor, Dielectric, Lambert, MetallicRoughness, Mirror, OrenNayar, PhongLobe, Refraction, ThinGlass,
};
use rt_math::{DVec3, Rgb};

/// Makes [`Bxdf`] from the list: its variants, what they are made from, and the way to each model's own functions.
macro_rules! lobes {
    ($($(#[$doc:meta])* $name:ident($model:ty),)*) => {
        /// One model of scattering.
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
            /// As [`super::Bsdf::eval`].
            #[inline]
            pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
                match self {
                    $(Self::$name(model) => model.eval(wo, wi),)*
                }
            }

            /// As [`super::Bsdf::pdf`].
            #[inline]
            pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
                match self {
                    $(Self::$name(model) => model.pdf(wo, wi),)*
                }
            }

            /// As [`super::Bsdf::sample`].
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
    /// Ideally diffuse.
    Lambert(Lambert),
    /// Diffuse with grooves.
    OrenNayar(OrenNayar),
    /// A highlight by a power of the cosine.
    Phong(PhongLobe),
    /// A perfect mirror.
    Mirror(Mirror),
    /// The surface of glass or water, smooth or rough.
    Dielectric(Dielectric),
    /// Metal with a measured index of refraction, smooth or rough.
    Conductor(Conductor),
    /// The material of glTF.
    MetallicRoughness(MetallicRoughness),
    /// A pane of glass without thickness.
    ThinGlass(ThinGlass),
    /// Light straight through, bent by Snell's law.
    Refraction(Refraction),
}

impl Bxdf {
    /// As [`super::Bsdf::eval_with_pdf`].
    #[inline]
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        match self {
            Self::Phong(phong) => phong.eval_with_pdf(wo, wi),
            lobe => (lobe.eval(wo, wi), lobe.pdf(wo, wi)),
        }
    }

    /// True if all light goes into single directions.
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Mirror(_) | Self::ThinGlass(_) | Self::Refraction(_) => true,
            Self::Dielectric(dielectric) => dielectric.is_smooth(),
            Self::Conductor(conductor) => conductor.is_smooth(),
            Self::Lambert(_) | Self::OrenNayar(_) | Self::Phong(_) | Self::MetallicRoughness(_) => false,
        }
    }

    /// True if the first number of [`sample`](Self::sample) matters.
    pub fn uses_component_sample(&self) -> bool {
        matches!(self, Self::Dielectric(_) | Self::MetallicRoughness(_) | Self::ThinGlass(_))
    }

    /// True if it spreads light evenly, and nothing else.
    pub fn is_diffuse(&self) -> bool {
        matches!(self, Self::Lambert(_) | Self::OrenNayar(_))
    }

    /// True if light may pass to the other side.
    pub fn transmits(&self) -> bool {
        matches!(self, Self::Dielectric(_) | Self::ThinGlass(_) | Self::Refraction(_))
    }

    /// Roughly what part of the light it scatters, to choose among lobes by.
    pub(super) fn strength(&self) -> f64 {
        match self {
            Self::Lambert(lambert) => lambert.albedo.max_component(),
            Self::OrenNayar(oren_nayar) => oren_nayar.albedo.max_component(),
            Self::Phong(phong) => phong.reflectance.max_component(),
            Self::Mirror(mirror) => mirror.reflectance.max_component(),
            Self::Refraction(refraction) => refraction.transmittance.max_component(),
            Self::Dielectric(_) | Self::Conductor(_) | Self::MetallicRoughness(_) | Self::ThinGlass(_) => 1.0,
        }
    }
}
