//! Irradiance from lights of radiance 1 in closed form: expected values for tests.

use rt_math::DVec3;
use rt_math::transcendental::{acos, atan2, sincos};
use std::f64::consts::PI;

/// Irradiance from a polygon of radiance 1 on both sides, at a point of a surface with a unit normal (Lambert 1760; Arvo 1995).
/// The horizon of the surface clips the polygon.
///
/// The corners are those of a flat polygon, in order. Fewer than three give 0, non-finite numbers any number or NaN. Angles
/// come from `atan2`: `acos` of a cosine loses half of the digits of a distant polygon.
///
/// ```
/// use rt_math::DVec3;
/// use rt_shading::light::polygon_irradiance;
///
/// // A unit square from far above is as bright as its solid angle.
/// let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 1000.0));
/// assert!((polygon_irradiance(&square, DVec3::ZERO, DVec3::Z) - 1e-6).abs() < 1e-11);
/// ```
pub fn polygon_irradiance(corners: &[DVec3], point: DVec3, normal: DVec3) -> f64 {
    let corners: Vec<_> = corners.iter().map(|corner| *corner - point).collect();
    let mut above = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (height_a, height_b) = (a.dot(normal), b.dot(normal));
        if height_a >= 0.0 {
            above.push(a);
        }
        if (height_a < 0.0) != (height_b < 0.0) {
            above.push(a.lerp(b, height_a / (height_a - height_b)));
        }
    }
    let edge = |i: usize| {
        let (a, b) = (above[i], above[(i + 1) % above.len()]);
        let across = a.cross(b);
        atan2(across.length(), a.dot(b)) * across.normalize_or_zero().dot(normal)
    };
    0.5 * (0..above.len()).map(edge).sum::<f64>().abs()
}

/// Irradiance from a sphere of radiance 1, also where the horizon clips it (Snyder 1996). NaN for NaN.
///
/// `sin` in (0, 1] is the sine of half the angle that the sphere subtends. `theta` in [0, π] is the angle between its centre and
/// the normal.
pub fn sphere_irradiance(sin: f64, theta: f64) -> f64 {
    let (sin_theta, cos_theta) = sincos(theta);
    if cos_theta >= sin {
        return PI * sin * sin * cos_theta;
    }
    if cos_theta <= -sin {
        return 0.0;
    }
    let cot = (1.0 / (sin * sin) - 1.0).sqrt();
    // Beyond 1 by rounding alone, where the horizon touches the sphere.
    let y = (-cot * cos_theta / sin_theta).clamp(-1.0, 1.0);
    let root = (1.0 - y * y).sqrt();
    sin * sin * (cos_theta * acos(y) - cot * sin_theta * root) + atan2(sin_theta * root, cot)
}

/// Irradiance from a disk of radiance 1 parallel to the surface (Howell, *A Catalog of Radiation Configuration Factors*, 1982).
/// NaN for NaN.
///
/// `radius` and `height` above the surface are positive; `off_axis` is the distance of the point from the axis.
///
/// ```text
///   (π/2) (1 − a/b)     a = h² + d² − r²     b² = (h² + (d − r)²) (h² + (d + r)²) = a² + 4 r² h²
/// ```
pub fn disk_irradiance(radius: f64, height: f64, off_axis: f64) -> f64 {
    let (r, h, d) = (radius, height, off_axis);
    let a = h * h + d * d - r * r;
    let b = ((h * h + (d - r) * (d - r)) * (h * h + (d + r) * (d + r))).sqrt();
    // From afar a and b are nearly equal: 1 − a/b is (b² − a²) / (b (a + b)).
    if a > 0.0 { 2.0 * PI * r * r * h * h / (b * (a + b)) } else { 0.5 * PI * (1.0 - a / b) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_1_SQRT_2;

    fn square(height: f64, aside: f64) -> f64 {
        let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        polygon_irradiance(&corners.map(|[x, y]| DVec3::new(x + aside, y + aside, height)), DVec3::ZERO, DVec3::Z)
    }

    /// Expected values have 40 digits and agree with quadrature.
    #[test]
    fn closed_forms_have_published_values() {
        let triangle = [DVec3::Z, DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, 1.0, 1.0)];
        let triangle = |normal| polygon_irradiance(&triangle, DVec3::ZERO, normal);
        for (name, computed, expected) in [
            ("square above", square(1.0, 0.0), 0.7522746885),
            ("square above a corner", square(1.0, 0.5), 0.4352098757),
            ("triangle", triangle(DVec3::Z), 0.3022998940),
            ("triangle, tilted", triangle(DVec3::ONE.normalize()), 0.2789169159),
            ("sphere", sphere_irradiance(1.0 / 3.0, 0.0), 0.3490658504),
            ("sphere at 60°", sphere_irradiance(1.0 / 3.0, PI / 3.0), 0.1745329252),
            ("sphere at the horizon", sphere_irradiance(1.0 / 3.0, PI / 2.0), 0.0255672289),
            ("sphere at 80°", sphere_irradiance(0.5, 80f64.to_radians()), 0.1718319751),
            ("sphere at 100°", sphere_irradiance(0.5, 100f64.to_radians()), 0.0354490153),
            ("sphere that touches", sphere_irradiance(1.0, PI / 2.0), PI / 2.0),
            ("disk", disk_irradiance(1.0, 1.0, 0.0), 0.5 * PI),
            ("disk, 2 above", disk_irradiance(1.0, 2.0, 0.0), 0.6283185307),
            ("disk, off by 1", disk_irradiance(1.0, 1.0, 1.0), 0.8683148537),
            ("disk, off by 3", disk_irradiance(1.0, 2.0, 3.0), 0.0806080869),
            ("disk of radius 3", disk_irradiance(3.0, 3.0, 3.0), 0.8683148537),
        ] {
            assert!((computed - expected).abs() < 6e-11, "{name}: {computed} instead of {expected}");
        }
    }

    #[test]
    fn lights_far_and_near_keep_their_digits() {
        let is = |computed: f64, expected: f64| (computed / expected - 1.0).abs() < 1e-10;
        assert!(is(square(1000.0, 0.0), 9.9999966667e-7));
        assert!(is(disk_irradiance(1.0, 1e6, 0.0), PI / (1e12 + 1.0)));
        assert!(is(disk_irradiance(1.0, 1e-6, 0.0), PI / (1.0 + 1e-12)));
        // Off the axis, h² above the plane: r² h² π / (d² − r²)² and less of the order of h⁴.
        assert!(is(disk_irradiance(1.0, 1e-6, 2.0), PI * 1e-12 / 9.0));
    }

    #[test]
    fn a_sphere_that_the_horizon_touches_is_whole_or_gone() {
        let (whole, cut) =
            (sphere_irradiance(FRAC_1_SQRT_2, PI / 4.0), sphere_irradiance(FRAC_1_SQRT_2, PI / 4.0 + 1e-9));
        assert!((cut / whole - 1.0).abs() < 1e-8);
        assert_eq!(sphere_irradiance(0.5, 121f64.to_radians()), 0.0);
        for step in 1..1000 {
            let sin = f64::from(step) / 1000.0;
            for theta in [acos(sin), acos(-sin)].map(|theta| [theta.next_down(), theta, theta.next_up()]).concat() {
                let irradiance = sphere_irradiance(sin, theta);
                assert!(
                    (0.0..=PI * sin * sin * sin * 1.001).contains(&irradiance.abs()),
                    "{sin}, {theta}: {irradiance}"
                );
            }
        }
    }

    #[test]
    fn nothing_comes_from_below_the_horizon_or_from_what_has_no_area() {
        assert_eq!(square(-1.0, 0.0), 0.0);
        for corners in [&[][..], &[DVec3::Z], &[DVec3::Z, DVec3::ONE]] {
            assert_eq!(polygon_irradiance(corners, DVec3::ZERO, DVec3::Z), 0.0);
        }
    }
}
