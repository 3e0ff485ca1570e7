//! Input on the edge of what makes sense, and beyond: nothing panics, and nothing but sound numbers comes out.

use super::*;
use core::f64::consts::FRAC_1_SQRT_2;

const ROUGHNESSES: [f64; 9] = [0.0, 1e-4, 1.1e-3, 0.5, 1.0, 2.0, -1.0, f64::NAN, f64::INFINITY];
const INDICES: [f64; 12] =
    [1.0, 1.0 + 1e-12, 1.0 + 1e-5, 1.5, 1e-3, 1e3, 1e300, 1e-300, 0.0, -1.5, f64::NAN, f64::INFINITY];

fn strange_surfaces() -> Vec<Bsdf> {
    let mut all: Vec<Bsdf> = surfaces().into_iter().map(|surface| surface.bsdf).collect();
    for roughness in ROUGHNESSES {
        all.extend(INDICES.map(|ior| Bsdf::from(Dielectric::clear(ior, roughness))));
        all.extend(INDICES.map(|ior| Bsdf::from(ThinGlass { ior, transmittance: Rgb::gray(roughness) })));
        all.extend([Bsdf::from(metal(roughness)), eon(roughness).into(), phong(roughness).into()]);
        all.extend([0.0, 0.5, 1.0, 3.0, f64::NAN].map(|metallic| Bsdf::from(gltf(metallic, roughness))));
        let glass = (1.0, Dielectric::clear(1.5, roughness).into());
        all.push(Mix::new(&[glass, (0.0, metal(roughness).into())]).expect("sound weights").into());
    }
    all.extend([1e3, 1e6, 1e12, 1e100, f64::INFINITY].map(|exponent| Bsdf::from(phong(exponent))));
    all
}

/// Directions at and next to the horizon, along the normal, and such that are none.
fn strange_directions() -> Vec<DVec3> {
    let mut all = vec![DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(0.0, 1.0, -0.0), DVec3::ZERO];
    for tiny in [1e-3, 1e-8, 1e-16, 1e-100, 1e-300, f64::MIN_POSITIVE / 8.0] {
        all.extend([DVec3::new(1.0, 0.0, tiny), DVec3::new(-1.0, 0.0, tiny), DVec3::new(1.0, 0.0, -tiny)]);
        all.push(DVec3::new(tiny, 0.0, 1.0));
    }
    all.extend([f64::NAN, f64::INFINITY].map(|bad| DVec3::new(0.6, bad, 0.8)));
    all.extend([f64::NAN, f64::INFINITY].map(|bad| DVec3::new(0.6, 0.0, bad)));
    all.push(DVec3::new(FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2));
    all
}

fn is_sound(value: Rgb) -> bool {
    value.to_array().into_iter().all(|x| x.is_finite() && x >= 0.0)
}

#[test]
fn strange_input_gives_sound_numbers_or_none() {
    let directions = strange_directions();
    let corners = [0.0, 0.5, 1.0 - f64::EPSILON / 2.0, 1.0];
    for bsdf in strange_surfaces() {
        for &wo in &directions {
            for &wi in &directions {
                let (value, pdf) = (bsdf.eval(wo, wi), bsdf.pdf(wo, wi));
                assert!(is_sound(value) && pdf.is_finite() && pdf >= 0.0, "{bsdf:?} {wo} {wi}: {value:?} {pdf}");
            }
            for index in 0..64usize {
                let u = [corners[index % 4], corners[index / 4 % 4], corners[index / 16]];
                for sample in [bsdf.sample(wo, u), bsdf.sample_importance(wo, u, Rgb::WHITE)].into_iter().flatten() {
                    assert!(is_sound(sample.value) && is_sound(sample.weight()), "{bsdf:?} {wo} {u:?}: {sample:?}");
                    assert!(sample.pdf > 0.0 && sample.pdf.is_finite(), "{bsdf:?} {wo} {u:?}: {sample:?}");
                    assert!((sample.wi.length() - 1.0).abs() < 1e-6, "{bsdf:?} {wo} {u:?}: {sample:?}");
                }
            }
        }
    }
}

#[test]
fn what_is_no_input_scatters_nothing() {
    let bad = strange_directions().into_iter().filter(|w| !w.is_finite() || w.z == 0.0);
    let bad: Vec<DVec3> = bad.collect();
    assert!(bad.len() > 6);
    for bsdf in strange_surfaces() {
        for &w in &bad {
            assert_eq!(bsdf.sample(w, [0.5; 3]), None, "{bsdf:?} {w}");
            assert_eq!((bsdf.eval(w, DVec3::Z), bsdf.pdf(w, DVec3::Z)), (Rgb::BLACK, 0.0), "{bsdf:?} {w}");
            assert_eq!((bsdf.eval(DVec3::Z, w), bsdf.pdf(DVec3::Z, w)), (Rgb::BLACK, 0.0), "{bsdf:?} {w}");
        }
        for number in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
            for at in 0..3 {
                let mut u = [0.5; 3];
                u[at] = number;
                assert_eq!(bsdf.sample(DVec3::Z, u), None, "{bsdf:?} {u:?}");
            }
        }
    }
    for ior in [0.0, -1.5, f64::NAN, f64::INFINITY] {
        assert_eq!(Dielectric::clear(ior, 0.5).sample(DVec3::Z, [0.5; 3]), None, "{ior}");
        assert_eq!(ThinGlass { ior, transmittance: Rgb::WHITE }.sample(DVec3::Z, [0.5; 3]), None, "{ior}");
    }
}

#[test]
fn glass_in_glass_is_not_seen() {
    for roughness in [0.0, 0.5] {
        for index in 0..100 {
            let wo = at_angle(180.0 * numbers(50, index)[0], 1.0);
            let glass = Dielectric::clear(1.0, roughness);
            assert!(glass.is_smooth());
            let sample = glass.sample(wo, numbers(51, index)).expect("passes");
            assert_eq!((sample.wi, sample.pdf, sample.eta), (-wo, 1.0, 1.0));
            assert!((sample.weight().g - 1.0).abs() < 1e-15);
        }
    }
}

#[test]
fn roughness_is_smooth_below_a_thousandth_only() {
    assert!(metal(0.0).is_smooth() && metal(1e-4).is_smooth() && !metal(0.00101).is_smooth());
    // The least rough surface looks as the smooth one does.
    for degrees in ANGLES {
        let wo = at_angle(degrees, 0.0);
        let weight = |roughness| {
            let sample = metal(roughness).sample(wo, [0.5, 0.3, 0.5]).expect("reflects");
            (sample.weight().r, sample.wi)
        };
        let ((smooth, there), (rough, near)) = (weight(1e-4), weight(0.00101));
        assert!((smooth - rough).abs() < 1e-4 && (there - near).length() < 1e-4, "{degrees}°: {smooth} {rough}");
    }
}

#[test]
fn mixes_refuse_what_cannot_be_weighed() {
    let lobe = Bxdf::from(Lambert { albedo: Rgb::WHITE });
    assert_eq!(Mix::new(&[]), Err(MixError::Count(0)));
    assert_eq!(Mix::new(&[(1.0, lobe); MAX_LOBES + 1]), Err(MixError::Count(MAX_LOBES + 1)));
    assert_eq!(Mix::new(&[(1.0, lobe), (-0.5, lobe)]), Err(MixError::Weight(-0.5)));
    assert!(matches!(Mix::new(&[(f64::NAN, lobe)]), Err(MixError::Weight(_))));
    let dark = Mix::new(&[(0.0, lobe)]).expect("no light is sound");
    assert_eq!(dark.sample(DVec3::Z, [0.5; 3]), None);
    assert_eq!(dark.eval_with_pdf(DVec3::Z, DVec3::Z), (Rgb::BLACK, 0.0));
}
