//! Phong surfaces that resemble physical ones, for the `whitted` integrator.

use rt_math::Rgb;
use rt_shading::{ColorTexture, Highlight, Phong, Transmission};

/// Share of the diffuse coefficient that ambient light is multiplied by.
pub(crate) const AMBIENT: f64 = 0.1;

/// Reflectance of a thin dielectric at normal incidence: about 4 % per side.
const THIN_REFLECTANCE: f64 = 0.08;

/// A surface that neither emits nor scatters.
pub(crate) const BLACK: Phong = Phong {
    ambient: ColorTexture::ZERO,
    diffuse: ColorTexture::ZERO,
    specular: ColorTexture::ZERO,
    exponent: 32.0,
    highlight: Highlight::Phong,
    emission: ColorTexture::ZERO,
    mirror: ColorTexture::ZERO,
    transmission: None,
};

/// A diffuse surface.
pub(crate) fn diffuse(albedo: ColorTexture) -> Phong {
    Phong { ambient: scaled(albedo, AMBIENT), diffuse: albedo, ..BLACK }
}

/// A metal: the smoother, the more of its reflectance is mirrored; the rest is diffuse.
pub(crate) fn metal(reflectance: ColorTexture, roughness: f64) -> Phong {
    let smooth = (1.0 - 2.0 * roughness).max(0.0);
    Phong { mirror: scaled(reflectance, smooth), ..diffuse(scaled(reflectance, 1.0 - smooth)) }
}

/// The surface of a dielectric body.
pub(crate) fn dielectric(ior: f64, transmittance: ColorTexture, absorption: Rgb, priority: i32) -> Phong {
    let inside = Transmission { coefficient: transmittance, ior, fresnel: true, absorption, priority };
    Phong { mirror: ColorTexture::Constant(Rgb::WHITE), transmission: Some(inside), ..BLACK }
}

/// A pane without thickness, which does not refract.
pub(crate) fn thin_dielectric(transmittance: ColorTexture) -> Phong {
    let air =
        Transmission { coefficient: transmittance, ior: 1.0, fresnel: false, absorption: Rgb::BLACK, priority: 0 };
    Phong { mirror: ColorTexture::Constant(Rgb::gray(THIN_REFLECTANCE)), transmission: Some(air), ..BLACK }
}

/// Product of a coefficient and a number.
pub(crate) fn scaled(coefficient: ColorTexture, by: f64) -> ColorTexture {
    match coefficient {
        ColorTexture::Constant(rgb) => ColorTexture::Constant(rgb * by),
        ColorTexture::Textured(id, rgb) => ColorTexture::Textured(id, rgb * by),
    }
}
