//! Attenuation, cones, shadow rays and bounds of delta lights.

use super::*;
use rt_geometry::SurfaceInteraction;

fn light(kind: DeltaLightKind) -> DeltaLight {
    DeltaLight::new(kind, Rgb::gray(8.0))
}

#[test]
fn falloff_is_none_or_inverse_square() {
    let at = DVec3::new(0.0, 2.0, 0.0);
    let none = light(DeltaLightKind::Point { position: at, falloff: Falloff::None, shadow_near: 0.0 });
    let square = light(DeltaLightKind::Point { position: at, falloff: Falloff::InverseSquare, shadow_near: 0.0 });
    assert_eq!(none.sample_li(DVec3::ZERO).expect("lit").strength, Rgb::gray(8.0));
    let lit = square.sample_li(DVec3::ZERO).expect("lit");
    assert_eq!((lit.strength, lit.direction, lit.distance), (Rgb::gray(2.0), DVec3::Y, 2.0));
    assert_eq!(square.sample_li(at), None, "a point at the light itself");
}

#[test]
fn a_spot_has_a_core_a_ramp_and_an_edge() {
    let spot = light(DeltaLightKind::Spot {
        position: DVec3::Y,
        direction: DVec3::NEG_Y,
        cos_inner: 0.9,
        cos_outer: 0.7,
        falloff: Falloff::None,
    });
    // A point below the spot whose direction has cosine c with the axis.
    let below = |c: f64| DVec3::new((1.0 - c * c).sqrt() / c, 0.0, 0.0);
    assert_eq!(spot.sample_li(below(0.95)).expect("core").strength, Rgb::gray(8.0));
    let ramp = spot.sample_li(below(0.8)).expect("ramp").strength.r;
    assert!((ramp - 8.0 * 0.25).abs() < 1e-12, "{ramp}");
    assert_eq!(spot.sample_li(below(0.69)), None);
}

#[test]
fn lights_behind_a_surface_are_known_without_their_distance() {
    let at = |position: DVec3| light(DeltaLightKind::Point { position, falloff: Falloff::None, shadow_near: 0.0 });
    let (point, normal) = (DVec3::new(0.3, -1.7, 2.9), DVec3::new(0.48, -0.6, 0.64));
    let mut n_behind = 0;
    for i in 0..10_000u32 {
        let number = |k: u64| rt_math::random::unit(rt_math::random::hash(&[3, u64::from(i), k])) - 0.5;
        let aside = DVec3::new(number(0), number(1), number(2));
        // Some next to the plane of the surface, to the last bit.
        let aside = if i % 2 == 0 { aside } else { aside - normal * normal.dot(aside) };
        let light = at(point + aside * 8.0);
        let cosine = light.sample_li(point).map(|lit| normal.dot(lit.direction));
        if light.is_behind(point.into(), normal.into()) {
            assert!(cosine < Some(0.0), "{cosine:?}");
            n_behind += 1;
        } else {
            assert!(cosine > Some(-1e-11), "{cosine:?}");
        }
    }
    assert!(n_behind > 2000, "{n_behind}");
    assert!(!at(point).is_behind(point.into(), normal.into()));
}

#[test]
fn a_sphere_around_a_light_does_not_shadow_it() {
    let kind = DeltaLightKind::Point { position: DVec3::Y * 4.0, falloff: Falloff::None, shadow_near: 1.0 };
    let surface = SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Y, [0.0; 2]);
    let light = light(kind);
    let (ray, span) = light.shadow_ray(&surface.shadow_rays(false), &light.sample_li(DVec3::ZERO).expect("lit"), 0.0);
    let end = ray.at(span.max).y;
    assert!(end < 3.0 && end > 3.0 - 1e-11, "{end}");
}

#[test]
fn an_offset_shadow_ray_ends_outside_shadow_near() {
    let light = light(DeltaLightKind::Point { position: DVec3::Y * 4.0, falloff: Falloff::None, shadow_near: 1.0 });
    for lift in [0.5, -0.5] {
        let surface = SurfaceInteraction {
            shadow_point: DVec3::Y * lift,
            ..SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Y * lift.signum(), [0.0; 2])
        };
        let lit = light.sample_li(surface.point).expect("lit");
        let (ray, span) = light.shadow_ray(&surface.shadow_rays(false), &lit, 0.0);
        let end = ray.at(span.max).y;
        assert!(end < 3.0 && end > 3.0 - 1e-10, "{end}");
    }
}

/// Over directions uniform in the cosine with the axis, the mean intensity times 4π is the power.
#[test]
fn power_is_the_integral_of_the_intensity() {
    let (position, falloff) = (DVec3::new(1.0, 2.0, 3.0), Falloff::InverseSquare);
    let n = 20_000;
    for kind in [
        DeltaLightKind::Point { position, falloff, shadow_near: 0.0 },
        DeltaLightKind::Spot { position, direction: DVec3::Z, cos_inner: 0.9, cos_outer: 0.2, falloff },
    ] {
        let light = light(kind);
        let mut mean = Rgb::BLACK;
        for i in 0..n {
            let cos = 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0;
            let wo = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let incident = light.sample_irradiance(position + wo).map_or(Rgb::BLACK, |sample| sample.radiance);
            mean += incident * f64::from(n).recip();
        }
        assert!((4.0 * PI * mean.g / light.power(7.0).g - 1.0).abs() < 1e-4, "{kind:?}");
        assert!((light.bounds().expect("bounds").power() / light.power(7.0).luminance() - 1.0).abs() < 1e-12);
    }
    let sun = light(DeltaLightKind::Directional { direction: DVec3::NEG_Y });
    assert!((sun.power(3.0).g / (9.0 * PI * 8.0 * PI) - 1.0).abs() < 1e-12 && sun.bounds().is_none());
}

#[test]
fn bounds_hold_all_points_that_a_light_reaches() {
    let (position, direction, falloff) = (DVec3::ZERO, DVec3::Z, Falloff::InverseSquare);
    for cos_outer in [0.5, 0.0, -0.6] {
        let light = light(DeltaLightKind::Spot { position, direction, cos_inner: 0.9, cos_outer, falloff });
        let bounds = light.bounds().expect("bounds");
        for i in 0..200 {
            let cos = f64::from(i) / 100.0 - 1.0 + 0.005;
            let point = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let is_reached = light.sample_li(point).is_some();
            assert!(!is_reached || bounds.importance(point, None) > 0.0, "{cos_outer}: {cos}");
        }
    }
}
