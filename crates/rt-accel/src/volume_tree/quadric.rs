//! Intersection of a ray with a sphere or a cylinder, widened for padded bounds.
//!
//! # Why the culling is conservative
//!
//! Round volumes are not monotone as boxes are: the computed chord of a larger sphere may begin later. So they are
//! widened by more than all rounding together. Let `u` be the unit roundoff, and `o` and `d` the origin and direction
//! of a ray. Let a volume with centre `c` contain padded bounds. `reach` is `|o − c|₁` plus the size of the volume, so
//! that no plane `b` of these boxes has `|b − o| > reach` on its axis.
//!
//! **The padded bounds.** Let [`Aabb::clip`](rt_math::Aabb::clip) let the ray pass padded bounds, entered at `τ`. Then
//! the point `o + τd`, of real numbers, is no farther than `16u·reach` from that box, because on each axis one of these
//! holds.
//!
//! * `fl(1/d)` is finite. Then `τ` is not before the entry into the slab, `(b − o)/d` with three relative errors `u`.
//!   Nor is it after the exit, with these and the far factor. That is `11u·reach` at most; what underflows adds
//!   `2⁻¹⁰⁷⁴ |d|`.
//! * It is infinite. Then `|d| < 2⁻¹⁰²³`, and `o` itself is in the slab. On the axis with the largest `|d|`, which is
//!   of the first kind, `|τ| ≤ 2 reach / max|d|`: the ray moves by far less than `u·reach` here.
//!
//! Both need `max|d|` between 2⁻⁴⁰⁰ and 2⁵⁰⁰, and `reach` between 2⁻⁴⁰⁰ and 2⁴⁰⁰. Then parameters do not overflow, and
//! underflow means nothing. The squares below need the same. [`error_margin`] refuses all other numbers, infinities and
//! NaN included; such volumes count as hit.
//!
//! **The chord.** So the point is within `R + 16u·reach` of the centre of the sphere or the axis of the cylinder. Hence
//! `τ` is inside the chord of that radius. With [`error_margin`] `e = 128u·reach` we compute the chord of `R + e`. The
//! parameter of the point closest to the centre is off by `8u|o − c|/|d|`, and its distance `w` by `12u·reach`. The
//! square root is taken of `(R + e)² − w²`, which therefore exceeds its real counterpart with `R + 16u·reach`, its own
//! rounding of `4u(R + e)²` included. All other errors are of parameters, some `10u·reach/|d|` together, and a second
//! `e/|d|` makes the chord longer at either end by more than that. If the root does not exist, no such point does.
//!
//! For a cylinder, `o − c` and `d` are those across it. If `|d|` across is less than `2⁻⁶⁰ max|d|`, the point is as far
//! from the axis as `o` is, within `u·reach`. Then the distance of `o` decides.
//!
//! Hence for every finite ray: padded bounds that pass [`clip`](rt_math::Aabb::clip) are not culled, and their entry is
//! no earlier than the entry into the volume.

use glam::DVec3;
use rt_math::float::UNIT_ROUNDOFF;
use rt_math::{Interval, Ray};

/// A power of two.
const fn exp2(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// Maximum distance of hits from a volume of this size, by rounding, or `None` where the arithmetic over- or
/// underflows. `offset` is from its centre to the origin of the ray.
#[inline(always)]
pub(super) fn error_margin(ray: &Ray, offset: DVec3, size: f64) -> Option<f64> {
    let speed = ray.direction.abs().max_element();
    let reach = offset.abs().element_sum() + size;
    let is_tame = (speed >= exp2(-400)) & (speed <= exp2(500)) & (reach >= exp2(-400)) & (reach <= exp2(400));
    is_tame.then_some(128.0 * UNIT_ROUNDOFF * reach)
}

/// Part of the ray whose distance from the centre, or for a cylinder from its axis, is at most `radius`, widened by
/// `error_margin`. For a cylinder, the components of `offset` and `direction` along it are 0, and `speed` is the
/// largest component of the whole direction.
#[inline(always)]
pub(super) fn chord(offset: DVec3, direction: DVec3, speed: f64, radius: f64, error_margin: f64) -> Option<Interval> {
    let grown = radius + error_margin;
    if direction.abs().max_element() < exp2(-60) * speed {
        let is_inside = offset.length_squared() <= grown * grown;
        return is_inside.then_some(Interval::new(f64::NEG_INFINITY, f64::INFINITY));
    }
    let rate = direction.length_squared();
    let closest = -offset.dot(direction) / rate;
    let across = offset + direction * closest;
    let half_squared = grown * grown - across.length_squared();
    if half_squared < 0.0 {
        return None;
    }
    let half = (half_squared.sqrt() + error_margin) / rate.sqrt();
    Some(Interval::new(closest - half, closest + half))
}

/// Beginning of the intersection of two intervals; `None` if it is empty.
#[inline(always)]
pub(super) fn entry(inside: Interval, span: Interval) -> Option<f64> {
    let enter = if inside.min > span.min { inside.min } else { span.min };
    let leave = if inside.max < span.max { inside.max } else { span.max };
    (enter <= leave).then_some(enter)
}

/// Upper bound of the square root of a computed square, with five roundings and underflow. The largest finite number on
/// overflow, for which [`error_margin`] rejects every ray.
pub(super) fn sqrt_up(square: f64) -> f64 {
    (square.sqrt() * (1.0 + 16.0 * UNIT_ROUNDOFF) + exp2(-511)).min(f64::MAX)
}

#[cfg(test)]
mod tests {
    use super::super::{BoundingCylinder, BoundingSphere, BoundingVolume};
    use super::*;
    use rt_math::random::{hash, unit};
    use rt_math::{Aabb, SlabRay};

    const WHOLE: Interval = Interval::new(f64::NEG_INFINITY, f64::INFINITY);

    /// Numbers that make rounding, cancellation, underflow and NaN likely.
    fn hostile(words: [u64; 3], scale: f64) -> f64 {
        let bits = hash(&words);
        let x = (unit(hash(&[bits])) * 2.0 - 1.0) * scale;
        match bits % 8 {
            0 => 0.0,
            1 => -0.0,
            2 => x.round(),
            3 => x.next_up(),
            4 => x * 1e-12,
            5 => x * 1e-200,
            _ => x,
        }
    }

    fn vector(i: u64, k: u64, scale: f64) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|axis| hostile([i, k, axis], scale)))
    }

    /// Boxes of one or many sizes; the first one is tested.
    fn boxes(i: u64) -> Vec<Aabb> {
        let scale = [1.0, 1e-4, 1e3, 1e7, 1e300, 1e-300, 1e154, 1e-154, 1e120, 1e-120, 1e-310][(i % 11) as usize];
        let offset = f64::min([0.0, 1.0, 1e7, 1e15][(i / 11 % 4) as usize] * scale, 1e300);
        (0..1 + hash(&[i, 99]) % 4)
            .map(|k| {
                let point = |j: u64| vector(i, 10 * k + j, scale) + offset;
                Aabb::from_points([point(0), point(1)]).padded()
            })
            .collect()
    }

    fn hostile_ray(i: u64, own: &Aabb) -> Ray {
        let size = own.max_abs() + own.extent().max_element();
        let mut origin = vector(i, 1000, size * [1.0, 1e6, 1e-6, 1e150][(i % 4) as usize]);
        let mut direction = vector(i, 1001, 1.0);
        let bits = hash(&[i, 1002]);
        match bits % 4 {
            0 => {}
            // Through a corner, where the sphere around one box touches it.
            1 => direction = own.corners()[(bits >> 8) as usize % 8] - origin,
            // Through the corner and along the tangent of that sphere, or nearly so.
            2 => {
                let corner = own.corners()[(bits >> 8) as usize % 8];
                direction = (corner - own.centre()).normalize_or(DVec3::X).any_orthonormal_vector() * size;
                origin = corner - direction * [0.0, 1.0, 1e3, 1e9][(bits >> 12) as usize % 4];
            }
            _ => direction = own.centre() - origin,
        }
        for axis in 0..3 {
            match (bits >> (16 + 8 * axis)) % 12 {
                0 => origin[axis] = own.min[axis],
                1 => origin[axis] = own.max[axis].next_up(),
                2 | 3 => direction[axis] = [0.0, -0.0, 5e-324, -1e-310][(bits >> 40) as usize % 4],
                4 => direction[axis] = direction[axis].next_down(),
                _ => {}
            }
        }
        Ray::new(origin, direction * [1.0, 1.0, 1e-200, 1e200, 1e-100, 1e100, 1e-20, 1e300][(bits >> 48) as usize % 8])
    }

    /// Checks the proof at the top of this file with hostile numbers, without tolerance.
    fn try_out<V: BoundingVolume>() {
        let (mut n_hits, mut n_culled, mut n_late) = (0, 0, 0);
        for i in 0..100_000 {
            let boxes = boxes(i);
            if !boxes.iter().all(Aabb::is_finite) {
                continue;
            }
            let volume = V::around(boxes.iter().copied());
            assert!(boxes.iter().all(|own| volume.encloses(own) && volume.bounds().encloses(own)), "case {i}");
            let own = boxes[0];
            let ray = hostile_ray(i, &own);
            if !crate::ray_query::is_finite(&ray) {
                continue;
            }
            let slab_ray = SlabRay::new(&ray);
            for span in [Interval::FORWARD, Interval::new(-3.0, 2.0), WHOLE, Interval::new(1.0, 1.0)] {
                let enter = volume.enter(&slab_ray, span);
                n_culled += usize::from(enter.is_none());
                n_late += usize::from(enter.is_some_and(|t| t > span.min));
                let Some(expected) = own.clip(&slab_ray, span) else { continue };
                let Some(enter) = enter else { panic!("case {i}: {ray:?} misses {volume:?} around {own:?}") };
                assert!(enter <= expected.min, "case {i}: {enter} {expected:?} {ray:?} {volume:?} {own:?}");
                n_hits += 1;
            }
        }
        assert!(n_hits > 30_000 && n_culled > 30_000 && n_late > 15_000, "{n_hits} {n_culled} {n_late}");
    }

    #[test]
    fn spheres_are_entered_no_later_than_padded_bounds() {
        try_out::<BoundingSphere>();
    }

    #[test]
    fn cylinders_are_entered_no_later_than_padded_bounds() {
        try_out::<BoundingCylinder>();
    }

    #[test]
    fn widening_is_needed() {
        // Without a margin the chord culls rays that pass padded bounds, so that the test above would fail.
        let mut n_culled = 0;
        for i in 0..100_000 {
            let own = boxes(i)[0];
            let ray = hostile_ray(i, &own);
            let sphere = BoundingSphere::around([own].into_iter());
            let (offset, slab_ray) = (ray.origin - sphere.centre(), SlabRay::new(&ray));
            let bare = error_margin(&ray, offset, sphere.radius())
                .is_some_and(|_| chord(offset, ray.direction, 1.0, sphere.radius(), 0.0).is_none());
            n_culled += usize::from(bare && own.clip(&slab_ray, WHOLE).is_some());
        }
        assert!(n_culled > 0);
    }

    #[test]
    fn a_chord_has_the_length_it_should() {
        let unit = |origin: DVec3, direction: DVec3| {
            let error_margin = error_margin(&Ray::new(origin, direction), origin, 1.0).expect("ordinary numbers");
            chord(origin, direction, direction.abs().max_element(), 1.0, error_margin)
        };
        let inside = unit(DVec3::X * -3.0, DVec3::X * 2.0).expect("through the centre");
        assert!((inside.min - 1.0).abs() < 1e-12 && (inside.max - 2.0).abs() < 1e-12, "{inside:?}");
        let inside = unit(DVec3::new(-3.0, 0.6, 0.0), DVec3::X).expect("off the centre");
        assert!((inside.min - 2.2).abs() < 1e-12 && (inside.max - 3.8).abs() < 1e-12, "{inside:?}");
        assert_eq!(unit(DVec3::new(-3.0, 1.000_000_001, 0.0), DVec3::X), None);
        let far = unit(DVec3::new(-3.0e7, 0.0, 1.000_01), DVec3::X);
        assert_eq!(far, None, "culling is as good from afar");
    }

    #[test]
    fn numbers_beyond_the_proof_are_refused() {
        let tame = |origin: f64, direction: f64, size: f64| {
            let ray = Ray::new(DVec3::X * origin, DVec3::X * direction);
            error_margin(&ray, ray.origin, size).is_some()
        };
        assert!(tame(1e7, 1e100, 1e-300) && tame(0.0, 1e-100, 1.0));
        assert!(!tame(1e200, 1.0, 1.0) && !tame(0.0, 1.0, f64::INFINITY) && !tame(f64::NAN, 1.0, 1.0));
        assert!(!tame(0.0, 0.0, 1.0) && !tame(0.0, 5e-324, 1.0) && !tame(0.0, 1e300, 1.0) && !tame(0.0, 1.0, 0.0));
    }
}
