//! Connection of a world point to the camera, for light tracing.

use rt_math::{CameraWiSample, DVec3};

use super::Camera;

impl Camera {
    /// Connects a point to the camera at a time; with a lens, to the lens point of a unit-square sample. `None`
    /// where [`project`](Self::project) is then, and where the point is so near to the camera that its image has no bounds.
    ///
    /// The ray to the point at the depth t has the direction d, whose component along the view is 1. The vectors r and
    /// b are one pixel to the right and down on the image plane. Rays through a pixel fill the solid angle `|d·(r × b)|
    /// / |d|³` where they start. A unit of area at the distance t·|d| thus covers
    ///
    /// ```text
    ///   |d| / (t² |d·(r × b)|)   pixels, and     |d| / |d·(r × b)|    in a parallel projection
    /// ```
    pub fn sample_wi(&self, world: DVec3, on_lens: [f64; 2], time: f64) -> Option<CameraWiSample> {
        if self.moves() {
            return self.at(time).sample_wi(world, on_lens, time);
        }
        let depth = -self.world_from_camera.inverse_point(world).z;
        let raster = match &self.lens {
            None => self.project(world),
            Some(lens) => self.project(world - self.aside(lens, on_lens) * (1.0 - depth / lens.lens().focus)),
        }?;
        let ray = self.generate_ray(raster, on_lens, time);
        let pixel = ray.direction.dot(self.step_right.cross(self.step_down)).abs();
        let nearness = if self.is_perspective { 1.0 / (depth * depth) } else { 1.0 };
        let importance = nearness * ray.direction.length() / pixel;
        let is_sound = importance > 0.0 && importance.is_finite();
        is_sound.then_some(CameraWiSample { origin: ray.origin, raster, importance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CameraSettings, FovAxis, Lens, Projection};
    use rt_math::{DVec2, Transform};

    fn cameras() -> Vec<Camera> {
        let view = Transform::look_at(DVec3::new(1.0, 2.0, 6.0), DVec3::ZERO, DVec3::Y).expect("a view");
        let scale = Transform::scale(DVec3::new(2.0, 0.5, 1.5)).expect("regular");
        let lens = Lens { radius: 0.3, focus: 3.0, blades: Some(5), rotation: 0.2 };
        let perspective = Projection::Perspective { fov: 1.1, axis: FovAxis::Vertical };
        [perspective, Projection::Orthographic { height: 4.0 }]
            .into_iter()
            .flat_map(|projection| [view, view.compose(&scale)].map(|place| CameraSettings::new(place, projection)))
            .flat_map(|settings| [settings, CameraSettings { lens: Some(lens), ..settings }])
            .map(|settings| CameraSettings { lens_shift: DVec2::new(0.1, -0.2), ..settings })
            .map(|settings| Camera::new(&settings, 300, 200).expect("a camera"))
            .collect()
    }

    /// A small square, by the images of its corners.
    #[test]
    fn areas_cover_as_many_pixels_as_is_said() {
        for camera in cameras() {
            for raster in [DVec2::new(150.0, 100.0), DVec2::new(3.0, 190.0), DVec2::new(280.0, 12.0)] {
                let on_lens = [0.3, 0.9];
                let ray = camera.generate_ray(raster, on_lens, 0.0);
                let point = ray.at(4.0);
                let sight = camera.sample_wi(point, on_lens, 0.0).expect("it is in front");
                assert!((sight.raster - raster).length() < 1e-9 && (sight.origin - ray.origin).length() < 1e-12);
                let towards = (point - sight.origin).normalize();
                let (a, b) = towards.any_orthonormal_pair();
                let size = 1e-4;
                let at =
                    |offset: DVec3| camera.sample_wi(point + offset * size, on_lens, 0.0).expect("in front").raster;
                let (u, v) = ((at(a) - at(-a)) / (2.0 * size), (at(b) - at(-b)) / (2.0 * size));
                let ratio = u.perp_dot(v).abs() / sight.importance;
                assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
            }
        }
    }

    #[test]
    fn what_is_behind_is_not_seen() {
        for camera in cameras() {
            let ray = camera.ray(DVec2::new(150.0, 100.0), 0.0);
            assert_eq!(camera.sample_wi(ray.at(-1.0), [0.5; 2], 0.0), None);
            assert_eq!(camera.sample_wi(DVec3::NAN, [0.5; 2], 0.0), None);
        }
    }
}
