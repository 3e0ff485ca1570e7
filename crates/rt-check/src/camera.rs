//! Distance and precision of visible points.

use std::fmt;

use rt_camera::Camera;
use rt_math::{DVec2, DVec3, Ray};
use rt_render::{RenderSpace, SceneGeometry};

use crate::finding::{Finding, Findings, Kind};
use crate::number::short_number;
use crate::objects::Objects;

/// Cells along each side of the image; one ray passes through the middle of each.
const CELLS: u32 = 64;

/// Acceptable displacement of visible points by rounding, in pixels.
const VISIBLE: f64 = 0.01;

/// Smallest acceptable size of the whole scene, in pixels.
const TOO_SMALL: f64 = 2.0;

/// Smallest acceptable angle between neighbouring rays, in radians: their directions share ten digits.
const NARROW: f64 = 1e-10;

/// View of a camera, measured by a few thousand rays. Lengths are in world units.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraMeasures {
    /// Name of the camera.
    pub name: String,
    /// Rays cast.
    pub rays: u64,
    /// Rays that hit something.
    pub hits: u64,
    /// Distance of the nearest hit; 0 without any.
    pub nearest: f64,
    /// Distance of the farthest hit; 0 without any.
    pub farthest: f64,
    /// Maximum bound on the rounding error of a hit point, from its shape and transforms.
    pub position_error: f64,
    /// Maximum bound on the rounding error of a hit point, in pixels.
    pub position_error_in_pixels: f64,
    /// Angle between neighbouring rays in the middle of the image, in radians; 0 for parallel rays.
    pub pixel_angle: f64,
}

impl fmt::Display for CameraMeasures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "camera {:<10}", self.name)?;
        if self.hits == 0 {
            return writeln!(f, "none of {} rays hits an object", self.rays);
        }
        let Self { rays, hits, nearest, farthest, position_error: error, position_error_in_pixels: pixels, .. } = self;
        let share = 100.0 * *hits as f64 / *rays as f64;
        let [nearest, farthest] = [*nearest, *farthest].map(|distance| short_number(distance, 5));
        writeln!(f, "sees objects {nearest} to {farthest} away ({share:.1} % of {rays} rays);")?;
        writeln!(f, "                 rounding moves them by at most {error:.1e}, {pixels:.1e} pixels")
    }
}

/// Traces a grid of camera rays against the geometry that a render would trace.
fn measure(name: &str, camera: &Camera, size: DVec2, geometry: &SceneGeometry) -> CameraMeasures {
    let mut measures = CameraMeasures {
        name: name.to_owned(),
        rays: u64::from(CELLS * CELLS),
        hits: 0,
        nearest: f64::INFINITY,
        farthest: 0.0,
        position_error: 0.0,
        position_error_in_pixels: 0.0,
        pixel_angle: pixel_angle(camera, size),
    };
    for cell in 0..CELLS * CELLS {
        let middle = DVec2::new(f64::from(cell % CELLS) + 0.5, f64::from(cell / CELLS) + 0.5);
        let raster = middle * size / f64::from(CELLS);
        let ray = camera.ray(raster, 0.0);
        let Some(hit) = geometry.closest_hit(&ray) else { continue };
        // Without the sign of a negative zero.
        let distance = hit.t.abs() * ray.direction.length();
        let error = hit.interaction.point_error.length();
        measures.hits += 1;
        measures.nearest = measures.nearest.min(distance);
        measures.farthest = measures.farthest.max(distance);
        measures.position_error = measures.position_error.max(error);
        let footprint = footprint(camera, raster, &ray, hit.t);
        let part = if footprint == 0.0 { f64::INFINITY } else { error / footprint };
        measures.position_error_in_pixels = measures.position_error_in_pixels.max(part);
    }
    if measures.hits == 0 {
        measures.nearest = 0.0;
    }
    measures
}

/// Distance of the points of neighbouring pixels at the same ray parameter.
fn footprint(camera: &Camera, raster: DVec2, ray: &Ray, t: f64) -> f64 {
    // Origins and directions are subtracted first: the points themselves may be far from the origin.
    let neighbour = camera.ray(raster + DVec2::X, 0.0);
    ((neighbour.origin - ray.origin) + (neighbour.direction - ray.direction) * t).length()
}

fn pixel_angle(camera: &Camera, size: DVec2) -> f64 {
    let [a, b] = [DVec2::ZERO, DVec2::X].map(|step| camera.ray(size * 0.5 + step, 0.0).direction);
    (b - a).length() / a.length()
}

/// Measures and checks all cameras. The geometry is `None` if the renderer rejects the scene.
pub(crate) fn check(
    objects: &Objects<'_>,
    space: RenderSpace,
    geometry: Option<&SceneGeometry>,
    findings: &mut Findings,
) -> Vec<CameraMeasures> {
    let film = &objects.scene.film;
    let mut all = Vec::new();
    for named in &objects.scene.cameras {
        match Camera::new(&space.camera(&named.settings), film.width, film.height) {
            Err(error) => {
                let finding = Finding::new(Kind::CannotRender, &named.name, &[], error.to_string());
                findings.add(finding.with_advice("fix the camera or the film"));
            }
            Ok(camera) => {
                let Some(geometry) = geometry else { continue };
                let size = DVec2::new(f64::from(film.width), f64::from(film.height));
                let measures = measure(&named.name, &camera, size, geometry);
                let eye = named.settings.world_from_camera.translation();
                check_camera(objects, &camera, size, eye, &measures, findings);
                all.push(measures);
            }
        }
    }
    all
}

fn check_camera(
    objects: &Objects<'_>,
    camera: &Camera,
    size: DVec2,
    eye: DVec3,
    measures: &CameraMeasures,
    findings: &mut Findings,
) {
    let finding = |kind, values: &[_], message| Finding::new(kind, &measures.name, values, message);
    let bounds = objects.bounds();
    let extent = bounds.extent().max_element();
    let distance = (bounds.centre() - eye).length();
    let ray = camera.ray(size * 0.5, 0.0);
    let pixels = extent / footprint(camera, size * 0.5, &ray, distance / ray.direction.length());
    if !bounds.is_empty() && pixels < TOO_SMALL {
        let message = format!("the scene is {distance:.3e} away, and covers {pixels:.3} pixels");
        findings.add(finding(Kind::CameraFar, &[("distance", distance), ("pixels", pixels)], message));
    } else if measures.hits == 0 {
        let rays = measures.rays;
        let nothing = |message| finding(Kind::CameraSeesNothing, &[("rays", rays as f64)], message);
        findings.add(if objects.list.is_empty() {
            nothing("the scene has no objects".to_owned()).with_advice("add nodes with shapes or models")
        } else {
            nothing(format!("none of {rays} rays hits an object; the centre of the scene is {distance:.3e} away"))
        });
    }
    if measures.pixel_angle > 0.0 && measures.pixel_angle < NARROW {
        let angle = measures.pixel_angle.to_degrees();
        let message = format!("neighbouring rays are {angle:.3e} degrees apart");
        findings.add(finding(Kind::NarrowView, &[("pixel_angle", angle)], message));
    }
    let (error, pixels) = (measures.position_error, measures.position_error_in_pixels);
    if pixels > VISIBLE {
        let values = [("position_error", error), ("position_error_in_pixels", pixels)];
        findings.add(if pixels.is_finite() {
            let message = format!("rounding may move visible points by {error:.3e}, {pixels:.3} pixels");
            finding(Kind::CameraPrecision, &values, message)
        } else {
            let message = "the camera lies on a surface, up to rounding".to_owned();
            finding(Kind::CameraPrecision, &values, message).with_advice("move the camera off the surface")
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::*;
    use rt_camera::Projection;
    use rt_math::transcendental::tan;

    #[test]
    fn distances_and_errors_are_measured() {
        let report = crate::check(&seen_from(DVec3::Z * 5.0, vec![sphere(DVec3::ZERO, 1.0)]));
        assert_eq!(report.measures.cameras.len(), 1);
        let seen = &report.measures.cameras[0];
        assert!((4.0..4.01).contains(&seen.nearest), "{seen:?}");
        assert!((4.7..24f64.sqrt()).contains(&seen.farthest), "{seen:?}");
        assert!((1e-17..1e-14).contains(&seen.position_error), "{seen:?}");
        // The field of view is 40 degrees over 48 pixels: a pixel is some 0.06 wide at the sphere.
        assert!((seen.position_error_in_pixels * 0.06 / seen.position_error - 1.0).abs() < 0.3, "{seen:?}");
        // The half angle of the sphere is asin(1/5). It covers the fraction π (tan/tan 20°)²/4 of the square image.
        let tangent = 0.2 / 0.96f64.sqrt() / tan(20f64.to_radians());
        let share = seen.hits as f64 / seen.rays as f64;
        assert!((share - std::f64::consts::FRAC_PI_4 * tangent * tangent).abs() < 0.01, "{seen:?}");
    }

    #[test]
    fn a_scene_without_objects_shows_nothing() {
        let scene = seen_from(DVec3::Z * 5.0, Vec::new());
        assert_eq!(only(&scene, Kind::CameraSeesNothing).message, "the scene has no objects");
    }

    #[test]
    fn a_scene_behind_the_camera_is_not_seen() {
        let scene = seen_from(DVec3::Z * 5.0, vec![sphere(DVec3::Z * 9.0, 1.0)]);
        assert_eq!(only(&scene, Kind::CameraSeesNothing).values, [value("rays", 4096.0)]);
    }

    #[test]
    fn a_scene_smaller_than_a_pixel_is_too_far() {
        let scene = seen_from(DVec3::Z * 1e4, vec![sphere(DVec3::ZERO, 1.0)]);
        let finding = only(&scene, Kind::CameraFar);
        let pixel = 1e4 * 2.0 * tan(20f64.to_radians()) / 48.0;
        assert!((finding.values[1].value - 2.0 / pixel).abs() < 1e-3, "{finding:?}");
    }

    #[test]
    fn a_telescope_into_the_void_is_too_narrow() {
        let mut scene = seen_from(DVec3::Z * 5.0, vec![sphere(DVec3::ZERO, 1.0)]);
        let fov = 4.8e-10f64;
        if let Projection::Perspective { fov: angle, .. } = &mut scene.cameras[0].settings.projection {
            *angle = fov;
        }
        let finding = only(&scene, Kind::NarrowView);
        assert!((finding.values[0].value - (fov / 48.0).to_degrees()).abs() < 1e-15, "{finding:?}");
    }

    #[test]
    fn rounding_shows_far_from_the_origin() {
        let far = DVec3::X * 1e14;
        // Render space moves a scene as a whole: objects far from the rest of it stay far.
        let mut scene = scene_with(vec![sphere(far, 2.0), sphere(DVec3::ZERO, 2.0)]);
        scene.cameras = vec![camera(far + DVec3::Z * 8.0, far)];
        let finding = &of_kind(&scene, Kind::CameraPrecision)[0];
        assert!(finding.values[1].value > VISIBLE, "{finding:?}");
    }

    #[test]
    fn a_camera_on_a_surface_is_to_leave_it() {
        // On the floor, the rounding error is 0.
        for surface in [sphere(DVec3::ZERO, 2.0), floor(0.0)] {
            let finding = &of_kind(&seen_from(DVec3::Z * 2.0, vec![surface]), Kind::CameraPrecision)[0];
            assert_eq!(finding.message, "the camera lies on a surface, up to rounding");
            assert_eq!(finding.advice, "move the camera off the surface");
        }
    }

    #[test]
    fn an_invalid_camera_is_an_error() {
        let mut scene = seen_from(DVec3::Z, Vec::new());
        if let Projection::Perspective { fov, .. } = &mut scene.cameras[0].settings.projection {
            *fov = 4.0;
        }
        let finding = only(&scene, Kind::CannotRender);
        assert_eq!((finding.severity, finding.object.as_str()), (Severity::Error, "main"));
    }
}
