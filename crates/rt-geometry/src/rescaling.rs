//! Directions of any length.

use rt_math::DVec3;

/// A power of two, exact to multiply with, that brings a direction whose square may leave the range of `f64` to a length
/// near 1, and 1 for all directions of ordinary length: what is `t` along the direction times this factor is `t` times
/// the factor along the direction itself.
#[inline]
pub(crate) fn rescaling(direction: DVec3) -> f64 {
    let size = direction.abs().max_element();
    if (1e-60..=1e60).contains(&size) || !size.is_finite() {
        return 1.0;
    }
    // Biased exponents: of the factor, such that both add up to those of 1 · 1.
    let exponent = (size.to_bits() >> 52).clamp(1, 2045);
    f64::from_bits((2046 - exponent) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::transcendental::exp2;

    #[test]
    fn lengths_come_near_one() {
        for k in -1022..=1023i32 {
            let direction = DVec3::new(exp2(f64::from(k)), 0.0, -0.75 * exp2(f64::from(k)));
            let scaled = direction * rescaling(direction);
            if k.abs() > 200 {
                assert!((1.0..=4.0).contains(&scaled.x), "2^{k}: {scaled}");
            } else if k.abs() < 199 {
                assert_eq!(scaled, direction);
            }
        }
        assert!(rescaling(DVec3::splat(5e-324)) * 5e-324 > 1e-17);
        for useless in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert!(rescaling(useless).is_finite());
        }
    }
}
