//! What cameras see, and how far rounding may move it.

use std::fmt;

use rt_accel::Accelerator;
use rt_camera::Camera;
use rt_geometry::{InteractionFlags, NoProbe};
use rt_math::{DVec2, DVec3, Interval, Ray};
use rt_shading::SurfaceHit;

use super::objects::Objects;
use super::report::{Finding, Findings, Kind, Severity, value};
use crate::rebase;
use crate::world::{Assembly, Levels};

/// Rays are cast through the middles of this many cells along each side of the image.
const CELLS: u32 = 64;

/// Part of a pixel by which rounding may move what is seen before it is warned of.
const VISIBLE: f64 = 0.01;

/// Pixels that the whole scene must cover.
const TOO_SMALL: f64 = 2.0;

/// Angle between neighbouring rays, in radians, below which a warning is due: their directions share ten digits.
const NARROW: f64 = 1e-10;

/// What a camera sees, measured by a few thousand rays. Lengths are in world units.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraMeasures {
    /// Name of the camera.
    pub name: String,
    /// Rays cast.
    pub rays: u64,
    /// How many hit something.
    pub hits: u64,
    /// Distance of the nearest hit; 0 without any.
    pub nearest: f64,
    /// Distance of the farthest hit; 0 without any.
    pub farthest: f64,
    /// Greatest bound on the rounding error of a hit point, from its shape and transforms.
    pub position_error: f64,
    /// The greatest such bound as a part of the pixel that sees the point.
    pub position_error_in_pixels: f64,
    /// Angle between neighbouring rays in the middle of the image, in radians; 0 for parallel rays.
    pub pixel_angle: f64,
}

impl fmt::Display for CameraMeasures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "camera {:<10}", self.name)?;
        if self.hits == 0 {
            return writeln!(f, "none of {} rays hits anything", self.rays);
        }
        let Self { rays, hits, nearest, farthest, position_error: error, position_error_in_pixels: pixels, .. } = self;
        let share = 100.0 * *hits as f64 / *rays as f64;
        writeln!(f, "sees things {nearest:.4e} to {farthest:.4e} away ({share:.1} % of {rays} rays);")?;
        writeln!(f, "                 rounding moves them by at most {error:.1e}, {pixels:.1e} pixels")
    }
}

/// Looks through a camera at the world that a render would trace.
fn look(name: &str, camera: &Camera, size: DVec2, top: &Assembly, levels: &Levels) -> CameraMeasures {
    let needs = InteractionFlags::NONE;
    let parts = top.set(levels);
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
        let Some(hit) = top.structure.closest(&parts, &ray, Interval::FORWARD, &mut NoProbe) else { continue };
        let Some(SurfaceHit { interaction: surface, .. }) = parts.surface(&ray, &hit, needs) else { continue };
        let distance = hit.t * ray.direction.length();
        let error = surface.point_error.length();
        measures.hits += 1;
        measures.nearest = measures.nearest.min(distance);
        measures.farthest = measures.farthest.max(distance);
        measures.position_error = measures.position_error.max(error);
        let part = error / footprint(camera, raster, &ray, hit.t);
        measures.position_error_in_pixels = measures.position_error_in_pixels.max(part);
    }
    if measures.hits == 0 {
        measures.nearest = 0.0;
    }
    measures
}

/// Distance of the points that neighbouring pixels see at the same ray parameter.
fn footprint(camera: &Camera, raster: DVec2, ray: &Ray, t: f64) -> f64 {
    // Origins and directions are subtracted first: the points themselves may be far from the origin.
    let neighbour = camera.ray(raster + DVec2::X, 0.0);
    ((neighbour.origin - ray.origin) + (neighbour.direction - ray.direction) * t).length()
}

fn pixel_angle(camera: &Camera, size: DVec2) -> f64 {
    let [a, b] = [DVec2::ZERO, DVec2::X].map(|step| camera.ray(size * 0.5 + step, 0.0).direction);
    (b - a).length() / a.length()
}

/// Looks through all cameras at the world, whose coordinates are relative to `origin`; it is missing where the plan
/// refuses the scene.
pub(super) fn check(
    objects: &Objects<'_>,
    world: Option<&(Assembly, Levels)>,
    origin: DVec3,
    findings: &mut Findings,
) -> Vec<CameraMeasures> {
    let film = &objects.scene.film;
    let mut all = Vec::new();
    for named in &objects.scene.cameras {
        match Camera::new(&rebase::camera(&named.settings, origin), film.width, film.height) {
            Err(error) => findings.add(refused(&named.name, &error.to_string())),
            Ok(camera) => {
                let Some((top, levels)) = world else { continue };
                let size = DVec2::new(f64::from(film.width), f64::from(film.height));
                let measures = look(&named.name, &camera, size, top, levels);
                let eye = named.settings.world_from_camera.translation();
                judge(objects, &camera, size, eye, &measures, findings);
                all.push(measures);
            }
        }
    }
    all
}

fn refused(name: &str, message: &str) -> Finding {
    Finding {
        severity: Severity::Error,
        kind: Kind::CannotRender,
        object: name.to_owned(),
        values: vec![],
        message: message.to_owned(),
        advice: "mend the camera or the film",
    }
}

fn judge(
    objects: &Objects<'_>,
    camera: &Camera,
    size: DVec2,
    eye: DVec3,
    measures: &CameraMeasures,
    findings: &mut Findings,
) {
    let mut warn = |kind, values, message, advice| {
        findings.add(Finding {
            severity: Severity::Warning,
            kind,
            object: measures.name.clone(),
            values,
            message,
            advice,
        });
    };
    let bounds = objects.bounds();
    let extent = bounds.extent().max_element();
    let distance = (bounds.centre() - eye).length();
    let ray = camera.ray(size * 0.5, 0.0);
    let across = footprint(camera, size * 0.5, &ray, distance / ray.direction.length());
    let pixels = extent / across;
    if !bounds.is_empty() && pixels < TOO_SMALL {
        warn(
            Kind::CameraFar,
            vec![value("distance", distance), value("pixels", pixels)],
            format!("the scene is {distance:.3e} away, and {pixels:.3} pixels large"),
            "go nearer, or narrow the field of view",
        );
    } else if measures.hits == 0 && !objects.list.is_empty() {
        warn(
            Kind::CameraSeesNothing,
            vec![value("rays", measures.rays as f64)],
            format!("none of {} rays hits anything; the middle of the scene is {distance:.3e} away", measures.rays),
            "turn the camera to the scene, or leave it out to have one put where it sees everything",
        );
    }
    if measures.pixel_angle > 0.0 && measures.pixel_angle < NARROW {
        warn(
            Kind::NarrowView,
            vec![value("pixel_angle", measures.pixel_angle.to_degrees())],
            format!("neighbouring rays are {:.3e} degrees apart", measures.pixel_angle.to_degrees()),
            "widen the field of view and go nearer, or use an orthographic camera",
        );
    }
    if measures.position_error_in_pixels > VISIBLE {
        warn(
            Kind::CameraPrecision,
            vec![
                value("position_error", measures.position_error),
                value("position_error_in_pixels", measures.position_error_in_pixels),
            ],
            format!(
                "rounding may move what is seen by {:.3e}, {:.3} pixels",
                measures.position_error, measures.position_error_in_pixels
            ),
            "bring camera and scene nearer to the origin, and to each other",
        );
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::*;
    use super::*;
    use rt_camera::Projection;
    use rt_math::transcendental::tan;

    #[test]
    fn distances_and_errors_are_measured() {
        let mut scene = empty();
        scene.nodes = vec![ball(DVec3::ZERO, 1.0)];
        scene.cameras = vec![camera(DVec3::Z * 5.0, DVec3::ZERO)];
        let report = super::super::check(&scene);
        assert_eq!(report.measures.cameras.len(), 1);
        let seen = &report.measures.cameras[0];
        assert!((4.0..4.01).contains(&seen.nearest), "{seen:?}");
        assert!((4.7..24f64.sqrt()).contains(&seen.farthest), "{seen:?}");
        assert!((1e-17..1e-14).contains(&seen.position_error), "{seen:?}");
        // The field of view is 40 degrees over 48 pixels: a pixel is some 0.06 wide at the ball.
        assert!((seen.position_error_in_pixels * 0.06 / seen.position_error - 1.0).abs() < 0.3, "{seen:?}");
        // The ball's half angle is asin(1/5): the part of the square image that it covers is π(tan/tan 20°)²/4.
        let tangent = 0.2 / 0.96f64.sqrt() / tan(20f64.to_radians());
        let share = seen.hits as f64 / seen.rays as f64;
        assert!((share - std::f64::consts::FRAC_PI_4 * tangent * tangent).abs() < 0.01, "{seen:?}");
    }

    #[test]
    fn a_scene_behind_the_camera_is_not_seen() {
        let mut scene = empty();
        scene.nodes = vec![ball(DVec3::Z * 9.0, 1.0)];
        scene.cameras = vec![camera(DVec3::Z * 5.0, DVec3::ZERO)];
        assert_eq!(only(&scene, Kind::CameraSeesNothing).values, [value("rays", 4096.0)]);
    }

    #[test]
    fn a_scene_smaller_than_a_pixel_is_too_far() {
        let mut scene = empty();
        scene.nodes = vec![ball(DVec3::ZERO, 1.0)];
        scene.cameras = vec![camera(DVec3::Z * 1e4, DVec3::ZERO)];
        let finding = only(&scene, Kind::CameraFar);
        let pixel = 1e4 * 2.0 * tan(20f64.to_radians()) / 48.0;
        assert!((finding.values[1].value - 2.0 / pixel).abs() < 1e-3, "{finding:?}");
    }

    #[test]
    fn a_telescope_into_the_void_is_too_narrow() {
        let mut scene = empty();
        scene.nodes = vec![ball(DVec3::ZERO, 1.0)];
        scene.cameras = vec![camera(DVec3::Z * 5.0, DVec3::ZERO)];
        let fov = 4.8e-10f64;
        if let Projection::Perspective { fov: angle, .. } = &mut scene.cameras[0].settings.projection {
            *angle = fov;
        }
        let finding = only(&scene, Kind::NarrowView);
        assert!((finding.values[0].value - (fov / 48.0).to_degrees()).abs() < 1e-15, "{finding:?}");
    }

    #[test]
    fn rounding_shows_far_from_the_origin() {
        let mut scene = empty();
        let far = DVec3::X * 1e14;
        // Plans move a scene to the origin as a whole: what is far from the rest of it stays far.
        scene.nodes = vec![ball(far, 2.0), ball(DVec3::ZERO, 2.0)];
        scene.cameras = vec![camera(far + DVec3::Z * 8.0, far)];
        let findings = super::super::check(&scene).findings;
        let finding = findings.iter().find(|finding| finding.kind == Kind::CameraPrecision).unwrap();
        assert!(finding.values[1].value > VISIBLE, "{finding:?}");
    }

    #[test]
    fn a_camera_that_cannot_be_is_an_error() {
        let mut scene = empty();
        scene.cameras = vec![camera(DVec3::Z, DVec3::ZERO)];
        if let Projection::Perspective { fov, .. } = &mut scene.cameras[0].settings.projection {
            *fov = 4.0;
        }
        let finding = only(&scene, Kind::CannotRender);
        assert_eq!((finding.severity, finding.object.as_str()), (Severity::Error, "main"));
    }
}
