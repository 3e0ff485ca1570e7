//! Reflection models of materials: parameters of the BSDF at each point.

use crate::{
    ColorTexture, Highlight, LayeredSurface, MaterialEvalContext, Phong, TextureId, Transmission,
    bsdf::{
        Bsdf, Bxdf, ComplexIor, Conductor, Coupling, Dielectric, Ggx, Lambert, MAX_LOBES, MetallicRoughness, Mirror,
        Mix, OrenNayar, PhongLobe, Refraction, ThinGlass,
    },
};
use rt_math::Rgb;

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
    /// A weighted sum of models with up to [`MAX_LOBES`] lobes in total. A part must not be a mix or layered.
    Mix(Vec<(f64, Self)>),
}

impl MaterialModel {
    /// BSDF at a point.
    pub fn bsdf(&self, at: &MaterialEvalContext<'_>) -> Bsdf {
        match self {
            Self::Phong(phong) => phong_bsdf(phong, at),
            Self::Glossy { diffuse, specular, exponent } => {
                let mut lobes = LobeList::default();
                lobes.push_scaled(Lambert { albedo: at.reflectance(diffuse) }.into(), diffuse);
                let lobe = PhongLobe { reflectance: at.reflectance(specular), exponent: *exponent };
                lobes.push_scaled(lobe.into(), specular);
                lobes.into_bsdf()
            }
            Self::Mix(parts) => {
                let mut lobes = LobeList::default();
                for (weight, part) in parts {
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

const BLACK: Bxdf = Bxdf::Lambert(Lambert { albedo: Rgb::BLACK });

fn metallic_roughness(at: &MaterialEvalContext<'_>, base_color: &ColorTexture, metallic: f64, roughness: f64) -> Bxdf {
    let base_color = at.reflectance(base_color);
    MetallicRoughness { base_color, metallic, roughness, coupling: Coupling::Albedo }.into()
}

/// BSDF with the brightness of the Phong model under [`Whitted`](crate::Whitted).
///
/// The diffuse coefficient is an albedo. The highlight keeps its peak. Mirrored and refracted light are split by the same rule.
fn phong_bsdf(phong: &Phong, at: &MaterialEvalContext<'_>) -> Bsdf {
    let is_diffuse = phong.specular.is_zero() && phong.mirror.is_zero() && phong.transmission.is_none();
    if is_diffuse && !phong.diffuse.is_zero() {
        return Bsdf::Single(Lambert { albedo: at.reflectance(&phong.diffuse) }.into());
    }
    let mut lobes = LobeList::default();
    lobes.push_scaled(Lambert { albedo: at.reflectance(&phong.diffuse) }.into(), &phong.diffuse);
    let exponent = match phong.highlight {
        Highlight::Phong => phong.exponent,
        // The angle between half vector and normal is half of that to the mirrored direction.
        Highlight::Blinn => 0.25 * phong.exponent,
    };
    let specular = at.reflectance(&phong.specular) * (2.0 / (exponent + 2.0));
    lobes.push_scaled(PhongLobe { reflectance: specular, exponent }.into(), &phong.specular);
    let mirror = at.reflectance(&phong.mirror);
    match &phong.transmission {
        Some(Transmission { coefficient, fresnel: true }) => {
            let transmittance = at.reflectance(coefficient);
            let interface = Dielectric { ior: at.ior, roughness: 0.0, reflectance: mirror, transmittance };
            lobes.push(interface.into());
        }
        Some(Transmission { coefficient, fresnel: false }) => {
            lobes.push_scaled(Mirror { reflectance: mirror }.into(), &phong.mirror);
            let refraction = Refraction { ior: at.ior, transmittance: at.reflectance(coefficient) };
            lobes.push_scaled(refraction.into(), coefficient);
        }
        None => lobes.push_scaled(Mirror { reflectance: mirror }.into(), &phong.mirror),
    }
    lobes.into_bsdf()
}

/// Weighted lobes of a BSDF.
struct LobeList {
    lobes: [(f64, Bxdf); MAX_LOBES],
    count: usize,
}

impl Default for LobeList {
    fn default() -> Self {
        Self { lobes: [(0.0, BLACK); MAX_LOBES], count: 0 }
    }
}

impl LobeList {
    /// Adds a lobe, unless its coefficient is zero everywhere.
    fn push_scaled(&mut self, lobe: Bxdf, coefficient: &ColorTexture) {
        if !coefficient.is_zero() {
            self.push(lobe);
        }
    }

    fn push(&mut self, lobe: Bxdf) {
        self.push_weighted(1.0, lobe);
    }

    fn push_weighted(&mut self, weight: f64, lobe: Bxdf) {
        if let Some(slot) = self.lobes.get_mut(self.count) {
            *slot = (weight, lobe);
            self.count += 1;
        }
    }

    fn push_all(&mut self, weight: f64, bsdf: &Bsdf) {
        match bsdf {
            Bsdf::Single(lobe) => self.push_weighted(weight, *lobe),
            Bsdf::Mix(mix) => mix.lobes().iter().for_each(|(within, lobe)| self.push_weighted(weight * within, *lobe)),
            // A mix contains no layered surface, which has lobes of its own.
            Bsdf::Layered(_) => {}
        }
    }

    fn into_bsdf(self) -> Bsdf {
        match &self.lobes[..self.count] {
            [] => Bsdf::Single(BLACK),
            [(1.0, lobe)] => Bsdf::Single(*lobe),
            lobes => Mix::new(lobes).map_or(Bsdf::Single(BLACK), Bsdf::Mix),
        }
    }
}
