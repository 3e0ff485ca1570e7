//! Planes of any direction.
//!
//! # Why crossings are conservative
//!
//! Let `u` be the unit roundoff, and `o` and `d` the origin and direction of a ray. Let `f(p) = n·p − w` for real
//! numbers, with `n` of unit length but for rounding. Let `M` be the largest magnitudes of coordinates in the bounds of
//! the scene, by axis, and `R = max (|oᵢ| + Mᵢ)`. Let `E` be the parameter at which the slab test enters padded bounds.
//!
//! * `E` has the error of three roundings at the near planes. At the far ones, where the far factor adds to them, it is
//!   at most 12 `u`. So on each axis the ray at `E` is within `13 u·R` of the box. Where the slab test takes the
//!   inverse of `d` to be infinite, the ray counts as not moving, as it does there. Its origin is then in the box.
//!   Hence `f` at `E` is at most `23 u·R` more than its greatest value in the box, as `|n₁| + |n₂| + |n₃| < 1.74`.
//! * The computed `A = n·o − w` is off by at most `4 u·(1.74 R + |w|)`. `E·B`, with the computed `B = n·d`, is off by
//!   `3 u·1.74 R`, as `|E dᵢ|` is no more than `|oᵢ| + Mᵢ` and a little. Where products underflow, it is off by
//!   `13 u·R` more.
//! * A box that lies below only has no point with `f ≥ 0`. Hence `A + E·B < 50 u·(R + |w|)`. So much for real numbers.
//!   Let `e = 128 u·(R + |w|)`. If `B > 0`, the quotient `(e − A)/|B|` is, with its roundings, an upper bound of `E`.
//!   If `B < 0`, its negative is a lower bound. The same holds above, with the signs turned around.
//!
//! `R` is increased by a bound on the underflow of `E` and of the products. Rays whose products may overflow, and those
//! that stay within the bounds forever, are tested against every primitive.
//!
//! [`SplitPlane::classify`] allows for four times the rounding of `f` at a corner. That is twice the sum of its own
//! rounding and that of [`SplitPlane::is_above`] anywhere in the box.

use glam::DVec3;
use rt_math::float::{UNIT_ROUNDOFF, gamma};
use rt_math::{Aabb, Interval, SlabRay};

use crate::space_partition::{PlaneHit, SplitPlane};

/// Uncertainty of an intersection relative to the magnitudes of its terms.
const UNCERTAINTY: f64 = 128.0 * UNIT_ROUNDOFF;

/// Uncertainty of a side relative to the magnitudes of its terms.
const SIDE_UNCERTAINTY: f64 = gamma(16);

/// Largest magnitude for which no sum of products with unit vectors overflows.
const LARGEST: f64 = 1e300;

/// Plane of all points with `normal · p = offset`; above is the side of the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Plane {
    pub(crate) normal: DVec3,
    pub(crate) offset: f64,
}

impl Plane {
    /// Distances along the normal of the nearest and the farthest point of a box, from the origin.
    pub(super) fn heights(normal: DVec3, aabb: &Aabb) -> [f64; 2] {
        let farthest = DVec3::select(normal.cmpge(DVec3::ZERO), aabb.max, aabb.min);
        let nearest = DVec3::select(normal.cmpge(DVec3::ZERO), aabb.min, aabb.max);
        [normal.dot(nearest), normal.dot(farthest)]
    }

    /// The two planes with this normal that are closest to a box on either side without touching it.
    pub(super) fn around(normal: DVec3, aabb: &Aabb) -> [Self; 2] {
        let [low, high] = Self::heights(normal, aabb);
        let gap = 4.0 * uncertainty(normal, aabb, low.abs().max(high.abs()));
        [low - gap, high + gap].map(|offset| Self { normal, offset })
    }
}

/// Uncertainty of the sides of points in a box.
fn uncertainty(normal: DVec3, aabb: &Aabb, offset: f64) -> f64 {
    let largest = aabb.min.abs().max(aabb.max.abs());
    SIDE_UNCERTAINTY * (normal.abs().dot(largest) + offset.abs()) + f64::MIN_POSITIVE
}

/// Ray prepared for planes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneRay {
    origin: DVec3,
    /// Zero where the slab test takes its inverse to be infinite.
    direction: DVec3,
    /// The `R` of the proof.
    reach: f64,
}

impl SplitPlane for Plane {
    type Ray = PlaneRay;

    fn prepare(ray: &SlabRay, bounds: &Aabb, inside: Interval) -> Option<PlaneRay> {
        let (origin, direction) = (ray.ray.origin, ray.ray.direction);
        let still = ray.inverse.abs().cmpeq(DVec3::INFINITY);
        let magnitude = origin.abs() + bounds.min.abs().max(bounds.max.abs());
        let speed = direction.abs().max_element();
        let underflow = f64::MIN_POSITIVE / UNIT_ROUNDOFF * (1.0 + speed);
        let reach = magnitude.max_element() + underflow;
        let is_proven = inside.min.is_finite() && inside.max.is_finite() && reach <= LARGEST && speed <= LARGEST;
        is_proven.then(|| PlaneRay { origin, direction: DVec3::select(still, DVec3::ZERO, direction), reach })
    }

    #[inline(always)]
    fn plane_hit(&self, ray: &PlaneRay) -> PlaneHit {
        let height = self.normal.dot(ray.origin) - self.offset;
        let slope = self.normal.dot(ray.direction);
        let uncertainty = UNCERTAINTY * (ray.reach + self.offset.abs());
        let from_above = slope < 0.0;
        let height = if from_above { -height } else { height };
        let slope = slope.abs();
        PlaneHit { from_above, near_max: (uncertainty - height) / slope, far_min: (-uncertainty - height) / slope }
    }

    #[inline(always)]
    fn is_above(&self, point: DVec3) -> bool {
        self.normal.dot(point) - self.offset >= 0.0
    }

    #[inline(always)]
    fn classify(&self, aabb: &Aabb) -> [bool; 2] {
        let [low, high] = Self::heights(self.normal, aabb);
        let uncertainty = uncertainty(self.normal, aabb, self.offset);
        // A NaN is on both sides.
        [!(low - self.offset > uncertainty), !(high - self.offset < -uncertainty)]
    }

    /// Clips each axis as far as the rest of the box allows.
    fn split_bounds(&self, cell: &Aabb) -> [Aabb; 2] {
        let mut parts = [*cell; 2];
        let [low, high] = Self::heights(self.normal, cell);
        for axis in 0..3 {
            let n = self.normal[axis];
            let (near, far) = if n > 0.0 { (cell.min[axis], cell.max[axis]) } else { (cell.max[axis], cell.min[axis]) };
            // Intersect the plane with the edges along this axis that reach farthest below, and farthest above.
            let last_below = (self.offset - (low - n * near)) / n;
            let first_above = (self.offset - (high - n * far)) / n;
            let within = |x: f64, instead: f64| if x > cell.min[axis] && x < cell.max[axis] { x } else { instead };
            if n > 0.0 {
                parts[0].max[axis] = within(last_below, far);
                parts[1].min[axis] = within(first_above, near);
            } else if n < 0.0 {
                parts[0].min[axis] = within(last_below, far);
                parts[1].max[axis] = within(first_above, near);
            }
        }
        parts
    }

    fn is_tight(&self) -> bool {
        self.normal.to_array().iter().filter(|&&n| n != 0.0).count() == 1
    }

    fn is_valid(&self) -> bool {
        (self.normal.length_squared() - 1.0).abs() < 1e-9 && self.offset.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::Ray;
    use rt_math::random::{hash, unit};

    /// Numbers that make rounding, cancellation and underflow likely.
    fn hostile(words: [u64; 3], scale: f64) -> f64 {
        let bits = hash(&words);
        let x = (unit(hash(&[bits])) * 2.0 - 1.0) * scale;
        match bits % 8 {
            0 => 0.0,
            1 => -0.0,
            2 => x.round(),
            3 => x * 1e-12,
            4 => scale,
            _ => x,
        }
    }

    struct Case {
        own: Aabb,
        bounds: Aabb,
        ray: Ray,
        plane: Plane,
    }

    fn case(i: u64) -> Case {
        let scale = [1.0, 1e-4, 1e3, 1e7, 1e150, 1e-150, 1e-300, 1e290][(i % 8) as usize];
        let offset = DVec3::new(1.0, -0.7, 0.0) * [0.0, 1.0, 1e7][(i / 8 % 3) as usize] * scale;
        let vector = |k: u64, scale: f64| DVec3::from_array([0, 1, 2].map(|axis| hostile([i, k, axis], scale)));
        let own = Aabb::from_points([vector(0, scale) + offset, vector(1, scale) + offset]);
        let bounds = own.include(vector(2, scale) + offset);
        let bits = hash(&[i, 3]);
        let mut origin = offset + vector(4, scale * [1.0, 1e6, 1e-6][(bits % 3) as usize]);
        let mut direction =
            if bits & 8 == 0 { own.corners()[(bits >> 4) as usize % 8] - origin } else { vector(5, 1.0) };
        for axis in 0..3 {
            match (bits >> (16 + 8 * axis)) % 9 {
                0 => origin[axis] = own.min[axis],
                1 => origin[axis] = own.max[axis].next_up(),
                2 => direction[axis] = [0.0, -0.0, 5e-324, -1e-310][(bits >> 40) as usize % 4],
                3 => direction[axis] *= [1e-200, 1e200][(bits >> 40) as usize % 2],
                4 => direction[axis] = direction[axis].next_down(),
                _ => {}
            }
        }
        let normal = match bits >> 60 {
            0..4 => DVec3::AXES[(bits >> 44) as usize % 3],
            // Nearly at right angles to the ray, or to an axis.
            4..8 => direction.cross(vector(6, 1.0)).normalize_or(DVec3::Y),
            8..10 => (DVec3::X + vector(6, 1e-9)).normalize(),
            _ => vector(6, 1.0).normalize_or(DVec3::Z),
        };
        let plane = match (bits >> 50) % 3 {
            0 => Plane::around(normal, &own)[0],
            1 => Plane::around(normal, &own)[1],
            _ => Plane { normal, offset: normal.dot(vector(7, scale) + offset) },
        };
        Case { own, bounds, ray: Ray::new(origin, direction), plane }
    }

    /// Checks the proof at the top of this file with hostile numbers.
    #[test]
    fn boxes_on_one_side_are_entered_within_the_interval_of_that_side() {
        let mut n_sides = [0; 2];
        for i in 0..200_000 {
            let Case { own, bounds, ray, plane } = case(i);
            if !(bounds.is_finite() && crate::ray_query::is_finite(&ray) && plane.is_valid()) {
                continue;
            }
            let slab_ray = SlabRay::new(&ray);
            let [below, above] = plane.classify(&own);
            assert!(below || above, "case {i}: {own:?} is nowhere: {plane:?}");
            for span in [Interval::FORWARD, Interval::new(-3.0, 2.0), Interval::new(f64::NEG_INFINITY, f64::INFINITY)] {
                let Some(outer) = bounds.clip(&slab_ray, span) else { continue };
                let Some(prepared) = Plane::prepare(&slab_ray, &bounds, outer) else { continue };
                let PlaneHit { from_above, near_max, far_min } = plane.plane_hit(&prepared);
                assert!(!(far_min > near_max), "case {i}: {plane:?} {ray:?}");
                let Some(inside) = own.clip(&slab_ray, span).filter(|_| below != above) else { continue };
                if above == from_above {
                    assert!(!(inside.min > near_max), "case {i}: {inside:?} {near_max} {plane:?} {own:?} {ray:?}");
                } else {
                    assert!(!(inside.min < far_min), "case {i}: {inside:?} {far_min} {plane:?} {own:?} {ray:?}");
                }
                n_sides[usize::from(above == from_above)] += 1;
            }
        }
        assert!(n_sides.iter().all(|&n| n > 5_000), "{n_sides:?}");
    }

    #[test]
    fn boxes_are_where_their_points_are() {
        let mut n_one_sided = 0;
        for i in 0..200_000 {
            let Case { own, plane, .. } = case(i);
            if !(own.is_finite() && plane.is_valid()) {
                continue;
            }
            let sides = plane.classify(&own);
            let draw = |k| unit(hash(&[i, 20, k]));
            let weights = DVec3::new(draw(0), draw(1), draw(2));
            let inside = (own.min + (own.max - own.min) * weights).clamp(own.min, own.max);
            for point in own.corners().into_iter().chain([inside]) {
                assert!(sides[usize::from(plane.is_above(point))], "case {i}: {point} in {own:?}, {plane:?}");
            }
            n_one_sided += u32::from(sides != [true; 2]);
        }
        assert!(n_one_sided > 50_000, "{n_one_sided}");
    }

    #[test]
    fn planes_around_a_box_do_not_touch_it() {
        for i in 0..100_000 {
            let Case { own, plane, .. } = case(i);
            if own.is_finite() && plane.is_valid() {
                let [under, over] = Plane::around(plane.normal, &own);
                assert_eq!(
                    (under.classify(&own), over.classify(&own)),
                    ([false, true], [true, false]),
                    "case {i}: {own:?}"
                );
            }
        }
    }

    #[test]
    fn crossings_are_sharp() {
        let plane = Plane { normal: DVec3::new(0.6, 0.8, 0.0), offset: 5.0 };
        let bounds = Aabb::new(DVec3::splat(-10.0), DVec3::splat(10.0));
        for (start, direction, t) in [(DVec3::ZERO, DVec3::X, 5.0 / 0.6), (DVec3::ONE * 9.0, DVec3::NEG_Y, 7.6 / 0.8)] {
            let ray = SlabRay::new(&Ray::new(start, direction));
            let prepared = Plane::prepare(&ray, &bounds, Interval::new(0.0, 20.0)).expect("an ordinary ray");
            let crossing = plane.plane_hit(&prepared);
            assert_eq!(crossing.from_above, direction == DVec3::NEG_Y);
            assert!((crossing.near_max - t).abs() < 1e-11 && (crossing.far_min - t).abs() < 1e-11, "{crossing:?}");
        }
        let prepared = |direction: DVec3, inside: Interval| {
            Plane::prepare(&SlabRay::new(&Ray::new(DVec3::ZERO, direction)), &bounds, inside)
        };
        assert!(prepared(DVec3::X, Interval::FORWARD).is_none(), "stays within the bounds forever");
        assert!(prepared(DVec3::X * 1e305, Interval::new(0.0, 1.0)).is_none(), "products may overflow");
    }

    #[test]
    fn cells_shrink_as_far_as_the_plane_allows() {
        let cell = Aabb::new(DVec3::ZERO, DVec3::ONE);
        let corner = Plane { normal: DVec3::splat(1.0 / 3f64.sqrt()), offset: 0.5 / 3f64.sqrt() };
        let [below, above] = corner.split_bounds(&cell);
        assert!((below.max - 0.5).abs().max_element() < 1e-15 && above == cell, "{below:?} {above:?}");
        let axial = Plane { normal: DVec3::NEG_Y, offset: -0.25 };
        let [below, above] = axial.split_bounds(&cell);
        assert_eq!((below.min, below.max), (DVec3::Y * 0.25, DVec3::ONE));
        assert_eq!((above.min, above.max), (DVec3::ZERO, DVec3::new(1.0, 0.25, 1.0)));
    }
}
