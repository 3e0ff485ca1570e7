//! Position and target of a camera, and its motions.
//!
//! ```text
//!                 up
//!                 │   orbit: the eye goes around the target
//!      turn ↻ eye ●───────────────▶● target
//!                      dolly, fly
//! ```

use core::f64::consts::FRAC_PI_2;

use rt_math::transcendental::acos;
use rt_math::{DVec3, Transform};

/// Least angle between the view and `up`, in radians. Beyond it the camera would be upside down.
const POLE_DISTANCE: f64 = 0.01;

/// Largest difference that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Position and target of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    pub(super) eye: DVec3,
    pub(super) target: DVec3,
    /// Axis of rotation, and the direction that is up in the image as nearly as possible.
    pub(super) up: DVec3,
    /// Transform before the camera is placed, for a camera that scales or mirrors.
    pub(super) shape: Option<Transform>,
}

impl Pose {
    /// Pose of a camera whose target lies at this distance along its view, in world units. `None` for a camera without a direction,
    /// or for a distance that is not positive.
    pub(super) fn of(world_from_camera: &Transform, distance: f64) -> Option<Self> {
        let axes = world_from_camera.linear();
        let forward = (-axes.z_axis).try_normalize()?;
        let (eye, own_up) = (world_from_camera.translation(), axes.y_axis.try_normalize()?);
        let is_up = |axis: &DVec3| {
            let in_image = (*axis - forward * axis.dot(forward)).normalize_or_zero();
            (in_image - own_up).length() < ROUNDING
        };
        let axes = [DVec3::Y, DVec3::Z, DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z, DVec3::NEG_X];
        let up = axes.into_iter().find(is_up).unwrap_or(own_up);
        let target = Some(eye + forward * distance).filter(|target| target.is_finite() && distance > 0.0)?;
        let bare = Self { eye, target, up, shape: None };
        let shape = bare.placed()?.inverse().compose(world_from_camera);
        let difference = shape.linear() - rt_math::DMat3::IDENTITY;
        let is_bare = difference.to_cols_array().iter().all(|part| part.abs() < ROUNDING);
        // The place is that of the eye exactly.
        let shape = Transform::from_linear(shape.linear(), DVec3::ZERO).ok().filter(|_| !is_bare);
        Some(Self { shape, ..bare })
    }

    /// Transform of the camera. `None` if the eye is in the target, or the view along `up`.
    pub(super) fn world_from_camera(&self) -> Option<Transform> {
        let placed = self.placed()?;
        let Some(shape) = &self.shape else { return Some(placed) };
        // As a matrix, the form in which it is written: its inverse is then rounded as that of the text.
        let shaped = placed.compose(shape);
        Transform::from_linear(shaped.linear(), shaped.translation()).ok()
    }

    fn placed(&self) -> Option<Transform> {
        Transform::look_at(self.eye, self.target, self.up).ok()
    }

    /// Distance from the eye to the target.
    pub(super) fn distance(&self) -> f64 {
        self.eye.distance(self.target)
    }

    /// Moves the eye around the target, by angles in radians to the right and up, as far as the poles.
    pub(super) fn orbit(self, right: f64, up: f64) -> Self {
        let eye = self.target + self.turned(self.eye - self.target, right, up);
        Self { eye, ..self }.or_stay(self)
    }

    /// Rotates the view about the eye, by angles in radians to the right and up, as far as the poles.
    pub(super) fn turn(self, right: f64, up: f64) -> Self {
        let target = self.eye + self.turned(self.target - self.eye, -right, up);
        Self { target, ..self }.or_stay(self)
    }

    /// Moves eye and target by a part of their distance along the axes of the image.
    pub(super) fn pan(self, right: f64, up: f64) -> Self {
        self.fly(DVec3::new(right, up, 0.0) * self.distance())
    }

    /// Moves eye and target along the camera's axes: to the right, up, and backward, in world units.
    pub(super) fn fly(self, along_axes: DVec3) -> Self {
        let Some(placed) = self.placed() else { return self };
        let way = placed.vector(along_axes);
        Self { eye: self.eye + way, target: self.target + way, ..self }.or_stay(self)
    }

    /// Brings the eye to `factor` times its distance from the target.
    pub(super) fn dolly(self, factor: f64) -> Self {
        let eye = self.target + (self.eye - self.target) * factor;
        Self { eye, ..self }.or_stay(self)
    }

    /// Rotates the view towards a point, which becomes the target.
    pub(super) fn look_at(self, target: DVec3) -> Self {
        Self { target, ..self }.or_stay(self)
    }

    /// An arm rotated about `up`, then by `pitch` towards it, as far as the poles.
    fn turned(&self, arm: DVec3, yaw: f64, pitch: f64) -> DVec3 {
        let Some(up) = self.up.try_normalize() else { return arm };
        let Ok(about_up) = Transform::rotate(up, yaw) else { return arm };
        let arm = about_up.vector(arm);
        let Some(side) = arm.cross(up).try_normalize() else { return arm };
        let height = FRAC_PI_2 - acos((arm.normalize_or_zero().dot(up)).clamp(-1.0, 1.0));
        let limit = FRAC_PI_2 - POLE_DISTANCE;
        // A camera that begins beyond the limit is not pushed back by a turn to the other side.
        let limited = (height + pitch).clamp(height.min(-limit), height.max(limit));
        Transform::rotate(side, limited - height).map_or(arm, |pitched| pitched.vector(arm))
    }

    /// The pose if it has a transform, and otherwise the one before.
    fn or_stay(self, before: Self) -> Self {
        if self.world_from_camera().is_some() { self } else { before }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;
    use rt_math::DMat3;

    const FRONT: Pose = Pose { eye: DVec3::new(0.0, 0.0, 5.0), target: DVec3::ZERO, up: DVec3::Y, shape: None };

    fn near(a: DVec3, b: DVec3) -> bool {
        (a - b).length() < 1e-12
    }

    #[test]
    fn an_orbit_keeps_the_distance_and_goes_the_way_it_says() {
        let right = FRONT.orbit(FRAC_PI_2, 0.0);
        assert!(near(right.eye, DVec3::X * 5.0) && right.target == DVec3::ZERO, "{right:?}");
        let up = FRONT.orbit(0.0, PI / 6.0);
        assert!(near(up.eye, DVec3::new(0.0, 2.5, 2.5 * 3f64.sqrt())), "{up:?}");
        let around = (0..360).fold(FRONT, |pose, _| pose.orbit(PI / 180.0, 0.0));
        assert!((around.eye - FRONT.eye).length() < 1e-10, "{around:?}");
    }

    #[test]
    fn the_camera_is_never_upside_down() {
        for far in [3.0, 100.0, -3.0, -100.0] {
            for pose in [FRONT.orbit(0.1, far), FRONT.turn(0.1, far)] {
                let camera = pose.world_from_camera().expect("a pose");
                assert!(camera.linear().y_axis.y > 0.0, "{far}: {pose:?}");
                assert!((pose.distance() - 5.0).abs() < 1e-12);
            }
        }
        assert!(FRONT.orbit(0.0, 10.0).eye.y > 4.99 && FRONT.turn(0.0, 10.0).target.y > 4.99);
    }

    #[test]
    fn a_turn_keeps_the_place() {
        let right = FRONT.turn(FRAC_PI_2, 0.0);
        assert!(right.eye == FRONT.eye && near(right.target, DVec3::new(5.0, 0.0, 5.0)), "{right:?}");
        let up = FRONT.turn(0.0, PI / 4.0);
        assert!(up.target.y > 3.5 && up.target.x == 0.0, "{up:?}");
    }

    #[test]
    fn flying_and_panning_go_along_the_axes_of_the_image() {
        let aside = FRONT.orbit(FRAC_PI_2, 0.0);
        let flown = aside.fly(DVec3::new(0.0, 0.0, -1.0));
        assert!(near(flown.eye, DVec3::X * 4.0) && near(flown.target, -DVec3::X), "{flown:?}");
        let panned = aside.pan(0.2, 0.4);
        assert!(near(panned.eye, DVec3::new(5.0, 2.0, -1.0)) && near(panned.target, DVec3::new(0.0, 2.0, -1.0)));
        assert!(near(FRONT.dolly(0.5).eye, DVec3::Z * 2.5));
    }

    #[test]
    fn motions_without_a_pose_change_nothing() {
        assert_eq!(FRONT.look_at(FRONT.eye), FRONT);
        assert_eq!(FRONT.dolly(0.0), FRONT);
        assert_eq!(FRONT.look_at(DVec3::new(0.0, 7.0, 5.0)), FRONT);
        assert_eq!(FRONT.fly(DVec3::NAN), FRONT);
        assert_eq!(FRONT.fly(DVec3::splat(f64::INFINITY)), FRONT);
    }

    #[test]
    fn a_pose_of_a_camera_stands_where_the_camera_does() {
        let eye = DVec3::new(3.0, 2.0, -1.0);
        for up in [DVec3::Y, DVec3::Z, DVec3::new(0.3, 1.0, -0.2)] {
            let place = Transform::look_at(eye, DVec3::new(-1.0, 0.5, 0.0), up).expect("a view");
            let pose = Pose::of(&place, 2.0).expect("a pose");
            assert_eq!((pose.eye, pose.shape), (eye, None));
            assert!((pose.distance() - 2.0).abs() < 1e-12);
            let camera = pose.world_from_camera().expect("a pose");
            let off = camera.linear() - place.linear();
            assert!(off.to_cols_array().iter().all(|part| part.abs() < 1e-12), "{up}");
            assert!(up == DVec3::new(0.3, 1.0, -0.2) || pose.up == up, "{pose:?}");
        }
        assert!(Pose::of(&Transform::IDENTITY, 0.0).is_none() && Pose::of(&Transform::IDENTITY, f64::NAN).is_none());
    }

    #[test]
    fn cameras_that_scale_or_mirror_go_on_doing_so() {
        let stretch = Transform::scale(DVec3::new(-2.0, 2.0, 3.0)).expect("a scale");
        let place = Transform::look_at(DVec3::Z * 4.0, DVec3::ZERO, DVec3::Y).expect("a view").compose(&stretch);
        let pose = Pose::of(&place, 4.0).expect("a pose");
        let moved = pose.orbit(FRAC_PI_2, 0.0).world_from_camera().expect("a pose");
        let expected = DMat3::from_cols(DVec3::Z * 2.0, DVec3::Y * 2.0, DVec3::X * 3.0);
        assert!(near(moved.translation(), DVec3::X * 4.0));
        let off = moved.linear() - expected;
        assert!(off.to_cols_array().iter().all(|part| part.abs() < 1e-12), "{:?}", moved.linear());
    }
}
