//! Axis-aligned boxes and the slab test.

use crate::{Interval, Ray, float::gamma};
use glam::DVec3;

/// Factor of the far side of a box in the slab test, which covers its rounding (Ize, "Robust BVH Ray Traversal", JCGT
/// 2(2), 2013). Accelerators whose boxes replace padded bounds must widen by at least as much.
pub const FAR_FACTOR: f64 = 1.0 + 2.0 * gamma(3);

/// Padding of bounds relative to their largest coordinate, 2⁻⁴⁰. It exceeds the rounding error of the kernels, so that no hit lies
/// outside the padded bounds.
pub const BOUNDS_PADDING: f64 = 1.0 / (1u64 << 40) as f64;

/// A closed axis-aligned box. Empty when `min > max` on any axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Aabb {
    /// Minimum corner.
    pub min: DVec3,
    /// Maximum corner.
    pub max: DVec3,
}

impl Aabb {
    /// Empty box, the neutral element of [`union`](Self::union).
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The box from `min` to `max`.
    #[inline]
    pub const fn new(min: DVec3, max: DVec3) -> Self {
        Self { min, max }
    }

    /// The smallest box around the points; empty for none.
    pub fn from_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::include)
    }

    /// The smallest box around this one and a point.
    #[inline]
    pub fn include(self, point: DVec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// The smallest box around both.
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// True if the box contains no point, or has a NaN corner.
    #[inline]
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// True if all corners are finite numbers.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// True if the point lies in the closed box.
    #[inline]
    pub fn contains(&self, point: DVec3) -> bool {
        self.min.cmple(point).all() && point.cmple(self.max).all()
    }

    /// True if `other` lies within this box.
    #[inline]
    pub fn encloses(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && other.max.cmple(self.max).all()
    }

    /// True if the closed boxes have a point in common. A NaN has none.
    #[inline]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Squared distance from a point to the nearest point of the box; 0 inside. Monotone, also in its rounding: never
    /// larger for a larger box.
    #[inline]
    pub fn distance_squared(&self, point: DVec3) -> f64 {
        let outside = (self.min - point).max(point - self.max).max(DVec3::ZERO);
        outside.x * outside.x + outside.y * outside.y + outside.z * outside.z
    }

    /// Centre of the box. Meaningless for an empty box.
    #[inline]
    pub fn centre(&self) -> DVec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Edge lengths; negative for an empty box.
    #[inline]
    pub fn extent(&self) -> DVec3 {
        self.max - self.min
    }

    /// Surface area; 0 for an empty box.
    pub fn surface_area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let e = self.extent();
        2.0 * (e.x * e.y + e.y * e.z + e.z * e.x)
    }

    /// Largest magnitude of any coordinate.
    #[inline]
    pub fn max_abs(&self) -> f64 {
        self.min.abs().max(self.max.abs()).max_element()
    }

    /// Box widened on all sides by 2⁻⁴⁰ of its largest coordinate.
    #[inline]
    pub fn padded(&self) -> Self {
        let pad = DVec3::splat(self.max_abs() * BOUNDS_PADDING);
        Self { min: self.min - pad, max: self.max + pad }
    }

    /// The eight corners, in unspecified order.
    pub fn corners(&self) -> [DVec3; 8] {
        core::array::from_fn(|i| {
            let pick = |bit: usize, low: f64, high: f64| if i & bit == 0 { low } else { high };
            DVec3::new(
                pick(1, self.min.x, self.max.x),
                pick(2, self.min.y, self.max.y),
                pick(4, self.min.z, self.max.z),
            )
        })
    }

    /// The part of `span` in which the ray is inside the box; `None` if there is none.
    ///
    /// The slab test (Williams et al. 2005) with the far side moved out by a rounding error. `0 · ∞`, a ray in the
    /// plane of a face, is NaN and imposes no constraint, so the box is closed. Each operation is monotone in the box:
    /// a larger box is never entered later nor left earlier. The equality of all accelerators depends on this.
    #[inline(always)]
    pub fn clip(&self, ray: &SlabRay, span: Interval) -> Option<Interval> {
        let Interval { min: mut enter, max: mut leave } = span;
        for axis in 0..3 {
            let (origin, inverse) = (ray.ray.origin[axis], ray.inverse[axis]);
            let (near, far) = if inverse.is_sign_negative() {
                (self.max[axis], self.min[axis])
            } else {
                (self.min[axis], self.max[axis])
            };
            let t_near = (near - origin) * inverse;
            let t_far = (far - origin) * inverse * FAR_FACTOR;
            // A NaN fails both comparisons and keeps the old value.
            if t_near > enter {
                enter = t_near;
            }
            if t_far < leave {
                leave = t_far;
            }
        }
        (enter <= leave).then_some(Interval { min: enter, max: leave })
    }
}

/// Ray with the reciprocals of its direction, prepared for many slab tests.
#[derive(Clone, Copy, Debug)]
pub struct SlabRay {
    /// The ray itself.
    pub ray: Ray,
    /// `1 / direction`, component by component; ±∞ for ±0.
    pub inverse: DVec3,
}

impl SlabRay {
    /// Prepares a ray.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        Self { ray: *ray, inverse: ray.direction.recip() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Aabb = Aabb::new(DVec3::ZERO, DVec3::ONE);

    fn clip(aabb: Aabb, origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, f64)> {
        let ray = SlabRay::new(&Ray::new(origin.into(), direction.into()));
        aabb.clip(&ray, Interval::FORWARD).map(|i| (i.min, (i.max * 1e12).round() / 1e12))
    }

    #[test]
    fn known_values() {
        assert_eq!(clip(UNIT, [-1.0; 3], [1.0; 3]), Some((1.0, 2.0)));
        assert_eq!(clip(UNIT, [-1.0, 0.0, 0.5], [1.0, 0.0, 0.0]), Some((1.0, 2.0)));
        assert_eq!(clip(UNIT, [-1.0, 0.0, 0.5], [1.0, -0.0, 0.0]), Some((1.0, 2.0)));
        assert_eq!(clip(UNIT, [-1.0, 1.0, 0.5], [1.0, -0.0, 0.0]), Some((1.0, 2.0)));
        assert_eq!(clip(UNIT, [0.5; 3], [1.0, 0.0, 0.0]), Some((0.0, 0.5)));
        assert_eq!(clip(UNIT, [0.0, 0.0, 0.5], [0.0, 1.0, 0.0]), Some((0.0, 1.0)));
        assert_eq!(clip(UNIT, [-1.0, 2.0, 0.5], [1.0, 0.0, 0.0]), None);
        assert_eq!(clip(UNIT, [2.0, 0.5, 0.5], [1.0, 0.0, 0.0]), None);
    }

    #[test]
    fn box_without_thickness_is_hit() {
        let flat = Aabb::new(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(clip(flat, [0.5, 0.5, -1.0], [0.0, 0.0, 1.0]), Some((1.0, 1.0)));
    }

    #[test]
    fn empty_box_is_missed_and_has_no_area() {
        assert_eq!(clip(Aabb::EMPTY, [0.0; 3], [1.0; 3]), None);
        assert_eq!(Aabb::EMPTY.surface_area(), 0.0);
        assert!(Aabb::EMPTY.is_empty());
        assert!(Aabb::new(DVec3::NAN, DVec3::ONE).is_empty());
    }

    #[test]
    fn touching_boxes_overlap_and_empty_ones_do_not() {
        let outside = Aabb::new(DVec3::X, DVec3::new(2.0, 1.0, 1.0));
        assert!(UNIT.overlaps(&outside) && outside.overlaps(&UNIT));
        let above = Aabb::new(DVec3::splat(1.0f64.next_up()), DVec3::splat(2.0));
        assert!(!UNIT.overlaps(&above) && !above.overlaps(&UNIT));
        assert!(!UNIT.overlaps(&Aabb::EMPTY) && !UNIT.overlaps(&Aabb::new(DVec3::NAN, DVec3::NAN)));
    }

    #[test]
    fn distances_to_a_box() {
        assert_eq!(UNIT.distance_squared(DVec3::splat(0.5)), 0.0);
        assert_eq!(UNIT.distance_squared(DVec3::new(3.0, 0.5, -1.0)), 5.0);
        assert_eq!(Aabb::EMPTY.distance_squared(DVec3::ZERO), f64::INFINITY);
    }

    #[test]
    fn larger_boxes_are_entered_no_later_and_left_no_earlier() {
        // The monotonicity that culling relies on, with hostile rays: zeros of both signs, grazing, through corners.
        let values = [-1.0, -0.0, 0.0, 1.0, 0.3, 1e-300, 1e17, -3.0];
        let draw = |i: u64, k: u64| values[(crate::random::hash(&[i, k]) % 8) as usize];
        let mut tried = 0;
        for i in 0..200_000 {
            let corner = DVec3::new(draw(i, 0), draw(i, 1), draw(i, 2));
            let inner = Aabb::from_points([corner, DVec3::new(draw(i, 3), draw(i, 4), draw(i, 5))]);
            let outer = inner.include(DVec3::new(draw(i, 6), draw(i, 7), draw(i, 8)));
            let ray = Ray::new(
                DVec3::new(draw(i, 9), draw(i, 10), draw(i, 11)),
                DVec3::new(draw(i, 12), draw(i, 13), draw(i, 14)),
            );
            let ray = SlabRay::new(&ray);
            if let Some(small) = inner.clip(&ray, Interval::FORWARD) {
                let large = outer.clip(&ray, Interval::FORWARD).expect("the larger box is crossed as well");
                assert!(large.min <= small.min && large.max >= small.max, "ray {i}: {large:?} in {small:?}");
                tried += 1;
            }
        }
        assert!(tried > 10_000, "{tried}");
    }
}
