//! Camera as text of a scene file.

use ron::extensions::Extensions;
use ron::ser::PrettyConfig;
use rt_camera::{CameraSettings, FovAxis, Lens, Projection};
use rt_math::DVec3;
use rt_scene_io::format::{self, Step};

use super::pose::Pose;

/// Field `camera` of a scene file for a camera that another file describes.
pub(super) fn file_camera_text(fields: &format::Camera) -> String {
    // The name may be that of a camera in the list `cameras`.
    written(&format::Camera { name: None, ..fields.clone() })
}

/// Field `camera` of a scene file for a static camera in this pose. Reading it gives a bit-identical camera, except for
/// angles without an exact number of degrees, which a comment reports.
///
/// `shutter` is that of the scene file. That of `settings` is relative to the common interval of all cameras.
pub(super) fn camera_text(
    pose: &Pose,
    settings: &CameraSettings,
    medium: Option<&str>,
    shutter: Option<(f64, f64)>,
) -> String {
    let mut camera = fields_without_position(settings, medium, shutter);
    // The pose of a camera that has not been moved is rounded.
    let is_exact = pose.shape.is_none() && pose.world_from_camera() == Some(settings.world_from_camera);
    match Some(settings.world_from_camera).filter(|_| !is_exact) {
        None => {
            camera.look_from = Some(pose.eye.to_array());
            camera.look_at = Some(pose.target.to_array());
            camera.up = (pose.up != DVec3::Y).then(|| pose.up.to_array());
        }
        Some(transform) => {
            let (axes, place) = (transform.linear(), transform.translation());
            let row = |row: usize| [axes.x_axis[row], axes.y_axis[row], axes.z_axis[row], place[row]];
            camera.transform = vec![Step::Matrix(row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0])];
        }
    }
    let angles = [
        ("fov", camera.fov.zip(fov_radians(&settings.projection))),
        ("rotate", camera.lens.as_ref().zip(settings.lens).map(|(text, lens)| (text.rotate, lens.rotation))),
    ];
    let mut text = written(&camera);
    for (field, angle) in angles {
        if angle.is_some_and(|(degrees, radians)| degrees.to_radians() != radians) {
            text += &format!("\n/* `{field}` is rounded: no number of degrees is this angle exactly. */");
        }
    }
    text
}

/// Fields of a static camera other than its position, direction and `up`.
pub(super) fn fields_without_position(
    settings: &CameraSettings,
    medium: Option<&str>,
    shutter: Option<(f64, f64)>,
) -> format::Camera {
    let mut camera = format::Camera {
        shutter,
        lens_shift: settings.lens_shift.to_array(),
        lens: settings.lens.as_ref().map(lens),
        medium: medium.map(str::to_owned),
        ..format::Camera::default()
    };
    match settings.projection {
        Projection::Perspective { fov, axis } => {
            camera.fov = Some(degrees(fov));
            camera.fov_axis = (axis == FovAxis::Horizontal).then_some(format::FovAxis::Horizontal);
        }
        Projection::Orthographic { height } => camera.orthographic = Some(height),
    }
    camera
}

const fn fov_radians(projection: &Projection) -> Option<f64> {
    match projection {
        Projection::Perspective { fov, .. } => Some(*fov),
        Projection::Orthographic { .. } => None,
    }
}

fn written(camera: &format::Camera) -> String {
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    let layout = PrettyConfig::new().depth_limit(2).new_line("\n").compact_arrays(true);
    let text = options.to_string_pretty(camera, layout).unwrap_or_default();
    format!("camera: {text},")
}

fn lens(lens: &Lens) -> format::Lens {
    format::Lens {
        radius: Some(lens.radius),
        focus: Some(lens.focus),
        blades: lens.blades,
        rotate: degrees(lens.rotation),
        ..format::Lens::default()
    }
}

/// Degrees that are read as this angle, with few digits where possible.
fn degrees(radians: f64) -> f64 {
    let exact = radians.to_degrees();
    let short = (exact * 1e9).round() / 1e9;
    let candidates = [short, exact, exact.next_up(), exact.next_down()];
    candidates.into_iter().find(|degrees| degrees.to_radians() == radians).unwrap_or(exact)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    use rt_math::{DVec2, Transform};
    use rt_scene_io::format::parse_ron;
    use rt_scene_io::{LoadOptions, resolve};

    fn read_again(text: &str) -> CameraSettings {
        let file = format!("({text} nodes: [(shape: sphere())])");
        let name = Path::new("pasted.ron");
        let parsed = parse_ron(&file, name).unwrap_or_else(|error| panic!("{error}: {file}"));
        let scene = resolve(&parsed, name, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}: {file}"));
        scene.cameras[0].settings
    }

    fn settings(pose: &Pose, projection: Projection) -> CameraSettings {
        CameraSettings::new(pose.world_from_camera().expect("a pose"), projection)
    }

    const POSE: Pose = Pose {
        eye: DVec3::new(0.1 + 0.2, -1e-7, 6.0),
        target: DVec3::new(1.0 / 3.0, 0.5, 0.0),
        up: DVec3::Y,
        shape: None,
    };

    #[test]
    fn text_is_read_as_the_same_camera_to_the_bit() {
        let tilted = Pose { up: DVec3::new(0.1, 0.9, 0.3), ..POSE };
        let stretched = Pose { shape: Transform::scale(DVec3::new(1.5, 2.0, 2.5)).ok(), ..POSE };
        for (index, pose) in [POSE, POSE.orbit(0.3, 0.2), tilted, stretched].into_iter().enumerate() {
            for degrees in [40.0, 0.1, 63.7, 179.9] {
                let fov = f64::to_radians(degrees);
                let perspective = settings(&pose, Projection::Perspective { fov, axis: FovAxis::Horizontal });
                let lens = Lens { radius: 0.1, focus: 7.3, blades: Some(5), rotation: 12f64.to_radians() };
                let blurred = CameraSettings { lens: Some(lens), lens_shift: DVec2::new(0.1, 0.0), ..perspective };
                let parallel = settings(&pose, Projection::Orthographic { height: 1.0 / 7.0 });
                for camera in [perspective, blurred, parallel] {
                    let text = camera_text(&pose, &camera, None, None);
                    assert_eq!(read_again(&text), camera, "pose {index}: {text}");
                }
            }
        }
    }

    #[test]
    fn text_is_short_and_has_only_what_differs_from_the_default() {
        let pose = Pose { eye: DVec3::new(0.0, 1.0, 6.0), target: DVec3::ZERO, ..POSE };
        let camera = settings(&pose, Projection::Perspective { fov: 40f64.to_radians(), axis: FovAxis::Vertical });
        let expected = "camera: (\n    look_from: (0.0, 1.0, 6.0),\n    look_at: (0.0, 0.0, 0.0),\n    fov: 40.0,\n),";
        assert_eq!(camera_text(&pose, &camera, None, None), expected);
        assert!(camera_text(&pose, &camera, Some("water"), None).contains("medium: \"water\""));
        assert!(camera_text(&pose, &camera, None, Some((0.0, 1.0))).contains("shutter: (0.0, 1.0)"));
    }

    #[test]
    fn rounded_angles_are_reported() {
        let mut rounded = 0;
        for step in 1..1000 {
            let fov = 0.001 * f64::from(step);
            let text = camera_text(
                &POSE,
                &settings(&POSE, Projection::Perspective { fov, axis: FovAxis::Vertical }),
                None,
                None,
            );
            let is_same = read_again(&text).projection == Projection::Perspective { fov, axis: FovAxis::Vertical };
            assert_eq!(is_same, !text.contains("/* `fov` is rounded"), "{text}");
            rounded += usize::from(!is_same);
        }
        assert!(rounded > 0, "each angle has an exact number of degrees");
    }
}
