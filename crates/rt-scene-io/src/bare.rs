//! A scene around a model that comes without one.

use rt_camera::Projection;
use rt_math::{Aabb, DVec3, Rgb, Transform, transcendental};
use rt_shading::{Coefficient, Falloff, Highlight, Light, LightKind, Phong};

use crate::bounds::tree_bounds;
use crate::format::{self, CameraAnimation, CameraKey, Color, Interpolation, Material, Node, SceneFile, Shape, Step};
use crate::resolve::{backdrop, rounded};
use crate::{LightUnits, LoadOptions, Model, NamedCamera};

/// Name of the plane that `ground` asks for.
const GROUND: &str = "ground";

/// A scene file that shows a model by its own cameras and lights, and the choices that were made for it. What the
/// model does not bring is left open.
///
/// Choices are made for the model `at_rest`, which may be another pose of it.
pub(crate) fn scene_around(
    model: &Model,
    at_rest: &Model,
    reference: &str,
    options: &LoadOptions,
) -> (SceneFile, Vec<String>) {
    let mut notes = Vec::new();
    let bounds = tree_bounds(&at_rest.nodes, &[], &at_rest.meshes);
    let content = Node { model: Some(reference.to_owned()), ..Node::default() };
    let mut file = SceneFile::of_nodes(vec![content]);
    if options.ground && !bounds.is_empty() {
        add_ground(&mut file, &bounds, model);
        notes.push(format!("A ground plane was put under the model, at y = {}.", bounds.min.y));
    }
    let exposure = options.exposure().unwrap_or_default();
    file.cameras = model.cameras.iter().map(|model| camera(model, exposure)).collect();
    file.background.clone_from(&model.background);
    if let Some([width, height]) = model.image_size {
        file.film.size = (width.into(), height.into());
    }
    notes.extend(model.notes.iter().cloned());
    if model.lights.is_empty() && model.light_units != LightUnits::Radiometric {
        return (file, notes);
    }
    match model.light_units {
        LightUnits::Radiometric => {
            file.lights = Some(model.lights.iter().map(light).collect());
            file.settings.integrator = Some(format::Integrator::Path);
        }
        LightUnits::Classical => file.lights = Some(model.lights.iter().map(light).collect()),
        LightUnits::Photometric => notes.push(expose(&mut file, model, typical_illuminance(&at_rest.lights, &bounds))),
    }
    (file, notes)
}

/// True if the box around a model matters to what is chosen for it.
pub(crate) const fn asks_for_bounds(model: &Model, options: &LoadOptions) -> bool {
    options.ground || (matches!(model.light_units, LightUnits::Photometric) && !model.lights.is_empty())
}

/// Takes over lights in candela and lux, with a film that suits those that shine with this level; the sentence says how.
fn expose(file: &mut SceneFile, model: &Model, level: f64) -> String {
    // Lights that reach nothing, or are out of range, give no hint.
    let level = if level > 0.0 && level.is_finite() { rounded(level, level) } else { 1.0 };
    file.film.exposure = rounded(-transcendental::log2(level), 10.0);
    // What is nearer to a lamp than most is many times as bright: the curve keeps its shape visible.
    file.film.tone = format::Tone::Aces;
    // Shadows would be pitch black, and a sky of the usual brightness invisible beside lights in lux.
    file.lights = Some(model.lights.iter().map(light).chain([format::Light::Ambient(Color::Gray(level))]).collect());
    file.background.get_or_insert_with(|| backdrop(level));
    format!(
        "The model's lights shine with about {level}; exposure {} and a filmic tone curve make that bright. Ambient \
         light and a background of that level were added.",
        file.film.exposure
    )
}

fn add_ground(file: &mut SceneFile, bounds: &Aabb, model: &Model) {
    // A material of the model that had the same name would be changed by that of the ground.
    let mut name = GROUND.to_owned();
    while model.materials.iter().any(|material| material.name == name) {
        name.push('\'');
    }
    let centre = bounds.centre();
    let point = [centre.x, bounds.min.y, centre.z];
    file.nodes.push(Node {
        name: GROUND.to_owned(),
        shape: Some(Shape::Plane { point, normal: [0.0, 1.0, 0.0] }),
        material: Some(name.clone().into()),
        ..Node::default()
    });
    let matte = Phong { diffuse: Coefficient::Constant(Rgb::gray(0.5)), ..Phong::default() };
    file.materials.insert(name, material(&matte));
}

/// Luminance of the unshadowed light that falls straight on places in a box: the geometric mean of the average and the
/// greatest, since a spot may light a small part, and a lamp may stand near to one.
fn typical_illuminance(lights: &[Light], bounds: &Aabb) -> f64 {
    let bounds = if bounds.is_empty() { Aabb::new(DVec3::NEG_ONE, DVec3::ONE) } else { *bounds };
    // A light may stand in such a place: it is taken to keep a tenth of the size away.
    let nearest = (bounds.extent().length() * 0.1).max(f64::MIN_POSITIVE);
    let at = |place: DVec3| -> f64 {
        let lit = lights.iter().filter_map(|light| Some((light, light.illuminate(place)?)));
        lit.map(|(light, lit)| {
            let closeness = match light.kind {
                LightKind::Directional { .. } => 1.0,
                _ => (lit.distance / nearest).min(1.0),
            };
            lit.strength.luminance() * closeness * closeness
        })
        .sum()
    };
    let part = |i: u32| f64::from(i) * 0.25;
    let places =
        (0..125).map(|i| bounds.min + bounds.extent() * DVec3::new(part(i % 5), part(i / 5 % 5), part(i / 25)));
    let (sum, greatest) = places.map(at).fold((0.0, 0.0), |(sum, greatest), e: f64| (sum + e, e.max(greatest)));
    (sum / 125.0 * greatest).sqrt()
}

/// A camera, which moves from one place to another while the shutter is open.
fn camera(camera: &NamedCamera, exposure: [f64; 2]) -> format::Camera {
    let start = vec![matrix(&camera.settings.world_from_camera)];
    let (transform, animation) = match &camera.settings.moves_to {
        None => (start, None),
        Some(end) => {
            let keys = exposure.into_iter().zip([start, vec![matrix(end)]]);
            let key =
                |(time, transform)| CameraKey { time, look_from: None, look_at: None, up: None, transform, fov: None };
            let keys = keys.map(key).collect();
            (Vec::new(), Some(CameraAnimation { interpolation: Interpolation::Linear, keys }))
        }
    };
    let mut written = format::Camera {
        name: Some(camera.name.clone()),
        transform,
        animation,
        lens_shift: camera.settings.lens_shift.to_array(),
        ..format::Camera::default()
    };
    match camera.settings.projection {
        Projection::Perspective { fov, axis } => {
            written.fov = Some(fov.to_degrees());
            written.fov_axis = Some(match axis {
                rt_camera::FovAxis::Vertical => format::FovAxis::Vertical,
                rt_camera::FovAxis::Horizontal => format::FovAxis::Horizontal,
            });
        }
        Projection::Orthographic { height } => written.orthographic = Some(height),
    }
    written
}

/// The map as one step, to the last bit.
fn matrix(transform: &Transform) -> Step {
    let (linear, translation) = (transform.linear(), transform.translation());
    let row = |i: usize| [linear.x_axis[i], linear.y_axis[i], linear.z_axis[i], translation[i]];
    Step::Matrix(row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0])
}

fn light(light: &Light) -> format::Light {
    let name = light.name.clone();
    let intensity = Color::from_rgb(light.intensity.to_array());
    let casts_shadows = light.casts_shadows;
    let falloff = |falloff| match falloff {
        Falloff::None => format::Falloff::None,
        Falloff::InverseSquare => format::Falloff::InverseSquare,
    };
    match light.kind {
        LightKind::Point { position, falloff: f, lamp_radius } => format::Light::Point {
            name,
            position: position.to_array(),
            intensity,
            falloff: falloff(f),
            lamp_radius,
            casts_shadows,
        },
        LightKind::Directional { direction } => {
            format::Light::Directional { name, direction: direction.to_array(), intensity, casts_shadows }
        }
        LightKind::Spot { position, direction, cos_inner, cos_outer, falloff: f } => format::Light::Spot {
            name,
            position: position.to_array(),
            direction: direction.to_array(),
            inner: transcendental::acos(cos_inner).to_degrees(),
            outer: transcendental::acos(cos_outer).to_degrees().min(90.0),
            intensity,
            falloff: falloff(f),
            casts_shadows,
        },
    }
}

/// All that is constant about a surface. Coefficients with a texture are left to the model.
pub(crate) fn material(phong: &Phong) -> Material {
    let constant = |coefficient: Coefficient| match coefficient {
        Coefficient::Constant(rgb) => Some(Color::from_rgb(rgb.to_array()).into()),
        Coefficient::Textured(..) => None,
    };
    Material::Phong {
        color: None,
        ambient: constant(phong.ambient),
        diffuse: constant(phong.diffuse),
        specular: constant(phong.specular),
        exponent: Some(phong.exponent),
        highlight: Some(match phong.highlight {
            Highlight::Phong => format::Highlight::Phong,
            Highlight::Blinn => format::Highlight::Blinn,
        }),
        emission: constant(phong.emission),
        mirror: constant(phong.mirror),
        transmission: phong.transmission.and_then(|t| constant(t.coefficient)),
        ior: phong.transmission.map(|t| t.ior),
        fresnel: phong.transmission.map(|t| t.fresnel),
        absorption: phong.transmission.map(|t| Color::from_rgb(t.absorption.to_array())),
        priority: phong.transmission.map(|t| t.priority),
        shines: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resolve::resolve_with;
    use crate::{Content, Material, MaterialId, Node as SceneNode, Scene};
    use rt_geometry::{AxisBox, Shape};
    use std::path::Path;

    /// A box of side 2 around the origin, lit by these lights.
    fn lit(kinds: &[LightKind], intensity: f64) -> Model {
        let cube = AxisBox::new(DVec3::NEG_ONE, DVec3::ONE).unwrap();
        let light = |&kind| Light { name: String::new(), kind, intensity: Rgb::gray(intensity), casts_shadows: true };
        Model {
            materials: vec![Material::new("ground".to_owned(), Phong::default())],
            nodes: vec![SceneNode::new(Content::Shape(Shape::AxisBox(cube)), MaterialId(0))],
            lights: kinds.iter().map(light).collect(),
            ..Model::default()
        }
    }

    fn scene(model: Model, ground: bool) -> Scene {
        let (mut file, _) = scene_around(&model, &model, "a.glb", &LoadOptions { ground, ..LoadOptions::default() });
        resolve_with(&mut file, Path::new("a.glb"), &LoadOptions::default(), Some(("a.glb".to_owned(), model))).unwrap()
    }

    fn point(position: DVec3) -> LightKind {
        LightKind::Point { position, falloff: Falloff::InverseSquare, lamp_radius: 0.0 }
    }

    #[test]
    fn exposure_takes_the_light_of_a_model_to_white() {
        let sun = LightKind::Directional { direction: DVec3::NEG_Y };
        let day = scene(lit(&[sun], 65_536.0), false);
        assert_eq!(day.film.development.exposure, -16.0);
        assert_eq!(day.appearance.ambient, Rgb::gray(65_536.0));
        assert_eq!(day.appearance.lights[0].intensity, Rgb::gray(65_536.0));
        // 8 candela, 4 away from the middle of a small box: half a lux.
        let near = scene(lit(&[point(DVec3::new(0.0, 4.0, 0.0))], 8.0), false);
        assert!((near.film.development.exposure - 1.0).abs() < 0.5, "{}", near.film.development.exposure);
        // A light in the very middle, or in a corner, does not blow up.
        for place in [DVec3::ZERO, DVec3::ONE] {
            let exposure = scene(lit(&[point(place)], 3.0), false).film.development.exposure;
            assert!(exposure.abs() < 3.0, "{exposure}");
        }
    }

    #[test]
    fn lights_that_reach_nothing_leave_the_exposure_alone() {
        let up = DVec3::Y;
        let away = LightKind::Spot {
            position: up * 9.0,
            direction: up,
            cos_inner: 0.9,
            cos_outer: 0.8,
            falloff: Falloff::InverseSquare,
        };
        let scene = scene(lit(&[away], 100.0), false);
        assert_eq!(scene.film.development.exposure, 0.0);
        let LightKind::Spot { cos_inner, cos_outer, .. } = scene.appearance.lights[0].kind else { panic!("a spot") };
        assert!((cos_inner - 0.9).abs() < 1e-15 && (cos_outer - 0.8).abs() < 1e-15);
    }

    #[test]
    fn spots_with_a_sharp_edge_are_written_and_read() {
        for degrees in 1..=90 {
            let cos_outer = transcendental::cos(f64::from(degrees).to_radians()).max(0.0);
            let sharp = LightKind::Spot {
                position: DVec3::Y * 9.0,
                direction: DVec3::NEG_Y,
                cos_inner: cos_outer.next_up(),
                cos_outer,
                falloff: Falloff::InverseSquare,
            };
            let LightKind::Spot { cos_inner: inner, cos_outer: outer, .. } =
                scene(lit(&[sharp], 100.0), false).appearance.lights[0].kind
            else {
                panic!("a spot")
            };
            assert!(outer < inner && inner - outer < 1e-9, "{degrees}°: {inner} {outer}");
            assert!((outer - cos_outer).abs() < 1e-9, "{degrees}°: {outer}");
        }
    }

    #[test]
    fn the_ground_keeps_out_of_the_way_of_a_material_of_its_name() {
        let mut model = lit(&[], 0.0);
        model.materials[0].phong.diffuse = Coefficient::Constant(Rgb::gray(0.25));
        let scene = scene(model, true);
        let materials: Vec<_> = scene
            .appearance
            .materials
            .iter()
            .map(|material| (material.name.as_str(), material.phong.diffuse))
            .collect();
        let gray = |value| Coefficient::Constant(Rgb::gray(value));
        assert_eq!(materials, [("ground", gray(0.25)), ("ground'", gray(0.5))]);
    }
}
