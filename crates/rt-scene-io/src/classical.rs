//! The classical surfaces that come nearest to physical ones, for `whitted`.

use rt_shading::{ColorTexture, Highlight, Phong};

/// Part of the ambient light that a diffuse surface shows.
pub(crate) const AMBIENT: f64 = 0.1;

/// How much a pane of glass mirrors when looked at straight.
pub(crate) const PANE_MIRROR: f64 = 0.08;

/// Nothing is seen of it.
pub(crate) const BARE: Phong = Phong {
    ambient: ColorTexture::ZERO,
    diffuse: ColorTexture::ZERO,
    specular: ColorTexture::ZERO,
    exponent: 32.0,
    highlight: Highlight::Phong,
    emission: ColorTexture::ZERO,
    mirror: ColorTexture::ZERO,
    transmission: None,
};

/// A matte surface.
pub(crate) fn diffuse(albedo: ColorTexture) -> Phong {
    Phong { ambient: scaled(albedo, AMBIENT), diffuse: albedo, ..BARE }
}

/// The smoother metal is, the more of its light is shown as mirrored, and the rest as diffuse.
pub(crate) fn metal(reflectance: ColorTexture, roughness: f64) -> Phong {
    let smooth = (1.0 - 2.0 * roughness).max(0.0);
    Phong { mirror: scaled(reflectance, smooth), ..diffuse(scaled(reflectance, 1.0 - smooth)) }
}

/// The coefficient, everywhere so many times as great.
pub(crate) fn scaled(coefficient: ColorTexture, by: f64) -> ColorTexture {
    match coefficient {
        ColorTexture::Constant(rgb) => ColorTexture::Constant(rgb * by),
        ColorTexture::Textured(id, rgb) => ColorTexture::Textured(id, rgb * by),
    }
}
