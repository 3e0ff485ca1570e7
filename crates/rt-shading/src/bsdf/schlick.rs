//! Schlick's approximation of Fresnel's equations (1994).

/// Reflectance of a dielectric of index 1.5 at normal incidence.
const DIELECTRIC_F0: f64 = 0.04;

/// Reflectance of a dielectric of index 1.5.
pub(super) fn dielectric_fresnel(cos: f64) -> f64 {
    DIELECTRIC_F0 + (1.0 - DIELECTRIC_F0) * schlick_weight(cos)
}

/// (1 − cos)⁵.
pub(super) fn schlick_weight(cos: f64) -> f64 {
    let x = 1.0 - cos.clamp(0.0, 1.0);
    x * x * x * x * x
}
