//! Affine transforms that change with time.
//!
//! ```text
//!   M(τ) = T(τ) · R(τ) · S(τ),    T, S linear in τ,  R along the shortest arc
//! ```

use core::fmt;

use crate::{
    Aabb, Transform,
    float::UNIT_ROUNDOFF,
    transcendental::{atan2, sin},
};
use glam::{DMat3, DQuat, DVec3, DVec4};

/// Maximum steps of the polar decomposition. Each halves large errors and squares small ones: a condition number of
/// 10¹² takes 45.
const MAX_STEPS: u32 = 100;

/// Number of time intervals of a rotation in bounds.
const PARTS: u32 = 32;

/// Bound on the roundings between the bounds of a rotating point and the transformed point, relative to its distance.
/// There are fewer than 64, and those of the rotation's parts.
const ROUNDINGS: f64 = 256.0;

/// Transform that changes from one value at time 0 to another at time 1.
///
/// Both are decomposed into translation, rotation and stretch by the polar decomposition (Shoemake and Duff 1992). The
/// rotation is interpolated along the shortest arc at constant speed (Shoemake 1985), the others linearly. So rigid
/// motions stay rigid, and the transform is never singular: a mean of two positive definite stretches is positive
/// definite.
///
/// ```
/// use rt_math::{DVec3, AnimatedTransform, Transform};
///
/// let quarter = Transform::rotate(DVec3::Z, core::f64::consts::FRAC_PI_2)?;
/// let turn = AnimatedTransform::new(&Transform::IDENTITY, &quarter)?;
/// let halfway = turn.at(0.5).point(DVec3::X);
/// assert!((halfway - DVec3::new(1.0, 1.0, 0.0).normalize()).length() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnimatedTransform {
    start: Transform,
    end: Transform,
    rotations: [DQuat; 2],
    /// Angle between the rotations as quaternions, half the angle of the rotation: 0 to π/2.
    angle: f64,
    stretches: [DMat3; 2],
}

/// Error of [`AnimatedTransform::new`]: transforms that cannot be interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnimatedTransformError {
    /// Only one of them mirrors: the transform would be singular at some time.
    Mirrors,
    /// One of them has no polar decomposition: its numbers are too large, too small, or too different.
    Decomposition,
}

impl fmt::Display for AnimatedTransformError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mirrors => "the motion mirrors on its way, where all would be flat",
            Self::Decomposition => "the motion has no rotation: its numbers are too large, too small, or too different",
        })
    }
}

impl core::error::Error for AnimatedTransformError {}

impl AnimatedTransform {
    /// Interpolates from `start` at time 0 to `end` at time 1, rotating by at most half a turn.
    ///
    /// # Errors
    /// [`AnimatedTransformError`] if only one of them mirrors, or one has no polar decomposition.
    pub fn new(start: &Transform, end: &Transform) -> Result<Self, AnimatedTransformError> {
        if start.flips_handedness() != end.flips_handedness() {
            return Err(AnimatedTransformError::Mirrors);
        }
        let (from, first) = polar_decomposition(&start.linear()).ok_or(AnimatedTransformError::Decomposition)?;
        let (to, second) = polar_decomposition(&end.linear()).ok_or(AnimatedTransformError::Decomposition)?;
        let to = shortest_arc(from, to);
        let angle = angle_between(from, to);
        Ok(Self { start: *start, end: *end, rotations: [from, to], angle, stretches: [first, second] })
    }

    /// The transform at time 0.
    pub const fn start(&self) -> &Transform {
        &self.start
    }

    /// The transform at time 1.
    pub const fn end(&self) -> &Transform {
        &self.end
    }

    /// Transform at a time: exactly that of the start or end there and beyond, and that of the start for a NaN.
    #[inline]
    pub fn at(&self, time: f64) -> Transform {
        if !(time > 0.0) {
            return self.start;
        }
        if time >= 1.0 {
            return self.end;
        }
        let [first, second] = self.stretches;
        let translation = self.start.translation().lerp(self.end.translation(), time);
        compose_trs(translation, self.rotation(time), first * (1.0 - time) + second * time)
    }

    /// Rotations at both ends as quaternions with a positive dot product.
    pub(crate) const fn rotations(&self) -> [DQuat; 2] {
        self.rotations
    }

    /// Symmetric stretches at both ends: negative definite for mirroring transforms.
    pub(crate) const fn stretches(&self) -> [DMat3; 2] {
        self.stretches
    }

    fn rotation(&self, time: f64) -> DQuat {
        let [from, to] = self.rotations;
        slerp(from, to, self.angle, time)
    }

    /// Bounds of the image of a box over times 0 to 1. Empty stays empty.
    ///
    /// Without a rotation each point moves along a straight line, and the union of both ends contains it. Otherwise
    /// time is divided into intervals of length 2h around times m. A point is `T(τ) + x(τ)` with `x = R·S·p`; as
    /// `|R'·v| ≤ ω·|v|`, with the angular speed ω, and `S'` is constant,
    ///
    /// ```text
    /// |x(τ) − x(m)| ≤ h·max |x'| ≤ h·(ω·max(|S(0)·p|, |S(1)·p|) + |(S(1) − S(0))·p|),
    /// ```
    ///
    /// where the norms are convex in `p`, so that they are largest at corners of the box. The bounds of `x(m)` are
    /// widened by that, and moved by the translations at both ends of the interval, between which `T` is linear.
    pub fn aabb(&self, aabb: &Aabb) -> Aabb {
        if aabb.is_empty() {
            return Aabb::EMPTY;
        }
        let ends = self.start.aabb(aabb).union(self.end.aabb(aabb));
        let [first, second] = self.stretches;
        let farthest = |map: DMat3| aabb.corners().into_iter().map(|p| (map * p).length()).fold(0.0, f64::max);
        let distance = farthest(first).max(farthest(second));
        let far = distance + self.start.translation().abs().max(self.end.translation().abs()).max_element();
        let rounding = ROUNDINGS * UNIT_ROUNDOFF * far;
        let widened = |aabb: Aabb, by: f64| Aabb::new(aabb.min - by, aabb.max + by);
        if self.angle == 0.0 {
            return widened(ends, rounding);
        }
        let half = 0.5 / f64::from(PARTS);
        let reach = half * (2.0 * self.angle * distance + farthest(second - first)) + rounding;
        let swept = (0..PARTS).map(|part| {
            let middle = self.at((f64::from(part) + 0.5) * 2.0 * half);
            let around_origin = Transform::translate(-middle.translation()).compose(&middle).aabb(aabb);
            let [before, after] = [part, part + 1]
                .map(|at| self.start.translation().lerp(self.end.translation(), f64::from(at) * 2.0 * half));
            let moved = |by: DVec3| Aabb::new(around_origin.min + by, around_origin.max + by);
            widened(moved(before).union(moved(after)), reach)
        });
        swept.fold(ends, Aabb::union)
    }
}

/// Composes a stretch, then a rotation, then a translation.
pub(crate) fn compose_trs(translation: DVec3, rotation: DQuat, stretch: DMat3) -> Transform {
    let rotation = DMat3::from_quat(rotation);
    Transform::from_parts(rotation * stretch, stretch.inverse() * rotation.transpose(), translation)
}

/// The quaternion or its negative, which represent the same rotation: the one closer to `from`.
pub(crate) fn shortest_arc(from: DQuat, to: DQuat) -> DQuat {
    if from.dot(to) < 0.0 { -to } else { to }
}

/// Angle between unit quaternions, half the angle of the rotation between them.
pub(crate) fn angle_between(from: DQuat, to: DQuat) -> f64 {
    2.0 * atan2((to - from).length(), (to + from).length())
}

/// Spherical linear interpolation (Shoemake) of unit quaternions with this angle between them, at a time from 0 to 1.
pub(crate) fn slerp(from: DQuat, to: DQuat, angle: f64, time: f64) -> DQuat {
    let (from, to) = (DVec4::from(from), DVec4::from(to));
    if angle == 0.0 {
        return DQuat::from_vec4(from / from.length());
    }
    let (before, after) = (sin((1.0 - time) * angle), sin(time * angle));
    let sum = if before + after > 0.0 { from * before + to * after } else { from };
    DQuat::from_vec4(sum / sum.length())
}

/// Polar decomposition into a rotation and a symmetric stretch, which is negative definite for a mirroring transform.
///
/// Newton's iteration for the orthogonal factor (Higham 1986): the mean of a matrix and its inverse transpose converges
/// to it.
fn polar_decomposition(linear: &DMat3) -> Option<(DQuat, DMat3)> {
    let scale = linear.to_cols_array().into_iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
    if !(scale > 0.0 && scale.is_finite()) {
        return None;
    }
    let mut orthogonal = *linear * (1.0 / scale);
    for _ in 0..MAX_STEPS {
        let next = (orthogonal + orthogonal.inverse().transpose()) * 0.5;
        let change = (next - orthogonal).to_cols_array().into_iter().fold(0.0, |sum: f64, entry| sum.max(entry.abs()));
        orthogonal = next;
        if change <= 4.0 * UNIT_ROUNDOFF {
            break;
        }
    }
    if orthogonal.determinant() < 0.0 {
        orthogonal = -orthogonal;
    }
    let rotation = DQuat::from_mat3(&orthogonal);
    let rotation = DQuat::from_vec4(DVec4::from(rotation) / rotation.length());
    // Computed from the rounded rotation, so that the product is the transform.
    let stretch = DMat3::from_quat(rotation).transpose() * *linear;
    let stretch = (stretch + stretch.transpose()) * 0.5;
    let error = (DMat3::from_quat(rotation) * stretch - *linear).to_cols_array();
    error.into_iter().all(|entry| entry.abs() <= 1e-10 * scale).then_some((rotation, stretch))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AnimatedTransformChain;
    use core::f64::consts::{FRAC_PI_2, PI};
    use proptest::prelude::*;

    fn vector(range: f64) -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-range..range).prop_map(DVec3::from)
    }

    /// Translation, rotation, shear and scale, without mirroring.
    fn transform() -> impl Strategy<Value = Transform> {
        let factors = prop::array::uniform3(0.2..5.0f64).prop_map(DVec3::from);
        (vector(10.0), vector(1.0), -3.1..3.1f64, factors, -0.4..0.4f64).prop_filter_map(
            "flat",
            |(offset, axis, angle, factors, shear)| {
                let turn = Transform::rotate(axis, angle).ok()?;
                let shear = Transform::shear([shear, 0.2, 0.0, shear, 0.1, -shear]).ok()?;
                let scale = Transform::scale(factors).ok()?;
                Some(Transform::translate(offset).compose(&turn).compose(&shear).compose(&scale))
            },
        )
    }

    fn about_z(angle: f64) -> Transform {
        Transform::rotate(DVec3::Z, angle).expect("an axis")
    }

    fn largest(m: DMat3) -> f64 {
        m.to_cols_array().into_iter().fold(0.0, |sum: f64, entry| sum.max(entry.abs()))
    }

    #[test]
    fn the_ends_are_those_given_to_the_bit() {
        let (start, end) = (about_z(0.3), Transform::translate(DVec3::X).compose(&about_z(1.0)));
        let motion = AnimatedTransform::new(&start, &end).expect("a motion");
        for time in [0.0, -1.0, f64::NAN] {
            assert_eq!(motion.at(time), start);
        }
        assert_eq!(motion.at(1.0), end);
        assert_eq!(motion.at(7.0), end);
    }

    #[test]
    fn turns_have_constant_speed_and_take_the_shorter_way() {
        for (from, to, way) in [(0.0, 2.0, 2.0), (0.1, 0.1 + PI * 1.25, -PI * 0.75), (0.0, PI * 0.999, PI * 0.999)] {
            let motion = AnimatedTransform::new(&about_z(from), &about_z(to)).expect("a motion");
            for time in [0.125, 0.5, 0.75] {
                let (expected, turned) = (about_z(from + way * time), motion.at(time));
                assert!(largest(expected.linear() - turned.linear()) < 1e-14, "{from} {to} {time}");
            }
        }
    }

    #[test]
    fn mirrors_move_into_mirrors_alone() {
        let mirror = Transform::scale(DVec3::new(-1.0, 2.0, 1.0)).expect("regular");
        assert_eq!(AnimatedTransform::new(&mirror, &Transform::IDENTITY), Err(AnimatedTransformError::Mirrors));
        let turned = about_z(FRAC_PI_2).compose(&mirror);
        let motion = AnimatedTransform::new(&mirror, &turned).expect("a motion");
        assert!(largest(motion.at(0.5).linear() - about_z(FRAC_PI_2 / 2.0).compose(&mirror).linear()) < 1e-14);
    }

    #[test]
    fn numbers_beyond_all_measure_are_refused() {
        let wide = Transform::scale(DVec3::new(1e-5, 1.0, 1e6)).expect("regular");
        assert!(AnimatedTransform::new(&wide, &about_z(1.0).compose(&wide)).is_ok());
        let tiny = Transform::scale(DVec3::splat(1e-100)).expect("regular");
        let motion = AnimatedTransform::new(&tiny, &Transform::IDENTITY).expect("a motion");
        assert!((motion.at(0.5).linear().x_axis.x - 0.5).abs() < 1e-15);
    }

    #[test]
    fn boxes_of_straight_motions_are_tight() {
        let unit = Aabb::new(DVec3::ZERO, DVec3::ONE);
        let motion =
            AnimatedTransform::new(&Transform::IDENTITY, &Transform::translate(DVec3::X * 3.0)).expect("a motion");
        let swept = motion.aabb(&unit);
        assert!(swept.encloses(&Aabb::new(DVec3::ZERO, DVec3::new(4.0, 1.0, 1.0))));
        assert!((swept.extent() - DVec3::new(4.0, 1.0, 1.0)).length() < 1e-12);
        assert!(motion.aabb(&Aabb::EMPTY).is_empty());
    }

    #[test]
    fn boxes_of_turns_reach_a_little_beyond_the_arc() {
        let tip = Aabb::new(DVec3::X, DVec3::X);
        let motion = AnimatedTransform::new(&about_z(0.0), &about_z(3.0)).expect("a motion");
        let swept = motion.aabb(&tip);
        assert!(swept.max.y >= 1.0 && swept.max.y < 1.05, "{swept:?}");
        assert!(swept.min.y <= 0.0 && swept.min.y > -0.05, "{swept:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(512))]

        #[test]
        fn the_parts_make_the_map(transform in transform()) {
            let (rotation, stretch) = polar_decomposition(&transform.linear()).expect("a rotation");
            let product = DMat3::from_quat(rotation) * stretch;
            prop_assert!(largest(product - transform.linear()) < 1e-13);
            prop_assert!(stretch.determinant() > 0.0 && (rotation.length() - 1.0).abs() < 1e-15);
        }

        #[test]
        fn rigid_motions_stay_rigid(a in vector(1.0), b in vector(1.0), x in -3.0..3.0f64, y in -3.0..3.0f64, time in 0.0..1.0f64) {
            let turn = |axis: DVec3, angle| Transform::rotate(axis, angle).ok();
            let (Some(start), Some(end)) = (turn(a, x), turn(b, y)) else { return Ok(()) };
            let map = AnimatedTransform::new(&start, &end).expect("a motion").at(time);
            prop_assert!(largest(map.linear().transpose() * map.linear() - DMat3::IDENTITY) < 1e-13);
        }

        #[test]
        fn the_inverse_undoes_at_any_moment(start in transform(), end in transform(), time in 0.0..1.0f64, p in vector(10.0)) {
            let map = AnimatedTransform::new(&start, &end).expect("a motion").at(time);
            prop_assert!((map.inverse_point(map.point(p)) - p).length() < 1e-9);
        }

        #[test]
        fn boxes_contain_their_points_at_any_moment(
            start in transform(), end in transform(), time in 0.0..1.0f64, a in vector(5.0), b in vector(5.0), f in prop::array::uniform3(0.0..=1.0f64),
        ) {
            let motion = AnimatedTransform::new(&start, &end).expect("a motion");
            let inside = a + (b - a) * DVec3::from(f);
            let swept = motion.aabb(&Aabb::from_points([a, b]));
            prop_assert!(swept.contains(motion.at(time).point(inside)));
        }

        #[test]
        fn chains_are_products_and_their_boxes_contain_their_points(
            ends in [transform(), transform(), transform(), transform()], still in transform(), time in 0.0..1.0f64, a in vector(2.0), b in vector(2.0),
        ) {
            let [outer, inner] = [0, 2].map(|i| AnimatedTransform::new(&ends[i], &ends[i + 1]).expect("a motion"));
            let chain = AnimatedTransformChain::constant(still).compose_animated(&outer).compose(&still).compose_animated(&inner);
            let expected = still.point(outer.at(time).point(still.point(inner.at(time).point(a))));
            prop_assert!((chain.at(time).point(a) - expected).length() < 1e-9 * (1.0 + expected.length()));
            prop_assert!(chain.aabb(&Aabb::from_points([a, b])).contains(chain.at(time).point(a)));
        }
    }
}
