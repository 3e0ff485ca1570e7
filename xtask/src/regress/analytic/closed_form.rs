//! Closed forms of means over a surface, of form factors and of coverage. Irradiance at a point is in
//! `rt_shading::light`.

use std::f64::consts::PI;

use rt_math::transcendental::{acos, atan, cos, log};

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
    use super::*;

    /// Computed with 40 digits, and checked by quadrature.
    #[test]
    fn closed_forms_have_the_values_that_others_computed() {
        for (name, computed, expected) in [
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
    }
}
