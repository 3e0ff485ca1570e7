//! Solid angles of triangles, accurate near and far, and uniform directions within them.

use rt_math::transcendental::{atan2, sincos};
use rt_math::{DVec3, Float64, Vector3};
use std::f64::consts::TAU;

/// Solid angle below which flat lights are sampled by area. The solid angle is the excess of the angles of the projection on the
/// unit sphere. Below this limit fewer than eleven digits of it remain, and variance is almost the same.
pub(super) const MIN_SPHERICAL: f64 = 1.0 / (1u64 << 14) as f64;

/// Solid angle, at most 2π, of a flat figure that is a fan of triangles around its first corner. Each triangle has (Van Oosterom
/// and Strackee, "The Solid Angle of a Plane Triangle", 1983)
///
/// ```text
///   tan(Ω/2) = |a·(b×c)| / (abc + (a·b)c + (b·c)a + (c·a)b)
/// ```
///
/// with corners relative to the receiver. The triple product is `height · area2`: the distance of the plane times twice the
/// area of the triangle, so that far away no digits cancel. Half angles are added as those of complex numbers. 0 for a
/// figure that is edge-on; NaN for a point on a corner.
#[inline(always)]
pub(super) fn of_fan<R: Float64, const N: usize>(corners: [Vector3<R>; N], height: R, area2: f64) -> R {
    let (hub, hub_length, triple) = (corners[0], corners[0].length(), height.abs() * area2);
    let (mut b, mut b_length) = (corners[1], corners[1].length());
    let (mut re, mut im) = (height.splat(1.0), height.splat(0.0));
    for &c in &corners[2..] {
        let c_length = c.length();
        let product = hub_length * b_length * c_length;
        let rest = product + hub.dot(b) * c_length + b.dot(c) * hub_length + c.dot(hub) * b_length;
        let (cos, sin) = (rest / product, triple / product);
        (re, im) = (re * cos - im * sin, re * sin + im * cos);
        (b, b_length) = (c, c_length);
    }
    atan2(im, re) * 2.0
}

/// Maps `u` of the unit square to a unit direction, uniform over a spherical triangle of the given solid angle. Corners are
/// relative to the receiver. Arvo, "Stratified Sampling of Spherical Triangles", 1995.
///
/// The first number selects a part of the area, bounded by an arc from b to a point on the arc from a to c. The second selects a
/// point on the new arc, uniform in the height over b.
pub(super) fn sample_triangle(corners: [DVec3; 3], solid_angle: f64, u: [f64; 2]) -> DVec3 {
    let [a, b, c] = corners.map(DVec3::normalize_or_zero);
    // Sine and cosine of the angle at a, between the great circles to b and to c.
    let (to_b, to_c) = (a.cross(b).normalize_or_zero(), a.cross(c).normalize_or_zero());
    let (sin_alpha, cos_alpha) = (to_b.cross(to_c).length(), to_b.dot(to_c));
    let (sin, cos) = sincos(u[0] * solid_angle);
    let (s, t) = (sin * cos_alpha - cos * sin_alpha, cos * cos_alpha + sin * sin_alpha);
    let (p, q) = (t - cos_alpha, s + sin_alpha * a.dot(b));
    let cos_arc = ((q * t - p * s) * cos_alpha - q) / ((q * s + p * t) * sin_alpha);
    let on_arc = along_arc(a, c, cos_arc.max(a.dot(c)).min(1.0));
    along_arc(b, on_arc, 1.0 - u[1] * (1.0 - on_arc.dot(b)))
}

/// Unit vector on the arc from `start` towards `end` whose cosine with `start` is given.
fn along_arc(start: DVec3, end: DVec3, cos: f64) -> DVec3 {
    let across = (end - start * end.dot(start)).normalize_or_zero();
    start * cos + across * ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt()
}

/// Uniform direction over the sphere.
pub(crate) fn uniform_sphere(u: [f64; 2]) -> DVec3 {
    let z = 1.0 - 2.0 * u[0];
    let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
    let (sin, cos) = sincos(TAU * u[1]);
    DVec3::new(r * cos, r * sin, z)
}
