//! Exact ray-sphere test, for single spheres, sets of spheres and the SIMD tests of accelerators.

use rt_math::DVec3;
use rt_math::float::{gamma, power_of_two_scale};
use rt_math::{Interval, Ray};

/// Bound on the rounding of the quick rejection: its three dot products, their products and their difference have fewer
/// than 24 roundings of their terms.
const REJECTION: f64 = gamma(24);

/// Sphere for intersection. The radius is positive, and its square neither overflows nor underflows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereKernel {
    /// The centre.
    pub centre: DVec3,
    /// The radius.
    pub radius: f64,
}

impl SphereKernel {
    /// Factors that make the square of a distance a lower bound and the square of a radius an upper bound. For
    /// accelerators with the arithmetic of [`intersect`](Self::intersect).
    pub const REJECTION_BOUNDS: [f64; 2] = [1.0 - REJECTION, 1.0 + REJECTION];

    /// First of the two intersections within `span`. `None` on a miss, and for rays without a direction.
    ///
    /// With f from the centre to the ray's origin, the crossings solve a·t² − 2b·t + c = 0. Three cancellations are
    /// avoided. The discriminant is taken from the ray's closest approach to the centre (Haines, Günther,
    /// Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection", RTG 2019, ch. 7). c is taken from a
    /// difference of lengths rather than of squares, and the smaller root from c/q.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<f64> {
        // Most tests end here.
        if self.quick_reject(ray, span) { None } else { self.crossing(ray, span) }
    }

    /// True only if the ray certainly misses: it starts outside, and passes by or leads away.
    #[inline(always)]
    fn quick_reject(&self, ray: &Ray, span: Interval) -> bool {
        let d = ray.direction;
        let f = ray.origin - self.centre;
        let (a, b, ff, rr) = (d.dot(d), -f.dot(d), f.dot(f), self.radius * self.radius);
        // Positive only if the origin is outside.
        let excess = ff * Self::REJECTION_BOUNDS[0] - rr * Self::REJECTION_BOUNDS[1];
        // Never certain for directions whose square may over- or underflow.
        let passes_by = b * b < a * excess && (1e-100..1e100).contains(&a);
        let lies_behind = excess > 0.0 && b < 0.0 && span.min >= 0.0;
        passes_by | lies_behind
    }

    #[inline(never)]
    fn crossing(&self, ray: &Ray, span: Interval) -> Option<f64> {
        let scale = power_of_two_scale(ray.direction);
        let d = ray.direction * scale;
        let f = ray.origin - self.centre;
        let (a, b, ff, rr) = (d.dot(d), -f.dot(d), f.dot(f), self.radius * self.radius);
        let closest = f + d * (b / a);
        let discriminant = a * (rr - closest.dot(closest));
        if !(0.0..f64::INFINITY).contains(&discriminant) {
            return None;
        }
        let q = b + discriminant.sqrt().copysign(b);
        let length = ff.sqrt();
        let c = (length - self.radius) * (length + self.radius);
        // Both roots are 0 for a tangent at its own origin.
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        span.first(t0.min(t1) * scale, t0.max(t1) * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: SphereKernel = SphereKernel { centre: DVec3::ZERO, radius: 1.0 };

    #[test]
    fn the_first_crossing_within_the_span_is_met() {
        let ray = Ray::new(DVec3::new(0.0, 0.0, -3.0), DVec3::Z);
        let within = |min, max| UNIT.intersect(&ray, Interval::new(min, max));
        assert_eq!(within(0.0, f64::INFINITY), Some(2.0));
        assert_eq!(within(2.5, 4.0), Some(4.0));
        assert_eq!((within(0.0, 1.9), within(2.5, 3.9)), (None, None));
    }

    #[test]
    fn a_distance_is_rejected_only_if_it_is_farther_than_rounding_may_have_put_it() {
        let at = |x: f64| Ray::new(DVec3::new(x, 0.0, -5.0), DVec3::Z);
        let quick_reject = |x: f64| UNIT.quick_reject(&at(x), Interval::FORWARD);
        assert!(quick_reject(1.0 + 1e-12) && !quick_reject(1.0f64.next_up()) && !quick_reject(1.0));
        assert_eq!(UNIT.intersect(&at(1.0f64.next_up()), Interval::FORWARD), None, "by the closest approach");
    }
}
