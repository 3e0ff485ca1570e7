//! Camera, lights and backdrop for scenes that omit them. Defaults of fields are in `format/default_values.rs`.

use rt_camera::{CameraSettings, Projection};
use rt_math::{Aabb, DVec3, Rgb, transcendental::tan};

use super::camera_pose::{DEFAULT_FOV_DEGREES, listed, look_at};
use super::value::colour as resolve_color;
use crate::diagnostics::Diagnostics;
use crate::format::{Background, Camera, CameraAnimation, Color, Film, FovAxis, Light, LightUnits, SceneFile};
use crate::{Integrator, LoadErrorKind, LoadOptions, StudioLights, limits};

/// Direction from the centre of the scene to the default camera: slightly above and to the side.
const VIEW: DVec3 = DVec3::new(0.5, 0.4, 1.0);

/// Margin around the objects in the image.
const MARGIN: f64 = 1.1;

/// Smallest size of the framed objects, as a share of their largest coordinate: 12 of the 16 digits of a number.
const MIN_RELATIVE_SIZE: f64 = 1e-12;

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
    /// True if the file has a camera.
    has_camera: bool,
    pub(super) film: Film,
    pub(super) lights: Option<Vec<Light>>,
    pub(super) background: Option<Background>,
}

impl EffectiveFields {
    /// The fields of a file, with those that options replace.
    pub(super) fn new(file: &SceneFile, options: &LoadOptions) -> Self {
        let mut cameras: Vec<_> = listed(file).map(|(path, camera)| (path, camera.clone())).collect();
        let has_camera = !cameras.is_empty();
        if !has_camera {
            cameras.push(("camera".to_owned(), Camera::default()));
        }
        if let Some([opens, closes]) = options.shutter {
            cameras.iter_mut().for_each(|(_, camera)| camera.shutter = Some((opens, closes)));
        }
        let mut film = file.film.clone();
        if let Some([width, height]) = options.size {
            film.size = (width.into(), height.into());
        }
        Self { cameras, has_camera, film, lights: file.lights.clone(), background: file.background.clone() }
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

    /// Fills in missing settings; returns one sentence per choice. `bounds` encloses the objects. A camera that would be too far
    /// away is an error.
    pub(super) fn fill(
        &mut self,
        report: &mut Diagnostics,
        bounds: &Aabb,
        lighting: SceneLighting,
        options: &LoadOptions,
    ) -> Vec<String> {
        let mut notes = Vec::new();
        let bounds =
            if bounds.is_empty() || !bounds.is_finite() { Aabb::new(DVec3::NEG_ONE, DVec3::ONE) } else { *bounds };
        let size = <[u64; 2]>::from(self.film.size).map(|side| side.clamp(1, limits::FILM_PIXELS) as u32);
        for (path, camera) in self.cameras.iter_mut().filter(|(_, camera)| is_unplaced(camera)) {
            let framing = Framing::new(camera, &bounds, size);
            if camera.orthographic.is_none() {
                camera.fov.get_or_insert(DEFAULT_FOV_DEGREES);
            }
            camera.look_from = Some(framing.eye.to_array());
            camera.look_at = Some(framing.target.to_array());
            if framing.is_in_range() {
                notes.push(framing.note(camera, &bounds, size));
            } else {
                let path = if self.has_camera { path } else { "nodes" };
                report.check::<()>(path, Err(framing.refused()));
                // A pose that is valid, so that this is the only error.
                (camera.look_from, camera.look_at) = (Some(VIEW.to_array()), None);
            }
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
            let has_background = self.background.is_some() || options.background.is_some() || has_image;
            self.background.get_or_insert_with(default_background);
            let rest = if has_background { " and ambient light" } else { ", ambient light and a background" };
            return Some(format!("{reason} key light, a fill light{rest} were added."));
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
        (is_lit_by_these && integrator == Integrator::Whitted).then(|| {
            format!("`whitted` takes no light from {sources}: use `distributed` or `path`, or --lights studio.")
        })
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

/// Pose of a camera that shows the whole box, as rounded numbers.
#[derive(Clone, Copy, Debug)]
struct Framing {
    eye: DVec3,
    target: DVec3,
}

impl Framing {
    /// Framing of a box in an image of this size.
    fn new(camera: &Camera, bounds: &Aabb, [width, height]: [u32; 2]) -> Self {
        let aspect = f64::from(width) / f64::from(height);
        let back = VIEW.normalize();
        let right = DVec3::Y.cross(back).normalize();
        let up = back.cross(right);
        let centre = bounds.centre();
        // A point is a box of no size: its distance is a share of its coordinates, and 1 at the origin.
        let size = bounds.extent().length().max(bounds.max_abs() * MIN_RELATIVE_SIZE);
        let size = if size > 0.0 { size } else { 1.0 };

        let [shift_x, shift_y] = camera.lens_shift.map(|shift| if shift.is_finite() { 2.0 * shift } else { 0.0 });
        if let Some(height) = camera.orthographic {
            // Other heights are refused elsewhere.
            let height = if height.is_finite() { height } else { 0.0 };
            let aside = right * (shift_x * height * aspect / 2.0) + up * (shift_y * height / 2.0);
            return Self::rounded(centre + back * size - aside, centre - aside, size);
        }
        let across = tan((narrowest_fov(camera) / 2.0).to_radians());
        let (tan_x, tan_y) = match camera.fov_axis {
            Some(FovAxis::Horizontal) => (across, across / aspect),
            _ => (across * aspect, across),
        };
        // The centre of the box is in the centre of the image. The nearest eye from which a corner lies within the image, for
        // all corners.
        let distance = bounds.corners().into_iter().fold(0.0, |distance: f64, corner| {
            let offset = corner - centre;
            let depth = offset.dot(back);
            let needed_x = (offset.dot(right) / tan_x + shift_x * depth).abs();
            let needed_y = (offset.dot(up) / tan_y + shift_y * depth).abs();
            distance.max(needed_x.max(needed_y) * MARGIN + depth)
        });
        // A wide view shows the box as more than a dot only from close by.
        let nearest = size / tan_x.min(tan_y).max(1.0);
        let distance = distance.max(nearest);
        let aside = (right * (shift_x * tan_x) + up * (shift_y * tan_y)) * distance;
        Self::rounded(centre + back * distance - aside, centre - aside, nearest)
    }

    /// Points rounded to a thousandth of `size`.
    fn rounded(eye: DVec3, target: DVec3, size: f64) -> Self {
        let round = |point: DVec3| DVec3::from(point.to_array().map(|c| rounded(c, size)));
        Self { eye: round(eye), target: round(target) }
    }

    /// Sentence about the pose, and whether the whole box is shown.
    fn note(&self, camera: &Camera, bounds: &Aabb, size: [u32; 2]) -> String {
        let Self { eye, target } = self;
        let pose = format!("The camera has no position: it looks from {eye} at {target}");
        match camera.orthographic {
            _ if self.shows(camera, bounds, size) => format!("{pose}, and shows the whole scene."),
            Some(height) => format!("{pose}. Its height, `orthographic: {height}`, is too small for the whole scene."),
            None => format!("{pose}. Its `fov` or `lens_shift` is too extreme to show the whole scene."),
        }
    }

    /// Error of a pose that is out of range.
    fn refused(&self) -> LoadErrorKind {
        let farthest = [self.eye, self.target].map(|point| point.abs().max_element()).into_iter().fold(0.0, f64::max);
        let rule = "is a coordinate of the camera that shows the whole scene, and above 1e60: place the camera by `look_from`, \
                    or move the objects closer to the origin";
        LoadErrorKind::invalid(format_args!("{farthest:e}"), rule)
    }

    /// True if the camera can be placed here.
    fn is_in_range(&self) -> bool {
        // A NaN fails the comparison.
        [self.eye, self.target].iter().flat_map(DVec3::to_array).all(|c| c.abs() <= limits::NUMBER)
    }

    /// True if all corners of the box are within an image of this size. Other values of the camera that are invalid are reported
    /// elsewhere, and count as true.
    fn shows(&self, camera: &Camera, bounds: &Aabb, [width, height]: [u32; 2]) -> bool {
        let projection = match camera.orthographic {
            Some(height) => Projection::Orthographic { height },
            None => Projection::Perspective {
                fov: narrowest_fov(camera).to_radians(),
                axis: camera.fov_axis.map_or(rt_camera::FovAxis::Vertical, Into::into),
            },
        };
        let Ok(place) = look_at(self.eye, self.target, DVec3::Y) else { return false };
        let lens_shift = camera.lens_shift.into();
        let settings = CameraSettings { lens_shift, ..CameraSettings::new(place, projection) };
        let Ok(camera) = rt_camera::Camera::new(&settings, width, height) else { return true };
        bounds.corners().into_iter().all(|corner| {
            let Some(at) = camera.project(corner) else { return false };
            (0.0..=f64::from(width)).contains(&at.x) && (0.0..=f64::from(height)).contains(&at.y)
        })
    }
}

/// The narrowest field of view of a camera, in degrees; the default where it is invalid.
fn narrowest_fov(camera: &Camera) -> f64 {
    let fov = camera.fov.unwrap_or(DEFAULT_FOV_DEGREES);
    let keys = camera.animation.iter().flat_map(|animation| &animation.keys);
    let fov = keys.map(|key| key.fov.unwrap_or(fov)).reduce(f64::min).unwrap_or(fov);
    if fov > 0.0 && fov < 180.0 { fov } else { DEFAULT_FOV_DEGREES }
}

/// The value with as few decimals as resolve a thousandth of `size`.
pub(crate) fn rounded(value: f64, size: f64) -> f64 {
    let (mut decimals, mut reach) = (0, size);
    while reach < 1000.0 && decimals < 300 {
        reach *= 10.0;
        decimals += 1;
    }
    let rounded: f64 = format!("{value:.decimals$}").parse().unwrap_or(value);
    // 0 for −0.
    rounded + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sees_all(camera: &Camera, bounds: &Aabb, size: [u32; 2]) -> bool {
        Framing::new(camera, bounds, size).shows(camera, bounds, size)
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
            for size in [[640, 480], [100, 1000], [2000, 50]] {
                for (fov, fov_axis) in [(None, None), (Some(10.0), Some(FovAxis::Horizontal)), (Some(120.0), None)] {
                    let camera = Camera { fov, fov_axis, ..Camera::default() };
                    assert!(sees_all(&camera, &bounds, size), "{bounds:?} {size:?} {fov:?}");
                }
            }
        }
    }

    fn cube(half: f64) -> Aabb {
        Aabb::new(DVec3::splat(-half), DVec3::splat(half))
    }

    fn distance(camera: &Camera, bounds: &Aabb) -> f64 {
        let Framing { eye, target } = Framing::new(camera, bounds, [640, 480]);
        (eye - target).length()
    }

    #[test]
    fn tiny_scenes_are_framed_from_as_close_as_others() {
        let at_one = distance(&Camera::default(), &cube(1.0));
        for half in [1e-7, 1e-8, 1e-100] {
            let relative = distance(&Camera::default(), &cube(half)) / half;
            assert!((relative / at_one - 1.0).abs() < 1e-2, "{half}: {relative}");
        }
        assert!(distance(&Camera::default(), &cube(0.0)) > 0.0);
    }

    #[test]
    fn the_framed_camera_keeps_extreme_fields_of_view() {
        for fov in [1e-6, 0.1, 1.0, 170.0, 175.0, 179.0] {
            let camera = Camera { fov: Some(fov), ..Camera::default() };
            assert!(sees_all(&camera, &cube(1.0), [640, 480]), "{fov}");
        }
        let wide = Camera { fov: Some(175.0), ..Camera::default() };
        assert!(distance(&wide, &cube(1.0)) < 2.0, "{}", distance(&wide, &cube(1.0)));
    }

    #[test]
    fn the_framed_camera_sees_every_corner_with_a_shifted_lens() {
        for lens_shift in [[0.5, 0.0], [1.0, 0.0], [-1.0, 3.0]] {
            for orthographic in [None, Some(5.0)] {
                let camera = Camera { lens_shift, orthographic, ..Camera::default() };
                assert!(sees_all(&camera, &cube(1.0), [640, 480]), "{lens_shift:?} {orthographic:?}");
            }
        }
    }

    #[test]
    fn the_note_claims_to_show_the_whole_scene_only_if_it_is_shown() {
        let note = |camera: Camera| Framing::new(&camera, &cube(1.0), [640, 480]).note(&camera, &cube(1.0), [640, 480]);
        let with_height = |height| note(Camera { orthographic: Some(height), ..Camera::default() });
        assert!(with_height(4.0).ends_with(", and shows the whole scene."));
        let text = with_height(1e-3);
        assert!(text.ends_with("Its height, `orthographic: 0.001`, is too small for the whole scene."), "{text}");
        let text = note(Camera { fov: Some(1e-30), ..Camera::default() });
        assert!(text.ends_with("Its `fov` or `lens_shift` is too extreme to show the whole scene."), "{text}");
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(rounded(1.234_567_89, 1.0), 1.235);
        assert_eq!(rounded(12_345.678, 12_345.0), 12_346.0);
        assert_eq!(rounded(1.234_567_89e-9, 1e-9), 1.235e-9);
    }
}
