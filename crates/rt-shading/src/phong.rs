//! The reflection model of Phong and Whitted.

use crate::ColorTexture;
use rt_math::{DVec3, Mask, Real, Rgb, Vector3, transcendental::Pow};

/// Shape of the specular highlight.
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
        self.strength_lanes(normal.into(), wo.into(), wi.into(), exponent)
    }

    /// Version of [`strength`](Self::strength) for several surfaces of the same exponent, one per lane.
    #[inline(always)]
    pub(crate) fn strength_lanes<R: Pow>(self, normal: Vector3<R>, wo: Vector3<R>, wi: Vector3<R>, exponent: f64) -> R {
        let cosine = match self {
            Self::Phong => (normal * (normal.dot(wi) * 2.0) - wi).dot(wo),
            Self::Blinn => normal.dot(normalize_or_zero(wi + wo)),
        };
        let zero = cosine.splat(0.0);
        let is_visible = cosine.gt(zero);
        if !is_visible.any() {
            return zero;
        }
        R::select(is_visible, power(cosine, exponent), zero)
    }
}

/// Unit vector of the same direction, as [`DVec3::normalize_or_zero`].
#[inline(always)]
fn normalize_or_zero<R: Real>(v: Vector3<R>) -> Vector3<R> {
    let (unit, has_direction) = v.try_normalize();
    Vector3::select(has_direction, unit, Vector3::splat(v.x, DVec3::ZERO))
}

/// `base` to the power of `exponent >= 0`. Integer exponents up to 1024 use repeated squaring, which is several times
/// faster than the general function.
#[inline(always)]
fn power<R: Pow>(base: R, exponent: f64) -> R {
    const MAX_INTEGER: f64 = 1024.0;
    // The conversion truncates.
    let mut remaining = exponent as u32;
    if !(exponent <= MAX_INTEGER && f64::from(remaining) == exponent) {
        return base.powf(exponent);
    }
    let (mut square, mut product) = (base, base.splat(1.0));
    while remaining > 0 {
        if remaining & 1 == 1 {
            product = product * square;
        }
        square = square * square;
        remaining >>= 1;
    }
    product
}

/// Specular transmission of a Phong surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission {
    /// Factor of the transmitted light.
    pub coefficient: ColorTexture,
    /// True if Fresnel's equations split the light between `mirror` and this coefficient.
    ///
    /// Otherwise both are constant and totally reflected light is dropped, as in Whitted's model.
    pub fresnel: bool,
}

/// The reflection model of Phong and Whitted.
///
/// Under `whitted`, radiance = emission + ambient · ambient light + Σ lights (diffuse · cos θ + specular · highlight)
/// · intensity + mirror · reflected + transmission · refracted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// Ambient coefficient.
    pub ambient: ColorTexture,
    /// Diffuse coefficient.
    pub diffuse: ColorTexture,
    /// Strength of the highlight.
    pub specular: ColorTexture,
    /// Exponent of the highlight, at least 0.
    pub exponent: f64,
    /// Shape of the highlight.
    pub highlight: Highlight,
    /// Coefficient of mirrored light.
    pub mirror: ColorTexture,
    /// Transmission, if any. The index of refraction is that of the material's interior medium.
    pub transmission: Option<Transmission>,
}

impl Phong {
    /// A surface that scatters no light.
    pub const BLACK: Self = Self {
        ambient: ColorTexture::ZERO,
        diffuse: ColorTexture::ZERO,
        specular: ColorTexture::ZERO,
        exponent: 32.0,
        highlight: Highlight::Phong,
        mirror: ColorTexture::ZERO,
        transmission: None,
    };

    /// Ambient coefficient divided by the diffuse one, where only the albedo is known.
    const AMBIENT: f64 = 0.1;

    /// A diffuse surface, with a tenth of its albedo as ambient coefficient.
    pub fn lambertian(albedo: ColorTexture) -> Self {
        Self { ambient: albedo.scaled(Self::AMBIENT), diffuse: albedo, ..Self::BLACK }
    }

    /// True if an index-matched interface of this surface is invisible.
    ///
    /// Without Fresnel's equations, the mirror and the highlight are constants, which stay visible.
    pub fn is_clear(&self) -> bool {
        let is_zero = |coefficients: &[ColorTexture]| coefficients.iter().all(ColorTexture::is_zero);
        self.transmission.is_some_and(|transmission| {
            transmission.coefficient == ColorTexture::Constant(Rgb::WHITE)
                && is_zero(&[self.ambient, self.diffuse])
                && (transmission.fresnel || is_zero(&[self.specular, self.mirror]))
        })
    }

    /// Coefficients, which may be textured.
    pub fn color_textures_mut(&mut self) -> Vec<&mut ColorTexture> {
        let transmission = self.transmission.as_mut().map(|transmission| &mut transmission.coefficient);
        let coefficients = [&mut self.ambient, &mut self.diffuse, &mut self.specular, &mut self.mirror];
        coefficients.into_iter().chain(transmission).collect()
    }
}

impl Default for Phong {
    /// A grey diffuse surface with a little ambient light.
    fn default() -> Self {
        Self {
            ambient: ColorTexture::Constant(Rgb::gray(0.07)),
            diffuse: ColorTexture::Constant(Rgb::gray(0.7)),
            ..Self::BLACK
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integer_powers_equal_the_general_function() {
        for exponent in 0..200u32 {
            for base in [0.0, 0.1, 0.5, 0.999, 1.0] {
                let expected = rt_math::transcendental::pow(base, f64::from(exponent));
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
