//! Closed forms of irradiance from lights of radiance 1, of form factors and of coverage.

use std::f64::consts::PI;

use rt_math::{
    DVec3,
    transcendental::{acos, atan, atan2, cos, log, sincos},
};

/// The irradiance at `point` from a polygon, with what is below the horizon of `normal` cut off (Lambert 1760; Arvo 1995).
/// Angles come from `atan2`: `acos` of a cosine loses half of the digits of a polygon far away.
pub(super) fn polygon(corners: &[DVec3], point: DVec3, normal: DVec3) -> f64 {
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

/// The irradiance from a sphere of which the sine of half the angle is `s`, seen `theta` from the normal; also where the
/// horizon cuts it (Snyder 1996).
pub(super) fn sphere(s: f64, theta: f64) -> f64 {
    let (sin, cos) = sincos(theta);
    if cos >= s {
        return PI * s * s * cos;
    }
    if cos <= -s {
        return 0.0;
    }
    let k = (1.0 / (s * s) - 1.0).sqrt();
    let y = -k * cos / sin;
    let root = (1.0 - y * y).sqrt();
    s * s * (cos * acos(y) - k * sin * root) + atan(sin * root / k)
}

/// The irradiance from a disk of radius `r`, parallel to the receiver at the height `h`, off its axis by `d` (Howell C-14):
/// (π/2)(1 − a / b), with the difference taken so that small disks keep their digits.
pub(super) fn disk(r: f64, h: f64, d: f64) -> f64 {
    let sum = h * h + d * d + r * r;
    let a = sum - 2.0 * r * r;
    let b = (sum * sum - 4.0 * r * r * d * d).sqrt();
    2.0 * PI * r * r * h * h / (b * (a + b))
}

/// Mean of h / (h² + x² + y²)^(3/2) over [0, a] × [0, b]: the irradiance from a point light of intensity 1 above a corner.
pub(super) fn point_light_over_rectangle(a: f64, b: f64, h: f64) -> f64 {
    atan(a * b / (h * (a * a + b * b + h * h).sqrt())) / (a * b)
}

/// Form factor of unit squares that face each other at the distance `d` (Howell C-11).
pub(super) fn parallel_squares(d: f64) -> f64 {
    let x = 1.0 / d;
    let (square, root) = (1.0 + x * x, (1.0 + x * x).sqrt());
    let logarithm = 0.5 * log(square * square / (1.0 + 2.0 * x * x));
    2.0 / (PI * x * x) * (logarithm + 2.0 * x * root * atan(x / root) - 2.0 * x * atan(x))
}

/// Form factor of unit squares at right angles along an edge that they share: what a closed cube leaves to each of four
/// sides.
pub(super) fn perpendicular_squares() -> f64 {
    0.25 * (1.0 - parallel_squares(1.0))
}

/// Form factor of unit disks on one axis at the distance `h` (Howell C-41).
pub(super) fn coaxial_disks(h: f64) -> f64 {
    let x = 2.0 + h * h;
    0.5 * (x - (x * x - 4.0).sqrt())
}

/// The part of a disk on one side of a straight cut at `x` radii from its middle.
pub(super) fn cut_disk(x: f64) -> f64 {
    (acos(x) - x * (1.0 - x * x).sqrt()) / PI
}

/// The area that disks of the radii `a` and `b` have in common, whose middles are `d` apart, neither within the other.
pub(super) fn lens(a: f64, b: f64, d: f64) -> f64 {
    let sector = |r: f64, other: f64| {
        let along = (d * d + r * r - other * other) / (2.0 * d);
        r * r * acos(along / r) - along * (r * r - along * along).sqrt()
    };
    sector(a, b) + sector(b, a)
}

/// The part of a plane at a distance of 1 from a pinhole that a sphere covers, in area: an ellipse. The sine of half its
/// angle is `s`, and it is seen `a` from the axis.
pub(super) fn projected_sphere(s: f64, a: f64) -> f64 {
    let cos = cos(a);
    let below = cos * cos - s * s;
    let (major, minor) = (s * (1.0 - s * s).sqrt() / below, s / below.sqrt());
    PI * major * minor
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_SQRT_2;

    use super::*;

    /// Computed with 40 digits, and checked by quadrature.
    #[test]
    fn closed_forms_have_the_values_that_others_computed() {
        let square = |h: f64, x: f64| {
            let corners =
                [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[a, b]| DVec3::new(a + x, b + x, h));
            polygon(&corners, DVec3::ZERO, DVec3::Z)
        };
        let triangle = [DVec3::Z, DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, 1.0, 1.0)];
        let tilted = DVec3::ONE.normalize();
        for (name, computed, expected) in [
            ("square above", square(1.0, 0.0), 0.7522746885),
            ("square above a corner", square(1.0, 0.5), 0.4352098757),
            ("triangle", polygon(&triangle, DVec3::ZERO, DVec3::Z), 0.3022998940),
            ("triangle, tilted", polygon(&triangle, DVec3::ZERO, tilted), 0.2789169159),
            ("sphere", sphere(1.0 / 3.0, 0.0), 0.3490658504),
            ("sphere at 60°", sphere(1.0 / 3.0, PI / 3.0), 0.1745329252),
            ("sphere at the horizon", sphere(1.0 / 3.0, PI / 2.0), 0.0255672289),
            ("sphere at 80°", sphere(0.5, 80f64.to_radians()), 0.1718319751),
            ("sphere at 100°", sphere(0.5, 100f64.to_radians()), 0.0354490153),
            ("disk", disk(1.0, 1.0, 0.0), 0.5 * PI),
            ("disk, 2 above", disk(1.0, 2.0, 0.0), 0.6283185307),
            ("disk, off by 1", disk(1.0, 1.0, 1.0), 0.8683148537),
            ("disk, off by 3", disk(1.0, 2.0, 3.0), 0.0806080869),
            ("point light", point_light_over_rectangle(1.0, 1.0, 1.0), PI / 6.0),
            ("squares at 1", parallel_squares(1.0), 0.1998248957),
            ("squares at 2", parallel_squares(2.0), 0.0685895888),
            ("squares at .1", parallel_squares(0.1), 0.8269945224),
            ("squares at 10", parallel_squares(10.0), 0.0031620568),
            ("squares at right angles", perpendicular_squares(), 0.2000437761),
            ("disks at 1", coaxial_disks(1.0), 0.3819660113),
            ("disks at 2", coaxial_disks(2.0), 0.1715728753),
            ("half a disk", cut_disk(0.0), 0.5),
            ("a cut at .25", cut_disk(0.25), 0.3425188212),
            ("a cut at .5", cut_disk(0.5), 0.1955011095),
            ("a cut at .75", cut_disk(0.75), 0.0721468064),
            ("unit disks", 1.0 - lens(1.0, 1.0, 1.0) / PI, 0.6089977810),
            ("unit disk and half", 1.0 - lens(1.0, 0.5, 1.0) / PI, 0.8883475203),
            ("sphere in view", projected_sphere(0.25, 0.0) / 4.0, PI / 60.0),
            ("sphere aside", projected_sphere(0.25, atan(0.5)) / 4.0, 0.0750433996),
        ] {
            assert!((computed - expected).abs() < 6e-11, "{name}: {computed} instead of {expected}");
        }
        assert!((square(1000.0, 0.0) / 9.9999966667e-7 - 1.0).abs() < 1e-10);
        assert!((sphere(FRAC_1_SQRT_2, PI / 4.0 + 1e-9) / sphere(FRAC_1_SQRT_2, PI / 4.0) - 1.0).abs() < 1e-8);
    }
}
