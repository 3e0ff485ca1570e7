//! Conversion of materials to the Phong model, for the `whitted` integrator.
//!
//! The Phong model has no blurred reflection. The reflectance of a metal is therefore split: smooth metals mirror, and the
//! rest is diffuse. Thin glass reflects and transmits at any angle what it does along its normal. For layered materials:
//!
//! ```text
//! α        = roughness²            exponent = 2/α² − 2   (Blinn's half vector; Karis 2013, as Walter et al. 2007)
//! F0       = (1 − metallic) · specular · ((ior − 1)/(ior + 1))² + metallic · base
//! smooth   = max(0, 1 − 2 · roughness)
//! diffuse  = base · (1 − metallic) · (1 − transmission) + base · metallic · (1 − smooth)
//! mirror   = base · metallic · smooth
//! specular = (1 − roughness) · min(1, F0 · (exponent + 8)/8)
//! ambient  = 1/10 of diffuse
//! ```
//!
//! (exponent + 8)/8 normalises the lobe for lights whose diffuse reflection is not divided by π (Akenine-Möller et al.,
//! Real-Time Rendering, 4th ed., section 9.8). The bound keeps the highlight of a point light no brighter than the light.
//! Textured roughness and metalness are replaced by their means; under `path` they vary. Transmission becomes a dielectric
//! with Fresnel's equations, whose mirror has the share of the transmission. Clearcoat, sheen and anisotropy are left out.

use crate::bsdf::ThinGlass;
use crate::{
    ColorTexture, Highlight, InteriorMedium, LayeredBase, LayeredSurface, Material, MaterialModel, Phong, Transmission,
};
use rt_math::Rgb;
use std::borrow::Cow;

/// Reflectance of a dielectric; the specular colour of metals is above it.
const DIELECTRIC_F0: f64 = 0.04;

impl Material {
    /// The Phong model of `whitted`: the override, the model itself, or the conversion of another model.
    pub fn to_phong(&self) -> Cow<'_, Phong> {
        match (&self.phong_override, &self.model) {
            (Some(phong), _) | (None, MaterialModel::Phong(phong)) => Cow::Borrowed(phong),
            (None, model) => Cow::Owned(convert(model)),
        }
    }

    /// Medium behind the [Phong model](Self::to_phong), which has no thin transmission: that of a thin surface is the index
    /// of refraction of the surface.
    pub fn phong_interior(&self) -> Option<InteriorMedium> {
        self.to_phong().transmission?;
        self.interior.or_else(|| match &self.model {
            MaterialModel::Layered(layered) => Some(InteriorMedium::clear(layered.ior.max(1.0))),
            _ => Some(InteriorMedium::clear(1.0)),
        })
    }

    /// True if an index-matched interface of this material is invisible.
    pub fn is_clear(&self) -> bool {
        self.emission.is_zero() && !self.model.shows_layers() && self.to_phong().is_clear()
    }

    /// True if the material is invisible in air. It casts no shadow.
    pub fn is_air(&self) -> bool {
        let is_matched = match (&self.interior, &self.model) {
            (Some(interior), _) => interior.is_air(),
            (None, MaterialModel::ThinGlass { ior, .. }) => *ior == 1.0,
            (None, MaterialModel::Layered(layered)) => layered.ior == 1.0,
            (None, _) => true,
        };
        is_matched && self.is_clear()
    }
}

fn convert(model: &MaterialModel) -> Phong {
    match model {
        MaterialModel::Phong(phong) => *phong,
        MaterialModel::Black => Phong::BLACK,
        MaterialModel::Diffuse { albedo, .. } => Phong::lambertian(*albedo),
        MaterialModel::Glossy { diffuse, specular, exponent } => {
            Phong { specular: *specular, exponent: *exponent, ..Phong::lambertian(*diffuse) }
        }
        MaterialModel::Mirror { reflectance } => Phong { mirror: *reflectance, ..Phong::BLACK },
        MaterialModel::Dielectric { transmittance, .. } => Phong {
            mirror: ColorTexture::Constant(Rgb::WHITE),
            transmission: Some(Transmission { coefficient: *transmittance, fresnel: true }),
            ..Phong::BLACK
        },
        MaterialModel::Conductor { ior, roughness } => {
            partly_mirrored(ColorTexture::Constant(ior.fresnel(1.0)), smooth_share(*roughness))
        }
        MaterialModel::MetallicRoughness { base_color, metallic, roughness } => {
            partly_mirrored(*base_color, *metallic * smooth_share(*roughness))
        }
        MaterialModel::ThinGlass { ior, transmittance } => {
            let (reflected, transmitted) = ThinGlass { ior: *ior, transmittance: Rgb::WHITE }.shares(1.0);
            Phong {
                mirror: ColorTexture::Constant(reflected),
                transmission: Some(Transmission {
                    coefficient: transmittance.scaled(transmitted.max_component()),
                    fresnel: false,
                }),
                ..Phong::BLACK
            }
        }
        MaterialModel::Layered(layered) => convert_layered(layered),
        MaterialModel::Mix(parts) => {
            parts.iter().fold(Phong::BLACK, |sum, (weight, part)| added(sum, *weight, &convert(part)))
        }
    }
}

/// Share of the reflectance of a metal that is mirrored.
fn smooth_share(roughness: f64) -> f64 {
    (1.0 - 2.0 * roughness).max(0.0)
}

/// A surface of which a share of the reflectance is mirrored; the rest is diffuse.
fn partly_mirrored(reflectance: ColorTexture, share: f64) -> Phong {
    Phong { mirror: reflectance.scaled(share), ..Phong::lambertian(reflectance.scaled(1.0 - share)) }
}

/// Adds `part` times a weight to `sum`. Of each coefficient, the first texture is kept. Fresnel's equations weigh all of the mirror and
/// transmission if they weigh that of one part.
fn added(sum: Phong, weight: f64, part: &Phong) -> Phong {
    let add = |sum: ColorTexture, part: ColorTexture| match (sum, part.scaled(weight)) {
        (ColorTexture::Constant(a), ColorTexture::Constant(b)) => ColorTexture::Constant(a + b),
        (textured @ ColorTexture::Textured(..), _) | (_, textured) => textured,
    };
    Phong {
        ambient: add(sum.ambient, part.ambient),
        diffuse: add(sum.diffuse, part.diffuse),
        specular: add(sum.specular, part.specular),
        exponent: if part.specular.is_zero() { sum.exponent } else { part.exponent },
        highlight: sum.highlight,
        mirror: add(sum.mirror, part.mirror),
        transmission: match (sum.transmission, part.transmission) {
            (sum, None) => sum,
            (None, Some(part)) => Some(Transmission { coefficient: part.coefficient.scaled(weight), ..part }),
            (Some(sum), Some(part)) => Some(Transmission {
                coefficient: add(sum.coefficient, part.coefficient),
                fresnel: sum.fresnel || part.fresnel,
            }),
        },
    }
}

fn convert_layered(layered: &LayeredSurface) -> Phong {
    let (base, metallic, roughness) = base_parameters(&layered.base);
    let transmission = layered.transmission.mean() * (1.0 - metallic);
    let smooth = smooth_share(roughness);
    let diffuse = (1.0 - metallic) - transmission + metallic * (1.0 - smooth);
    let exponent = exponent(roughness);
    let strength = (exponent + 8.0) / 8.0;
    let fresnel = if layered.ior == 0.0 { 1.0 } else { (layered.ior - 1.0) / (layered.ior + 1.0) };
    let specular = layered.specular_color.factor() * layered.specular.mean();
    let f0 = (specular * (fresnel * fresnel)).map(|f| f.min(1.0)).lerp(base.factor(), metallic);
    let transmitted = base.scaled(transmission);
    // The mirror of glass is a share of the surface, which Fresnel's equations weigh. Thin glass reflects as along its normal.
    let (mirror, transmission) = if transmitted.is_zero() {
        (base.scaled(metallic * smooth), None)
    } else if layered.is_thin {
        let reflected = layered.specular.mean() * fresnel * fresnel;
        let thin = Transmission { coefficient: transmitted.scaled(1.0 - reflected), fresnel: false };
        (ColorTexture::Constant(Rgb::gray(transmission * reflected)), Some(thin))
    } else {
        let glass = Transmission { coefficient: transmitted, fresnel: true };
        (ColorTexture::Constant(Rgb::gray(transmission)), Some(glass))
    };
    Phong {
        ambient: base.scaled(0.1 * diffuse),
        diffuse: base.scaled(diffuse),
        specular: ColorTexture::Constant(f0.map(|f| (1.0 - roughness) * (f * strength).min(1.0))),
        exponent,
        highlight: Highlight::Blinn,
        mirror,
        transmission,
    }
}

/// Base colour, and means of metalness and roughness.
///
/// Specular-glossiness materials are metallic to the degree that they reflect more than a dielectric.
fn base_parameters(base: &LayeredBase) -> (ColorTexture, f64, f64) {
    match base {
        LayeredBase::MetallicRoughness { base_color, metallic, roughness } => {
            (*base_color, metallic.mean(), roughness.mean())
        }
        LayeredBase::SpecularGlossiness { base_color, mean_specular, glossiness, .. } => {
            let metallic = ((mean_specular.max_component() - DIELECTRIC_F0) / (1.0 - DIELECTRIC_F0)).clamp(0.0, 1.0);
            let base_color = match base_color {
                ColorTexture::Textured(..) => *base_color,
                ColorTexture::Constant(colour) => {
                    ColorTexture::Constant(*colour * (1.0 - metallic) + *mean_specular * metallic)
                }
            };
            (base_color, metallic, 1.0 - glossiness.mean())
        }
    }
}

/// Exponent of the Blinn–Phong lobe as wide as Beckmann's for this roughness, at most 10⁷.
fn exponent(roughness: f64) -> f64 {
    let alpha = roughness * roughness;
    (2.0 / (alpha * alpha) - 2.0).min(1e7)
}

#[cfg(test)]
mod tests;
