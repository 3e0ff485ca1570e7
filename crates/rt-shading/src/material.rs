//! Surface properties.

use crate::{Coverage, Physical, PhysicalPoint, Relief, Texture, TextureId, bsdf::Bsdf, light::EmissionSides as Sides};
use rt_geometry::SurfaceInteraction;
use rt_math::{DVec3, Rgb, transcendental};

/// A coefficient that may vary over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColorTexture {
    /// The same everywhere.
    Constant(Rgb),
    /// A texture, multiplied by a colour.
    Textured(TextureId, Rgb),
}

impl ColorTexture {
    /// Zero everywhere: what it scales is left out.
    pub const ZERO: Self = Self::Constant(Rgb::BLACK);

    /// True if it is zero everywhere.
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Constant(rgb) | Self::Textured(_, rgb) if rgb.is_black())
    }

    /// The value at a point of the surface. A texture that is not in the list is black.
    #[inline]
    pub fn at(&self, textures: &[Texture], surface: &SurfaceInteraction) -> Rgb {
        match self {
            Self::Constant(rgb) => *rgb,
            Self::Textured(TextureId(id), rgb) => {
                textures.get(*id as usize).map_or(Rgb::BLACK, |texture| texture.at(&surface.into())) * *rgb
            }
        }
    }
}

/// A part of the pixels of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// How much the texture covers.
    Alpha,
}

/// A number that may vary over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatTexture {
    /// The same everywhere.
    Constant(f64),
    /// A channel of a texture, multiplied by a factor.
    Textured(TextureId, Channel, f64),
}

impl FloatTexture {
    /// True if it is zero everywhere.
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Constant(factor) | Self::Textured(.., factor) if *factor == 0.0)
    }

    /// The value at a point of the surface. A texture that is not in the list is 0.
    #[inline]
    pub fn at(&self, textures: &[Texture], surface: &SurfaceInteraction) -> f64 {
        let (TextureId(id), channel, factor) = match *self {
            Self::Constant(value) => return value,
            Self::Textured(id, channel, factor) => (id, channel, factor),
        };
        let Some(texture) = textures.get(id as usize) else { return 0.0 };
        let point = surface.into();
        factor
            * match channel {
                Channel::Red => texture.at(&point).r,
                Channel::Green => texture.at(&point).g,
                Channel::Blue => texture.at(&point).b,
                Channel::Alpha => texture.alpha_at(&point),
            }
    }
}

/// The shape of the highlight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Highlight {
    /// cosⁿ of the angle between the light and the mirrored view (Phong 1975).
    Phong,
    /// cosⁿ of the angle between the normal and the half vector (Blinn 1977).
    Blinn,
}

impl Highlight {
    /// Strength of the highlight, 0 to 1, for unit vectors: the `normal` on the viewer's side, `wo` to the viewer,
    /// `wi` to the light.
    #[inline]
    pub fn strength(self, normal: DVec3, wo: DVec3, wi: DVec3, exponent: f64) -> f64 {
        let cosine = match self {
            Self::Phong => (normal * (2.0 * normal.dot(wi)) - wi).dot(wo),
            Self::Blinn => normal.dot((wi + wo).normalize_or_zero()),
        };
        if cosine > 0.0 { power(cosine, exponent) } else { 0.0 }
    }
}

/// `base` to the power of `exponent >= 0`; by repeated squaring for whole exponents, which is several times faster
/// than the general function.
fn power(base: f64, exponent: f64) -> f64 {
    const WHOLE: f64 = 1024.0;
    // The conversion cuts the fraction off.
    let mut remaining = exponent as u32;
    if !(exponent <= WHOLE && f64::from(remaining) == exponent) {
        return transcendental::pow(base, exponent);
    }
    let (mut square, mut product) = (base, 1.0);
    while remaining > 0 {
        if remaining & 1 == 1 {
            product *= square;
        }
        square *= square;
        remaining >>= 1;
    }
    product
}

/// Light through the surface into the body behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission {
    /// How much of the refracted light passes.
    pub coefficient: ColorTexture,
    /// Index of refraction of the inside, positive; that of air is 1.
    pub ior: f64,
    /// Whether Fresnel's equations share the light between `mirror` and this coefficient. Otherwise both are constant
    /// and totally reflected light is dropped, as in Whitted's model.
    pub fresnel: bool,
    /// Absorption per world unit of way through the inside (Beer's law): light falls by exp(−absorption · length).
    pub absorption: Rgb,
    /// Where transparent bodies overlap, the one of the greatest number is there, among equals the one that was entered
    /// last: glass above the liquid that reaches into its wall, ice above the liquid that it swims in.
    pub priority: i32,
}

/// The classical surface of Phong and Whitted.
///
/// Under `whitted`, radiance = emission + ambient · ambient light + Σ lights (diffuse · cos θ + specular · highlight)
/// · intensity + mirror · reflected + transmission · refracted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// Share of the ambient light.
    pub ambient: ColorTexture,
    /// Diffuse coefficient.
    pub diffuse: ColorTexture,
    /// Strength of the highlight.
    pub specular: ColorTexture,
    /// Exponent of the highlight, at least 0.
    pub exponent: f64,
    /// Shape of the highlight.
    pub highlight: Highlight,
    /// Light of its own.
    pub emission: ColorTexture,
    /// Share of mirrored light.
    pub mirror: ColorTexture,
    /// Light through the surface, if any.
    pub transmission: Option<Transmission>,
}

impl Phong {
    /// True if nothing shows the surface but what its body's index of refraction does to light: where that is the same on
    /// both sides, the surface is not to be seen. Reflections and highlights are the work of that index where Fresnel's
    /// equations rule, and otherwise constants that stay.
    pub fn is_clear(&self) -> bool {
        let is_zero = |coefficients: &[ColorTexture]| coefficients.iter().all(ColorTexture::is_zero);
        self.transmission.is_some_and(|transmission| {
            transmission.coefficient == ColorTexture::Constant(Rgb::WHITE)
                && is_zero(&[self.ambient, self.diffuse, self.emission])
                && (transmission.fresnel || is_zero(&[self.specular, self.mirror]))
        })
    }

    /// True if the body is of air: in air there is nothing of it to be seen, and it casts no shadow.
    pub fn is_air(&self) -> bool {
        self.is_clear() && self.transmission.is_some_and(|inside| inside.ior == 1.0 && inside.absorption.is_black())
    }
}

impl Default for Phong {
    /// A grey diffuse surface with a little ambient light.
    fn default() -> Self {
        Self {
            ambient: ColorTexture::Constant(Rgb::gray(0.07)),
            diffuse: ColorTexture::Constant(Rgb::gray(0.7)),
            specular: ColorTexture::ZERO,
            exponent: 32.0,
            highlight: Highlight::Phong,
            emission: ColorTexture::ZERO,
            mirror: ColorTexture::ZERO,
            transmission: None,
        }
    }
}

/// A named surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// For messages and `explain`.
    pub name: String,
    /// The classical surface; for a physical one, what comes nearest to it.
    pub phong: Phong,
    /// The physical surface, if there is one. What fills the body behind it stands in `phong`.
    pub physical: Option<Physical>,
    /// Which sides shine with the emission of `phong`.
    pub shines: Sides,
    /// Where the surface is.
    pub coverage: Coverage,
    /// A normal map, if there is one.
    pub relief: Option<Relief>,
    /// Part of the ambient light that gets to a point between what its detail hides: a texture that is made for it.
    pub occlusion: FloatTexture,
}

impl Material {
    /// A classical surface that shines, if at all, from both sides.
    pub const fn new(name: String, phong: Phong) -> Self {
        Self {
            name,
            phong,
            physical: None,
            shines: Sides::Both,
            coverage: Coverage::ALL,
            relief: None,
            occlusion: FloatTexture::Constant(1.0),
        }
    }

    /// True if it is described by a physical surface that scatters light, of which `phong` is an approximation.
    pub fn has_physical_surface(&self) -> bool {
        self.physical.as_ref().is_some_and(|physical| *physical != Physical::Black)
    }

    /// Radiance that the surface emits by itself; black on the inside of one that shines from its front alone.
    #[inline]
    pub fn emission(&self, textures: &[Texture], surface: &SurfaceInteraction, is_inside: bool) -> Rgb {
        if is_inside && self.shines == Sides::Front { Rgb::BLACK } else { self.phong.emission.at(textures, surface) }
    }

    /// Part of the ambient light that the surface reflects at a point.
    #[inline]
    pub fn ambient(&self, textures: &[Texture], surface: &SurfaceInteraction) -> Rgb {
        let ambient = self.phong.ambient.at(textures, surface);
        match self.occlusion {
            FloatTexture::Constant(1.0) => ambient,
            occlusion => ambient * occlusion.at(textures, surface),
        }
    }

    /// What fills the body behind the surface, if there is a transparent one: behind a pane without thickness is what is before it.
    #[inline]
    pub fn body(&self) -> Option<&Transmission> {
        let transmission = self.phong.transmission.as_ref()?;
        self.physical.as_ref().is_none_or(Physical::encloses_body).then_some(transmission)
    }

    /// What the surface does to light at a point.
    pub fn bsdf(&self, at: &PhysicalPoint<'_>) -> Bsdf {
        match &self.physical {
            Some(physical) => physical.bsdf(at),
            None => Physical::bsdf_of_phong(&self.phong, at),
        }
    }

    /// True if light may go on in a single direction, as from mirrors and through glass: at least where it is false, it does
    /// not.
    pub fn is_sharp(&self) -> bool {
        match &self.physical {
            Some(physical) => physical.is_sharp(),
            None => self.phong.transmission.is_some() || !self.phong.mirror.is_zero(),
        }
    }

    /// True if it looks at the [`VertexAttributes`](rt_geometry::VertexAttributes) of meshes.
    pub fn needs_detail(&self) -> bool {
        matches!(&self.physical, Some(Physical::Layered(layered)) if layered.needs_tangents()) || self.is_textured()
    }

    /// True if its BSDF is the same at every point: no texture and no tangent has a part in it, and it is not the surface of
    /// a body, where it would matter what is on the other side.
    pub fn is_uniform(&self) -> bool {
        self.body().is_none() && !self.needs_detail()
    }

    /// Numbers the textures that it refers to from `first` on.
    pub fn count_textures_from(&mut self, first: u32) {
        let phong = &mut self.phong;
        let of_transmission = phong.transmission.as_mut().map(|transmission| &mut transmission.coefficient);
        let coefficients =
            [&mut phong.ambient, &mut phong.diffuse, &mut phong.specular, &mut phong.emission, &mut phong.mirror];
        let shift = |TextureId(id): &mut TextureId| *id += first;
        let shift_coefficient = |coefficient: &mut ColorTexture| {
            if let ColorTexture::Textured(id, _) = coefficient {
                shift(id);
            }
        };
        let shift_scalar = |scalar: &mut FloatTexture| {
            if let FloatTexture::Textured(id, ..) = scalar {
                shift(id);
            }
        };
        coefficients.into_iter().chain(of_transmission).for_each(shift_coefficient);
        shift_scalar(&mut self.occlusion);
        if let Some(physical) = &mut self.physical {
            physical.coefficients_mut().into_iter().for_each(shift_coefficient);
            physical.scalars_mut().into_iter().for_each(shift_scalar);
            if let Physical::Layered(layered) = physical {
                layered.anisotropy_direction.iter_mut().for_each(shift);
                layered.coat_relief.iter_mut().for_each(|relief| shift(&mut relief.texture));
            }
        }
        self.relief.iter_mut().for_each(|relief| shift(&mut relief.texture));
        self.coverage.texture.iter_mut().for_each(shift);
    }

    /// True if it looks at textures.
    pub fn is_textured(&self) -> bool {
        !self.textures().is_empty()
    }

    /// The textures that it looks at, in no particular order; not that of its coverage, which rays look at.
    pub fn textures(&self) -> Vec<TextureId> {
        let Phong { ambient, diffuse, specular, emission, mirror, ref transmission, .. } = self.phong;
        let physical = self.physical.as_ref();
        let coefficients = [ambient, diffuse, specular, emission, mirror]
            .into_iter()
            .chain(transmission.map(|transmission| transmission.coefficient))
            .chain(physical.map(Physical::coefficients).unwrap_or_default().into_iter().copied());
        let of_coefficients = coefficients.filter_map(|coefficient| match coefficient {
            ColorTexture::Textured(id, _) => Some(id),
            ColorTexture::Constant(_) => None,
        });
        let scalars = physical.map(Physical::scalars).unwrap_or_default().into_iter().chain([&self.occlusion]);
        let of_scalars = scalars.filter_map(|scalar| match scalar {
            FloatTexture::Textured(id, ..) => Some(*id),
            FloatTexture::Constant(_) => None,
        });
        let (coat, direction) = match physical {
            Some(Physical::Layered(layered)) => (layered.coat_relief, layered.anisotropy_direction),
            _ => (None, None),
        };
        let reliefs = [self.relief, coat].into_iter().flatten().map(|relief| relief.texture);
        of_coefficients.chain(of_scalars).chain(reliefs).chain(direction).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LayeredBase, LayeredSurface};

    #[test]
    fn a_map_of_the_coat_alone_was_no_texture() {
        let relief = Relief { texture: TextureId(3), scale: 1.0 };
        let (base_color, metallic) = (ColorTexture::Constant(Rgb::WHITE), FloatTexture::Constant(0.0));
        let base = LayeredBase::MetallicRoughness { base_color, metallic, roughness: metallic };
        let surface = LayeredSurface { coat_relief: Some(relief), ..LayeredSurface::new(base) };
        let material = Material {
            physical: Some(Physical::Layered(Box::new(surface))),
            ..Material::new("coated".into(), Phong::default())
        };
        assert_eq!((material.textures(), material.is_textured()), (vec![TextureId(3)], true));
    }

    #[test]
    fn whole_powers_agree_with_the_general_function() {
        for exponent in 0..200u32 {
            for base in [0.0, 0.1, 0.5, 0.999, 1.0] {
                let expected = transcendental::pow(base, f64::from(exponent));
                let computed = power(base, f64::from(exponent));
                assert!((computed - expected).abs() <= 1e-13 * expected, "{base}^{exponent}");
            }
        }
        assert_eq!(power(0.25, 0.5), 0.5);
    }

    #[test]
    fn highlights_peak_at_the_mirrored_direction() {
        let wo = DVec3::new(0.6, 0.8, 0.0);
        let mirrored = DVec3::new(-0.6, 0.8, 0.0);
        for highlight in [Highlight::Phong, Highlight::Blinn] {
            assert!((highlight.strength(DVec3::Y, wo, mirrored, 40.0) - 1.0).abs() < 1e-13);
            assert!(highlight.strength(DVec3::Y, wo, DVec3::Y, 40.0) < 0.2);
        }
        assert_eq!(Highlight::Phong.strength(DVec3::Y, wo, wo, 0.0), 1.0, "exponent 0 is flat");
        let grazing = Highlight::Phong.strength(DVec3::Y, DVec3::X, DVec3::X, 4.0);
        assert_eq!(grazing, 0.0, "facing away");
    }
}
