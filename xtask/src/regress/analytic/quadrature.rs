//! What a surface scatters in all, by a rule that knows nothing of its samples.

use std::f64::consts::{PI, TAU};

use rt_math::{DVec3, Frame, transcendental::sincos};
use rt_shading::{bsdf::Bsdf, optics::refract};

const RINGS: u32 = 600;
const SECTORS: u32 = 240;

/// The part of light from `wo` that a surface scatters, ∫ f |cos θ| dω in green, by the midpoint rule in rings around the
/// directions in which a smooth surface would send it; `ior` is that below the surface, relative to that above. Single
/// directions are not part of it.
pub(super) fn albedo(bsdf: &Bsdf, wo: DVec3, ior: f64) -> f64 {
    let mirrored = DVec3::new(-wo.x, -wo.y, wo.z);
    let refracted = refract(-wo, DVec3::Z, 1.0 / ior).unwrap_or(-wo);
    let integrand = |wi: DVec3| bsdf.eval(wo, wi).g * wi.z.abs();
    hemisphere(mirrored, 1.0, integrand) + hemisphere(refracted, -1.0, integrand)
}

/// The integral over the directions on a side of the surface; rings are narrow near the axis.
fn hemisphere(axis: DVec3, side: f64, integrand: impl Fn(DVec3) -> f64) -> f64 {
    let frame = Frame::from_z(axis);
    let step = 1.0 / f64::from(RINGS);
    let ring = |index: u32| {
        let x = (f64::from(index) + 0.5) * step;
        // The angle from the axis is π x³.
        let (sin, cos) = sincos(PI * x * x * x);
        let width = 3.0 * PI * x * x * step * sin * TAU / f64::from(SECTORS);
        let sector = |index: u32| {
            let (sin_phi, cos_phi) = sincos(TAU * (f64::from(index) + 0.5) / f64::from(SECTORS));
            let wi = frame.from_local(DVec3::new(sin * cos_phi, sin * sin_phi, cos));
            if wi.z * side > 0.0 { integrand(wi) } else { 0.0 }
        };
        width * (0..SECTORS).map(sector).sum::<f64>()
    };
    (0..RINGS).map(ring).sum()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_SQRT_2;

    use rt_math::Rgb;
    use rt_shading::bsdf::{Lambert, OrenNayar, PhongLobe};

    use super::*;

    fn at(degrees: f64) -> DVec3 {
        let (sin, cos) = sincos(degrees.to_radians());
        DVec3::new(sin, 0.0, cos)
    }

    #[test]
    fn surfaces_that_absorb_nothing_have_an_albedo_of_1() {
        for degrees in [0.0, 45.0, 80.0] {
            let lambert = albedo(&Lambert { albedo: Rgb::WHITE }.into(), at(degrees), 1.0);
            let grooves = albedo(&OrenNayar { albedo: Rgb::WHITE, roughness: 0.7 }.into(), at(degrees), 1.0);
            assert!((lambert - 1.0).abs() < 1e-5 && (grooves - 1.0).abs() < 1e-5, "{lambert}, {grooves}");
        }
    }

    /// Computed with 40 digits.
    #[test]
    fn phong_has_the_albedo_that_others_computed() {
        for (exponent, degrees, expected) in [
            (1.0, 45.0, 0.75540916),
            (10.0, 45.0, 0.70737419),
            (50.0, 45.0, FRAC_1_SQRT_2),
            (1.0, 80.0, 0.40994526),
            (10.0, 80.0, 0.22805629),
            (50.0, 80.0, 0.18080803),
        ] {
            let computed = albedo(&PhongLobe { reflectance: Rgb::WHITE, exponent }.into(), at(degrees), 1.0);
            assert!((computed - expected).abs() < 2e-5, "{exponent} at {degrees}°: {computed}");
        }
    }
}
