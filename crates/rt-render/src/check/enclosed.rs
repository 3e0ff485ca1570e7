//! Cameras and lights where they can do no good.

use rt_math::DVec3;
use rt_shading::LightKind;

use super::bodies::{Bodies, Within};
use super::objects::Objects;
use super::report::{Finding, Findings, Kind, Severity, value};

/// Distance of a light over the extent of the scene beyond which it is as good as directional: neighbouring points get
/// directions that differ in the last digits of `f32` only.
const FAR: f64 = 1e7;

pub(super) fn check(objects: &Objects<'_>, bodies: &Bodies, findings: &mut Findings) {
    for camera in &objects.scene.cameras {
        let eye = camera.settings.world_from_camera.translation();
        for within in bodies.around(objects, eye) {
            findings.add(camera_inside(objects, &camera.name, eye, &within, bodies));
        }
    }
    for (index, light) in objects.scene.appearance.lights.iter().enumerate() {
        let name = if light.name.is_empty() {
            format!("light number {index}, not counting ambient light")
        } else {
            light.name.clone()
        };
        let (LightKind::Point { position, .. } | LightKind::Spot { position, .. }) = light.kind else { continue };
        let lamp_radius = match light.kind {
            LightKind::Point { lamp_radius, .. } => lamp_radius,
            _ => 0.0,
        };
        if light.casts_shadows {
            let enclosing = bodies.around(objects, position).filter(|within| within.wall > lamp_radius);
            for within in enclosing.filter(|within| darkens(objects, within, bodies)) {
                findings.add(light_enclosed(objects, &name, &within));
            }
        }
        findings.extend(light_far(objects, &name, position));
    }
}

/// Whether a body keeps the light in it from all cameras.
fn darkens(objects: &Objects<'_>, within: &Within<'_>, bodies: &Bodies) -> bool {
    let eyes = objects.scene.cameras.iter().map(|camera| camera.settings.world_from_camera.translation());
    let same = |eye| bodies.around(objects, eye).any(|around| std::ptr::eq(around.object, within.object));
    within.object.casts_shadow && !objects.is_glass(within.object) && !eyes.into_iter().any(same)
}

fn camera_inside(objects: &Objects<'_>, name: &str, eye: DVec3, within: &Within<'_>, bodies: &Bodies) -> Finding {
    let is_glass = objects.is_glass(within.object);
    // A light with the camera makes a room of the body.
    let lit = objects.scene.appearance.lights.iter().any(|light| match light.kind {
        LightKind::Point { position, .. } | LightKind::Spot { position, .. } => {
            bodies.around(objects, position).any(|around| std::ptr::eq(around.object, within.object))
        }
        LightKind::Directional { .. } => false,
    });
    Finding {
        severity: if lit || is_glass { Severity::Info } else { Severity::Warning },
        kind: Kind::CameraInside,
        object: name.to_owned(),
        values: vec![value("distance_to_wall", within.wall)],
        message: format!(
            "stands at ({}, {}, {}) inside {}, {:.6e} from its wall",
            eye.x,
            eye.y,
            eye.z,
            objects.name(within.object),
            within.wall
        ),
        advice: if is_glass {
            "nothing if the view is from within the glass"
        } else {
            "move the camera out, or put a light inside if this is a room"
        },
    }
}

fn light_enclosed(objects: &Objects<'_>, name: &str, within: &Within<'_>) -> Finding {
    Finding {
        severity: Severity::Warning,
        kind: Kind::LightEnclosed,
        object: name.to_owned(),
        values: vec![value("distance_to_wall", within.wall)],
        message: format!("stands inside {}, which keeps its light in", objects.name(within.object)),
        advice: "move it out, give it a `lamp_radius` beyond the wall, or let the object cast no shadow",
    }
}

fn light_far(objects: &Objects<'_>, name: &str, position: DVec3) -> Option<Finding> {
    let bounds = objects.bounds();
    let extent = bounds.extent().max_element();
    let distance = (position - bounds.centre()).length();
    (!bounds.is_empty() && distance > FAR * extent).then(|| Finding {
        severity: Severity::Warning,
        kind: Kind::LightFar,
        object: name.to_owned(),
        values: vec![value("distance", distance), value("distance_over_extent", distance / extent)],
        message: format!("stands {distance:.3e} away, {:.3e} times the extent of the scene", distance / extent),
        advice: "make it a directional light: from so far away its rays are parallel",
    })
}

#[cfg(test)]
mod tests {
    use super::super::fixture::*;
    use super::*;

    #[test]
    fn a_light_in_an_opaque_ball_is_found() {
        let mut scene = empty();
        scene.nodes = vec![ball(DVec3::X, 2.0)];
        scene.appearance.lights = vec![lamp(DVec3::ZERO, 0.0)];
        let finding = only(&scene, Kind::LightEnclosed);
        assert_eq!(finding.object, "lamp");
        assert!((1.0..1.2).contains(&finding.values[0].value), "{finding:?}");

        scene.appearance.lights = vec![lamp(DVec3::X, 2.0 + 1e-9)];
        assert_eq!(of_kind(&scene, Kind::LightEnclosed), [], "the ball is its lamp");
        scene.appearance.lights = vec![lamp(DVec3::ZERO, 0.0)];
        scene.nodes[0].material = GLASS;
        assert_eq!(of_kind(&scene, Kind::LightEnclosed), [], "light passes");
        scene.nodes[0].material = GREY;
        scene.nodes[0].casts_shadow = false;
        assert_eq!(of_kind(&scene, Kind::LightEnclosed), []);
    }

    #[test]
    fn a_camera_in_a_dark_ball_is_warned_of_and_one_in_a_lit_room_noted() {
        let mut scene = empty();
        scene.nodes = vec![ball(DVec3::ZERO, 2.0)];
        scene.cameras = vec![camera(DVec3::Z, DVec3::ZERO)];
        let finding = only(&scene, Kind::CameraInside);
        assert_eq!((finding.severity, finding.object.as_str()), (Severity::Warning, "main"));
        scene.appearance.lights = vec![lamp(DVec3::X, 0.0)];
        assert_eq!(only(&scene, Kind::CameraInside).severity, Severity::Info);
    }

    #[test]
    fn a_light_beyond_all_sense_is_named() {
        let mut scene = empty();
        scene.nodes = vec![ball(DVec3::ZERO, 1.0)];
        scene.appearance.lights = vec![lamp(DVec3::Y * 4e7, 0.0)];
        let finding = only(&scene, Kind::LightFar);
        assert_eq!(finding.values[0], value("distance", 4e7));
        assert!((finding.values[1].value - 2e7).abs() < 1e-3, "{finding:?}");
        scene.appearance.lights = vec![lamp(DVec3::Y * 1e7, 0.0)];
        assert_eq!(of_kind(&scene, Kind::LightFar), []);
    }
}
