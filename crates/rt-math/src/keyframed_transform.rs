//! Affine transforms interpolated between keyframes.
//!
//! ```text
//!   M(t) = T(t) · R(t) · S(t),   each through those of the keys, along lines and arcs or along cubic curves
//! ```

use core::fmt;

use crate::{
    AnimatedTransform, AnimatedTransformError, Interpolation, Keyframes, Transform,
    animated_transform::{angle_between, compose_trs, shortest_arc, slerp},
    keyframes::{KeyframePosition, bezier},
    transcendental::{atan2, sincos},
};
use glam::{DMat3, DQuat, DVec3, DVec4};

/// Maximum halvings of a velocity before it is set to zero.
const MAX_HALVINGS: u32 = 64;

/// Transform interpolated between keyframes.
///
/// [`Interpolation::Linear`] uses an [`AnimatedTransform`] between two keys. [`Interpolation::Smooth`] interpolates
/// translations and stretches along cubic curves, and rotations along Bézier curves of spherical interpolations
/// (Shoemake 1985), with continuous velocities. Stretches stay definite, so that the transform is never singular.
///
/// ```
/// use rt_math::{DVec3, Interpolation, Keyframes, Transform, KeyframedTransform};
///
/// let turned = |degrees: f64| Transform::rotate(DVec3::Y, degrees.to_radians());
/// let timeline = Keyframes::new(vec![0.0, 1.0, 3.0], Interpolation::Linear)?;
/// let keys = KeyframedTransform::new(timeline, vec![turned(0.0)?, turned(90.0)?, turned(180.0)?])?;
/// let eighth = keys.at(0.5).point(DVec3::Z);
/// assert!((eighth - DVec3::new(1.0, 0.0, 1.0).normalize()).length() < 1e-15);
/// assert_eq!(keys.at(7.0), turned(180.0)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct KeyframedTransform {
    timeline: Keyframes,
    keys: Vec<Transform>,
    /// Segments between neighbouring keys.
    segments: Vec<AnimatedTransform>,
    /// Velocities at the keys, for smooth interpolation.
    velocities: Vec<Velocity>,
}

/// Rates of change of the three parts of a transform.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Velocity {
    translation: DVec3,
    /// Angle in radians times axis, in the space before the rotation.
    rotation: DVec3,
    stretch: DMat3,
}

/// Error of [`KeyframedTransform::new`]: keys that cannot be interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyframedTransformError {
    /// The number of times (first) differs from the number of transforms (second).
    Count(usize, usize),
    /// The transforms of the previous key and of the key with this index cannot be interpolated.
    AnimatedTransform(usize, AnimatedTransformError),
}

impl fmt::Display for KeyframedTransformError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(times, maps) => write!(f, "there are {times} times, but {maps} transforms"),
            Self::AnimatedTransform(index, error) => write!(f, "on the way to key {index}, {error}"),
        }
    }
}

impl core::error::Error for KeyframedTransformError {}

impl KeyframedTransform {
    /// Interpolates between transforms at the times of the keys.
    ///
    /// # Errors
    /// [`KeyframedTransformError`] if the numbers of transforms and times differ, or only one of two neighbours
    /// mirrors, or one has no polar decomposition.
    pub fn new(timeline: Keyframes, keys: Vec<Transform>) -> Result<Self, KeyframedTransformError> {
        if timeline.times().len() != keys.len() {
            return Err(KeyframedTransformError::Count(timeline.times().len(), keys.len()));
        }
        let segment = |key: usize| {
            AnimatedTransform::new(&keys[key], &keys[key + 1])
                .map_err(|error| KeyframedTransformError::AnimatedTransform(key + 1, error))
        };
        let segments = (0..keys.len() - 1).map(segment).collect::<Result<Vec<_>, _>>()?;
        let mut all = Self { timeline, keys, segments, velocities: Vec::new() };
        if all.timeline.interpolation() == Interpolation::Smooth && !all.segments.is_empty() {
            all.velocities = (0..all.keys.len()).map(|key| all.velocity(key)).collect();
        }
        Ok(all)
    }

    /// Transform at a time. Exactly that of a key at its time, and of the nearest key before the first and after the
    /// last.
    pub fn at(&self, time: f64) -> Transform {
        match self.timeline.find(time) {
            KeyframePosition::Key(key) => self.keys[key],
            KeyframePosition::Between(key, s) => match self.timeline.interpolation() {
                Interpolation::Step => self.keys[key],
                Interpolation::Linear => self.segments[key].at(s),
                Interpolation::Smooth => self.on_curve(key, s),
            },
        }
    }

    fn velocity(&self, key: usize) -> Velocity {
        let per_time = |segment: usize| 1.0 / self.timeline.span(segment);
        let translation = |segment: usize| {
            (self.keys[segment + 1].translation() - self.keys[segment].translation()) * per_time(segment)
        };
        let rotation = |segment: usize| {
            let [from, to] = self.segments[segment].rotations();
            logarithm(from.conjugate() * to) * per_time(segment)
        };
        let stretch = |segment: usize| {
            let [from, to] = self.segments[segment].stretches();
            (to - from) * per_time(segment)
        };
        Velocity {
            translation: self.timeline.velocity(key, translation),
            rotation: self.timeline.velocity(key, rotation),
            stretch: self.definite(key, self.timeline.velocity(key, stretch)),
        }
    }

    /// Velocity of the stretch at a key, halved until the adjacent control points are as definite as the stretch is.
    /// The whole curve is then definite, as a mean of its control points.
    fn definite(&self, key: usize, velocity: DMat3) -> DMat3 {
        let stretch = match self.segments.get(key) {
            Some(segment) => segment.stretches()[0],
            None => self.segments[key - 1].stretches()[1],
        };
        let sign = if stretch.determinant() < 0.0 { -1.0 } else { 1.0 };
        let before = key.checked_sub(1).map_or(0.0, |segment| self.timeline.span(segment));
        let after = if key < self.segments.len() { self.timeline.span(key) } else { 0.0 };
        let mut velocity = velocity;
        for _ in 0..MAX_HALVINGS {
            let controls = [stretch - velocity * (before / 3.0), stretch + velocity * (after / 3.0)];
            if controls.iter().all(|control| is_positive_definite(*control * sign)) {
                return velocity;
            }
            velocity *= 0.5;
        }
        DMat3::ZERO
    }

    fn on_curve(&self, key: usize, s: f64) -> Transform {
        let [from, to] = [self.velocities[key], self.velocities[key + 1]];
        let places = [self.keys[key], self.keys[key + 1]].map(|key| key.translation());
        let translation = bezier(self.timeline.controls(key, places, [from.translation, to.translation]), s);
        let stretches = self.segments[key].stretches();
        let stretch = bezier(self.timeline.controls(key, stretches, [from.stretch, to.stretch]), s);
        let third = self.timeline.span(key) / 3.0;
        let [first, last] = self.segments[key].rotations();
        let out = first * exponential(from.rotation * third);
        let into = last * exponential(to.rotation * -third);
        compose_trs(translation, casteljau([first, out, into, last], s), stretch)
    }
}

/// De Casteljau's construction by spherical interpolations.
fn casteljau([a, b, c, d]: [DQuat; 4], s: f64) -> DQuat {
    let between = |from: DQuat, to: DQuat| {
        let to = shortest_arc(from, to);
        slerp(from, to, angle_between(from, to), s)
    };
    let [ab, bc, cd] = [between(a, b), between(b, c), between(c, d)];
    between(between(ab, bc), between(bc, cd))
}

/// Rotation vector (angle in radians times axis) of a unit quaternion, for at most half a turn.
fn logarithm(rotation: DQuat) -> DVec3 {
    let [x, y, z, w] = rotation.to_array();
    let (axis, w) = if w < 0.0 { (DVec3::new(-x, -y, -z), -w) } else { (DVec3::new(x, y, z), w) };
    let sine = axis.length();
    if sine > 0.0 { axis * (2.0 * atan2(sine, w) / sine) } else { DVec3::ZERO }
}

/// Rotation of a rotation vector.
fn exponential(vector: DVec3) -> DQuat {
    let angle = vector.length();
    if !(angle > 0.0 && angle.is_finite()) {
        return DQuat::IDENTITY;
    }
    let (sine, cosine) = sincos(0.5 * angle);
    let rotation = DVec4::from((vector * (sine / angle), cosine));
    DQuat::from_vec4(rotation / rotation.length())
}

/// Sylvester's criterion, for a symmetric matrix.
fn is_positive_definite(matrix: DMat3) -> bool {
    let [x, y] = [matrix.x_axis, matrix.y_axis];
    x.x > 0.0 && x.x * y.y - x.y * y.x > 0.0 && matrix.determinant() > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn about_z(angle: f64) -> Transform {
        Transform::rotate(DVec3::Z, angle).expect("an axis")
    }

    fn scaled(factor: f64) -> Transform {
        Transform::scale(DVec3::splat(factor)).expect("regular")
    }

    fn keys(interpolation: Interpolation, keys: &[(f64, Transform)]) -> KeyframedTransform {
        let timeline = Keyframes::new(keys.iter().map(|key| key.0).collect(), interpolation).expect("rising");
        KeyframedTransform::new(timeline, keys.iter().map(|key| key.1).collect()).expect("reachable")
    }

    fn largest(m: DMat3) -> f64 {
        m.to_cols_array().into_iter().fold(0.0, |sum: f64, entry| sum.max(entry.abs()))
    }

    #[test]
    fn keys_are_met_to_the_bit_and_held() {
        let [a, b, c] = [about_z(0.3), about_z(1.0), Transform::translate(DVec3::X).compose(&about_z(2.0))];
        for interpolation in [Interpolation::Step, Interpolation::Linear, Interpolation::Smooth] {
            let all = keys(interpolation, &[(0.0, a), (1.0, b), (3.0, c)]);
            for (time, expected) in [(-1.0, a), (0.0, a), (1.0, b), (3.0, c), (9.0, c), (f64::NAN, a)] {
                assert_eq!(all.at(time), expected, "{interpolation:?} {time}");
            }
            let single = keys(interpolation, &[(2.0, b)]);
            assert_eq!([single.at(0.0), single.at(5.0)], [b, b]);
        }
        assert_eq!(keys(Interpolation::Step, &[(0.0, a), (1.0, b)]).at(0.99), a);
    }

    #[test]
    fn straight_ways_are_those_of_motions() {
        let all = keys(Interpolation::Linear, &[(0.0, about_z(0.0)), (2.0, about_z(2.0)), (3.0, about_z(2.5))]);
        for (time, angle) in [(0.5, 0.5), (1.5, 1.5), (2.5, 2.25)] {
            assert!(largest(all.at(time).linear() - about_z(angle).linear()) < 1e-14, "{time}");
        }
    }

    #[test]
    fn smooth_turns_about_one_axis_follow_the_curve_of_the_angle() {
        // As for points: the angles t² have the velocities 2t at the inner keys.
        let times = [-0.5, 0.0, 0.5, 1.0, 1.5];
        let all = keys(Interpolation::Smooth, &times.map(|t| (t, about_z(t * t))));
        for t in [0.0, 0.2, 0.5, 0.7, 0.9, 1.0] {
            // The construction on an arc is that on a line, as all turns share their axis.
            assert!(largest(all.at(t).linear() - about_z(t * t).linear()) < 1e-14, "{t}");
        }
        let ease = keys(Interpolation::Smooth, &[(0.0, about_z(0.0)), (1.0, about_z(1.0))]);
        assert!(largest(ease.at(0.25).linear() - about_z(0.15625).linear()) < 1e-15);
    }

    #[test]
    fn scales_that_shoot_up_do_not_pass_through_nothing() {
        // The velocity of a parabola at the middle key would take the curve before it below 0.
        let all = keys(Interpolation::Smooth, &[(0.0, scaled(1.0)), (1.0, scaled(0.01)), (1.1, scaled(100.0))]);
        for i in 0..=110 {
            let factor = all.at(f64::from(i) * 0.01).linear().x_axis.x;
            assert!(factor > 0.0, "{i}: {factor}");
        }
    }

    #[test]
    fn mirrors_and_counts_are_checked() {
        let mirror = Transform::scale(DVec3::new(-1.0, 1.0, 1.0)).expect("regular");
        let timeline = || Keyframes::new(vec![0.0, 1.0], Interpolation::Smooth).expect("rising");
        let refused = |keys| KeyframedTransform::new(timeline(), keys).expect_err("refused");
        let motion = KeyframedTransformError::AnimatedTransform(1, AnimatedTransformError::Mirrors);
        assert_eq!(refused(vec![Transform::IDENTITY, mirror]), motion);
        assert_eq!(refused(vec![mirror]), KeyframedTransformError::Count(2, 1));
        let both = keys(Interpolation::Smooth, &[(0.0, mirror), (1.0, about_z(1.0).compose(&mirror))]);
        assert!(both.at(0.5).flips_handedness());
    }

    #[test]
    fn exponentials_undo_logarithms() {
        for (axis, angle) in [(DVec3::X, 0.0), (DVec3::Y, 1e-9), (DVec3::new(0.6, 0.0, 0.8), 3.0)] {
            let vector = axis * angle;
            assert!((logarithm(exponential(vector)) - vector).length() < 1e-15 * (1.0 + angle), "{angle}");
        }
    }

    fn rigid() -> impl Strategy<Value = Transform> {
        let vector = |range: f64| prop::array::uniform3(-range..range).prop_map(DVec3::from);
        (vector(1.0), -3.0..3.0f64, vector(10.0)).prop_filter_map("no axis", |(axis, angle, offset)| {
            Some(Transform::translate(offset).compose(&Transform::rotate(axis, angle).ok()?))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        #[test]
        fn smooth_rigid_ways_stay_rigid_and_have_no_kinks(all in prop::array::uniform4(rigid()), time in 0.0..3.5f64) {
            let times = [0.0, 1.0, 1.5, 3.0];
            let keyed = keys(Interpolation::Smooth, &std::array::from_fn::<_, 4, _>(|i| (times[i], all[i])));
            let map = keyed.at(time);
            prop_assert!(largest(map.linear().transpose() * map.linear() - DMat3::IDENTITY) < 1e-13);
            let h = 1e-6;
            for time in times {
                let [before, here, after] = [-h, 0.0, h].map(|d| keyed.at(time + d).point(DVec3::X));
                prop_assert!(((after - here) - (here - before)).length() / h < 1e-2, "{time}");
            }
        }
    }
}
