//! Surfaces that obey physics, as a scene describes them: what a BSDF is made from at each point.

use crate::{
    ColorTexture, FloatTexture, Highlight, LayeredSurface, Phong, Texture, Transmission,
    bsdf::{
        Bsdf, Bxdf, ComplexIor, Conductor, Coupling, Dielectric, Ggx, Lambert, MAX_LOBES, MetallicRoughness, Mirror,
        Mix, OrenNayar, PhongLobe, Refraction, ThinGlass,
    },
};
use rt_geometry::SurfaceInteraction;
use rt_math::Rgb;

/// A physical surface, of which colours may vary with the texture coordinates. Integrators that follow light from surface
/// to surface ask it for a [`Bsdf`]: once where that is the same everywhere, otherwise at each hit.
#[derive(Clone, Debug, PartialEq)]
pub enum Physical {
    /// Scatters nothing: the surface of a lamp.
    Black,
    /// Diffuse: Lambert's law, with grooves (Oren, Nayar 1994) where `roughness` is not 0.
    Diffuse {
        /// Part of the light that is reflected.
        albedo: ColorTexture,
        /// Roughness of [`OrenNayar`], 0 to 1.
        roughness: f64,
    },
    /// Diffuse with a highlight of Phong's shape, energy-normalised.
    Glossy {
        /// Part of the light that is reflected diffusely.
        diffuse: ColorTexture,
        /// Part of the light along the normal that the highlight reflects.
        specular: ColorTexture,
        /// Exponent of [`PhongLobe`].
        exponent: f64,
    },
    /// A perfect mirror.
    Mirror {
        /// Part of the light that is reflected.
        reflectance: ColorTexture,
    },
    /// The surface of glass or water. The indices of refraction are those of the bodies on both sides.
    Dielectric {
        /// Roughness of the facets, 0 to 1.
        roughness: f64,
        /// What is left of light that passes through the surface.
        transmittance: ColorTexture,
    },
    /// Metal.
    Conductor {
        /// Index of refraction.
        ior: ComplexIor,
        /// Roughness of the facets, 0 to 1.
        roughness: f64,
    },
    /// The material of glTF.
    MetallicRoughness {
        /// Colour of the diffuse part, or of the metal.
        base_color: ColorTexture,
        /// 0 for a dielectric, 1 for metal.
        metallic: f64,
        /// Roughness of the facets, 0 to 1.
        roughness: f64,
    },
    /// A pane of glass without thickness.
    ThinGlass {
        /// Index of refraction.
        ior: f64,
        /// What is left of light that crosses it once along the normal.
        transmittance: ColorTexture,
    },
    /// The material of glTF with its extensions.
    Layered(Box<LayeredSurface>),
    /// A weighted sum of up to [`MAX_LOBES`] surfaces, none of which is a mix or layered itself.
    Mix(Vec<(f64, Self)>),
}

/// Lists the coefficients of a surface, borrowed as the surface is; `iter` and `coefficients` do it to the parts of a mix.
macro_rules! list_coefficients {
    ($surface:expr, $iter:ident, $coefficients:ident) => {
        match $surface {
            Self::Black | Self::Conductor { .. } => vec![],
            Self::Diffuse { albedo: one, .. }
            | Self::Mirror { reflectance: one }
            | Self::Dielectric { transmittance: one, .. }
            | Self::MetallicRoughness { base_color: one, .. }
            | Self::ThinGlass { transmittance: one, .. } => vec![one],
            Self::Glossy { diffuse, specular, .. } => vec![diffuse, specular],
            Self::Layered(layered) => layered.$coefficients(),
            Self::Mix(parts) => parts.$iter().flat_map(|(_, part)| part.$coefficients()).collect(),
        }
    };
}

/// Lists the numbers of a surface that may have textures, borrowed as the surface is.
macro_rules! list_scalars {
    ($surface:expr, $scalars:ident) => {
        match $surface {
            Self::Layered(layered) => layered.$scalars(),
            Self::Black
            | Self::Diffuse { .. }
            | Self::Glossy { .. }
            | Self::Mirror { .. }
            | Self::Dielectric { .. }
            | Self::Conductor { .. }
            | Self::MetallicRoughness { .. }
            | Self::ThinGlass { .. }
            | Self::Mix(_) => vec![],
        }
    };
}

/// The surface at one point, for [`Physical::bsdf`].
#[derive(Clone, Copy, Debug)]
pub struct PhysicalPoint<'a> {
    /// The textures that coefficients refer to.
    pub textures: &'a [Texture],
    /// The surface itself.
    pub surface: &'a SurfaceInteraction,
    /// Index of refraction below the surface divided by that above.
    pub ior: f64,
}

impl PhysicalPoint<'_> {
    /// A reflectance: what is beyond 1 would make light of nothing.
    pub(crate) fn reflectance(&self, coefficient: &ColorTexture) -> Rgb {
        coefficient.at(self.textures, self.surface).map(|c| c.min(1.0))
    }

    /// A number from 0 to 1.
    pub(crate) fn share(&self, scalar: &FloatTexture) -> f64 {
        scalar.at(self.textures, self.surface).clamp(0.0, 1.0)
    }
}

impl Physical {
    /// The surface as the classical one describes it, with the brightness that it has under [`Whitted`](crate::Whitted):
    /// the diffuse coefficient is an albedo, the highlight is as bright as it was along its axis, and mirrored and refracted
    /// light is shared by the same rule.
    pub fn bsdf_of_phong(phong: &Phong, at: &PhysicalPoint<'_>) -> Bsdf {
        let mut lobes = MixBuilder::default();
        lobes.push_scaled(Lambert { albedo: at.reflectance(&phong.diffuse) }.into(), &phong.diffuse);
        let exponent = match phong.highlight {
            Highlight::Phong => phong.exponent,
            // Between the half vector and the normal the angle is half of that to the mirrored direction.
            Highlight::Blinn => 0.25 * phong.exponent,
        };
        let specular = at.reflectance(&phong.specular) * (2.0 / (exponent + 2.0));
        lobes.push_scaled(PhongLobe { reflectance: specular, exponent }.into(), &phong.specular);
        let mirror = at.reflectance(&phong.mirror);
        match &phong.transmission {
            Some(Transmission { coefficient, fresnel: true, .. }) => {
                let transmittance = at.reflectance(coefficient);
                let surface = Dielectric { ior: at.ior, roughness: 0.0, reflectance: mirror, transmittance };
                lobes.push(surface.into());
            }
            Some(Transmission { coefficient, fresnel: false, .. }) => {
                lobes.push_scaled(Mirror { reflectance: mirror }.into(), &phong.mirror);
                let passing = Refraction { ior: at.ior, transmittance: at.reflectance(coefficient) };
                lobes.push_scaled(passing.into(), coefficient);
            }
            None => lobes.push_scaled(Mirror { reflectance: mirror }.into(), &phong.mirror),
        }
        lobes.finish()
    }

    /// What the surface does to light at a point.
    pub fn bsdf(&self, at: &PhysicalPoint<'_>) -> Bsdf {
        match self {
            Self::Glossy { diffuse, specular, exponent } => {
                let mut lobes = MixBuilder::default();
                lobes.push_scaled(Lambert { albedo: at.reflectance(diffuse) }.into(), diffuse);
                let lobe = PhongLobe { reflectance: at.reflectance(specular), exponent: *exponent };
                lobes.push_scaled(lobe.into(), specular);
                lobes.finish()
            }
            Self::Mix(parts) => {
                let mut lobes = MixBuilder::default();
                for (weight, part) in parts {
                    lobes.push_all(*weight, &part.bsdf(at));
                }
                lobes.finish()
            }
            Self::Layered(layered) => Bsdf::Layered(layered.bsdf(at)),
            single => Bsdf::Single(single.lobe(at)),
        }
    }

    /// True if a diffuse part lies below a layer, as [`Bsdf::is_diffuse_below_layer`] tells it of a point.
    pub fn has_layers(&self) -> bool {
        match self {
            Self::MetallicRoughness { .. } | Self::Layered(_) => true,
            Self::Mix(parts) => parts.iter().any(|(_, part)| part.has_layers()),
            _ => false,
        }
    }

    /// True if light that comes through the surface goes on in a body behind it.
    pub fn encloses_body(&self) -> bool {
        match self {
            Self::Dielectric { .. } => true,
            Self::Layered(layered) => layered.encloses_body(),
            Self::Mix(parts) => parts.iter().any(|(_, part)| part.encloses_body()),
            Self::Black
            | Self::Diffuse { .. }
            | Self::Glossy { .. }
            | Self::Mirror { .. }
            | Self::Conductor { .. }
            | Self::MetallicRoughness { .. }
            | Self::ThinGlass { .. } => false,
        }
    }

    fn lobe(&self, at: &PhysicalPoint<'_>) -> Bxdf {
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
            Self::MetallicRoughness { base_color, metallic, roughness } => MetallicRoughness {
                base_color: at.reflectance(base_color),
                metallic: *metallic,
                roughness: *roughness,
                coupling: Coupling::Albedo,
            }
            .into(),
            Self::ThinGlass { ior, transmittance } => {
                ThinGlass { ior: *ior, transmittance: at.reflectance(transmittance) }.into()
            }
            Self::Black | Self::Glossy { .. } | Self::Layered(_) | Self::Mix(_) => BLACK,
        }
    }

    /// True if light may go on in a single direction. Rough glass counts: between media that are nearly alike it does not bend
    /// light enough to be rough.
    pub fn is_sharp(&self) -> bool {
        match self {
            Self::Mirror { .. } | Self::Dielectric { .. } | Self::ThinGlass { .. } => true,
            Self::Conductor { roughness, .. } | Self::MetallicRoughness { roughness, .. } => {
                Ggx::from_roughness(*roughness).is_none()
            }
            Self::Black | Self::Diffuse { .. } | Self::Glossy { .. } => false,
            Self::Layered(layered) => layered.is_sharp(),
            Self::Mix(parts) => parts.iter().any(|(_, part)| part.is_sharp()),
        }
    }

    /// The coefficients, which may have textures.
    pub fn coefficients(&self) -> Vec<&ColorTexture> {
        list_coefficients!(self, iter, coefficients)
    }

    /// The coefficients, to change them.
    pub fn coefficients_mut(&mut self) -> Vec<&mut ColorTexture> {
        list_coefficients!(self, iter_mut, coefficients_mut)
    }

    /// The numbers that may have textures.
    pub fn scalars(&self) -> Vec<&FloatTexture> {
        list_scalars!(self, scalars)
    }

    /// The numbers that may have textures, to change these.
    pub fn scalars_mut(&mut self) -> Vec<&mut FloatTexture> {
        list_scalars!(self, scalars_mut)
    }
}

const BLACK: Bxdf = Bxdf::Lambert(Lambert { albedo: Rgb::BLACK });

/// Lobes over each other.
struct MixBuilder {
    lobes: [(f64, Bxdf); MAX_LOBES],
    count: usize,
}

impl Default for MixBuilder {
    fn default() -> Self {
        Self { lobes: [(0.0, BLACK); MAX_LOBES], count: 0 }
    }
}

impl MixBuilder {
    /// A lobe, unless its coefficient is zero everywhere.
    fn push_scaled(&mut self, lobe: Bxdf, coefficient: &ColorTexture) {
        if !coefficient.is_zero() {
            self.push(lobe);
        }
    }

    fn push(&mut self, lobe: Bxdf) {
        self.push_weighted(1.0, lobe);
    }

    fn push_weighted(&mut self, weight: f64, lobe: Bxdf) {
        if let Some(place) = self.lobes.get_mut(self.count) {
            *place = (weight, lobe);
            self.count += 1;
        }
    }

    fn push_all(&mut self, weight: f64, bsdf: &Bsdf) {
        match bsdf {
            Bsdf::Single(lobe) => self.push_weighted(weight, *lobe),
            Bsdf::Mix(mix) => mix.lobes().iter().for_each(|(within, lobe)| self.push_weighted(weight * within, *lobe)),
            // A mix holds none: it has layers of its own.
            Bsdf::Layered(_) => {}
        }
    }

    fn finish(self) -> Bsdf {
        match &self.lobes[..self.count] {
            [] => Bsdf::Single(BLACK),
            [(1.0, lobe)] => Bsdf::Single(*lobe),
            lobes => Mix::new(lobes).map_or(Bsdf::Single(BLACK), Bsdf::Mix),
        }
    }
}
