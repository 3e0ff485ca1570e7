//! Properties of every light for arbitrary numbers.

use super::test_estimate::white;
use super::*;
use proptest::prelude::*;
use rt_math::transcendental::pow;
use rt_math::{DQuat, Ray};

/// Numbers of all sizes: ordinary, huge, tiny and non-finite ones.
fn number() -> impl Strategy<Value = f64> {
    let powers = (-1.0..1.0f64, -80i32..80).prop_map(|(x, power)| x * pow(10.0, f64::from(power)));
    let odd = prop_oneof![Just(0.0), Just(-0.0), Just(f64::NAN), Just(f64::INFINITY), any::<f64>()];
    prop_oneof![6 => -3.0..3.0f64, 3 => powers, 1 => odd]
}

fn vector() -> impl Strategy<Value = DVec3> {
    [number(), number(), number()].prop_map(DVec3::from)
}

/// A vector in an ordinary range.
fn plain() -> impl Strategy<Value = DVec3> {
    [-3.0..3.0f64, -3.0..3.0f64, -3.0..3.0f64].prop_map(DVec3::from)
}

/// A light of each kind over the same numbers, if there is one.
fn lights(a: DVec3, b: DVec3, c: DVec3, size: f64, sides: EmissionSides) -> Vec<Light> {
    let emission = white(sides);
    let pixels = vec![Rgb::new(1.0, 0.0, 0.0), Rgb::BLACK, Rgb::WHITE, Rgb::BLACK, Rgb::BLACK, Rgb::BLACK];
    let rotation = DQuat::from_xyzw(b.x, b.y, b.z, size);
    let made = [
        QuadLight::new(a, [b, c], emission).map(Light::Quad),
        QuadLight::new(a, [b, b.cross(c)], emission).map(Light::Quad),
        DiskLight::new(a, b, size, 0.0, emission).map(Light::Disk),
        DiskLight::new(a, b, size, c.x, emission).map(Light::Disk),
        SphereLight::new(a, size, emission).map(Light::Sphere),
        CylinderLight::new(a, b, size, true, emission).map(Light::Cylinder),
        CylinderLight::new(a, b, size, false, emission).map(Light::Cylinder),
        MeshLight::new([[a, b, c], [c, b, b + c], [a, a, b]], emission).map(Light::Mesh),
        EnvironmentLight::new(3, 2, pixels, rotation).map(Light::Environment),
    ];
    made.into_iter().flatten().collect()
}

fn sides() -> impl Strategy<Value = EmissionSides> {
    prop_oneof![Just(EmissionSides::Front), Just(EmissionSides::Both)]
}

#[test]
fn odd_points_and_numbers_give_nothing() {
    for sides in [EmissionSides::Front, EmissionSides::Both] {
        let lights = lights(DVec3::Z, DVec3::X, DVec3::Y, 0.5, sides);
        for light in lights.iter().filter(|light| !light.is_environment()) {
            for point in [DVec3::NAN, DVec3::INFINITY, DVec3::MAX] {
                let found = (light.sample_li(point, [0.5; 2]), light.pdf_li(point, DVec3::X));
                assert_eq!(found, (None, 0.0), "{light:?} from {point}");
            }
            for point in [DVec3::ZERO, DVec3::Z, DVec3::X, DVec3::Z * 1.6] {
                for u in [[f64::NAN; 2], [f64::INFINITY; 2], [-1.0, 2.0], [3.0; 2], [1.0; 2], [0.0; 2]] {
                    let sample = light.sample_li(point, u);
                    assert!(sample.is_none_or(|sample| sample.direction.is_finite()), "{light:?}: {sample:?}");
                }
                for direction in [DVec3::ZERO, DVec3::NAN] {
                    assert_eq!(light.pdf_li(point, direction), 0.0, "{light:?} from {point}");
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// No numbers make a light panic or give an invalid sample.
    #[test]
    fn samples_are_sound(
        [a, b, c, point, direction] in [vector(), vector(), vector(), vector(), vector()],
        size in number(),
        u in [number(), number()],
        sides in sides(),
    ) {
        let lights = lights(a, b, c, size, sides);
        for light in &lights {
            if let Some(sample) = light.sample_li(point, u) {
                prop_assert!((sample.direction.length() - 1.0).abs() < 1e-6, "{light:?}: {sample:?}");
                prop_assert!(sample.pdf > 0.0 && sample.pdf.is_finite(), "{light:?}: {sample:?}");
                prop_assert!(sample.radiance.is_finite() && !sample.radiance.is_black(), "{light:?}: {sample:?}");
            }
            for on_light in [light.intersect(point, direction), Some(LightPoint { point: a, normal: b, triangle: 1 })] {
                let pdf = on_light.map_or(0.0, |at| light.pdf_li_at(point, &at));
                prop_assert!(pdf >= 0.0 && pdf.is_finite(), "{light:?}: {pdf}");
            }
            let pdf = light.pdf_li(point, direction);
            prop_assert!(pdf >= 0.0 && pdf.is_finite(), "{light:?}: {pdf}");
            prop_assert!(light.le(direction, c).is_finite());
        }
        let tree = LightTree::new(lights.iter().map(Light::extent));
        if let Some(choice) = tree.sample(point, Some(direction), u[0]) {
            prop_assert!(choice.probability >= 0.0 && choice.probability <= 1.0, "{choice:?}");
        }
    }

    /// A ray in a sampled direction finds the same point, radiance and density.
    #[test]
    fn rays_find_what_samples_promise(
        [a, b, c, point] in [plain(), plain(), plain(), plain()],
        size in 0.1..2.0f64,
        u in [0.01..0.99f64, 0.01..0.99f64],
        sides in sides(),
    ) {
        for light in lights(a, b, c, size, sides) {
            let Some(sample) = light.sample_li(point, u) else { continue };
            let Some(on_light) = sample.point else { continue };
            let ray = Ray::new(point, sample.direction);
            let grazing = sample.direction.dot(sample.normal).abs() < 1e-4;
            let Some(at) = light.intersect(point, sample.direction).filter(|_| !grazing) else { continue };
            // What is nearer hides the sample: the far side of a two-sided tube.
            if (at.point - point).length() < sample.distance * (1.0 - 1e-6) {
                continue;
            }
            prop_assert!((ray.at(sample.distance) - on_light).length() < 1e-9, "{light:?}: {sample:?}");
            prop_assert!((at.point - on_light).length() < 1e-6 * (1.0 + sample.distance), "{light:?}: {sample:?}, {at:?}");
            prop_assert_eq!(light.le(sample.direction, at.normal), sample.radiance, "{:?}", light);
            let pdf = light.pdf_li_at(point, &at);
            prop_assert!((pdf / sample.pdf - 1.0).abs() < 1e-6, "{:?}: {:?}, {}", light, sample, pdf);
        }
    }
}
