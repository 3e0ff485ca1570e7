//! The camera as the user leads it: what buttons, wheel and keys do to it.

use std::time::Duration;

use rt_camera::{CameraSettings, Projection};
use rt_math::transcendental::pow;
use rt_math::{DVec2, DVec3};

use super::pose::Pose;

/// Angle that a drag across the height of the window turns by, in radians.
const DRAG: f64 = core::f64::consts::PI;

/// Distance that is left after a notch of the wheel.
const NOTCH: f64 = 0.9;

/// Part of the distance to the target, as it was at first, that is flown in a second.
const SPEED: f64 = 0.5;

/// What holding Shift multiplies the speed of flight by.
const HASTE: f64 = 4.0;

/// What a drag does, by its button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drag {
    /// Go around the target.
    Orbit,
    /// Turn the view.
    Look,
    /// Move along the image.
    Shift,
}

/// A camera that is led around. Until it is, it is that of the scene to the bit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Explorer {
    home: CameraSettings,
    home_pose: Pose,
    camera: CameraSettings,
    pose: Pose,
}

impl Explorer {
    /// Begins with the camera of the scene, whose point of interest lies so far along its view in world units. `None` for a
    /// camera that has no [`Pose`].
    pub(super) fn new(camera: CameraSettings, distance: f64) -> Option<Self> {
        let home_pose = Pose::of(&camera.world_from_camera, distance)?;
        Some(Self { home: camera, home_pose, camera, pose: home_pose })
    }

    /// The camera as it is now.
    pub(super) const fn camera(&self) -> &CameraSettings {
        &self.camera
    }

    /// Where it stands now.
    pub(super) const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Puts the camera back to where it was.
    pub(super) const fn reset(&mut self) {
        (self.camera, self.pose) = (self.home, self.home_pose);
    }

    /// The mouse was dragged so far, as parts of the window's height, to the right and down.
    pub(super) fn drag(&mut self, drag: Drag, way: DVec2) {
        let angle = way * DRAG;
        let pose = self.pose;
        self.go(match drag {
            // What is seen follows the mouse.
            Drag::Orbit => pose.orbit(-angle.x, angle.y),
            Drag::Look => pose.turn(angle.x, -angle.y),
            Drag::Shift => {
                let height = self.height_at_target() / pose.distance();
                pose.pan(-way.x * height, way.y * height)
            }
        });
    }

    /// Goes around the target by angles in radians to the right and up.
    pub(super) fn orbit(&mut self, right: f64, up: f64) {
        self.go(self.pose.orbit(right, up));
    }

    /// The wheel was turned by so many notches, forward counting positive.
    pub(super) fn wheel(&mut self, notches: f64) {
        let factor = pow(NOTCH, notches);
        if let Projection::Orthographic { height } = &mut self.camera.projection {
            // Parallel rays show the same from everywhere along the view.
            let nearer = *height * factor;
            *height = if nearer.is_normal() { nearer } else { *height };
            self.go(self.pose);
        } else {
            self.go(self.pose.dolly(factor));
        }
    }

    /// Keys were held for some time that fly along these axes of the camera.
    pub(super) fn fly(&mut self, along_axes: DVec3, hurries: bool, time: Duration) {
        let speed = SPEED * self.home_pose.distance() * if hurries { HASTE } else { 1.0 };
        self.go(self.pose.fly(along_axes * (speed * time.as_secs_f64())));
    }

    /// Turns to a point.
    pub(super) fn look_at(&mut self, point: DVec3) {
        self.go(self.pose.look_at(point));
    }

    /// The camera stands still from now on, in this pose.
    fn go(&mut self, pose: Pose) {
        if let Some(world_from_camera) = pose.world_from_camera() {
            self.pose = pose;
            self.camera = CameraSettings { world_from_camera, moves_to: None, ..self.camera };
        }
    }

    /// Height of what is seen at the distance of the target, in world units, about.
    fn height_at_target(&self) -> f64 {
        match self.camera.projection {
            Projection::Perspective { fov, .. } => 2.0 * rt_math::transcendental::tan(fov / 2.0) * self.pose.distance(),
            Projection::Orthographic { height } => height,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_camera::FovAxis;
    use rt_math::Transform;

    fn explorer(projection: Projection) -> Explorer {
        let place = Transform::look_at(DVec3::Z * 4.0, DVec3::ZERO, DVec3::Y).expect("a view");
        Explorer::new(CameraSettings::new(place, projection), 4.0).expect("a pose")
    }

    fn perspective() -> Explorer {
        explorer(Projection::Perspective { fov: core::f64::consts::FRAC_PI_2, axis: FovAxis::Vertical })
    }

    #[test]
    fn what_is_seen_follows_the_mouse() {
        let mut orbited = perspective();
        orbited.drag(Drag::Orbit, DVec2::new(0.5, 0.0));
        assert!((orbited.pose().eye - DVec3::X * -4.0).length() < 1e-12, "{:?}", orbited.pose());
        let mut shifted = perspective();
        // At a distance of 4, a right angle shows a height of 8.
        shifted.drag(Drag::Shift, DVec2::new(0.25, 0.5));
        assert!((shifted.pose().eye - DVec3::new(-2.0, 4.0, 4.0)).length() < 1e-12, "{:?}", shifted.pose());
        let mut turned = perspective();
        turned.drag(Drag::Look, DVec2::new(0.5, 0.0));
        assert!((turned.pose().target - DVec3::new(4.0, 0.0, 4.0)).length() < 1e-12, "{:?}", turned.pose());
    }

    #[test]
    fn the_wheel_brings_things_nearer() {
        let mut near = perspective();
        near.wheel(1.0);
        assert!((near.pose().distance() - 3.6).abs() < 1e-12);
        let mut parallel = explorer(Projection::Orthographic { height: 2.0 });
        parallel.wheel(2.0);
        assert!(
            matches!(parallel.camera().projection, Projection::Orthographic { height } if (height - 1.62).abs() < 1e-12)
        );
        assert_eq!(parallel.pose().distance(), 4.0);
        (0..100).for_each(|_| parallel.wheel(1e6));
        assert!(matches!(parallel.camera().projection, Projection::Orthographic { height } if height > 0.0));
    }

    #[test]
    fn flight_takes_time() {
        let mut flown = perspective();
        flown.fly(DVec3::NEG_Z, false, Duration::from_millis(500));
        assert!((flown.pose().eye.z - 3.0).abs() < 1e-12);
        flown.fly(DVec3::NEG_Z, true, Duration::from_millis(500));
        assert!((flown.pose().eye.z + 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_camera_that_was_led_stands_still_and_comes_back_to_the_bit() {
        let home = CameraSettings { moves_to: Some(Transform::translate(DVec3::X)), ..*perspective().camera() };
        let mut explorer = Explorer::new(home, 4.0).expect("a pose");
        assert_eq!(explorer.camera(), &home);
        explorer.orbit(0.1, 0.2);
        explorer.look_at(DVec3::new(0.3, 0.1, 0.0));
        assert_eq!((explorer.camera().moves_to, explorer.pose().target), (None, DVec3::new(0.3, 0.1, 0.0)));
        explorer.reset();
        assert_eq!(explorer.camera(), &home);
    }
}
