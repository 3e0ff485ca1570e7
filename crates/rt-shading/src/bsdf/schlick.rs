//! Schlick's approximation of Fresnel's equations (1994).

use rt_math::Real;

/// Reflectance of a dielectric of index 1.5 at normal incidence.
const DIELECTRIC_F0: f64 = 0.04;

/// Reflectance of a dielectric of index 1.5, for one number or for lanes.
#[inline(always)]
pub(super) fn dielectric_fresnel<R: Real>(cos: R) -> R {
    schlick_weight(cos) * (1.0 - DIELECTRIC_F0) + DIELECTRIC_F0
}

/// (1 − cos)⁵, for one number or for lanes.
#[inline(always)]
pub(super) fn schlick_weight<R: Real>(cos: R) -> R {
    let (zero, one) = (cos.splat(0.0), cos.splat(1.0));
    let x = one - cos.max(zero).min(one);
    x * x * x * x * x
}
