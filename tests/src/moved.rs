//! Scenes somewhere else, in another size.

use rt_camera::Projection;
use rt_math::{DVec3, Transform, TransformError};
use rt_scene_io::{Scene, SceneNode};
use rt_shading::{DeltaLightKind, Falloff};

/// The scene enlarged and then moved, as a whole: nodes by a transform above them all, cameras and lights by their
/// numbers. It looks the same.
///
/// # Errors
/// If the scale is 0 or not finite.
pub fn moved(scene: &Scene, scale: f64, offset: DVec3) -> Result<Scene, TransformError> {
    let mut scene = scene.clone();
    let enlarge = Transform::scale(DVec3::splat(scale))?;
    let root = SceneNode {
        name: String::new(),
        parent_from_local: Transform::translate(offset).compose(&enlarge),
        moves_to: None,
        content: None,
        material: rt_scene_io::MaterialId(0),
        casts_shadow: true,
        is_left_handed: false,
        children: std::mem::take(&mut scene.nodes),
    };
    scene.nodes = vec![root];
    for camera in &mut scene.cameras {
        let elsewhere =
            |place: &Transform| Transform::from_linear(place.linear(), place.translation() * scale + offset);
        let settings = &mut camera.settings;
        settings.world_from_camera = elsewhere(&settings.world_from_camera)?;
        settings.moves_to = settings.moves_to.as_ref().map(elsewhere).transpose()?;
        if let Some(lens) = &mut settings.lens {
            (lens.radius, lens.focus) = (lens.radius * scale, lens.focus * scale);
        }
        if let Projection::Orthographic { height } = &mut camera.settings.projection {
            *height *= scale;
        }
    }
    for light in &mut scene.appearance.lights {
        let falloff = match &mut light.kind {
            DeltaLightKind::Point { position, falloff, shadow_near } => {
                *position = *position * scale + offset;
                *shadow_near *= scale;
                *falloff
            }
            DeltaLightKind::Spot { position, falloff, .. } => {
                *position = *position * scale + offset;
                *falloff
            }
            DeltaLightKind::Directional { .. } => Falloff::None,
        };
        if falloff == Falloff::InverseSquare {
            light.intensity = light.intensity * (scale * scale);
        }
    }
    for material in &mut scene.appearance.materials {
        if let Some(interior) = &mut material.interior {
            interior.absorption = interior.absorption * scale.recip();
        }
    }
    Ok(scene)
}
