//! The material of glTF with its extensions, as a scene describes it.

use crate::{
    ColorTexture, FloatTexture, PhysicalPoint, Relief, TextureId,
    bsdf::{DispersiveDielectric, Ggx, Layered, Sheen},
};
use rt_geometry::SurfaceInteraction;
use rt_math::{DVec3, Frame, Rgb, Vec3, transcendental};

/// How the base of a layered surface is described.
#[derive(Clone, Debug, PartialEq)]
pub enum LayeredBase {
    /// A dielectric mixed with metal.
    MetallicRoughness {
        /// Colour of the diffuse part, or of the metal.
        base_color: ColorTexture,
        /// 0 for a dielectric, 1 for metal.
        metallic: FloatTexture,
        /// Roughness of the facets, 0 to 1.
        roughness: FloatTexture,
    },
    /// Diffuse and mirrored colours apart (KHR_materials_pbrSpecularGlossiness).
    SpecularGlossiness {
        /// Albedo of the diffuse part.
        diffuse: ColorTexture,
        /// What facets reflect along their normal.
        specular: ColorTexture,
        /// 1 less the roughness.
        glossiness: FloatTexture,
    },
}

/// A base under facets, fibres and a coat. Factors that are zero leave their layer out.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredSurface {
    /// The base.
    pub base: LayeredBase,
    /// Index of refraction, which says how much facets of a dielectric reflect; 0 for all.
    pub ior: f64,
    /// Strength of that reflection (KHR_materials_specular).
    pub specular: FloatTexture,
    /// Its colour along the normal.
    pub specular_color: ColorTexture,
    /// Part of the light that comes through where it would be scattered below the surface (KHR_materials_transmission).
    pub transmission: FloatTexture,
    /// Whether that is a pane without thickness rather than the surface of a body (KHR_materials_volume).
    pub is_thin: bool,
    /// 20 divided by Abbe's number, 0 for none (KHR_materials_dispersion).
    pub dispersion: f64,
    /// Part that the coat covers (KHR_materials_clearcoat).
    pub coat: FloatTexture,
    /// Roughness of the coat.
    pub coat_roughness: FloatTexture,
    /// Normal map of the coat, whose normals are smooth without one, whatever those of the base.
    pub coat_relief: Option<Relief>,
    /// Colour of the fibres (KHR_materials_sheen).
    pub sheen_color: ColorTexture,
    /// Their roughness.
    pub sheen_roughness: FloatTexture,
    /// How much facets are stretched, 0 to 1 (KHR_materials_anisotropy).
    pub anisotropy: FloatTexture,
    /// Angle from the tangent to the direction of the stretch, in radians, counter-clockwise.
    pub anisotropy_rotation: f64,
    /// Texture whose red and green turn that direction.
    pub anisotropy_direction: Option<TextureId>,
}

impl LayeredSurface {
    /// The base alone.
    pub const fn new(base: LayeredBase) -> Self {
        Self {
            base,
            ior: 1.5,
            specular: FloatTexture::Constant(1.0),
            specular_color: ColorTexture::Constant(Rgb::WHITE),
            transmission: FloatTexture::Constant(0.0),
            is_thin: true,
            dispersion: 0.0,
            coat: FloatTexture::Constant(0.0),
            coat_roughness: FloatTexture::Constant(0.0),
            coat_relief: None,
            sheen_color: ColorTexture::ZERO,
            sheen_roughness: FloatTexture::Constant(0.0),
            anisotropy: FloatTexture::Constant(0.0),
            anisotropy_rotation: 0.0,
            anisotropy_direction: None,
        }
    }

    /// What the surface does to light at a point.
    pub(crate) fn bsdf(&self, at: &PhysicalPoint<'_>) -> Layered {
        let mut layers = match &self.base {
            LayeredBase::MetallicRoughness { base_color, metallic, roughness } => {
                self.mixed_with_metal(at, at.reflectance(base_color), at.share(metallic), at.share(roughness))
            }
            LayeredBase::SpecularGlossiness { diffuse, specular, glossiness } => {
                let f0 = at.reflectance(specular);
                let strongest = f0.max_component();
                let diffuse = at.reflectance(diffuse) * (1.0 - strongest);
                Layered {
                    diffuse,
                    f0,
                    dims: [strongest, 1.0],
                    roughness: 1.0 - at.share(glossiness),
                    ..Layered::PLASTIC
                }
            }
        };
        if !self.coat.is_zero() {
            layers.coat = at.share(&self.coat);
            layers.coat_roughness = at.share(&self.coat_roughness);
            layers.coat_normal = self.coat_normal(at);
        }
        if !self.sheen_color.is_zero() {
            let (color, roughness) = (at.reflectance(&self.sheen_color), at.share(&self.sheen_roughness));
            layers.sheen = (!color.is_black()).then_some(Sheen { color, roughness });
        }
        if !self.anisotropy.is_zero() {
            (layers.anisotropy, layers.axis) = self.stretch(at);
        }
        layers
    }

    fn mixed_with_metal(&self, at: &PhysicalPoint<'_>, color: Rgb, metallic: f64, roughness: f64) -> Layered {
        let fresnel = if self.ior == 0.0 { 1.0 } else { (self.ior - 1.0) / (self.ior + 1.0) };
        let strength = at.share(&self.specular);
        let tint = self.specular_color.at(at.textures, at.surface);
        let f0 = (tint * (fresnel * fresnel)).map(|f| f.min(1.0)) * strength;
        let passes = if self.transmission.is_zero() { 0.0 } else { at.share(&self.transmission) };
        let below = color * (1.0 - metallic);
        let layers = Layered {
            f0: f0.lerp(color, metallic),
            f90: Rgb::gray(strength).lerp(Rgb::WHITE, metallic),
            dims: [f0.max_component(), strength],
            roughness,
            ..Layered::PLASTIC
        };
        if self.is_thin {
            return Layered { diffuse: below * (1.0 - passes), passing: below * passes, ..layers };
        }
        let share = passes * (1.0 - metallic);
        let glass = DispersiveDielectric { iors: self.iors(at.ior), roughness, transmittance: color };
        Layered { diffuse: below, glass: (share > 0.0).then_some((share, glass)), ..layers }
    }

    /// The indices of red, green and blue light, where that of green is `ior`.
    fn iors(&self, ior: f64) -> [f64; 3] {
        let spread = (self.ior - 1.0) * 0.025 * self.dispersion / self.ior;
        [1.0 - spread, 1.0, 1.0 + spread].map(|part| ior * part)
    }

    /// The normal of the coat in shading coordinates.
    fn coat_normal(&self, at: &PhysicalPoint<'_>) -> DVec3 {
        let base = at.surface.shading_normal;
        let is_turned = at.surface.detail.smooth_normal != Vec3::ZERO;
        let smooth = if is_turned { at.surface.detail.smooth_normal.as_dvec3().normalize() } else { base };
        let turned = self.coat_relief.and_then(|relief| relief.turned(at.textures, at.surface, smooth));
        match turned {
            None if !is_turned => DVec3::Z,
            turned => Frame::from_z(base).to_local(turned.unwrap_or(smooth)),
        }
    }

    /// How much facets are stretched at a point, and along which axis in shading coordinates.
    fn stretch(&self, at: &PhysicalPoint<'_>) -> (f64, [f64; 2]) {
        let SurfaceInteraction { detail, shading_normal, .. } = at.surface;
        let texture = self.anisotropy_direction.and_then(|id| at.textures.get(id.0 as usize));
        let turned = texture.map_or([1.0, 0.0], |texture| {
            let map = texture.at(&at.surface.into());
            [2.0 * map.r - 1.0, 2.0 * map.g - 1.0]
        });
        let (sin, cos) = transcendental::sincos(self.anisotropy_rotation);
        let [along, across] = [turned[0] * cos - turned[1] * sin, turned[0] * sin + turned[1] * cos];
        if detail.tangent == Vec3::ZERO {
            return (0.0, [1.0, 0.0]);
        }
        let tangent = Frame::from_z(*shading_normal).to_local(detail.tangent.as_dvec3());
        let side = if detail.is_mirrored { -1.0 } else { 1.0 };
        let axis = DVec3::new(
            tangent.x * along - tangent.y * across * side,
            tangent.y * along + tangent.x * across * side,
            0.0,
        );
        match axis.try_normalize() {
            Some(axis) => (at.share(&self.anisotropy), [axis.x, axis.y]),
            None => (0.0, [1.0, 0.0]),
        }
    }

    /// True if light that comes through the surface goes on in a body behind it.
    pub(crate) fn encloses_body(&self) -> bool {
        !self.is_thin && !self.transmission.is_zero()
    }

    /// True if light may go on in a single direction; what textures say is not known.
    pub(crate) fn is_sharp(&self) -> bool {
        let may_be_smooth = |roughness: &FloatTexture| match roughness {
            FloatTexture::Constant(value) => Ggx::from_roughness(*value).is_none(),
            FloatTexture::Textured(..) => true,
        };
        let facets = match &self.base {
            LayeredBase::MetallicRoughness { roughness, .. } => may_be_smooth(roughness),
            LayeredBase::SpecularGlossiness { glossiness: FloatTexture::Constant(value), .. } => {
                Ggx::from_roughness(1.0 - value).is_none()
            }
            LayeredBase::SpecularGlossiness { .. } => true,
        };
        facets || self.encloses_body() || (!self.coat.is_zero() && may_be_smooth(&self.coat_roughness))
    }

    /// True if it looks at the tangents of meshes.
    pub fn needs_tangents(&self) -> bool {
        !self.anisotropy.is_zero() || (self.coat_relief.is_some() && !self.coat.is_zero())
    }
}

/// Lists what may have textures, borrowed as the surface is.
macro_rules! lists {
    ($coefficients:ident, $scalars:ident, $($borrow:tt)+) => {
        /// The coefficients.
        pub(crate) fn $coefficients($($borrow)+ self) -> Vec<$($borrow)+ ColorTexture> {
            let mut list = match $($borrow)+ self.base {
                LayeredBase::MetallicRoughness { base_color, .. } => vec![base_color],
                LayeredBase::SpecularGlossiness { diffuse, specular, .. } => vec![diffuse, specular],
            };
            list.extend([$($borrow)+ self.specular_color, $($borrow)+ self.sheen_color]);
            list
        }

        /// The numbers.
        pub(crate) fn $scalars($($borrow)+ self) -> Vec<$($borrow)+ FloatTexture> {
            let mut list = match $($borrow)+ self.base {
                LayeredBase::MetallicRoughness { metallic, roughness, .. } => vec![metallic, roughness],
                LayeredBase::SpecularGlossiness { glossiness, .. } => vec![glossiness],
            };
            list.extend([
                $($borrow)+ self.specular,
                $($borrow)+ self.transmission,
                $($borrow)+ self.coat,
                $($borrow)+ self.coat_roughness,
                $($borrow)+ self.sheen_roughness,
                $($borrow)+ self.anisotropy,
            ]);
            list
        }
    };
}

impl LayeredSurface {
    lists!(coefficients, scalars, &);
    lists!(coefficients_mut, scalars_mut, &mut);
}
