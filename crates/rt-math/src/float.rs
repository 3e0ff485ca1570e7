//! Rounding: error bounds and products whose sign is exact.

use crate::Real;
use glam::DVec3;

/// Unit roundoff of `f64`: half the distance from 1 to the next number.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// Bound on the relative error of `n` roundings in a row: `n·u / (1 − n·u)` (Higham 2002, lemma 3.1).
pub const fn gamma(n: u32) -> f64 {
    let nu = n as f64 * UNIT_ROUNDOFF;
    nu / (1.0 - nu)
}

/// `a·b` as the unevaluated sum of the rounded product and its exact error.
///
/// Dekker's product with Veltkamp's splitting (Dekker 1971): the bits of a fused multiply-add, on any processor.
/// Exact while nothing over- or underflows.
#[inline]
pub fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let (a_high, a_low) = split(a);
    let (b_high, b_low) = split(b);
    (product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low)
}

/// `a + b` as the unevaluated sum of the rounded sum and its exact error.
///
/// Knuth, "The Art of Computer Programming", volume 2, 4.2.2, theorem B. Exact while nothing overflows.
#[inline(always)]
pub fn two_sum<R: Real>(a: R, b: R) -> (R, R) {
    let sum = a + b;
    let from_b = sum - a;
    (sum, (a - (sum - from_b)) + (b - from_b))
}

/// Halves of 26 bits that add up to `a`.
#[inline]
fn split(a: f64) -> (f64, f64) {
    const FACTOR: f64 = ((1u64 << 27) + 1) as f64;
    let c = FACTOR * a;
    let high = c - (c - a);
    (high, a - high)
}

/// `a·b − c·d` with the exact sign, and 0 only when it is exactly 0.
///
/// Uses the plain expression where its error bound proves the sign; otherwise Kahan's algorithm (Jeannerod, Louvet,
/// Muller 2013: relative error at most 2u). Assumes no over- and underflow.
#[inline]
pub fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let (ab, cd) = (a * b, c * d);
    let plain = ab - cd;
    if is_sign_certain(plain, ab, cd) {
        return plain;
    }
    let (cd, cd_error) = two_product(c, d);
    let (ab, ab_error) = two_product(a, b);
    (ab - cd) + (ab_error - cd_error)
}

/// Bound relative to the sum of magnitudes, above which the rounded difference of two rounded products has the exact
/// sign. Each product has a relative error of at most u, and so has the difference.
const SIGN_ERROR_BOUND: f64 = 4.0 * UNIT_ROUNDOFF;

/// True if the rounded difference of two rounded products has the exact sign.
#[inline(always)]
fn is_sign_certain(difference: f64, minuend: f64, subtrahend: f64) -> bool {
    difference.abs() > (minuend.abs() + subtrahend.abs()) * SIGN_ERROR_BOUND
}

/// `a × b` with [`difference_of_products`] in each component.
#[inline(always)]
pub fn cross(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(
        difference_of_products(a.y, b.z, a.z, b.y),
        difference_of_products(a.z, b.x, a.x, b.z),
        difference_of_products(a.x, b.y, a.y, b.x),
    )
}

/// Power of two that scales a direction whose square may over- or underflow to a length near 1; 1 for directions of
/// ordinary length. A parameter `t` along the scaled direction is `t` times the factor along the direction itself.
#[inline]
pub fn power_of_two_scale(direction: DVec3) -> f64 {
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
    use crate::transcendental::exp2;
    use proptest::prelude::*;

    #[test]
    fn rescaled_lengths_come_near_one() {
        for k in -1022..=1023i32 {
            let direction = DVec3::new(exp2(f64::from(k)), 0.0, -0.75 * exp2(f64::from(k)));
            let scaled = direction * power_of_two_scale(direction);
            if k.abs() > 200 {
                assert!((1.0..=4.0).contains(&scaled.x), "2^{k}: {scaled}");
            } else if k.abs() < 199 {
                assert_eq!(scaled, direction);
            }
        }
        assert!(power_of_two_scale(DVec3::splat(5e-324)) * 5e-324 > 1e-17);
        for useless in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert!(power_of_two_scale(useless).is_finite());
        }
    }

    proptest! {
        #[test]
        fn two_product_is_a_fused_multiply_add(a in -1e100..1e100f64, b in -1e100..1e100f64) {
            let (product, error) = two_product(a, b);
            prop_assert_eq!(error, a.mul_add(b, -product));
        }

        /// Sums of 64-bit integers, which `i128` checks.
        #[test]
        fn two_sum_loses_nothing(a in any::<i64>(), b in any::<i64>(), shift in 0u32..60) {
            let (a, b) = (a as f64, (b >> shift) as f64);
            let (sum, error) = two_sum(a, b);
            prop_assert_eq!(sum, a + b);
            prop_assert_eq!(sum as i128 + error as i128, a as i128 + b as i128);
        }

        /// 26-bit integers have exact 52-bit products, which `i128` checks.
        #[test]
        fn sign_of_a_difference_of_products_is_exact(a in any::<i64>(), b in any::<i64>(), j in -2i64..3, k in -2i64..3) {
            let (a, b) = (a >> 12, b >> 12);
            let (c, d) = (a + j, b + k);
            let exact = i128::from(a) * i128::from(b) - i128::from(c) * i128::from(d);
            let computed = difference_of_products(a as f64, b as f64, c as f64, d as f64);
            prop_assert_eq!(exact.signum(), computed.partial_cmp(&0.0).map_or(9, |o| o as i128));
        }
    }

    #[test]
    fn gamma_bounds_chains_of_roundings() {
        assert_eq!(gamma(1), UNIT_ROUNDOFF / (1.0 - UNIT_ROUNDOFF));
        assert!(gamma(3) > 3.0 * UNIT_ROUNDOFF);
    }
}
