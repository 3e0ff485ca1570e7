//! Directions of pixels, and agreement of samples with radiance.

use super::super::Light;
use super::super::test_estimate::{Estimate, integral_of_pdf, irradiance, irradiance_by};
use super::*;
use rt_math::random::{hash, unit};

const WIDTH: usize = 12;
const HEIGHT: usize = 7;

fn turned() -> DQuat {
    DQuat::from_xyzw(0.1, -0.5, 0.3, 0.8)
}

/// An image that is black but for the pixels given.
fn image(lit: &[(usize, usize, f64)], rotation: DQuat) -> EnvironmentLight {
    let mut pixels = vec![Rgb::BLACK; WIDTH * HEIGHT];
    for &(column, row, radiance) in lit {
        pixels[row * WIDTH + column] = Rgb::new(radiance, 2.0 * radiance, 0.5 * radiance);
    }
    EnvironmentLight::new(WIDTH, HEIGHT, pixels, rotation).expect("an environment")
}

/// Bright and faint pixels at the poles, at the seam and elsewhere, black rows between.
fn images() -> Vec<EnvironmentLight> {
    let noise = (0..WIDTH * HEIGHT).map(|i| (i % WIDTH, i / WIDTH, unit(hash(&[i as u64])))).collect::<Vec<_>>();
    vec![
        image(&[(4, 3, 1.0)], turned()),
        image(&[(0, 0, 2.0)], DQuat::IDENTITY),
        image(&[(11, 6, 1.0), (0, 6, 1e-6)], turned()),
        image(&[(0, 3, 5.0), (6, 5, 1e4), (7, 5, 1e-3)], turned()),
        image(&noise, turned()),
    ]
}

fn draw(i: u64) -> [f64; 2] {
    [unit(hash(&[i, 0, 5])), unit(hash(&[i, 1, 5]))]
}

#[test]
fn pixels_lie_where_they_are_seen() {
    let sky = |column, row| image(&[(column, row, 1.0)], DQuat::IDENTITY);
    let height = DVec3::Y * sincos(PI / 7.0).0 / sincos(PI / 7.0).1;
    let column = |turn: f64| DVec3::new(-sincos(turn * TAU).0, 0.0, sincos(turn * TAU).1);
    // The middle of column 8 is 8.5 of 12 parts around from +z, over −x and −z.
    for (light, direction) in [(sky(8, 3), column(8.5 / 12.0)), (sky(3, 2), column(3.5 / 12.0) + height)] {
        assert!((light.le(direction * 7.0) - Rgb::new(1.0, 2.0, 0.5)).max_component().abs() < 1e-12);
    }
    assert!(sky(5, 3).le(DVec3::NEG_Z).g > 0.9 && sky(6, 3).le(DVec3::NEG_Z).g > 0.9, "the middle");
    assert!(sky(8, 3).le(DVec3::X).g > 0.9 && sky(2, 3).le(DVec3::NEG_X).g > 0.9, "right and left");
    assert!(sky(4, 0).le(column(4.5 / 12.0) + DVec3::Y * 1e3).g > 1.9, "above");
}

#[test]
fn a_turned_image_is_seen_turned() {
    let (plain, light) =
        (image(&[(4, 2, 1.0), (7, 5, 3.0)], DQuat::IDENTITY), image(&[(4, 2, 1.0), (7, 5, 3.0)], turned()));
    let rotation = turned().normalize();
    for i in 0..100 {
        let [x, y] = draw(i);
        let direction = DVec3::new(x - 0.5, y - 0.5, draw(i + 1000)[0] - 0.5);
        assert!((light.le(rotation * direction) - plain.le(direction)).max_component().abs() < 1e-12);
        assert!(
            (light.pdf_li(rotation * direction) - plain.pdf_li(direction)).abs() <= 1e-12 * plain.pdf_li(direction)
        );
    }
}

#[test]
fn a_constant_environment_is_sampled_uniformly() {
    let constant = EnvironmentLight::constant(Rgb::gray(3.0)).expect("an environment");
    let sky = EnvironmentLight::new(5, 4, vec![Rgb::gray(3.0); 20], turned()).expect("an environment");
    for light in [constant, sky] {
        for i in 0..1000 {
            let sample = light.sample_li(draw(i)).expect("a sample");
            assert!((sample.pdf * 4.0 * PI - 1.0).abs() < 1e-12 && (sample.radiance.r - 3.0).abs() < 1e-12);
        }
        assert!((light.power(2.0).g / (3.0 * 16.0 * PI * PI) - 1.0).abs() < 1e-12);
        let at = [DVec3::ONE, DVec3::new(0.6, 0.0, -0.8)];
        irradiance(&Light::Environment(light), at, 200_000).assert("hemisphere", 3.0 * PI);
    }
}

/// χ² of directions in boxes of their own, which divide the cells, against the density.
#[test]
fn samples_fall_as_densely_as_the_density_says() {
    let (columns, rows, count) = (2 * WIDTH, 2 * HEIGHT, 200_000u64);
    for light in images() {
        let mut found = vec![0.0; columns * rows];
        for i in 0..count {
            let local = light.world_from_local.transpose() * light.sample_li(draw(i)).expect("a sample").direction;
            let turn = (atan2(-local.x, local.z) / TAU).rem_euclid(1.0);
            let down = atan2((1.0 - local.y * local.y).max(0.0).sqrt(), local.y) / PI;
            let cell = [turn * columns as f64, down * rows as f64].map(|x| x as usize);
            found[cell[1].min(rows - 1) * columns + cell[0].min(columns - 1)] += 1.0;
        }
        let (mut chi2, mut freedom) = (0.0, -1.0);
        for (i, found) in found.iter().enumerate() {
            let [turn, down] = [(i % columns) as f64 + 0.5, (i / columns) as f64 + 0.5];
            let (sin, cos) = sincos(PI * down / rows as f64);
            let (s, c) = sincos(TAU * turn / columns as f64);
            let middle = light.world_from_local * DVec3::new(-sin * s, cos, sin * c);
            let [top, bottom] = [down - 0.5, down + 0.5].map(|y| PI * y / rows as f64);
            let solid_angle = TAU / columns as f64 * cos_difference(top, bottom);
            let expected = light.pdf_li(middle) * solid_angle * count as f64;
            if expected < 5.0 {
                assert!(*found <= expected + 5.0 * expected.sqrt() + if expected > 0.0 { 3.0 } else { 0.0 });
                continue;
            }
            chi2 += (found - expected) * (found - expected) / expected;
            freedom += 1.0;
        }
        println!("χ² = {chi2:.1} of {freedom} degrees");
        let limit = freedom + 5.0 * f64::sqrt(2.0 * freedom) + 10.0;
        assert!(chi2 < limit, "χ² = {chi2} of {freedom} degrees of freedom");
    }
}

#[test]
fn densities_agree_and_integrate_to_one() {
    for light in images() {
        let any_light = Light::Environment(light.clone());
        integral_of_pdf(&any_light, DVec3::ZERO, 200_000).assert("pdf", 1.0);
        let cells = (0..=HEIGHT).flat_map(|row| (0..WIDTH).map(move |column| (column, row)));
        let sum: f64 = cells.map(|(column, row)| light.probability(column, row)).sum();
        assert!((sum - 1.0).abs() < 1e-14);
        for i in 0..20_000 {
            let sample = light.sample_li(draw(i)).expect("a sample");
            assert!((sample.direction.length() - 1.0).abs() < 1e-14, "{sample:?}");
            assert_eq!((sample.point, sample.distance, sample.shadow_target()), (None, f64::INFINITY, None));
            let pdf = light.pdf_li(sample.direction);
            assert!((pdf / sample.pdf - 1.0).abs() < 1e-12, "{pdf} for {sample:?}");
        }
    }
}

/// The density is positive wherever there is light, also between the last lit pixel and its black neighbour.
#[test]
fn light_is_never_without_density() {
    for light in images() {
        for i in 0..50_000 {
            let [a, b] = draw(i);
            let (sin, cos) = sincos(TAU * a);
            let r = (1.0 - (2.0 * b - 1.0) * (2.0 * b - 1.0)).sqrt();
            let direction = DVec3::new(r * cos, r * sin, 2.0 * b - 1.0);
            assert_eq!(light.le(direction).is_black(), light.pdf_li(direction) == 0.0);
        }
    }
}

#[test]
fn irradiance_is_that_of_uniform_directions() {
    let normal = DVec3::new(0.48, 0.6, -0.64);
    for (light, peak) in images().into_iter().zip([0.5, 0.5, 0.5, 0.5, 1.5]) {
        let uniform = Estimate::of(200_000, |u| {
            let (z, (sin, cos)) = (2.0 * u[0] - 1.0, sincos(TAU * u[1]));
            let direction = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            4.0 * PI * light.le(direction).g * direction.dot(normal).max(0.0)
        });
        let light = Light::Environment(light);
        let at = [DVec3::ZERO, normal];
        let sampled = irradiance(&light, at, 200_000);
        let z = |a: Estimate, b: Estimate| {
            let square = a.standard_error * a.standard_error + b.standard_error * b.standard_error;
            (a.mean - b.mean).abs() / (square + f64::MIN_POSITIVE).sqrt()
        };
        println!("irradiance {:.6} ± {:.1e}, z = {:.2}", sampled.mean, sampled.standard_error, z(sampled, uniform));
        assert!(z(sampled, uniform) < 5.0, "{sampled:?}, uniform {uniform:?}");
        assert!(sampled.standard_error <= peak * uniform.standard_error, "importance does not pay");
    }
    let light = Light::Environment(EnvironmentLight::constant(Rgb::WHITE).expect("an environment"));
    assert!(irradiance_by(&light, [DVec3::ZERO, normal], 200_000, |s| s.pdf * 1.02).z(PI) > 5.0, "a wrong density");
}

#[test]
fn poles_are_ordinary() {
    for light in [image(&[(3, 0, 1.0), (8, 6, 1.0)], DQuat::IDENTITY), image(&[(3, 0, 1.0), (8, 6, 1.0)], turned())] {
        for pole in [DVec3::Y, DVec3::NEG_Y, DVec3::new(1e-300, 1.0, -1e-300), DVec3::new(-0.0, -1.0, 0.0)] {
            let (pdf, radiance) = (light.pdf_li(pole), light.le(pole));
            assert!(pdf.is_finite() && radiance.is_finite(), "{pole}: {pdf}, {radiance:?}");
        }
        for u in [[0.0, 0.0], [0.999_999, 0.0], [0.5, 1.0], [0.5, 0.999_999_999_999], [0.2, 1e-300]] {
            // A corner of a cell may be the black middle of a pixel.
            let sample = light.sample_li(u);
            assert!(sample.is_none_or(|s| s.pdf.is_finite() && s.direction.is_finite()), "{sample:?}");
        }
    }
}

#[test]
fn odd_images_and_numbers_are_refused_and_never_panic() {
    let grey = |count| vec![Rgb::WHITE; count];
    for (width, height, pixels) in [(0, 0, grey(0)), (2, 2, grey(3)), (usize::MAX, 2, grey(2)), (0, 4, grey(4))] {
        let refused = EnvironmentLight::new(width, height, pixels, DQuat::IDENTITY);
        assert!(matches!(refused, Err(LightError::BadImage { .. })));
    }
    let bad = vec![Rgb::WHITE, Rgb::WHITE, Rgb::new(0.0, f64::NAN, 0.0), Rgb::WHITE];
    let refused = EnvironmentLight::new(2, 2, bad, DQuat::IDENTITY);
    assert!(matches!(refused, Err(LightError::BadPixel { column: 0, row: 1, .. })));
    assert!(EnvironmentLight::new(1, 1, grey(1), DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)).is_err());
    assert!(EnvironmentLight::constant(Rgb::gray(-1.0)).is_err());
    let black = EnvironmentLight::constant(Rgb::BLACK).expect("an environment");
    assert_eq!((black.sample_li([0.5; 2]), black.pdf_li(DVec3::X)), (None, 0.0));
    let light = image(&[(1, 1, 1.0)], turned());
    for direction in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY, DVec3::X * 1e-300, DVec3::X * 1e200] {
        assert!(light.pdf_li(direction).is_finite() && light.le(direction).is_finite(), "{direction}");
    }
    for u in [[f64::NAN; 2], [-1.0; 2], [2.0; 2]] {
        assert!(light.sample_li(u).is_none_or(|s| s.direction.is_finite()));
    }
}
