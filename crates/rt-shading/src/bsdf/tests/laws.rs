//! Reciprocity, Fresnel's equations, Snell's law.

use super::*;
use crate::optics;

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * a.abs().max(b.abs())
}

/// f(wo, wi) / n(wo)² = f(wi, wo) / n(wi)²: Helmholtz's law, with Veach's factor for radiance.
#[test]
fn light_may_go_either_way() {
    for Surface { name, bsdf } in surfaces().into_iter().filter(|surface| !disperses(&surface.bsdf)) {
        let mut tried = 0;
        for index in 0..4000 {
            let wo = at_angle(180.0 * numbers(20, index)[0], 6.0 * numbers(20, index)[1]);
            let Some(sample) = bsdf.sample(wo, numbers(21, index)).filter(|sample| !sample.is_delta) else { continue };
            let (there, back) = (bsdf.eval(wo, sample.wi), bsdf.eval(sample.wi, wo));
            for (there, back) in there.to_array().into_iter().zip(back.to_array()) {
                let there = there * sample.eta * sample.eta;
                // The index of 1.01 makes a hundredfold of every rounding, and lobes of width 0.0025 some hundreds.
                assert!(close(there, back, 1e-9), "{name}, {index}: {there} {back}");
            }
            tried += 1;
        }
        assert!(tried > 1000 || bsdf.is_delta(), "{name}: {tried}");
    }
}

#[test]
fn delta_lobes_are_reciprocal() {
    for bsdf in [Bsdf::from(Dielectric::clear(1.5, 0.0)), thin_glass().into()] {
        for index in 0..1000 {
            let wo = at_angle(180.0 * numbers(30, index)[0], 1.0);
            let there = bsdf.sample(wo, numbers(31, index)).expect("scatters");
            let back = (0..200)
                .filter_map(|index| bsdf.sample(there.wi, numbers(32, index)))
                .find(|back| back.kind == there.kind);
            let Some(back) = back else { continue };
            assert!((back.wi - wo).length() < 1e-7, "{:?} {wo}", back.wi);
            // Towards the denser side the cosine is that of the sharper angle: shares, not values, are equal.
            let share = |sample: &BsdfSample| sample.weight().g * sample.pdf * sample.eta * sample.eta;
            assert!(close(share(&there), share(&back), 1e-6), "{} {}", share(&there), share(&back));
            let importance = bsdf.sample_importance(wo, numbers(31, index), Rgb::WHITE).expect("scatters");
            assert!(close(importance.weight().g * importance.pdf, share(&there), 1e-12));
        }
    }
}

#[test]
fn importance_is_the_adjoint() {
    for Surface { name, bsdf } in surfaces().into_iter().filter(|surface| !disperses(&surface.bsdf)) {
        for index in 0..200 {
            let (wo, u) = (at_angle(170.0 * numbers(33, index)[0], 1.0), numbers(34, index));
            let Some((radiance, importance)) = bsdf.sample(wo, u).zip(bsdf.sample_importance(wo, u, Rgb::WHITE)) else {
                continue;
            };
            assert_eq!((radiance.wi, radiance.pdf), (importance.wi, importance.pdf), "{name}");
            let (a, b) = (radiance.value.g * radiance.eta * radiance.eta, importance.value.g);
            assert!(close(a, b, 1e-9), "{name}: {a} {b}");
        }
    }
}

/// Share of the light that goes on the given way, summed over both choices.
fn share(bsdf: &Bsdf, wo: DVec3, kind: Scattering) -> f64 {
    let both = [0.0, 1.0].map(|u| bsdf.sample(wo, [u, 0.5, 0.5]));
    let of_kind = both.into_iter().flatten().find(|sample| sample.kind == kind);
    of_kind.map_or(0.0, |sample| sample.weight().g * sample.pdf * sample.eta * sample.eta)
}

#[test]
fn smooth_glass_shares_light_by_fresnel() {
    let glass = Bsdf::from(Dielectric::clear(1.5, 0.0));
    for (degrees, expected) in [
        (0.0, 0.04),
        (45.0, 0.050_239_911_0),
        (60.0, 0.089_186_712_8),
        (89.0, 0.904_184_949_8),
        (89.99, 0.998_985_895_2),
    ] {
        let wo = at_angle(degrees, 0.3);
        let reflected = share(&glass, wo, Scattering::Reflection);
        assert!((reflected - expected).abs() < 1e-10, "{degrees}°: {reflected}");
        assert!((reflected + share(&glass, wo, Scattering::Transmission) - 1.0).abs() < 1e-14);
        // Snell's law.
        let transmitted = glass.sample(wo, [1.0, 0.5, 0.5]).expect("passes");
        let sine = |w: DVec3| transcendental::hypot(w.x, w.y);
        assert!((sine(transmitted.wi) * 1.5 - sine(wo)).abs() < 1e-14 && transmitted.eta == 1.5);
    }
    let inside = at_angle(180.0 - 42.0, 0.0);
    assert_eq!(share(&glass, inside, Scattering::Transmission), 0.0, "beyond the critical angle");
    assert!((share(&glass, inside, Scattering::Reflection) - 1.0).abs() < 1e-14);
}

/// Mean over the hemisphere by the cosine, from Walsh's closed form.
#[test]
fn glass_reflects_the_hemispherical_mean_of_diffuse_light() {
    let count = 200_000;
    let mean = (0..count).map(|i| optics::fresnel(((i as f64 + 0.5) / count as f64).sqrt(), 1.0 / 1.5)).sum::<f64>();
    assert!((mean / count as f64 - 0.091_777_959_3).abs() < 1e-7, "{mean}");
    let glass = Bsdf::from(Dielectric::clear(1.5, 0.0));
    let shares =
        (0..2000).map(|i| share(&glass, at_cosine(((i as f64 + 0.5) / 2000.0).sqrt()), Scattering::Reflection));
    assert!((shares.sum::<f64>() / 2000.0 - 0.091_777_959_3).abs() < 1e-4);
}

fn at_cosine(cos: f64) -> DVec3 {
    DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
}

#[test]
fn thin_glass_sums_all_its_reflections() {
    let (reflected, transmitted) = thin_glass().shares(1.0);
    assert!((reflected.g - 0.076_923_076_9).abs() < 1e-10 && (transmitted.g - 0.923_076_923_1).abs() < 1e-10);
    for cos in [1.0, 0.7, 0.1, 1e-8] {
        let (reflected, transmitted) = thin_glass().shares(cos);
        assert!((reflected.g + transmitted.g - 1.0).abs() < 1e-14, "{cos}");
        // Ten bounces by hand, with a half absorbed at each crossing along the normal.
        let grey = ThinGlass { ior: 1.5, transmittance: Rgb::gray(0.5) };
        let inside = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
        let tau = transcendental::pow(0.5, 1.0 / inside);
        let mut expected = [0.0; 2];
        for fresnel in optics::polarised_fresnel(cos, 1.0 / 1.5) {
            let mut inner = (1.0 - fresnel) * tau;
            expected[0] += 0.5 * fresnel;
            for bounce in 0..40 {
                expected[1 - bounce % 2] += 0.5 * inner * (1.0 - fresnel);
                inner *= fresnel * tau;
            }
        }
        let (reflected, transmitted) = grey.shares(cos);
        assert!((reflected.g - expected[0]).abs() < 1e-6 && (transmitted.g - expected[1]).abs() < 1e-6, "{cos}");
    }
    let straight = thin_glass().sample(at_angle(50.0, 1.0), [1.0, 0.0, 0.0]).expect("passes");
    assert_eq!(straight.wi, -at_angle(50.0, 1.0));
}

#[test]
fn conductors_without_absorption_are_dielectrics() {
    for n in [0.5, 1.0, 1.5, 3.0] {
        for degrees in ANGLES.into_iter().chain([90.0]) {
            let cos = transcendental::cos(f64::to_radians(degrees));
            let (metal, glass) = (conductor_fresnel(cos, n, 0.0), optics::fresnel(cos, 1.0 / n));
            assert!((metal - glass).abs() < 1e-7, "{n} at {degrees}°: {metal} {glass}");
        }
    }
}

/// Reflectances along the normal of ((n − 1)² + k²) / ((n + 1)² + k²), as handbooks give them, within 3 %.
#[test]
fn metals_have_their_colours() {
    for (metal, expected) in [
        (ComplexIor::GOLD, [0.93, 0.79, 0.40]),
        (ComplexIor::SILVER, [0.99, 0.98, 0.98]),
        (ComplexIor::COPPER, [0.88, 0.62, 0.55]),
        (ComplexIor::ALUMINIUM, [0.91, 0.92, 0.92]),
        (ComplexIor::IRON, [0.53, 0.51, 0.50]),
        (ComplexIor::CHROMIUM, [0.55, 0.56, 0.56]),
        (ComplexIor::TITANIUM, [0.61, 0.58, 0.55]),
    ] {
        for (computed, expected) in metal.fresnel(1.0).to_array().into_iter().zip(expected) {
            assert!((computed - expected).abs() < 0.01, "{metal:?}: {computed} {expected}");
        }
        assert!((metal.fresnel(0.0).g - 1.0).abs() < 1e-12, "all is reflected at the horizon");
    }
}

/// |r|² for 80° and gold's red, from complex arithmetic written out on its own.
#[test]
fn complex_fresnel_at_an_angle() {
    let (n, k, degrees) = (0.222f64, 3.208f64, 80.0f64);
    let (sin, cos) = transcendental::sincos(degrees.to_radians());
    // The square root u + iv of (n + ik)² − sin².
    let (x, y) = (n * n - k * k - sin * sin, 2.0 * n * k);
    let size = transcendental::hypot(x, y);
    let (u, v) = (((size + x) / 2.0).sqrt(), ((size - x) / 2.0).sqrt());
    let perpendicular = ((cos - u) * (cos - u) + v * v) / ((cos + u) * (cos + u) + v * v);
    // (ε cos − (u + iv)) / (ε cos + (u + iv)) with ε = (n + ik)².
    let (re, im) = ((n * n - k * k) * cos, 2.0 * n * k * cos);
    let parallel = ((re - u) * (re - u) + (im - v) * (im - v)) / ((re + u) * (re + u) + (im + v) * (im + v));
    assert!((conductor_fresnel(cos, n, k) - 0.5 * (perpendicular + parallel)).abs() < 1e-13);
}

#[test]
fn gltf_follows_the_equations_of_its_specification() {
    let surface = MetallicRoughness { base_color: Rgb::new(0.8, 0.5, 0.1), metallic: 0.3, roughness: 0.6 };
    let layer = albedo_table::LayerAlbedo::new(0.6);
    let passes = |w: DVec3| 1.0 - layer.directional(w.z);
    for index in 0..100 {
        let u = numbers(40, index);
        let (v, l) = (at_angle(89.0 * u[0], 0.0), at_angle(89.0 * u[1], 6.0 * u[2]));
        let h = (v + l).normalize();
        let a2 = 0.6f64 * 0.6 * 0.6 * 0.6;
        let q = h.z * h.z * (a2 - 1.0) + 1.0;
        let d = a2 / (core::f64::consts::PI * q * q);
        let root = |w: DVec3| (a2 + (1.0 - a2) * w.z * w.z).sqrt();
        let specular = d * 0.5 / (v.z * root(l) + l.z * root(v));
        let w = transcendental::pow(1.0 - v.dot(h), 5.0);
        let through = passes(v) * passes(l) / (1.0 - layer.mean());
        let (value, _) = surface.eval_with_pdf(v, l);
        for (base, computed) in surface.base_color.to_array().into_iter().zip(value.to_array()) {
            let fresnel = 0.04 + 0.96 * w;
            let dielectric = base / core::f64::consts::PI * through + specular * fresnel;
            let metal = (base + (1.0 - base) * w) * specular;
            let expected = 0.7 * dielectric + 0.3 * metal;
            assert!((computed - expected).abs() < 1e-12 * expected.max(1.0), "{computed} {expected}");
        }
    }
}

#[test]
fn without_roughness_oren_nayar_is_lambert() {
    let (rough, flat) =
        (OrenNayar { albedo: Rgb::new(0.9, 0.4, 0.1), roughness: 0.0 }, Lambert { albedo: Rgb::new(0.9, 0.4, 0.1) });
    for index in 0..50 {
        let (wo, wi) = (at_angle(1.7 * index as f64, 0.3), at_angle(40.0, 2.0));
        assert!(close(rough.eval_with_pdf(wo, wi).0.r, flat.eval_with_pdf(wo, wi).0.r, 1e-14));
    }
    // Grooves send light back to where it came from.
    let rough = Bsdf::from(eon(1.0));
    let (wo, span_after) = (at_angle(60.0, 0.0), at_angle(60.0, core::f64::consts::PI));
    assert!(rough.eval(wo, wo).g > 1.3 * rough.eval(wo, span_after).g);
}

/// Each channel of a dispersive dielectric equals a dielectric of its index.
#[test]
fn channels_of_a_prism_are_glass_of_their_own_index() {
    for roughness in [0.0, 0.4] {
        let prism = DispersiveDielectric { iors: [1.4, 1.5, 1.7], roughness, transmittance: Rgb::WHITE };
        let wo = at_angle(40.0, 0.3);
        let mean = |surface: &dyn Fn([f64; 3]) -> Option<BsdfSample>, channel: usize, kind: Scattering| {
            let samples = (0..40_000).filter_map(|index| surface(numbers(40, index)));
            samples.filter(|s| s.kind == kind).map(|s| s.weight().to_array()[channel]).sum::<f64>() / 40_000.0
        };
        for (channel, ior) in prism.iors.into_iter().enumerate() {
            for kind in [Scattering::Reflection, Scattering::Transmission] {
                let glass = mean(&|u| Dielectric::clear(ior, roughness).sample(wo, u), channel, kind);
                let own = mean(&|u| prism.sample(wo, u, Rgb::WHITE), channel, kind);
                assert!((own - glass).abs() < 0.02, "{roughness}, {ior}, {kind:?}: {own} instead of {glass}");
            }
        }
    }
}
