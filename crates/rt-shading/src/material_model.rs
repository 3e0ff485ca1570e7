//! Reflection models of materials: parameters of the BSDF at each point.

use crate::{
    ColorTexture, LayeredSurface, MaterialEvalContext, Phong, TextureId,
    bsdf::{
        Bsdf, Bxdf, ComplexIor, Conductor, Dielectric, Ggx, Lambert, MetallicRoughness, Mirror, OrenNayar, PhongLobe,
        ThinGlass,
    },
    lobe_list::{BLACK, LobeList},
    phong_to_bsdf::phong_to_bsdf,
};

/// Reflection model of a material.
///
/// `whitted` evaluates [`Phong`] and converts the others to it ([`Material::to_phong`](crate::Material::to_phong)). All other
/// integrators evaluate a [`Bsdf`]: one per material if it is uniform, else one per hit.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialModel {
    /// The model of Phong and Whitted.
    Phong(Phong),
    /// Scatters no light: emitters.
    Black,
    /// Lambert's law, or Oren and Nayar (1994) where `roughness` is not 0.
    Diffuse {
        /// Albedo.
        albedo: ColorTexture,
        /// Roughness of [`OrenNayar`], 0 to 1.
        roughness: f64,
    },
    /// A diffuse lobe and a normalised Phong lobe.
    Glossy {
        /// Albedo of the diffuse lobe.
        diffuse: ColorTexture,
        /// Albedo of the Phong lobe at normal incidence.
        specular: ColorTexture,
        /// Exponent of [`PhongLobe`].
        exponent: f64,
    },
    /// A perfect mirror.
    Mirror {
        /// Reflectance at all angles.
        reflectance: ColorTexture,
    },
    /// Interface of a dielectric. The indices of refraction are those of the media on both sides.
    Dielectric {
        /// Roughness of the microfacets, 0 to 1.
        roughness: f64,
        /// Factor of transmitted light.
        transmittance: ColorTexture,
    },
    /// Metal.
    Conductor {
        /// Complex index of refraction.
        ior: ComplexIor,
        /// Roughness of the microfacets, 0 to 1.
        roughness: f64,
    },
    /// The metallic-roughness model of glTF.
    MetallicRoughness {
        /// Albedo of the diffuse lobe, or reflectance of the metal.
        base_color: ColorTexture,
        /// 0 for a dielectric, 1 for metal.
        metallic: f64,
        /// Roughness of the microfacets, 0 to 1.
        roughness: f64,
    },
    /// A pane of glass without thickness.
    ThinGlass {
        /// Index of refraction.
        ior: f64,
        /// Transmittance of one crossing at normal incidence.
        transmittance: ColorTexture,
    },
    /// The metallic-roughness or specular-glossiness model of glTF with textures and extensions.
    Layered(Box<LayeredSurface>),
    /// A weighted sum of models with up to [`MAX_LOBES`](crate::bsdf::MAX_LOBES) lobes in total. A part must not be a mix or layered.
    Mix(Vec<(f64, Self)>),
}

impl MaterialModel {
    /// Evaluates textures at a point and builds the BSDF there. It takes time: the BSDFs of uniform materials are
    /// [cached](crate::BsdfCache).
    pub fn bsdf(&self, at: &MaterialEvalContext<'_>) -> Bsdf {
        match self {
            Self::Phong(phong) => phong_to_bsdf(phong, at),
            Self::Glossy { diffuse, specular, exponent } => {
                let mut lobes = LobeList::default();
                lobes.push_scaled(Lambert { albedo: at.reflectance(diffuse) }.into(), diffuse);
                let lobe = PhongLobe { reflectance: at.reflectance(specular), exponent: *exponent };
                lobes.push_scaled(lobe.into(), specular);
                lobes.into_bsdf()
            }
            Self::Mix(parts) => {
                let mut lobes = LobeList::default();
                // A light that reflects as well is a mix with a part that reflects nothing.
                for (weight, part) in parts.iter().filter(|(_, part)| *part != Self::Black) {
                    lobes.push_all(*weight, &part.bsdf(at));
                }
                lobes.into_bsdf()
            }
            Self::Layered(layered) => match layered.as_metallic_roughness() {
                Some((base_color, metallic, roughness)) => {
                    Bsdf::Single(metallic_roughness(at, base_color, metallic, roughness))
                }
                None => Bsdf::Layered(layered.bsdf(at)),
            },
            single => Bsdf::Single(single.lobe(at)),
        }
    }

    /// Number of lobes that a mix takes for this part, as [`bsdf`](Self::bsdf) makes them.
    pub fn lobes(&self) -> usize {
        match self {
            Self::Black => 0,
            Self::Glossy { diffuse, specular, .. } => {
                usize::from(!diffuse.is_zero()) + usize::from(!specular.is_zero())
            }
            Self::Mix(parts) => parts.iter().map(|(_, part)| part.lobes()).sum(),
            _ => 1,
        }
    }

    /// True if a diffuse lobe lies below a layer, as [`Bsdf::is_diffuse_below_layer`] reports it of a point.
    pub fn has_layers(&self) -> bool {
        match self {
            Self::MetallicRoughness { .. } | Self::Layered(_) => true,
            Self::Mix(parts) => parts.iter().any(|(_, part)| part.has_layers()),
            _ => false,
        }
    }

    /// True if light may pass the surface without entering a medium, or into the material's interior medium.
    pub fn is_transmissive(&self) -> bool {
        match self {
            Self::Phong(phong) => phong.transmission.is_some(),
            Self::Dielectric { .. } | Self::ThinGlass { .. } => true,
            Self::Layered(layered) => !layered.transmission.is_zero(),
            Self::Mix(parts) => parts.iter().any(|(_, part)| part.is_transmissive()),
            Self::Black
            | Self::Diffuse { .. }
            | Self::Glossy { .. }
            | Self::Mirror { .. }
            | Self::Conductor { .. }
            | Self::MetallicRoughness { .. } => false,
        }
    }

    /// True if layers, or roughness of thin glass, show even an index-matched surface. The Phong model leaves them out.
    pub(crate) fn shows_layers(&self) -> bool {
        match self {
            Self::Layered(layered) => layered.shows_layers(),
            Self::Mix(parts) => parts.iter().any(|(_, part)| part.shows_layers()),
            _ => false,
        }
    }

    /// True if a lobe may be a delta distribution.
    ///
    /// Rough dielectrics count: between media of nearly equal indices of refraction they scatter almost no light.
    pub fn may_be_delta(&self) -> bool {
        match self {
            Self::Phong(phong) => phong.transmission.is_some() || !phong.mirror.is_zero(),
            Self::Mirror { .. } | Self::Dielectric { .. } | Self::ThinGlass { .. } => true,
            Self::Conductor { roughness, .. } | Self::MetallicRoughness { roughness, .. } => {
                Ggx::from_roughness(*roughness).is_none()
            }
            Self::Black | Self::Diffuse { .. } | Self::Glossy { .. } => false,
            Self::Layered(layered) => layered.may_be_delta(),
            Self::Mix(parts) => parts.iter().any(|(_, part)| part.may_be_delta()),
        }
    }

    /// True if it reads the tangents of meshes.
    pub fn needs_tangents(&self) -> bool {
        matches!(self, Self::Layered(layered) if layered.needs_tangents())
    }

    /// Coefficients, which may be textured.
    pub fn color_textures_mut(&mut self) -> Vec<&mut ColorTexture> {
        match self {
            Self::Phong(phong) => phong.color_textures_mut(),
            Self::Black | Self::Conductor { .. } => vec![],
            Self::Diffuse { albedo: one, .. }
            | Self::Mirror { reflectance: one }
            | Self::Dielectric { transmittance: one, .. }
            | Self::MetallicRoughness { base_color: one, .. }
            | Self::ThinGlass { transmittance: one, .. } => vec![one],
            Self::Glossy { diffuse, specular, .. } => vec![diffuse, specular],
            Self::Layered(layered) => layered.color_textures_mut(),
            Self::Mix(parts) => parts.iter_mut().flat_map(|(_, part)| part.color_textures_mut()).collect(),
        }
    }

    /// Textures that are read as numbers or directions.
    pub fn data_textures_mut(&mut self) -> Vec<&mut TextureId> {
        match self {
            Self::Layered(layered) => layered.data_textures_mut(),
            _ => vec![],
        }
    }

    fn lobe(&self, at: &MaterialEvalContext<'_>) -> Bxdf {
        match self {
            Self::Diffuse { albedo, roughness: 0.0 } => Lambert { albedo: at.reflectance(albedo) }.into(),
            Self::Diffuse { albedo, roughness } => {
                OrenNayar { albedo: at.reflectance(albedo), roughness: *roughness }.into()
            }
            Self::Mirror { reflectance } => Mirror { reflectance: at.reflectance(reflectance) }.into(),
            Self::Dielectric { roughness, transmittance } => {
                let transmittance = at.reflectance(transmittance);
                Dielectric { transmittance, ..Dielectric::clear(at.ior, *roughness) }.into()
            }
            Self::Conductor { ior, roughness } => Conductor { ior: *ior, roughness: *roughness }.into(),
            Self::MetallicRoughness { base_color, metallic, roughness } => {
                metallic_roughness(at, base_color, *metallic, *roughness)
            }
            Self::ThinGlass { ior, transmittance } => {
                ThinGlass { ior: *ior, transmittance: at.reflectance(transmittance) }.into()
            }
            Self::Black | Self::Phong(_) | Self::Glossy { .. } | Self::Layered(_) | Self::Mix(_) => BLACK,
        }
    }
}

impl From<Phong> for MaterialModel {
    fn from(phong: Phong) -> Self {
        Self::Phong(phong)
    }
}

fn metallic_roughness(at: &MaterialEvalContext<'_>, base_color: &ColorTexture, metallic: f64, roughness: f64) -> Bxdf {
    let base_color = at.reflectance(base_color);
    MetallicRoughness { base_color, metallic, roughness }.into()
}
