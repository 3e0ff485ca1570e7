//! Multiple importance sampling (MIS): weights of two sampling techniques (Veach, Guibas 1995).
//!
//! ```text
//!   light samples   w = p(light)² / (p(light)² + p(BSDF)²)          f · L · cos / p(light) · w
//!   BSDF samples    w = p(BSDF)²  / (p(light)² + p(BSDF)²)          f · L · cos / p(BSDF)  · w
//! ```
//!
//! Both densities are per unit solid angle. The weights of a direction sum to 1. Delta lights and specular lobes are found by
//! one technique only; their weight is 1.

use crate::SurfaceHit;
use rt_math::Real;

/// MIS weight by the power heuristic with exponent 2, of a direction sampled with density `pdf`; `other_pdf` is the density of
/// the other technique.
#[inline(always)]
pub(crate) fn power_heuristic<R: Real>(pdf: R, other_pdf: R) -> R {
    // The quotient does not overflow where squares do.
    let ratio = other_pdf / pdf;
    (ratio * ratio + 1.0).recip()
}

/// Density of a sampled direction that light sampling cannot find: so large that its MIS weight is 1.
pub(crate) const PDF_OF_WEIGHT_ONE: f64 = f32::MAX as f64;

/// Density with which a BSDF has sampled a direction, for the lights that a path finds behind a null interface. Shadow rays end at the
/// interface, unless its object casts no shadow. Light sampling then does not compete. The density of a delta lobe stays 0.
pub(crate) fn pdf_behind(interface: &SurfaceHit, pdf: f64) -> f64 {
    if interface.casts_shadow && pdf > 0.0 { PDF_OF_WEIGHT_ONE } else { pdf }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_both_techniques_sum_to_one() {
        for (a, b) in [(1.0, 1.0), (0.25, 4.0), (1e-200, 3e-200), (1e200, 1e199), (7.0, 0.0)] {
            let sum = power_heuristic(a, b) + if b > 0.0 { power_heuristic(b, a) } else { 0.0 };
            assert!((sum - 1.0).abs() < 1e-15, "{a}, {b}: {sum}");
        }
        assert_eq!((power_heuristic(2.0, 0.0), power_heuristic(3.0, 4.0)), (1.0, 9.0 / 25.0));
    }
}
