//! Camera moved by drags, wheel, and keys.

use rt_camera::{CameraSettings, Projection};
use rt_math::transcendental::{pow, tan};
use rt_math::{DVec2, DVec3};
use serde::Deserialize;

use super::pose::Pose;

/// Angle of a drag across the height of the image, in radians.
const DRAG: f64 = core::f64::consts::PI;

/// Factor of the distance to the target for a notch of the wheel.
const NOTCH: f64 = 0.9;

/// Share of the first distance to the target that is flown in a second.
const SPEED: f64 = 0.5;

/// Longest flight of one command, in seconds.
const MAX_FLIGHT: f64 = 1.0;

/// Change of the camera. Drags are to the right and down, in heights of the image.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum CameraCommand {
    /// Go around the target by a drag.
    Orbit(DVec2),
    /// Turn the view by a drag.
    Look(DVec2),
    /// Move along the image by a drag.
    Pan(DVec2),
    /// Approach the target by notches of a wheel.
    Zoom(f64),
    /// Fly along the camera's axes, to the right, up, and backward, for some seconds.
    Fly(DVec3),
    /// Turn to a point, which becomes the target.
    LookAt(DVec3),
    /// Go back to the first camera.
    Reset,
}

/// A camera, bit-identical to the scene's until it is moved.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraController {
    home: CameraSettings,
    home_pose: Pose,
    camera: CameraSettings,
    pose: Pose,
}

impl CameraController {
    /// Begins with a camera whose target lies at this distance along its view, in world units. `None` for a camera without
    /// a [`Pose`].
    pub(super) fn new(camera: CameraSettings, distance: f64) -> Option<Self> {
        let home_pose = Pose::of(&camera.world_from_camera, distance)?;
        Some(Self { home: camera, home_pose, camera, pose: home_pose })
    }

    pub(super) const fn camera(&self) -> &CameraSettings {
        &self.camera
    }

    /// True while no command has moved the camera, and after a reset.
    pub(super) fn is_at_home(&self) -> bool {
        self.camera == self.home && self.pose == self.home_pose
    }

    pub(super) const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Moves the camera. A command without a valid pose has no effect.
    pub(super) fn apply(&mut self, command: &CameraCommand) {
        let pose = self.pose;
        let moved = match *command {
            // What is seen follows the pointer.
            CameraCommand::Orbit(drag) => pose.orbit(-drag.x * DRAG, drag.y * DRAG),
            CameraCommand::Look(drag) => pose.turn(drag.x * DRAG, -drag.y * DRAG),
            CameraCommand::Pan(drag) => {
                let height = self.height_at_target() / pose.distance();
                pose.pan(-drag.x * height, drag.y * height)
            }
            CameraCommand::Zoom(notches) => self.zoom(pow(NOTCH, notches)),
            CameraCommand::Fly(seconds) => {
                pose.fly(seconds.clamp_length_max(MAX_FLIGHT) * (SPEED * self.home_pose.distance()))
            }
            CameraCommand::LookAt(point) => pose.look_at(point),
            CameraCommand::Reset => {
                (self.camera, self.pose) = (self.home, self.home_pose);
                return;
            }
        };
        self.place(moved);
    }

    /// Multiplies the distance to the target. Parallel rays show the same from everywhere along the view: their image gets smaller
    /// instead.
    fn zoom(&mut self, factor: f64) -> Pose {
        let Projection::Orthographic { height } = &mut self.camera.projection else { return self.pose.dolly(factor) };
        let zoomed = *height * factor;
        *height = if zoomed.is_normal() { zoomed } else { *height };
        self.pose
    }

    /// Makes the camera static in this pose.
    fn place(&mut self, pose: Pose) {
        if let Some(world_from_camera) = pose.world_from_camera() {
            self.pose = pose;
            self.camera = CameraSettings { world_from_camera, moves_to: None, ..self.camera };
        }
    }

    /// Height of the image at the distance of the target, in world units, about.
    fn height_at_target(&self) -> f64 {
        match self.camera.projection {
            Projection::Perspective { fov, .. } => 2.0 * tan(fov / 2.0) * self.pose.distance(),
            Projection::Orthographic { height } => height,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_camera::FovAxis;
    use rt_math::Transform;

    fn controller(projection: Projection) -> CameraController {
        let place = Transform::look_at(DVec3::Z * 4.0, DVec3::ZERO, DVec3::Y).expect("a view");
        CameraController::new(CameraSettings::new(place, projection), 4.0).expect("a pose")
    }

    fn perspective() -> CameraController {
        controller(Projection::Perspective { fov: core::f64::consts::FRAC_PI_2, axis: FovAxis::Vertical })
    }

    #[test]
    fn what_is_seen_follows_the_pointer() {
        let mut orbited = perspective();
        orbited.apply(&CameraCommand::Orbit(DVec2::new(0.5, 0.0)));
        assert!((orbited.pose().eye - DVec3::X * -4.0).length() < 1e-12, "{:?}", orbited.pose());
        let mut shifted = perspective();
        // At a distance of 4, a right angle shows a height of 8.
        shifted.apply(&CameraCommand::Pan(DVec2::new(0.25, 0.5)));
        assert!((shifted.pose().eye - DVec3::new(-2.0, 4.0, 4.0)).length() < 1e-12, "{:?}", shifted.pose());
        let mut turned = perspective();
        turned.apply(&CameraCommand::Look(DVec2::new(0.5, 0.0)));
        assert!((turned.pose().target - DVec3::new(4.0, 0.0, 4.0)).length() < 1e-12, "{:?}", turned.pose());
    }

    #[test]
    fn the_wheel_approaches_the_target() {
        let mut near = perspective();
        near.apply(&CameraCommand::Zoom(1.0));
        assert!((near.pose().distance() - 3.6).abs() < 1e-12);
        let mut parallel = controller(Projection::Orthographic { height: 2.0 });
        parallel.apply(&CameraCommand::Zoom(2.0));
        assert!(
            matches!(parallel.camera().projection, Projection::Orthographic { height } if (height - 1.62).abs() < 1e-12)
        );
        assert_eq!(parallel.pose().distance(), 4.0);
        (0..100).for_each(|_| parallel.apply(&CameraCommand::Zoom(1e6)));
        assert!(matches!(parallel.camera().projection, Projection::Orthographic { height } if height > 0.0));
    }

    #[test]
    fn flight_takes_time() {
        let mut flown = perspective();
        flown.apply(&CameraCommand::Fly(DVec3::NEG_Z * 0.5));
        assert!((flown.pose().eye.z - 3.0).abs() < 1e-12);
        flown.apply(&CameraCommand::Fly(DVec3::NEG_Z * 1e9));
        assert!((flown.pose().eye.z - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_moved_camera_stands_still_and_comes_back_to_the_bit() {
        let home = CameraSettings { moves_to: Some(Transform::translate(DVec3::X)), ..*perspective().camera() };
        let mut controller = CameraController::new(home, 4.0).expect("a pose");
        assert!(controller.is_at_home() && controller.camera() == &home);
        controller.apply(&CameraCommand::Orbit(DVec2::new(0.1, 0.2)));
        controller.apply(&CameraCommand::LookAt(DVec3::new(0.3, 0.1, 0.0)));
        assert_eq!((controller.camera().moves_to, controller.pose().target), (None, DVec3::new(0.3, 0.1, 0.0)));
        assert!(!controller.is_at_home());
        controller.apply(&CameraCommand::Reset);
        assert!(controller.is_at_home() && controller.camera() == &home);
    }
}
