//! Camera, lights and backdrop for scenes that omit them. Defaults of fields are in `format/default_values.rs`.

use rt_math::{Aabb, DVec3, Rgb, transcendental::tan};

use super::camera_pose::{DEFAULT_FOV_DEGREES, listed};
use super::value::colour as resolve_color;
use crate::format::{Background, Camera, CameraAnimation, Color, Film, FovAxis, Light, LightUnits, SceneFile};
use crate::{Integrator, LoadOptions, StudioLights};

/// Direction from the centre of the scene to the default camera: slightly above and to the side.
const VIEW: DVec3 = DVec3::new(0.5, 0.4, 1.0);

/// Margin around the objects in the image.
const MARGIN: f64 = 1.1;

/// Properties of a scene that decide whether it gets studio lights.
#[derive(Clone, Copy, Debug)]
pub(super) struct SceneLighting {
    /// The integrator that renders.
    pub(super) integrator: Integrator,
    /// True if objects emit light.
    pub(super) has_emissive: bool,
    /// True if a material has a diffuse lobe below a layer. `distributed` samples such lobes by their BSDF, so that they receive the
    /// background.
    pub(super) has_layers: bool,
}

/// Fields of a scene file with options and defaults applied. The file itself is not changed.
#[derive(Debug)]
pub(crate) struct EffectiveFields {
    /// Cameras with their paths in the document: at least one, the default one first.
    pub(super) cameras: Vec<(String, Camera)>,
    pub(super) film: Film,
    pub(super) lights: Option<Vec<Light>>,
    pub(super) background: Option<Background>,
}

impl EffectiveFields {
    /// The fields of a file, with those that options replace.
    pub(super) fn new(file: &SceneFile, options: &LoadOptions) -> Self {
        let mut cameras: Vec<_> = listed(file).map(|(path, camera)| (path, camera.clone())).collect();
        if cameras.is_empty() {
            cameras.push(("camera".to_owned(), Camera::default()));
        }
        if let Some([opens, closes]) = options.shutter {
            cameras.iter_mut().for_each(|(_, camera)| camera.shutter = Some((opens, closes)));
        }
        let mut film = file.film.clone();
        if let Some([width, height]) = options.size {
            film.size = (width.into(), height.into());
        }
        Self { cameras, film, lights: file.lights.clone(), background: file.background.clone() }
    }

    /// Writes the fields to a file, in which the choices can be edited.
    pub(crate) fn write_to(self, file: &mut SceneFile) {
        let mut cameras = self.cameras.into_iter().map(|(_, camera)| camera);
        if file.camera.is_some() || file.cameras.is_empty() {
            file.camera = cameras.next();
        }
        file.cameras = cameras.collect();
        (file.film, file.lights, file.background) = (self.film, self.lights, self.background);
    }

    /// Fills in missing settings; returns one sentence per choice. `bounds` encloses the objects.
    pub(super) fn fill(&mut self, bounds: &Aabb, lighting: SceneLighting, options: &LoadOptions) -> Vec<String> {
        let mut notes = Vec::new();
        let bounds =
            if bounds.is_empty() || !bounds.is_finite() { Aabb::new(DVec3::NEG_ONE, DVec3::ONE) } else { *bounds };
        let (width, height) = self.film.size;
        let aspect = width.max(1) as f64 / height.max(1) as f64;
        for (_, camera) in self.cameras.iter_mut().filter(|(_, camera)| is_unplaced(camera)) {
            let (eye, target) = framed(camera, &bounds, aspect);
            if camera.orthographic.is_none() {
                camera.fov.get_or_insert(DEFAULT_FOV_DEGREES);
            }
            camera.look_from = Some(eye.to_array());
            camera.look_at = Some(target.to_array());
            notes.push(format!(
                "The camera has no position: it looks from {eye} at {target}, and shows the whole scene."
            ));
        }
        notes.extend(self.fill_lights(lighting, options));
        notes
    }

    /// Adds studio lights where options or the lack of other light call for them.
    fn fill_lights(&mut self, lighting: SceneLighting, options: &LoadOptions) -> Option<String> {
        let SceneLighting { integrator, has_emissive, has_layers } = lighting;
        let has_image = options.has_environment || matches!(self.background, Some(Background::Image { .. }));
        let gathers = integrator.gathers_background() || (has_layers && integrator == Integrator::Distributed);
        let has_background = gathers && !self.is_background_black(options);
        let is_unspecified = self.lights.is_none();
        let lights = self.lights.get_or_insert_default();
        let adds = match options.studio_lights {
            StudioLights::Auto => is_unspecified && !(has_emissive || has_image || has_background),
            StudioLights::None => false,
            StudioLights::Studio => true,
        };
        if adds {
            let reason = if lights.is_empty() { "The scene has no lights: a" } else { "A" };
            lights.extend(studio_lights());
            self.background.get_or_insert_with(default_background);
            return Some(format!("{reason} key light, a fill light and ambient light were added."));
        }
        let sources = match (has_emissive, has_image) {
            (true, true) => "area lights and the environment image",
            (true, false) => "area lights",
            (false, true) => "the environment image",
            (false, false) => return None,
        };
        let is_delta =
            |light: &Light| matches!(light, Light::Point { .. } | Light::Directional { .. } | Light::Spot { .. });
        let is_lit_by_these = options.studio_lights == StudioLights::Auto && !lights.iter().any(is_delta);
        (is_lit_by_these && integrator == Integrator::Whitted)
            .then(|| format!("`whitted` takes no light from {sources}: use `path`, or --lights studio."))
    }

    /// True if rays that leave the scene carry no light.
    fn is_background_black(&self, options: &LoadOptions) -> bool {
        if let Some(color) = options.background {
            return color.is_black();
        }
        let is_black = |color: &Color| resolve_color(color).is_ok_and(Rgb::is_black);
        match &self.background {
            None => true,
            Some(Background::Constant(color)) => is_black(color),
            Some(Background::Gradient { bottom, top }) => is_black(bottom) && is_black(top),
            Some(Background::Image { .. }) => false,
        }
    }

    /// True if a camera needs the bounds of the scene to be placed.
    pub(super) fn needs_bounds(&self) -> bool {
        self.cameras.iter().any(|(_, camera)| is_unplaced(camera))
    }
}

fn is_unplaced(camera: &Camera) -> bool {
    camera.is_unplaced() && !camera.animation.as_ref().is_some_and(CameraAnimation::places)
}

/// A key light from the upper left, a weaker fill light from the right without shadows, and ambient light.
///
/// The two irradiances add up to a vector of length 0.87 π between the default view and +z. Diffuse surfaces reflect a tenth of
/// the ambient light under `whitted`. Under `path`, [`default_background`] has a mean of 0.2. Either brings a white surface that
/// faces the vector close to 1: an albedo of 0.8 shows as about 0.8 under every integrator.
fn studio_lights() -> Vec<Light> {
    let sun = |name: &str, direction, strength, casts_shadows| Light::Directional {
        name: name.to_owned(),
        direction,
        intensity: Color::Gray(strength),
        units: LightUnits::Classical,
        casts_shadows,
    };
    vec![
        sun("key", [0.25, -0.35, -0.9], 0.72, true),
        sun("fill", [-1.0, -0.3, -0.6], 0.3, false),
        Light::Ambient(Color::Gray(1.0)),
    ]
}

/// The gradient behind a scene in the studio.
fn default_background() -> Background {
    Background::Gradient { bottom: Color::Gray(0.15), top: Color::Rgb(0.24, 0.26, 0.29) }
}

/// Eye and target of a camera that shows the whole box, as rounded numbers.
fn framed(camera: &Camera, bounds: &Aabb, aspect: f64) -> (DVec3, DVec3) {
    let back = VIEW.normalize();
    let right = DVec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let target = bounds.centre();
    // A point is a box of no size; it is seen from a distance that suits where it lies.
    let size = bounds.extent().length().max(bounds.max_abs() * 1e-6).max(1e-6);

    let half_angle = (camera.fov.unwrap_or(DEFAULT_FOV_DEGREES).clamp(1.0, 170.0) / 2.0).to_radians();
    let across = tan(half_angle);
    let (tan_x, tan_y) = match camera.fov_axis {
        Some(FovAxis::Horizontal) => (across, across / aspect),
        _ => (across * aspect, across),
    };
    // The nearest eye on the axis from which a corner lies within the image, for all corners.
    let distance = bounds.corners().into_iter().fold(0.0, |distance: f64, corner| {
        let offset = corner - target;
        let needed = (offset.dot(right).abs() / tan_x).max(offset.dot(up).abs() / tan_y);
        distance.max(needed * MARGIN + offset.dot(back))
    });
    let distance = if camera.orthographic.is_some() { size } else { distance.max(size) };
    let round = |point: DVec3| DVec3::from(point.to_array().map(|c| rounded(c, size)));
    (round(target + back * distance), round(target))
}

/// The value with as few decimals as resolve a thousandth of `size`.
pub(crate) fn rounded(value: f64, size: f64) -> f64 {
    let (mut decimals, mut reach) = (0, size);
    while reach < 1000.0 && decimals < 300 {
        reach *= 10.0;
        decimals += 1;
    }
    format!("{value:.decimals$}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_camera::{CameraSettings, FovAxis as Axis, Projection};
    use rt_math::Transform;

    fn sees_all(camera: &Camera, bounds: &Aabb, (width, height): (u32, u32)) -> bool {
        let (eye, target) = framed(camera, bounds, f64::from(width) / f64::from(height));
        let axis = if camera.fov_axis == Some(FovAxis::Horizontal) { Axis::Horizontal } else { Axis::Vertical };
        let fov = camera.fov.unwrap_or(DEFAULT_FOV_DEGREES).to_radians();
        let settings = CameraSettings::new(
            Transform::look_at(eye, target, DVec3::Y).unwrap(),
            Projection::Perspective { fov, axis },
        );
        let camera = rt_camera::Camera::new(&settings, width, height).unwrap();
        bounds.corners().into_iter().all(|corner| {
            let Some(at) = camera.project(corner) else { return false };
            (0.0..=f64::from(width)).contains(&at.x) && (0.0..=f64::from(height)).contains(&at.y)
        })
    }

    #[test]
    fn the_framed_camera_sees_every_corner() {
        let boxes = [
            ([-1.0; 3], [1.0; 3]),
            ([0.0, 0.0, 0.0], [100.0, 1.0, 1.0]),
            ([5.0, 5.0, -300.0], [5.1, 9.0, 20.0]),
            ([1e7, 0.0, 0.0], [1e7 + 1.0, 1.0, 1.0]),
            ([0.0; 3], [1e-9, 2e-9, 1e-9]),
            ([-1e30; 3], [1e30; 3]),
            ([3.0; 3], [3.0; 3]),
        ];
        for (min, max) in boxes {
            let bounds = Aabb::new(min.into(), max.into());
            for size in [(640, 480), (100, 1000), (2000, 50)] {
                for (fov, fov_axis) in [(None, None), (Some(10.0), Some(FovAxis::Horizontal)), (Some(120.0), None)] {
                    let camera = Camera { fov, fov_axis, ..Camera::default() };
                    assert!(sees_all(&camera, &bounds, size), "{bounds:?} {size:?} {fov:?}");
                }
            }
        }
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(rounded(1.234_567_89, 1.0), 1.235);
        assert_eq!(rounded(12_345.678, 12_345.0), 12_346.0);
        assert_eq!(rounded(1.234_567_89e-9, 1e-9), 1.235e-9);
    }
}
