//! Render space: world space translated so that the scene is near the origin.
//!
//! Near 10⁶, neighbouring `f64` numbers are 10⁻¹⁰ apart. Intersection tests subtract coordinates first and do not lose accuracy.
//! Stored hit points lose accuracy, and so do values computed from them, such as the origins of reflected rays.
//!
//! A scene that is small compared with its distance from the origin is therefore rendered relative to one of its points. The
//! point has few digits, so that its subtraction is exact.
//!
//! Source: rendering space, Pharr, Jakob and Humphreys, *Physically Based Rendering*, 4th ed., section 5.1.1.

use std::borrow::Cow;

use rt_camera::CameraSettings;
use rt_math::{DVec3, Transform};
use rt_scene_io::Scene;
use rt_shading::Appearance;

/// Ratio of distance to size above which a scene is translated. Below it, coordinates keep 43 of 53 bits.
const FAR: f64 = 1024.0;

/// Origin of the coordinates that a scene is rendered in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSpace {
    /// World space.
    origin: DVec3,
}

impl RenderSpace {
    /// World space itself.
    pub const WORLD: Self = Self { origin: DVec3::ZERO };

    /// Render space of a scene and camera; world space if they are near the origin or without bounds.
    pub fn of(scene: &Scene, camera: &CameraSettings) -> Self {
        let bounds = scene.bounds();
        if bounds.is_empty() {
            return Self::WORLD;
        }
        let cameras = [Some(camera.world_from_camera), camera.moves_to].into_iter().flatten();
        let all = cameras.fold(bounds, |all, transform| all.include(transform.translation()));
        let (size, centre) = (all.extent().max_element(), all.centre());
        let is_far = size > 0.0 && centre.is_finite() && centre.abs().max_element() > FAR * size;
        if !is_far {
            return Self::WORLD;
        }
        // Round to a multiple of the power of two above the size: it has few digits and is near the scene.
        let step = 2.0 * f64::from_bits(size.to_bits() >> 52 << 52);
        Self { origin: (centre / step).round() * step }
    }

    /// Origin of render space, in world space.
    pub(crate) const fn origin(self) -> DVec3 {
        self.origin
    }

    pub(crate) fn render_from_world(self) -> Transform {
        if self == Self::WORLD { Transform::IDENTITY } else { Transform::translate(-self.origin) }
    }

    /// Camera in render space.
    pub fn camera(self, settings: &CameraSettings) -> CameraSettings {
        let translated = |transform: &Transform| self.render_from_world().compose(transform);
        CameraSettings {
            world_from_camera: translated(&settings.world_from_camera),
            moves_to: settings.moves_to.as_ref().map(translated),
            ..*settings
        }
    }

    /// Appearance with lights in render space; borrowed if that is world space.
    pub(crate) fn appearance(self, appearance: &Appearance) -> Cow<'_, Appearance> {
        if self == Self::WORLD {
            return Cow::Borrowed(appearance);
        }
        let mut translated = appearance.clone();
        for light in &mut translated.lights {
            if let Some(position) = light.kind.position_mut() {
                *position -= self.origin;
            }
        }
        Cow::Owned(translated)
    }
}
