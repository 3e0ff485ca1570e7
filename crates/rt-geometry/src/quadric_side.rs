//! Curved side of cylinders, cones and frusta.

use crate::SurfaceInteraction;
use rt_math::float::{difference_of_products, gamma, power_of_two_scale, two_product, two_sum};
use rt_math::transcendental::atan2;
use rt_math::{DVec3, Interval, Ray};
use std::f64::consts::TAU;

/// Points with x² + z² = ρ(y)², where the radius ρ changes linearly with the height: an infinite cylinder (slope 0) or
/// an infinite double cone. The inside has smaller x² + z².
///
/// Heights are relative to that of the given radius, so that ρ is accurate near there: at the apex of a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct QuadricSide {
    /// Height of `radius`.
    pub(crate) height: f64,
    /// Radius at `height`.
    pub(crate) radius: f64,
    /// Change of the radius per height.
    pub(crate) slope: f64,
}

/// Part of a ray inside a [`QuadricSide`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Inside {
    /// The whole ray: it runs along the axis or along a straight line of the surface.
    Everywhere,
    /// From the first parameter to the second. One may be infinite.
    Between(f64, f64),
    /// Up to the first parameter and from the second on: the two nappes of a cone.
    Beyond(f64, f64),
}

impl QuadricSide {
    /// The radius at a height; negative beyond the apex.
    #[inline]
    pub(crate) fn radius_at(&self, y: f64) -> f64 {
        self.radius + self.slope * (y - self.height)
    }

    /// Part of the ray inside; `None` if it is empty, and for rays with a NaN.
    ///
    /// With the radius ρ + σ·t along the ray, the crossings solve a·t² − 2b·t + c = 0. Each cancellation of the
    /// textbook form is avoided. The coefficients are sums of products without loss of digits. The smaller root is c/q.
    /// By Lagrange's identity the discriminant is |ρ·d − σ·o|² − (o × d)² in the plane across the axis. It is computed
    /// as the product of a sum and a difference of lengths.
    #[inline]
    pub(crate) fn inside(&self, ray: &Ray) -> Option<Inside> {
        let scale = power_of_two_scale(ray.direction);
        let (o, d) = (ray.origin, ray.direction * scale);
        let (rho, sigma) = (self.radius_at(o.y), self.slope * d.y);
        let a = dot([d.x, d.z, sigma], [d.x, d.z, -sigma]);
        let b = -dot([o.x, o.z, rho], [d.x, d.z, -sigma]);
        let c = dot([o.x, o.z, rho], [o.x, o.z, -rho]);
        let reach = length(difference_of_products(rho, d.x, sigma, o.x), difference_of_products(rho, d.z, sigma, o.z));
        let cross = difference_of_products(o.x, d.z, o.z, d.x).abs();
        let discriminant = (reach - cross) * (reach + cross);
        // A ray that is steeper than the cone crosses it for any rounding.
        if !discriminant.is_finite() || (a > 0.0 && discriminant < 0.0) {
            return None;
        }
        let q = b + discriminant.max(0.0).sqrt().copysign(b);
        if q == 0.0 && a == 0.0 {
            return (c <= 0.0).then_some(Inside::Everywhere);
        }
        // Both roots are 0 for a tangent at its own origin. A ray along a generator has its second one at infinity.
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        let (near, far) = (t0.min(t1) * scale, t0.max(t1) * scale);
        Some(if a < 0.0 { Inside::Beyond(near, far) } else { Inside::Between(near, far) })
    }

    /// First intersection within `span` that satisfies `wanted`.
    #[inline]
    pub(crate) fn first_crossing(&self, ray: &Ray, span: Interval, wanted: impl Fn(f64) -> bool) -> Option<f64> {
        let (Inside::Between(near, far) | Inside::Beyond(near, far)) = self.inside(ray)? else { return None };
        // The choice is independent of `span.max`: shrinking it reveals no other hit.
        let t = [near, far].into_iter().find(|&t| t >= span.min && t.is_finite() && wanted(t))?;
        (t <= span.max).then_some(t)
    }

    /// Surface at an intersection with the ray, at a height between `bottom` and `top`, without texture coordinates.
    ///
    /// The normal points away from the axis; at an apex it is opposite to the ray.
    pub(crate) fn surface(&self, ray: &Ray, t: f64, [bottom, top]: [f64; 2]) -> SurfaceInteraction {
        let on_ray = ray.at(t);
        let rho = self.radius_at(on_ray.y);
        let (excess, slope) = (length(on_ray.x, on_ray.z) - rho.abs(), self.slope * 1.0f64.copysign(rho));
        let stretch = 1.0 + slope * slope;
        // Back to the surface by the shortest way, which for a flat cone is nearly along the axis.
        let y = (on_ray.y + slope * excess / stretch).clamp(bottom, top);
        let radius = self.radius_at(y).abs();
        let towards_viewer = -ray.direction.normalize_or(DVec3::Y);
        let across = |v: DVec3| DVec3::new(v.x, 0.0, v.z).try_normalize();
        // If rounding puts a faraway hit on the axis, use the side of the viewer.
        let away = across(on_ray).or_else(|| across(towards_viewer)).unwrap_or(DVec3::Z);
        let normal = if radius > 0.0 { (away - DVec3::Y * slope) / stretch.sqrt() } else { towards_viewer };
        let point = away * radius + DVec3::Y * y;
        // Both this radius and the one that the kernel compares it to are off by a few roundings of their terms.
        let terms = self.radius + (slope * (y - self.height)).abs();
        SurfaceInteraction::flat(point, away.abs() * (terms * gamma(12)), normal, [0.0; 2])
    }
}

/// Azimuth around +y as a texture coordinate, from −z over −x, +z (where it is ½) and +x.
pub(crate) fn azimuth(point: DVec3) -> f64 {
    0.5 + atan2(point.x, point.z) / TAU
}

/// The length of a vector in the plane across the axis.
fn length(x: f64, z: f64) -> f64 {
    (x * x + z * z).sqrt()
}

/// Dot product of two vectors, to the last digits even if its terms cancel. Then the errors of all products and sums
/// are added separately (Ogita, Rump, Oishi, "Accurate Sum and Dot Product", 2005, algorithm 5.3).
#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    let terms = [a[0] * b[0], a[1] * b[1], a[2] * b[2]];
    let plain = terms[0] + terms[1] + terms[2];
    if 2.0 * plain.abs() >= terms[0].abs() + terms[1].abs() + terms[2].abs() {
        return plain;
    }
    let (mut sum, mut error) = two_product(a[0], b[0]);
    for i in 1..3 {
        let (product, product_error) = two_product(a[i], b[i]);
        let (next, sum_error) = two_sum(sum, product);
        sum = next;
        error += product_error + sum_error;
    }
    sum + error
}
