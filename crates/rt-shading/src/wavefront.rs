//! Parts of integrators whose stages read and write structures of arrays.

pub(crate) mod delta_lights;
pub(crate) mod gathered_shapes;
pub(crate) mod hit_points;
pub(crate) mod shaded_surface;
pub(crate) mod streams;
pub(crate) mod surface_points;
#[cfg(test)]
pub(crate) mod test_world;

use core::ops::RangeInclusive;
use rt_math::Rgb;

/// Components of colours that are not 0.
const COLOR_RANGE: RangeInclusive<f64> = 1e-12..=1e12;

/// Indices of refraction whose products with a few numbers are neither too large nor too small for `f32`.
pub(crate) const IOR_RANGE: RangeInclusive<f64> = 1e-3..=1e3;

/// True for a colour whose products with a few others are neither too large nor too small for `f32`.
pub(crate) fn is_in_range(color: Rgb) -> bool {
    color.to_array().iter().all(|c| *c == 0.0 || COLOR_RANGE.contains(c))
}
