//! Fill colours as Phong surfaces.
//!
//! ```text
//! diffuse      = Kd · colour
//! specular     = Ks with exponent Shine, the highlight of Phong
//! mirror       = Ks
//! transmission = T, refracted, constant as in Whitted's model
//! ```
//!
//! The format has no ambient light.

use rt_math::Rgb;
use rt_shading::{ColorTexture, Highlight, InteriorMedium, Phong, Transmission};

use crate::error::LineError;
use crate::text::tokenizer::Tokenizer;
use crate::{Material, limits};

/// The numbers of an `f` statement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fill {
    colour: [f64; 3],
    diffuse: f64,
    specular: f64,
    shine: f64,
    pub(super) transmittance: f64,
    ior: f64,
}

impl Fill {
    /// Reads the numbers after the keyword.
    pub(super) fn read(tokens: &mut Tokenizer<'_>) -> Result<Self, LineError> {
        let fill = Self {
            colour: tokens.color("a part of the fill colour")?,
            diffuse: tokens.non_negative("Kd")?,
            specular: tokens.non_negative("Ks")?,
            shine: tokens.non_negative("the shine")?,
            transmittance: tokens.non_negative("the transmittance")?,
            ior: f64::NAN,
        };
        let line = tokens.peek_word().map_or(0, |word| word.line);
        let ior = tokens.non_negative("the index of refraction")?;
        // Opaque surfaces may leave it at 0.
        if ior == 0.0 && fill.transmittance > 0.0 {
            return Err(LineError::new(
                line,
                ior,
                "is not an index of refraction of a transparent material: give at least 1",
            ));
        }
        Ok(Self { ior, ..fill })
    }

    /// Its numbers to the last bit, to find equal ones by.
    pub(super) fn key(&self) -> [u64; 8] {
        let [r, g, b] = self.colour;
        // 0 and −0 are the same number.
        [r, g, b, self.diffuse, self.specular, self.shine, self.transmittance, self.ior].map(|x| (x + 0.0).to_bits())
    }

    pub(super) fn material(&self, name: String) -> Material {
        let phong = self.phong();
        let interior = phong.transmission.map(|_| InteriorMedium::clear(self.ior));
        Material { interior, ..Material::new(name, phong) }
    }

    fn phong(&self) -> Phong {
        let constant = |rgb| ColorTexture::Constant(rgb);
        let ks = constant(Rgb::gray(self.specular));
        let transmission = Transmission { coefficient: constant(Rgb::gray(self.transmittance)), fresnel: false };
        Phong {
            ambient: ColorTexture::ZERO,
            diffuse: constant(Rgb::from(self.colour) * self.diffuse),
            specular: ks,
            exponent: self.shine.min(limits::HIGHLIGHT_EXPONENT),
            highlight: Highlight::Phong,
            mirror: ks,
            transmission: (self.transmittance > 0.0).then_some(transmission),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fill(text: &str) -> Result<Fill, String> {
        Fill::read(&mut Tokenizer::words(text)).map_err(|error| error.kind.to_string())
    }

    #[test]
    fn coefficients_follow_the_convention() {
        let material = fill("1 0.5 0 0.8 0.25 12 0.5 1.5").expect("a fill").material(String::new());
        let phong = material.to_phong();
        assert_eq!(phong.diffuse, ColorTexture::Constant(Rgb::new(0.8, 0.4, 0.0)));
        assert_eq!((phong.specular, phong.mirror), (ColorTexture::Constant(Rgb::gray(0.25)), phong.specular));
        assert_eq!((phong.exponent, phong.ambient), (12.0, ColorTexture::ZERO));
        let coefficient = phong.transmission.expect("glass").coefficient;
        assert_eq!(coefficient, ColorTexture::Constant(Rgb::gray(0.5)));
        assert_eq!(material.interior, Some(InteriorMedium::clear(1.5)));
        assert_eq!(fill("1 1 1 1 0 100000 0 0").expect("a fill").phong().transmission, None);
    }

    #[test]
    fn what_is_transparent_needs_an_index() {
        assert!(fill("1 1 1 1 0 1 0.5 0").unwrap_err().starts_with("0 is not an index of refraction"));
        assert!(fill("1 1 1 1 -1 1 0 1").unwrap_err().contains("Ks: -1 must not be negative"));
        assert!(fill("1 1 1 1").unwrap_err().contains("comes before Ks"));
    }
}
