//! Irradiance, densities and bounds of rectangle lights.

use super::super::test_estimate::{
    assert_samples_and_pdf_agree, integral_of_pdf, irradiance, irradiance_by, irradiance_by_rays, white,
};
use super::super::{EmissionSides, Light, polygon_irradiance};
use super::*;
use rt_math::Rgb;
use rt_math::transcendental::asin;

/// Unit square at z = 1 that emits downwards.
fn square(sides: EmissionSides) -> QuadLight {
    QuadLight::new(DVec3::new(-0.5, -0.5, 1.0), [DVec3::Y, DVec3::X], white(sides)).expect("a light")
}

/// A light that also reflects sampled itself: rounding put points of its back in front of it, and light leaked behind.
#[test]
fn the_light_is_not_seen_from_its_own_plane_as_rounding_leaves_it() {
    let corner = DVec3::new(-0.24, 1.98, 0.16);
    let light =
        QuadLight::new(corner, [DVec3::NEG_Z * 0.38, DVec3::X * 0.47], white(EmissionSides::Front)).expect("a light");
    for y in [1.98f64.next_down().next_down(), 1.98f64.next_down(), 1.98, 1.98f64.next_up()] {
        assert_eq!(light.sample_li(DVec3::new(0.1, y, -0.1), [0.3, 0.6]), None, "{y}");
    }
    let faces_down = light.normal().y < 0.0;
    let span_after = DVec3::new(0.1, 1.98 + if faces_down { -1e-9 } else { 1e-9 }, -0.1);
    assert!(light.sample_li(span_after, [0.3, 0.6]).is_some());
}

fn corners(light: &QuadLight) -> [DVec3; 4] {
    let [a, b] = light.edges;
    [light.corner, light.corner + a, light.corner + a + b, light.corner + b]
}

/// Receivers above the middle and the corner, near, far, next to the plane, aside, and some whose horizon clips the light.
fn receivers() -> Vec<[DVec3; 2]> {
    let tilted = DVec3::new(1.0, 0.3, 0.2).normalize();
    vec![
        [DVec3::ZERO, DVec3::Z],
        [DVec3::new(0.5, 0.5, 0.0), DVec3::Z],
        [DVec3::new(0.1, 0.2, 0.999), DVec3::Z],
        [DVec3::new(0.1, 0.2, 1.0 - 1e-6), tilted],
        [DVec3::new(0.0, 0.0, -99.0), DVec3::Z],
        [DVec3::new(0.0, 0.0, -1e6), DVec3::Z],
        [DVec3::new(3.0, 1.0, 0.9), DVec3::NEG_X],
        [DVec3::new(-3.0, 0.0, 0.999), tilted],
        [DVec3::new(0.6, 0.2, 1.0 - 1e-9), DVec3::new(-1.0, 0.0, 1.0).normalize()],
        [DVec3::new(0.3, -0.2, 0.5), tilted],
        [DVec3::new(-2.0, -5.0, -7.0), DVec3::new(0.2, 0.9, 0.3).normalize()],
    ]
}

#[test]
fn irradiance_is_lamberts() {
    let light = square(EmissionSides::Front);
    let emitter = Light::Quad(light);
    for at in receivers() {
        let truth = polygon_irradiance(&corners(&light), at[0], at[1]);
        irradiance(&emitter, at, 100_000).assert(&format!("square from {}", at[0]), truth);
    }
}

#[test]
fn irradiance_of_thin_large_and_sheared_lights_is_lamberts() {
    let (point, normal) = (DVec3::new(0.2, 0.1, -0.7), DVec3::new(0.1, -0.3, 1.0).normalize());
    for edges in
        [[DVec3::Y * 1e-3, DVec3::X * 10.0], [DVec3::Y * 1e3, DVec3::X * 1e3], [DVec3::Y, DVec3::new(1.0, 0.5, 0.0)]]
    {
        let light = QuadLight::new(DVec3::new(-0.5, -0.5, 1.0), edges, white(EmissionSides::Front)).expect("a light");
        let truth = polygon_irradiance(&corners(&light), point, normal);
        irradiance(&Light::Quad(light), [point, normal], 100_000).assert(&format!("{edges:?}"), truth);
        assert_samples_and_pdf_agree(&Light::Quad(light), point, 1e-8);
    }
}

/// Lambert's formula loses the digits of lights that are this small; A cos θ cos θ′ / d² does not.
#[test]
fn irradiance_of_tiny_lights_is_that_of_points() {
    let (point, normal) = (DVec3::new(0.2, 0.1, -0.7), DVec3::new(0.1, -0.3, 1.0).normalize());
    for size in [1e-7, 1e-14] {
        let edges = [DVec3::Y * size, DVec3::X * size];
        let light = QuadLight::new(DVec3::new(-0.5, -0.5, 1.0), edges, white(EmissionSides::Front)).expect("a light");
        let offset = light.corner + (edges[0] + edges[1]) / 2.0 - point;
        let square = offset.length_squared();
        let truth = light.area() * offset.dot(normal) * offset.z / (square * square);
        irradiance(&Light::Quad(light), [point, normal], 1000).assert(&format!("size {size}"), truth);
    }
}

#[test]
fn solid_angle_is_that_of_the_closed_form() {
    let light = square(EmissionSides::Front);
    assert!((light.solid_angle(DVec3::ZERO) - 4.0 * asin(0.2)).abs() < 1e-15);
    for (d, tolerance) in [(1e-6, 1e-9), (0.3, 1e-14), (40.0, 1e-14), (1e6, 1e-12)] {
        let truth = 4.0 * asin(0.25 / (0.25 + d * d));
        let computed = light.solid_angle(DVec3::Z * (1.0 - d));
        assert!((computed / truth - 1.0).abs() < tolerance, "from {d}: {computed}, truth {truth}");
    }
    let quarter = light.solid_angle(DVec3::new(0.5, 0.5, 0.0));
    assert!((quarter - asin(0.5)).abs() < 1e-15, "a quarter of a square of side 2: {quarter}");
    assert_eq!(light.solid_angle(DVec3::new(3.0, 0.0, 1.0)), 0.0, "in the plane");
}

#[test]
fn densities_agree_and_integrate_to_one() {
    for sides in [EmissionSides::Front, EmissionSides::Both] {
        let emitter = Light::Quad(square(sides));
        for [point, _] in receivers() {
            assert_samples_and_pdf_agree(&emitter, point, 1e-6);
            if point.z > -10.0 && point.z < 0.99 {
                integral_of_pdf(&emitter, point, 200_000).assert(&format!("pdf from {point}"), 1.0);
            }
        }
    }
}

/// The mapping has equal areas: a quarter of the unit square comes to a quarter of the solid angle.
#[test]
fn directions_are_uniform() {
    let light = square(EmissionSides::Front);
    let point = DVec3::new(1.2, 0.4, 0.7);
    let at = [point, (DVec3::new(-0.2, 0.1, 1.0) - point).normalize()];
    let rays = irradiance_by_rays(&Light::Quad(light), at, 400_000);
    rays.assert("square by rays", polygon_irradiance(&corners(&light), at[0], at[1]));
    for (part, half) in [(0, 0.5), (1, 0.5), (0, 0.1), (1, 0.9)] {
        let count = 100;
        let inner = (0..count).map(|i| {
            let mut u = [0.0; 2];
            u[part] = half;
            u[1 - part] = (f64::from(i) + 0.5) / f64::from(count);
            light.sample_li(point, u).expect("a sample").point.expect("a point")
        });
        // All lie on one great circle for the first number; for the second they part each arc in equal heights.
        let points: Vec<_> = inner.map(|p| (p - point).normalize()).collect();
        if part == 0 {
            let circle = points[0].cross(points[99]).normalize();
            assert!(points.iter().all(|p| p.dot(circle).abs() < 1e-12));
            let x = light.sample_li(point, [half, 0.0]).expect("a sample").point.expect("a point").dot(light.axes[0]);
            let x0 = light.corner.dot(light.axes[0]);
            let edges = [light.axes[0] * (x - x0), light.edges[1]];
            let cut = QuadLight::new(light.corner, edges, white(EmissionSides::Front)).expect("a light");
            assert!((cut.solid_angle(point) / light.solid_angle(point) - half).abs() < 1e-12);
        }
    }
}

#[test]
fn a_wrong_density_is_caught() {
    let emitter = Light::Quad(square(EmissionSides::Front));
    for at in [[DVec3::ZERO, DVec3::Z], [DVec3::new(0.0, 0.0, -999.0), DVec3::Z]] {
        let truth = polygon_irradiance(&corners(&square(EmissionSides::Front)), at[0], at[1]);
        assert!(irradiance_by(&emitter, at, 100_000, |s| s.pdf * 1.01).z(truth) > 5.0, "1 % too dense");
        let by_area = |s: &LightLiSample| s.distance * s.distance;
        assert!(irradiance_by(&emitter, at, 100_000, by_area).z(truth) > 5.0, "the light's cosine forgotten");
    }
}

#[test]
fn nothing_comes_from_behind_or_from_a_plane() {
    let (front, both) = (Light::Quad(square(EmissionSides::Front)), Light::Quad(square(EmissionSides::Both)));
    let behind = DVec3::new(0.1, 0.1, 2.0);
    assert_eq!((front.sample_li(behind, [0.5; 2]), front.pdf_li(behind, DVec3::NEG_Z)), (None, 0.0));
    assert!(both.sample_li(behind, [0.5; 2]).is_some() && both.pdf_li(behind, DVec3::NEG_Z) > 0.0);
    assert_eq!((front.le(DVec3::NEG_Z, DVec3::NEG_Z), both.le(DVec3::NEG_Z, DVec3::NEG_Z)), (Rgb::BLACK, Rgb::WHITE));
    for point in [DVec3::new(0.1, 0.1, 1.0), DVec3::new(-0.5, -0.5, 1.0), DVec3::new(5.0, 0.0, 1.0)] {
        for light in [&front, &both] {
            assert_eq!(light.sample_li(point, [0.5; 2]), None, "{point}");
            assert_eq!(light.pdf_li(point, DVec3::Z), 0.0, "{point}");
        }
    }
    assert_eq!(both.power(0.0), front.power(0.0) * 2.0);
}

#[test]
fn lights_without_area_are_refused_and_black_ones_give_nothing() {
    for edges in [[DVec3::X, DVec3::X], [DVec3::X, DVec3::ZERO], [DVec3::X, DVec3::NAN], [DVec3::X * 1e200, DVec3::Y]] {
        assert!(QuadLight::new(DVec3::ZERO, edges, white(EmissionSides::Both)).is_err(), "{edges:?}");
    }
    let black = Emission::new(Rgb::BLACK, EmissionSides::Both).expect("an emission");
    let light = Light::Quad(QuadLight::new(DVec3::Z, [DVec3::X, DVec3::Y], black).expect("a light"));
    assert_eq!((light.sample_li(DVec3::ZERO, [0.5; 2]), light.pdf_li(DVec3::ZERO, DVec3::Z)), (None, 0.0));
}
