//! `sample` returns the same values as `eval` and `pdf`.

use super::*;

/// Relative difference, where the smaller of two numbers may be 0.
fn difference(a: f64, b: f64) -> f64 {
    (a - b).abs() / a.abs().max(b.abs()).max(f64::MIN_POSITIVE)
}

#[test]
fn samples_carry_what_eval_and_pdf_give() {
    for Surface { name, bsdf } in surfaces().into_iter().chain(leaning()) {
        let mut taken = 0;
        for (at, degrees) in ANGLES.into_iter().chain([120.0, 170.0]).enumerate() {
            let wo = at_angle(degrees, 0.7);
            for index in 0..500 {
                let Some(sample) = bsdf.sample(wo, numbers(at as u64, index)) else { continue };
                taken += 1;
                let is_same_side = sample.wi.z * wo.z > 0.0;
                assert_eq!(is_same_side, sample.kind == Scattering::Reflection, "{name} at {degrees}°");
                assert!((sample.wi.length() - 1.0).abs() < 1e-12, "{name} at {degrees}°: {}", sample.wi.length());
                assert!(is_same_side || bsdf.transmits(), "{name}");
                if sample.is_delta {
                    continue;
                }
                assert!(!bsdf.is_delta(), "{name}");
                // The half vector has an error of about 1e-16. Lobes of width 0.0025 multiply it by 400, and refraction by an
                // index of 1.01 by another 100.
                let (value, pdf) = bsdf.eval_with_pdf(wo, sample.wi);
                assert!(difference(pdf, sample.pdf) < 1e-9, "{name} at {degrees}°: {pdf} {}", sample.pdf);
                for (a, b) in value.to_array().into_iter().zip(sample.value.to_array()) {
                    assert!(difference(a, b) < 1e-9, "{name} at {degrees}°: {a} {b}");
                }
            }
        }
        assert!(taken > 1000, "{name}: {taken}");
    }
}

#[test]
fn delta_lobes_have_no_value_and_no_density() {
    for Surface { name, bsdf } in surfaces().into_iter().filter(|surface| surface.bsdf.is_delta()) {
        let wo = at_angle(30.0, 0.0);
        let sample = bsdf.sample(wo, [0.99, 0.5, 0.5]).expect("scatters");
        assert!(sample.is_delta, "{name}");
        assert_eq!((bsdf.eval(wo, sample.wi), bsdf.pdf(wo, sample.wi)), (Rgb::BLACK, 0.0), "{name}");
    }
}

#[test]
fn a_clearcoat_reflects_by_its_own_normal() {
    let [Surface { bsdf, .. }, _] = leaning();
    let normal = DVec3::new(0.48, -0.36, 0.8);
    for (wo, normal) in [(at_angle(20.0, 0.3), normal), (-at_angle(20.0, 0.3), -normal)] {
        let sample = bsdf.sample(wo, [0.0, 0.5, 0.5]).expect("scatters");
        let expected = normal * (2.0 * wo.dot(normal)) - wo;
        assert!(sample.is_delta && (sample.wi - expected).length() < 1e-12, "{} is not {expected}", sample.wi);
    }
    // The back of the clearcoat reflects nothing, without NaN.
    let behind = DVec3::new(-0.9, 0.4, 0.05).normalize();
    assert!(behind.dot(normal) < 0.0);
    for index in 0..200 {
        let Some(sample) = bsdf.sample(behind, numbers(3, index)) else { continue };
        assert!(sample.value.is_finite() && sample.pdf > 0.0);
    }
}
