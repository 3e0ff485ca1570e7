//! Cameras and lights inside of solids or too far away.

use rt_math::DVec3;

use crate::finding::{Finding, Findings, Kind};
use crate::objects::{Object, Objects};
use crate::solids::{Enclosure, Solids, contains};

/// Distance of a light over the extent of the scene beyond which it is practically directional. Directions to it from
/// neighbouring points differ in the last digits of `f32` only.
const FAR: f64 = 1e7;

/// Largest number of lights to look for in a solid with a camera.
const MAX_SOURCES: usize = 256;

pub(crate) fn check(objects: &Objects<'_>, solids: &Solids, findings: &mut Findings) {
    for camera in &objects.scene.cameras {
        let eye = camera.settings.world_from_camera.translation();
        for enclosure in solids.containing(objects, eye) {
            findings.add(camera_inside(objects, &camera.name, eye, &enclosure));
        }
    }
    for (index, light) in objects.scene.appearance.lights.iter().enumerate() {
        let name = match light.name.as_str() {
            "" => format!("light {index}, not counting ambient light"),
            name => name.to_owned(),
        };
        let Some(position) = light.kind.position() else { continue };
        let shadow_near = light.kind.shadow_near();
        if light.casts_shadows {
            let enclosures = solids.containing(objects, position).filter(|enclosure| enclosure.wall > shadow_near);
            for enclosure in enclosures.filter(|enclosure| hides_light(objects, enclosure)) {
                let message = format!("is inside {}, which blocks its light", objects.name(enclosure.object));
                findings.add(Finding::new(
                    Kind::LightEnclosed,
                    &name,
                    &[("distance_to_wall", enclosure.wall)],
                    message,
                ));
            }
        }
        findings.extend(light_far(objects, &name, position));
    }
}

/// True if a solid blocks light inside of it from all cameras.
fn hides_light(objects: &Objects<'_>, enclosure: &Enclosure<'_>) -> bool {
    let object = enclosure.object;
    object.casts_shadow && objects.is_opaque(object) && is_outside_of_cameras(objects, object)
}

/// True if a solid contains no camera.
pub(crate) fn is_outside_of_cameras(objects: &Objects<'_>, object: &Object<'_>) -> bool {
    let mut eyes = objects.scene.cameras.iter().map(|camera| camera.settings.world_from_camera.translation());
    !eyes.any(|eye| contains(object, eye))
}

fn camera_inside(objects: &Objects<'_>, name: &str, eye: DVec3, enclosure: &Enclosure<'_>) -> Finding {
    let &Enclosure { object, wall } = enclosure;
    let is_glass = objects.is_glass(object);
    // A solid with a camera and a light inside is a room.
    let positions = objects.scene.appearance.lights.iter().filter_map(|light| light.kind.position());
    let emitters = objects.list.iter().filter(|object| objects.is_emissive(object));
    let sources = positions.chain(emitters.filter_map(|emitter| emitter.bounds.map(|bounds| bounds.centre())));
    let near = sources.filter(|source| object.bounds.is_none_or(|bounds| bounds.contains(*source)));
    let is_lit = objects.is_emissive(object) || near.take(MAX_SOURCES).any(|source| contains(object, source));
    let DVec3 { x, y, z } = eye;
    let message = format!("is at ({x}, {y}, {z}) inside {}, {wall:.6e} from its wall", objects.name(object));
    let finding = Finding::new(Kind::CameraInside, name, &[("distance_to_wall", wall)], message);
    let finding = finding.warn_if(!is_lit && !is_glass);
    if is_glass { finding.with_advice("no action if the camera should be inside of the dielectric") } else { finding }
}

fn light_far(objects: &Objects<'_>, name: &str, position: DVec3) -> Option<Finding> {
    let bounds = objects.bounds();
    let extent = bounds.extent().max_element();
    let distance = (position - bounds.centre()).length();
    (!bounds.is_empty() && distance > FAR * extent).then(|| {
        let ratio = distance / extent;
        let message = format!("is {distance:.3e} away, {ratio:.3e} times the extent of the scene");
        Finding::new(Kind::LightFar, name, &[("distance", distance), ("distance_over_extent", ratio)], message)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::*;

    #[test]
    fn a_light_in_an_opaque_sphere_is_found() {
        let mut scene = scene_with(vec![sphere(DVec3::X, 2.0)]);
        scene.appearance.lights = vec![point_light(DVec3::ZERO, 0.0)];
        let finding = only(&scene, Kind::LightEnclosed);
        assert_eq!(finding.object, "lamp");
        assert!((1.0..1.2).contains(&finding.values[0].value), "{finding:?}");

        scene.appearance.lights = vec![point_light(DVec3::X, 2.0 + 1e-9)];
        assert_eq!(of_kind(&scene, Kind::LightEnclosed), [], "the sphere is the light source");
        scene.appearance.lights = vec![point_light(DVec3::ZERO, 0.0)];
        scene.nodes[0].material = GLASS;
        assert_eq!(of_kind(&scene, Kind::LightEnclosed), [], "light passes");
        scene.nodes[0].material = GREY;
        scene.nodes[0].casts_shadow = false;
        assert_eq!(of_kind(&scene, Kind::LightEnclosed), []);
    }

    #[test]
    fn a_camera_in_a_dark_sphere_is_a_warning_and_one_in_a_lit_room_a_note() {
        let mut scene = seen_from(DVec3::Z, vec![sphere(DVec3::ZERO, 2.0)]);
        let finding = only(&scene, Kind::CameraInside);
        assert_eq!((finding.severity, finding.object.as_str()), (Severity::Warning, "main"));
        scene.appearance.lights = vec![point_light(DVec3::X, 0.0)];
        assert_eq!(only(&scene, Kind::CameraInside).severity, Severity::Note);
    }

    #[test]
    fn a_very_distant_light_is_found() {
        let mut scene = scene_with(vec![sphere(DVec3::ZERO, 1.0)]);
        scene.appearance.lights = vec![point_light(DVec3::Y * 4e7, 0.0)];
        let finding = only(&scene, Kind::LightFar);
        assert_eq!(finding.values[0], value("distance", 4e7));
        assert!((finding.values[1].value - 2e7).abs() < 1e-3, "{finding:?}");
        scene.appearance.lights = vec![point_light(DVec3::Y * 1e7, 0.0)];
        assert_eq!(of_kind(&scene, Kind::LightFar), []);
    }
}
