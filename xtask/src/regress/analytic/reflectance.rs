//! Directional reflectance by published formulas, written down once more: nothing here calls the BSDFs under test.
//!
//! ```text
//! ρ(wo) = ∫ f(wo, wi) |cos θi| dωi
//! ```
//!
//! Facets are integrated over their normals `m`, and not over directions: with the Jacobians of Walter et al. 2007
//! (equations 14 and 17) the denominators of reflection and refraction cancel,
//!
//! ```text
//! reflection    ∫ F(wo·m) G₂(wo, wi) (wo·m) / cos θo · D(m) dm
//! transmission  ∫ (1 − F(wo·m)) G₁(wo) G₁(wi) (wo·m) / cos θo · D(m) dm / η²
//! ```
//!
//! where `D(m) cos θm dm` is uniform in `u` by `tan² θm = α² u / (1 − u)` (equation 35). Sums are midpoint rules.

use std::f64::consts::TAU;

use rt_math::{
    DVec3,
    transcendental::{pow, sincos},
};

/// Points of the midpoint rules, along the radius and around the axis.
const RINGS: u32 = 1000;
const SECTORS: u32 = 400;

/// Mean of a function over the unit square whose second coordinate is an angle, handed on as sine and cosine.
fn mean(integrand: impl Fn(f64, [f64; 2]) -> f64) -> f64 {
    let middle = |index: u32, count: u32| (f64::from(index) + 0.5) / f64::from(count);
    let angles: Vec<[f64; 2]> = (0..SECTORS).map(|index| sincos(TAU * middle(index, SECTORS)).into()).collect();
    let ring = |index| angles.iter().map(|angle| integrand(middle(index, RINGS), *angle)).sum::<f64>();
    (0..RINGS).map(ring).sum::<f64>() / f64::from(RINGS * SECTORS)
}

/// Reflectance of Phong's lobe `(n + 2) / 2π · (r·wi)ⁿ` around the mirrored direction `r` (Lafortune and Willems 1994).
pub(super) fn phong(exponent: f64, degrees: f64) -> f64 {
    let (sin, cos) = sincos(degrees.to_radians());
    // cosⁿ⁺¹ of the angle to the axis is uniform: the directions of the lobe by their power.
    let part_above = mean(|u, [_, turn]| {
        let along = pow(u, 1.0 / (exponent + 1.0));
        let aside = ((1.0 - along) * (1.0 + along)).sqrt();
        (along * cos + aside * turn * sin).max(0.0)
    });
    (exponent + 2.0) / (exponent + 1.0) * part_above
}

/// Fresnel reflectance of a smooth dielectric for unpolarised light from outside (Fresnel 1823): half the sum of the
/// squares of sin(i − t) / sin(i + t) and tan(i − t) / tan(i + t), in cosines. `ior` is the index below relative to
/// that above.
pub(super) fn dielectric_fresnel(cos: f64, ior: f64) -> f64 {
    let below = (1.0 - (1.0 - cos * cos) / (ior * ior)).sqrt();
    let perpendicular = (cos - ior * below) / (cos + ior * below);
    let parallel = (ior * cos - below) / (ior * cos + below);
    0.5 * (perpendicular * perpendicular + parallel * parallel)
}

/// Part of unpolarised light that a smooth metal of index n + ik reflects, without complex numbers (Lagarde, "Memo on Fresnel
/// equations", 2013).
pub(super) fn metal_fresnel(cos: f64, n: f64, k: f64) -> f64 {
    let (cos2, sin2) = (cos * cos, 1.0 - cos * cos);
    let real = n * n - k * k - sin2;
    let length = (real * real + 4.0 * n * n * k * k).sqrt();
    let a = (0.5 * (length + real)).sqrt();
    let perpendicular = (length + cos2 - 2.0 * a * cos) / (length + cos2 + 2.0 * a * cos);
    let across =
        (cos2 * length + sin2 * sin2 - 2.0 * a * cos * sin2) / (cos2 * length + sin2 * sin2 + 2.0 * a * cos * sin2);
    0.5 * perpendicular * (1.0 + across)
}

/// Smith's Λ of the distribution of Trowbridge and Reitz (Heitz 2014, equation 72), from the cosine to the normal.
fn lambda(alpha: f64, cos: f64) -> f64 {
    let tan2 = (1.0 - cos * cos) / (cos * cos);
    0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
}

/// ∫ g(wo, m) (wo·m) / cos θo · D(m) dm over facets that face the viewer.
fn over_facets(alpha: f64, degrees: f64, g: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    let (sin, cos) = sincos(degrees.to_radians());
    let wo = DVec3::new(sin, 0.0, cos);
    mean(|u, [sin_phi, cos_phi]| {
        // Squared, so that grazing facets, which are rare but large, have points enough.
        let (rest, weight) = ((1.0 - u) * (1.0 - u), 2.0 * (1.0 - u));
        let tan = alpha * ((1.0 - rest) / rest).sqrt();
        let cos_m = 1.0 / (1.0 + tan * tan).sqrt();
        let m = DVec3::new(tan * cos_phi, tan * sin_phi, 1.0) * cos_m;
        let facing = wo.dot(m);
        if facing <= 0.0 { 0.0 } else { weight * g(wo, m) * facing / (cos * cos_m) }
    })
}

/// Reflectance of facets of slope α with this Fresnel term, with the height-correlated G₂ (Heitz 2014, equation 99). What facets
/// reflect to each other is lost.
pub(super) fn facets(alpha: f64, degrees: f64, fresnel: impl Fn(f64) -> f64) -> f64 {
    over_facets(alpha, degrees, |wo, m| {
        let facing = wo.dot(m);
        let wi = 2.0 * facing * m - wo;
        if wi.z <= 0.0 {
            return 0.0;
        }
        fresnel(facing) / (1.0 + lambda(alpha, wo.z) + lambda(alpha, wi.z))
    })
}

/// Part of the radiance behind a rough surface of glass that comes through, from facets of slope α, with separate G₁
/// (Walter et al. 2007, equations 21 and 23). `ior` is that below relative to that above.
pub(super) fn transmission(alpha: f64, degrees: f64, ior: f64) -> f64 {
    over_facets(alpha, degrees, |wo, m| {
        let facing = wo.dot(m);
        // Snell's law at the facet.
        let below = (1.0 - (1.0 - facing * facing) / (ior * ior)).sqrt();
        let wi = (facing / ior - below) * m - wo / ior;
        if wi.z >= 0.0 {
            return 0.0;
        }
        let seen = 1.0 / ((1.0 + lambda(alpha, wo.z)) * (1.0 + lambda(alpha, -wi.z)));
        (1.0 - dielectric_fresnel(facing, ior)) * seen / (ior * ior)
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_SQRT_2;

    use rt_math::{Frame, Rgb};
    use rt_shading::{
        bsdf::{Bsdf, ComplexIor, Conductor, Dielectric, PhongLobe},
        optics::refract,
    };

    use super::*;

    /// Computed with 40 digits.
    #[test]
    fn phong_has_the_reflectance_that_others_computed() {
        for (exponent, degrees, expected) in [
            (1.0, 45.0, 0.75540916),
            (10.0, 45.0, 0.70737419),
            (50.0, 45.0, FRAC_1_SQRT_2),
            (1.0, 80.0, 0.40994526),
            (10.0, 80.0, 0.22805629),
            (50.0, 80.0, 0.18080803),
        ] {
            let computed = phong(exponent, degrees);
            assert!((computed - expected).abs() < 1e-5, "{exponent} at {degrees}°: {computed}");
        }
        // ∫ (3/2π) cos² over the hemisphere, and (n + 2) / (n + 1) · (n + 1) / (n + 2).
        assert!((phong(1.0, 0.0) - 1.0).abs() < 3e-5 && (phong(1e6, 0.0) - 1.0).abs() < 3e-5);
    }

    /// Tables in Born and Wolf, and Brewster's angle; gold as refractiveindex.info has it.
    #[test]
    fn fresnel_terms_have_published_values() {
        assert!((dielectric_fresnel(1.0, 1.5) - 0.04).abs() < 1e-15);
        assert!((dielectric_fresnel(0.0, 1.5) - 1.0).abs() < 1e-15);
        // At tan i = n nothing of the light in the plane is reflected, and ((n² − 1) / (n² + 1))² of the other.
        let brewster = 1.0 / (1.0f64 + 2.25).sqrt();
        assert!((dielectric_fresnel(brewster, 1.5) - 0.5 * (1.25 / 3.25) * (1.25 / 3.25)).abs() < 1e-15);
        for cos in [0.1, 0.5, 1.0] {
            assert!((metal_fresnel(cos, 1.5, 0.0) - dielectric_fresnel(cos, 1.5)).abs() < 1e-14, "{cos}");
        }
        // ((n − 1)² + k²) / ((n + 1)² + k²).
        let normal = (0.572 * 0.572 + 2.461 * 2.461) / (1.428 * 1.428 + 2.461 * 2.461);
        assert!((metal_fresnel(1.0, 0.428, 2.461) - normal).abs() < 1e-14);
    }

    /// Heitz 2014, section 4: what is seen of all facets is what is seen of the plane, and smooth facets are the plane.
    #[test]
    fn facets_are_normalised_and_smooth_ones_are_the_plane() {
        for degrees in [0.0, 30.0, 60.0, 85.0] {
            for alpha in [0.05, 0.16, 0.5, 1.0] {
                let seen = over_facets(alpha, degrees, |wo, _| 1.0 / (1.0 + lambda(alpha, wo.z)));
                assert!((seen - 1.0).abs() < 2e-4, "α = {alpha} at {degrees}°: {seen}");
            }
            let cos = sincos(degrees.to_radians()).1;
            let fresnel = dielectric_fresnel(cos, 1.5);
            let reflected = facets(1e-4, degrees, |cos| dielectric_fresnel(cos, 1.5));
            let passed = transmission(1e-4, degrees, 1.5);
            assert!((reflected - fresnel).abs() < 1e-4, "{degrees}°: {reflected} instead of {fresnel}");
            assert!((passed - (1.0 - fresnel) / 2.25).abs() < 1e-4, "{degrees}°: {passed}");
        }
    }

    /// ∫ f |cos θ| dω in green, by the midpoint rule in rings around the directions in which a smooth surface would send light.
    fn of_bsdf(bsdf: &Bsdf, degrees: f64, ior: f64) -> f64 {
        let (sin, cos) = sincos(degrees.to_radians());
        let wo = DVec3::new(sin, 0.0, cos);
        let refracted = refract(-wo, DVec3::Z, 1.0 / ior).unwrap_or(-wo);
        let hemisphere = |axis: DVec3, side: f64| {
            let frame = Frame::from_z(axis);
            let rings = 600;
            let ring = |index: u32| {
                let x = (f64::from(index) + 0.5) / f64::from(rings);
                // The angle from the axis is π x³.
                let (sin, cos) = sincos(TAU / 2.0 * x * x * x);
                let width = 1.5 * TAU * x * x / f64::from(rings) * sin * TAU / 240.0;
                let sector = |index: u32| {
                    let (sin_phi, cos_phi) = sincos(TAU * (f64::from(index) + 0.5) / 240.0);
                    let wi = frame.from_local(DVec3::new(sin * cos_phi, sin * sin_phi, cos));
                    if wi.z * side > 0.0 { bsdf.eval(wo, wi).g * wi.z.abs() } else { 0.0 }
                };
                width * (0..240).map(sector).sum::<f64>()
            };
            (0..rings).map(ring).sum::<f64>()
        };
        hemisphere(DVec3::new(-wo.x, -wo.y, wo.z), 1.0) + hemisphere(refracted, -1.0)
    }

    #[test]
    fn bsdfs_have_this_reflectance() {
        for degrees in [0.0, 45.0, 75.0] {
            let gold = Conductor { ior: ComplexIor::GOLD, roughness: 0.3 };
            let glass = Dielectric { ior: 1.5, roughness: 0.3, reflectance: Rgb::WHITE, transmittance: Rgb::WHITE };
            let shiny = PhongLobe { reflectance: Rgb::WHITE, exponent: 10.0 };
            for (name, bsdf, truth) in [
                ("gold", Bsdf::from(gold), facets(0.09, degrees, |cos| metal_fresnel(cos, 0.428, 2.461))),
                (
                    "glass",
                    glass.into(),
                    facets(0.09, degrees, |cos| dielectric_fresnel(cos, 1.5)) + transmission(0.09, degrees, 1.5),
                ),
                ("Phong", shiny.into(), phong(10.0, degrees)),
            ] {
                let found = of_bsdf(&bsdf, degrees, 1.5);
                assert!((found - truth).abs() < 2e-4, "{name} at {degrees}°: {found} instead of {truth}");
            }
        }
    }
}
