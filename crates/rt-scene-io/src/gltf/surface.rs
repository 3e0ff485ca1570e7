//! The surfaces of glTF, and what comes nearest to them among Phong's.
//!
//! The classical model has no blurred reflections, so the light that a metal reflects is split: the smoother it is, the
//! more goes to the mirror, and the rest is shown as diffuse.
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
//! Real-Time Rendering, 4th ed., section 9.8), and the bound keeps a point light's highlight no brighter than the light.
//! Where textures say how rough or metallic a surface is, their mean is taken: under `path`, each point has its own.
//! Transmission becomes glass with Fresnel's equations; unlit surfaces emit their base colour.

use rt_math::{Rgb, transcendental};
use rt_shading::{
    ColorTexture, FloatTexture, Highlight, LayeredBase, LayeredSurface, Phong, Physical, Relief, TextureId,
    Transmission,
};

/// A texture times a colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ColorFactor {
    pub(super) texture: Option<TextureId>,
    pub(super) colour: Rgb,
}

impl ColorFactor {
    const fn plain(colour: Rgb) -> Self {
        Self { texture: None, colour }
    }

    fn scaled(self, by: f64) -> ColorTexture {
        let colour = self.colour * by;
        match self.texture {
            Some(texture) if !colour.is_black() => ColorTexture::Textured(texture, colour),
            _ => ColorTexture::Constant(colour),
        }
    }
}

/// A number that may vary, and its mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FloatFactor {
    pub(super) scalar: FloatTexture,
    pub(super) mean: f64,
}

impl FloatFactor {
    pub(super) const fn constant(value: f64) -> Self {
        Self { scalar: FloatTexture::Constant(value), mean: value }
    }
}

/// How the base is described.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Base {
    MetallicRoughness {
        color: ColorFactor,
        metallic: FloatFactor,
        roughness: FloatFactor,
    },
    SpecularGlossiness {
        /// What shows the surface if there is but one colour.
        color: ColorFactor,
        diffuse: ColorFactor,
        specular: ColorFactor,
        glossiness: FloatFactor,
        mean_specular: Rgb,
    },
}

/// The surface of a glTF material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GltfSurface {
    pub(super) base: Base,
    pub(super) emission: ColorFactor,
    /// Index of refraction; 0 for facets that reflect all light.
    pub(super) ior: f64,
    /// Strength and colour of the reflection of what is no metal.
    pub(super) specular: FloatFactor,
    pub(super) specular_color: ColorFactor,
    /// Share of the light that enters the surface and passes.
    pub(super) transmission: FloatFactor,
    /// Whether it passes a pane without thickness rather than a body.
    pub(super) is_thin: bool,
    /// White light that has gone so far in the body has this colour left.
    pub(super) attenuation: Option<(f64, Rgb)>,
    pub(super) dispersion: f64,
    pub(super) coat: FloatFactor,
    pub(super) coat_roughness: FloatFactor,
    pub(super) coat_relief: Option<Relief>,
    pub(super) sheen_color: ColorFactor,
    pub(super) sheen_roughness: FloatFactor,
    pub(super) anisotropy: FloatFactor,
    pub(super) anisotropy_rotation: f64,
    pub(super) anisotropy_direction: Option<TextureId>,
    pub(super) unlit: bool,
}

impl Default for GltfSurface {
    /// What the specification says where a file says nothing: a white, rough metal.
    fn default() -> Self {
        let none = FloatFactor::constant(0.0);
        let (color, full) = (ColorFactor::plain(Rgb::WHITE), FloatFactor::constant(1.0));
        Self {
            base: Base::MetallicRoughness { color, metallic: full, roughness: full },
            emission: ColorFactor::plain(Rgb::BLACK),
            ior: 1.5,
            specular: full,
            specular_color: color,
            transmission: none,
            is_thin: true,
            attenuation: None,
            dispersion: 0.0,
            coat: none,
            coat_roughness: none,
            coat_relief: None,
            sheen_color: ColorFactor::plain(Rgb::BLACK),
            sheen_roughness: none,
            anisotropy: none,
            anisotropy_rotation: 0.0,
            anisotropy_direction: None,
            unlit: false,
        }
    }
}

impl GltfSurface {
    /// Its colour, how metallic and how rough it is in the mean. Of diffuse and specular colours, what reflects more than 4 %
    /// is metal to that degree.
    fn plain(&self) -> (ColorFactor, f64, f64) {
        match self.base {
            Base::MetallicRoughness { color, metallic, roughness } => (color, metallic.mean, roughness.mean),
            Base::SpecularGlossiness { color, glossiness, mean_specular, .. } => {
                let metallic = ((mean_specular.max_component() - 0.04) / 0.96).clamp(0.0, 1.0);
                let color = match color.texture {
                    Some(_) => color,
                    None => ColorFactor::plain(color.colour * (1.0 - metallic) + mean_specular * metallic),
                };
                (color, metallic, 1.0 - glossiness.mean)
            }
        }
    }

    /// The classical surface that resembles it.
    pub(super) fn phong(&self) -> Phong {
        let (base, metallic, roughness) = self.plain();
        if self.unlit {
            let zero = ColorTexture::ZERO;
            return Phong { ambient: zero, diffuse: zero, emission: base.scaled(1.0), ..Phong::default() };
        }
        let transmission = self.transmission.mean * (1.0 - metallic);
        let smooth = (1.0 - 2.0 * roughness).max(0.0);
        let diffuse = (1.0 - metallic) - transmission + metallic * (1.0 - smooth);
        let exponent = exponent(roughness);
        let strength = (exponent + 8.0) / 8.0;
        let fresnel = if self.ior == 0.0 { 1.0 } else { (self.ior - 1.0) / (self.ior + 1.0) };
        let specular = self.specular_color.colour * self.specular.mean;
        let f0 = (specular * (fresnel * fresnel)).map(|f| f.min(1.0)).lerp(base.colour, metallic);
        let glass = Transmission {
            coefficient: base.scaled(transmission),
            ior: self.ior.max(1.0),
            fresnel: true,
            absorption: self.absorption(),
            priority: 0,
        };
        let is_glass = !glass.coefficient.is_zero();
        Phong {
            ambient: base.scaled(0.1 * diffuse),
            diffuse: base.scaled(diffuse),
            specular: ColorTexture::Constant(f0.map(|f| (1.0 - roughness) * (f * strength).min(1.0))),
            exponent,
            highlight: Highlight::Blinn,
            emission: self.emission.scaled(1.0),
            // Fresnel's equations weigh the mirror of glass.
            mirror: if is_glass { ColorTexture::Constant(Rgb::WHITE) } else { base.scaled(metallic * smooth) },
            transmission: is_glass.then_some(glass),
        }
    }

    /// Absorption per length: light falls to the colour of the attenuation in its distance (KHR_materials_volume).
    fn absorption(&self) -> Rgb {
        let Some((distance, color)) = self.attenuation.filter(|(distance, _)| *distance > 0.0) else {
            return Rgb::BLACK;
        };
        // Of black, next to nothing is left.
        color.map(|part| (-transcendental::log(part.max(1e-6)) / distance).max(0.0))
    }

    /// The surface as the specification and its extensions describe it.
    pub(super) fn physical(&self) -> Physical {
        if self.unlit {
            return Physical::Black;
        }
        let base = match self.base {
            Base::MetallicRoughness { color, metallic, roughness } => {
                if let Some((metallic, roughness)) = self.is_plain().then_some(()).and(constants(metallic, roughness)) {
                    return Physical::MetallicRoughness { base_color: color.scaled(1.0), metallic, roughness };
                }
                LayeredBase::MetallicRoughness {
                    base_color: color.scaled(1.0),
                    metallic: metallic.scalar,
                    roughness: roughness.scalar,
                }
            }
            Base::SpecularGlossiness { diffuse, specular, glossiness, .. } => LayeredBase::SpecularGlossiness {
                diffuse: diffuse.scaled(1.0),
                specular: specular.scaled(1.0),
                glossiness: glossiness.scalar,
            },
        };
        Physical::Layered(Box::new(LayeredSurface {
            ior: self.ior,
            specular: self.specular.scalar,
            specular_color: self.specular_color.scaled(1.0),
            transmission: self.transmission.scalar,
            is_thin: self.is_thin,
            dispersion: self.dispersion,
            coat: self.coat.scalar,
            coat_roughness: self.coat_roughness.scalar,
            coat_relief: self.coat_relief,
            sheen_color: self.sheen_color.scaled(1.0),
            sheen_roughness: self.sheen_roughness.scalar,
            anisotropy: self.anisotropy.scalar,
            anisotropy_rotation: self.anisotropy_rotation,
            anisotropy_direction: self.anisotropy_direction,
            ..LayeredSurface::new(base)
        }))
    }

    /// True if no extension adds to the base.
    fn is_plain(&self) -> bool {
        let plain = Self::default();
        let Self { base, emission, unlit, .. } = *self;
        *self == Self { base, emission, unlit, ..plain }
    }
}

/// The numbers that a plain base of these has everywhere.
fn constants(metallic: FloatFactor, roughness: FloatFactor) -> Option<(f64, f64)> {
    match (metallic.scalar, roughness.scalar) {
        (FloatTexture::Constant(metallic), FloatTexture::Constant(roughness)) => Some((metallic, roughness)),
        _ => None,
    }
}

/// Exponent of the Blinn–Phong lobe as wide as Beckmann's for this roughness, at most 10⁷.
fn exponent(roughness: f64) -> f64 {
    let alpha = roughness * roughness;
    (2.0 / (alpha * alpha) - 2.0).min(1e7)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(metallic: f64, roughness: f64) -> GltfSurface {
        let color = ColorFactor::plain(Rgb::new(0.8, 0.4, 0.2));
        let (metallic, roughness) = (FloatFactor::constant(metallic), FloatFactor::constant(roughness));
        GltfSurface { base: Base::MetallicRoughness { color, metallic, roughness }, ..GltfSurface::default() }
    }

    fn red(coefficient: ColorTexture) -> f64 {
        match coefficient {
            ColorTexture::Constant(rgb) | ColorTexture::Textured(_, rgb) => rgb.r,
        }
    }

    #[test]
    fn plastics_keep_their_colour_and_gain_a_highlight() {
        let plastic = surface(0.0, 0.5).phong();
        assert_eq!((red(plastic.diffuse), red(plastic.mirror)), (0.8, 0.0));
        assert_eq!(plastic.exponent, 30.0);
        assert!((red(plastic.specular) - 0.5 * 0.04 * 38.0 / 8.0).abs() < 1e-12);
    }

    #[test]
    fn the_light_of_metals_moves_from_diffuse_to_mirror_as_they_get_smooth() {
        let parts = |roughness| {
            let phong = surface(1.0, roughness).phong();
            (red(phong.diffuse), red(phong.mirror))
        };
        assert_eq!([parts(0.0), parts(0.25), parts(1.0)], [(0.0, 0.8), (0.4, 0.4), (0.8, 0.0)]);
        assert_eq!(red(surface(1.0, 1.0).phong().specular), 0.0);
    }

    #[test]
    fn extreme_values_stay_finite() {
        for roughness in [0.0, 1e-9, 1.0] {
            let phong = surface(0.5, roughness).phong();
            assert!(phong.exponent >= 0.0 && phong.exponent <= 1e7);
            assert!((0.0..=1.0).contains(&red(phong.specular)), "{phong:?}");
        }
    }

    #[test]
    fn glass_and_unlit() {
        let glass = GltfSurface { transmission: FloatFactor::constant(1.0), ior: 1.3, ..surface(0.0, 0.0) };
        let phong = glass.phong();
        assert!(phong.diffuse.is_zero());
        let transmission = phong.transmission.expect("light passes");
        assert_eq!((transmission.ior, transmission.fresnel, red(phong.mirror)), (1.3, true, 1.0));
        assert!(!glass.physical().encloses_body(), "a pane, unless it has a volume");
        let unlit = GltfSurface { unlit: true, ..surface(0.0, 0.5) };
        assert!(unlit.phong().diffuse.is_zero() && unlit.phong().ambient.is_zero());
        assert_eq!(red(unlit.phong().emission), 0.8);
        assert_eq!(unlit.physical(), Physical::Black);
    }

    #[test]
    fn bodies_absorb_what_their_colour_says() {
        let attenuation = Some((2.0, Rgb::new(1.0, 0.5, 0.0)));
        let transmission = FloatFactor::constant(1.0);
        let glass = GltfSurface { transmission, is_thin: false, attenuation, ..surface(0.0, 0.0) };
        let absorption = glass.phong().transmission.expect("light passes").absorption;
        let left = absorption.map(|a| transcendental::exp(-2.0 * a));
        assert!((left.r - 1.0).abs() < 1e-12 && (left.g - 0.5).abs() < 1e-12 && left.b < 1e-5, "{left:?}");
        assert!(glass.physical().encloses_body());
    }

    #[test]
    fn plain_surfaces_stay_plain() {
        assert!(matches!(surface(0.5, 0.5).physical(), Physical::MetallicRoughness { .. }));
        let coated = GltfSurface { coat: FloatFactor::constant(0.5), ..surface(0.5, 0.5) };
        assert!(matches!(coated.physical(), Physical::Layered(_)));
    }

    #[test]
    fn specular_glossiness_as_one_colour() {
        let of = |diffuse: f64, specular: Rgb, glossiness: f64| {
            let (color, glossiness) = (ColorFactor::plain(Rgb::gray(diffuse)), FloatFactor::constant(glossiness));
            let specular_tint = ColorFactor::plain(specular);
            let base = Base::SpecularGlossiness {
                color,
                diffuse: color,
                specular: specular_tint,
                glossiness,
                mean_specular: specular,
            };
            GltfSurface { base, ..GltfSurface::default() }.plain()
        };
        let (color, metallic, roughness) = of(0.5, Rgb::gray(0.04), 0.75);
        assert_eq!((color.colour, metallic, roughness), (Rgb::gray(0.5), 0.0, 0.25));
        let gold = of(0.0, Rgb::new(1.0, 0.8, 0.3), 1.0);
        assert_eq!((gold.1, gold.0.colour), (1.0, Rgb::new(1.0, 0.8, 0.3)));
    }
}
