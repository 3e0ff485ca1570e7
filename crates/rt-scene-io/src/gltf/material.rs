//! Metallic-roughness and specular-glossiness as Phong surfaces.
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
//! Transmission becomes glass with Fresnel's equations; unlit surfaces emit their base colour.

use rt_math::Rgb;
use rt_shading::{Coefficient, Highlight, Phong, Physical, TextureId, Transmission};

/// A texture times a colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tint {
    pub(super) texture: Option<TextureId>,
    pub(super) colour: Rgb,
}

impl Tint {
    fn scaled(self, by: f64) -> Coefficient {
        let colour = self.colour * by;
        match self.texture {
            Some(texture) if !colour.is_black() => Coefficient::Textured(texture, colour),
            _ => Coefficient::Constant(colour),
        }
    }
}

/// The surface of a glTF material, as far as it is followed. Textures of metalness and roughness are taken at their
/// mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Surface {
    pub(super) base: Tint,
    pub(super) emission: Tint,
    pub(super) metallic: f64,
    pub(super) roughness: f64,
    /// Index of refraction; above 0.
    pub(super) ior: f64,
    /// Tint of the reflection of what is no metal.
    pub(super) specular: Rgb,
    /// Share of the light that enters the surface and passes.
    pub(super) transmission: f64,
    pub(super) unlit: bool,
}

impl Surface {
    /// The classical surface that resembles it.
    pub(super) fn phong(&self) -> Phong {
        if self.unlit {
            let zero = Coefficient::ZERO;
            return Phong { ambient: zero, diffuse: zero, emission: self.base.scaled(1.0), ..Phong::default() };
        }
        let (metallic, roughness) = (self.metallic.clamp(0.0, 1.0), self.roughness.clamp(0.0, 1.0));
        let transmission = self.transmission.clamp(0.0, 1.0) * (1.0 - metallic);
        let smooth = (1.0 - 2.0 * roughness).max(0.0);
        let diffuse = (1.0 - metallic) - transmission + metallic * (1.0 - smooth);
        let exponent = exponent(roughness);
        let strength = (exponent + 8.0) / 8.0;
        let fresnel = (self.ior - 1.0) / (self.ior + 1.0);
        let f0 = (self.specular * (fresnel * fresnel)).map(|f| f.min(1.0)).lerp(self.base.colour, metallic);
        let glass = Transmission {
            coefficient: self.base.scaled(transmission),
            ior: self.ior,
            fresnel: true,
            absorption: Rgb::BLACK,
            priority: 0,
        };
        let is_glass = !glass.coefficient.is_zero();
        Phong {
            ambient: self.base.scaled(0.1 * diffuse),
            diffuse: self.base.scaled(diffuse),
            specular: Coefficient::Constant(f0.map(|f| (1.0 - roughness) * (f * strength).min(1.0))),
            exponent,
            highlight: Highlight::Blinn,
            emission: self.emission.scaled(1.0),
            // Fresnel's equations weigh the mirror of glass.
            mirror: if is_glass { Coefficient::Constant(Rgb::WHITE) } else { self.base.scaled(metallic * smooth) },
            transmission: is_glass.then_some(glass),
        }
    }

    /// The surface as the specification describes it. What transmits is glass to that degree.
    pub(super) fn physical(&self) -> Physical {
        if self.unlit {
            return Physical::Black;
        }
        let (metallic, roughness) = (self.metallic.clamp(0.0, 1.0), self.roughness.clamp(0.0, 1.0));
        let opaque = Physical::MetallicRoughness { base_color: self.base.scaled(1.0), metallic, roughness };
        let transmission = self.transmission.clamp(0.0, 1.0) * (1.0 - metallic);
        let glass = Physical::Dielectric { roughness, transmittance: self.base.scaled(1.0) };
        match transmission {
            0.0 => opaque,
            1.0 => glass,
            _ => Physical::Mix(vec![(1.0 - transmission, opaque), (transmission, glass)]),
        }
    }

    /// Takes over the specular-glossiness model: diffuse colour, colour of the specular reflection, and glossiness.
    /// What reflects more than 4 % becomes metal to that degree.
    pub(super) fn with_specular_glossiness(self, diffuse: Tint, specular: Rgb, glossiness: f64) -> Self {
        let metallic = ((specular.max_component() - 0.04) / 0.96).clamp(0.0, 1.0);
        let base = match diffuse.texture {
            // The texture shows where the surface is no metal; there is but one texture to multiply.
            Some(_) => diffuse,
            None => Tint { texture: None, colour: diffuse.colour * (1.0 - metallic) + specular * metallic },
        };
        Self { base, metallic, roughness: 1.0 - glossiness, ..self }
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

    /// What the specification says where a file says nothing: a white, rough metal.
    const WHITE_METAL: Surface = Surface {
        base: Tint { texture: None, colour: Rgb::WHITE },
        emission: Tint { texture: None, colour: Rgb::BLACK },
        metallic: 1.0,
        roughness: 1.0,
        ior: 1.5,
        specular: Rgb::WHITE,
        transmission: 0.0,
        unlit: false,
    };

    fn surface(metallic: f64, roughness: f64) -> Phong {
        let base = Tint { texture: None, colour: Rgb::new(0.8, 0.4, 0.2) };
        Surface { base, metallic, roughness, ..WHITE_METAL }.phong()
    }

    fn red(coefficient: Coefficient) -> f64 {
        match coefficient {
            Coefficient::Constant(rgb) | Coefficient::Textured(_, rgb) => rgb.r,
        }
    }

    #[test]
    fn plastics_keep_their_colour_and_gain_a_highlight() {
        let plastic = surface(0.0, 0.5);
        assert_eq!((red(plastic.diffuse), red(plastic.mirror)), (0.8, 0.0));
        assert_eq!(plastic.exponent, 30.0);
        assert!((red(plastic.specular) - 0.5 * 0.04 * 38.0 / 8.0).abs() < 1e-12);
    }

    #[test]
    fn the_light_of_metals_moves_from_diffuse_to_mirror_as_they_get_smooth() {
        assert_eq!((red(surface(1.0, 0.0).diffuse), red(surface(1.0, 0.0).mirror)), (0.0, 0.8));
        assert_eq!((red(surface(1.0, 0.25).diffuse), red(surface(1.0, 0.25).mirror)), (0.4, 0.4));
        assert_eq!((red(surface(1.0, 1.0).diffuse), red(surface(1.0, 1.0).mirror)), (0.8, 0.0));
        assert_eq!(red(surface(1.0, 1.0).specular), 0.0);
    }

    #[test]
    fn extreme_values_stay_finite() {
        for roughness in [0.0, 1e-9, 1.0, 7.0, -1.0] {
            let phong = surface(0.5, roughness);
            assert!(phong.exponent >= 0.0 && phong.exponent <= 1e7);
            assert!((0.0..=1.0).contains(&red(phong.specular)), "{phong:?}");
        }
    }

    #[test]
    fn glass_and_unlit() {
        let glass = Surface { transmission: 1.0, metallic: 0.0, ior: 1.3, ..WHITE_METAL }.phong();
        assert!(glass.diffuse.is_zero());
        let transmission = glass.transmission.expect("light passes");
        assert_eq!((transmission.ior, transmission.fresnel, red(glass.mirror)), (1.3, true, 1.0));
        let unlit = Surface { unlit: true, ..WHITE_METAL }.phong();
        assert!(unlit.diffuse.is_zero() && unlit.ambient.is_zero());
        assert_eq!(unlit.emission, Coefficient::Constant(Rgb::WHITE));
    }

    #[test]
    fn specular_glossiness() {
        let gray = |value: f64| Tint { texture: None, colour: Rgb::gray(value) };
        let plastic = WHITE_METAL.with_specular_glossiness(gray(0.5), Rgb::gray(0.04), 0.75);
        assert_eq!((plastic.metallic, plastic.roughness, plastic.base), (0.0, 0.25, gray(0.5)));
        let gold = WHITE_METAL.with_specular_glossiness(gray(0.0), Rgb::new(1.0, 0.8, 0.3), 1.0);
        assert_eq!((gold.metallic, gold.base.colour), (1.0, Rgb::new(1.0, 0.8, 0.3)));
    }
}
