//! Scenes far from the origin, moved to it.
//!
//! Near 10⁶ the numbers of `f64` are 10⁻¹⁰ apart. Rays and shapes take their differences before anything else and lose
//! nothing by it, but a hit point has to be written down, and what is computed from it (the way to a light, the origin
//! of a mirrored ray) has its error. So the plan computes in coordinates relative to a point of the scene (as the
//! rendering space of Pharr, Jakob, Humphreys, PBR 4th ed., section 5.1.1), if the scene is small beside its distance
//! from the origin. The point has few digits: taking it off is exact.

use std::borrow::Cow;

use rt_camera::CameraSettings;
use rt_math::{DVec3, Transform};
use rt_scene_io::Scene;
use rt_shading::{Appearance, LightKind};

/// A scene this many times as far away as it is large is moved. Up to there, coordinates keep 43 of 53 bits.
const FAR: f64 = 1024.0;

/// The point of the scene that takes the place of the origin; 0 for a scene near it or without bounds.
pub(crate) fn origin(scene: &Scene, camera: &CameraSettings) -> DVec3 {
    let bounds = scene.bounds();
    if bounds.is_empty() {
        return DVec3::ZERO;
    }
    let cameras = [Some(camera.world_from_camera), camera.moves_to].into_iter().flatten();
    let all = cameras.fold(bounds, |all, place| all.include(place.translation()));
    let (size, centre) = (all.extent().max_element(), all.centre());
    let is_far = size > 0.0 && centre.is_finite() && centre.abs().max_element() > FAR * size;
    if !is_far {
        return DVec3::ZERO;
    }
    // The power of two above the size: multiples of it have few digits, and the scene is around one of them.
    let step = 2.0 * f64::from_bits(size.to_bits() >> 52 << 52);
    (centre / step).round() * step
}

/// Takes coordinates of the scene to those relative to `origin`.
pub(crate) fn plan_from_world(origin: DVec3) -> Transform {
    if origin == DVec3::ZERO { Transform::IDENTITY } else { Transform::translate(-origin) }
}

/// The camera, relative to `origin`.
pub(crate) fn camera(settings: &CameraSettings, origin: DVec3) -> CameraSettings {
    let moved = |place: &Transform| plan_from_world(origin).compose(place);
    CameraSettings {
        world_from_camera: moved(&settings.world_from_camera),
        moves_to: settings.moves_to.as_ref().map(moved),
        ..*settings
    }
}

/// The appearance with lights relative to `origin`; borrowed where nothing moves.
pub(crate) fn appearance(appearance: &Appearance, origin: DVec3) -> Cow<'_, Appearance> {
    if origin == DVec3::ZERO {
        return Cow::Borrowed(appearance);
    }
    let mut moved = appearance.clone();
    for light in &mut moved.lights {
        match &mut light.kind {
            LightKind::Point { position, .. } | LightKind::Spot { position, .. } => *position -= origin,
            LightKind::Directional { .. } => {}
        }
    }
    Cow::Owned(moved)
}
