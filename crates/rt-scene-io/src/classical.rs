//! The classical surfaces that come nearest to physical ones, for `whitted`.

use rt_shading::{Coefficient, Highlight, Phong};

/// Part of the ambient light that a diffuse surface shows.
pub(crate) const AMBIENT: f64 = 0.1;

/// How much a pane of glass mirrors when looked at straight.
pub(crate) const PANE_MIRROR: f64 = 0.08;

/// Nothing is seen of it.
pub(crate) const BARE: Phong = Phong {
    ambient: Coefficient::ZERO,
    diffuse: Coefficient::ZERO,
    specular: Coefficient::ZERO,
    exponent: 32.0,
    highlight: Highlight::Phong,
    emission: Coefficient::ZERO,
    mirror: Coefficient::ZERO,
    transmission: None,
};

/// A matte surface.
pub(crate) fn diffuse(albedo: Coefficient) -> Phong {
    Phong { ambient: scaled(albedo, AMBIENT), diffuse: albedo, ..BARE }
}

/// The smoother metal is, the more of its light is shown as mirrored, and the rest as diffuse.
pub(crate) fn metal(reflectance: Coefficient, roughness: f64) -> Phong {
    let smooth = (1.0 - 2.0 * roughness).max(0.0);
    Phong { mirror: scaled(reflectance, smooth), ..diffuse(scaled(reflectance, 1.0 - smooth)) }
}

/// The coefficient, everywhere so many times as great.
pub(crate) fn scaled(coefficient: Coefficient, by: f64) -> Coefficient {
    match coefficient {
        Coefficient::Constant(rgb) => Coefficient::Constant(rgb * by),
        Coefficient::Textured(id, rgb) => Coefficient::Textured(id, rgb * by),
    }
}
