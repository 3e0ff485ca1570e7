//! A scene around a model that comes without one.

use core::f64::consts::PI;
use rt_camera::Projection;

use rt_math::{Aabb, DVec3, Rgb, Transform, transcendental};
use rt_shading::{ColorTexture, DeltaLight, DeltaLightKind, MaterialModel, Phong};

use crate::bounds::tree_bounds;
use crate::format::{self, CameraAnimation, CameraKey, Color, Interpolation, Node, SceneFile, Shape, Step};
use crate::resolve::{rounded, written_phong};
use crate::scene::{is_emissive, used_materials};
use crate::{LoadOptions, Material, Model, NamedCamera, StudioLights};

/// Name of the ground plane.
const GROUND: &str = "ground";

/// Samples per pixel of a bare model under an integrator that samples directions.
const STOCHASTIC_SPP: u64 = 64;

/// A scene file that shows a model by its own cameras and lights, and the choices that were made for it. What the
/// model does not bring is left open.
///
/// Choices are made for the model `at_rest`, which may be another pose of it.
pub(crate) fn scene_for_model(
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
        notes.push(format!("A ground plane was added under the model, at y = {}.", bounds.min.y));
    }
    let exposure = options.shutter_interval().unwrap_or_default();
    file.cameras = model.cameras.iter().map(|model| camera(model, exposure)).collect();
    file.background.clone_from(&model.background);
    if let Some([width, height]) = model.image_size {
        file.film.size = (width.into(), height.into());
    }
    notes.extend(model.notes.iter().cloned());
    let used = used_materials([&*model.nodes]);
    let used: Vec<&Material> = used.iter().filter_map(|id| model.materials.get(*id as usize)).collect();
    let has_emissive = used.iter().any(|material| is_emissive(material, &model.textures));
    let is_lit_by_objects = has_emissive && model.lights.is_empty() && options.studio_lights != StudioLights::Studio;
    let reason = if used.iter().any(|material| !matches!(material.model, MaterialModel::Phong(_))) {
        Some("materials are physically based")
    } else {
        is_lit_by_objects.then_some("surfaces are its only lights")
    };
    if let (Some(reason), None) = (reason, options.integrator) {
        file.settings.integrator = Some(format::Integrator::Path);
        notes.push(format!("The integrator is `path`, because the model's {reason}."));
    }
    let is_sampled = match options.integrator {
        Some(integrator) => reason.is_some() && integrator.follows_light() && integrator.is_stochastic(),
        None => reason.is_some() || options.has_environment,
    };
    if is_sampled {
        file.settings.spp = STOCHASTIC_SPP;
    }
    if !model.lights.is_empty() {
        file.lights = Some(model.lights.iter().map(light).collect());
        if model.is_photometric {
            let has_radiance =
                has_emissive || options.has_environment || options.background.is_some_and(|color| !color.is_black());
            notes.push(expose(&mut file, typical_illuminance(&at_rest.lights, &bounds), has_radiance));
        }
    }
    (file, notes)
}

/// True if the defaults of a model depend on its bounds.
pub(crate) const fn needs_bounds(model: &Model, options: &LoadOptions) -> bool {
    options.ground || (model.is_photometric && !model.lights.is_empty())
}

/// Sets the exposure at which a white surface under this illuminance (lx) becomes white. Returns a note.
///
/// Emissive materials and environment images use radiance 1 as white. With such sources, 1 is added to the radiance of the
/// white surface, so that neither is overexposed.
fn expose(file: &mut SceneFile, illuminance: f64, has_radiance: bool) -> String {
    // Lights that reach no object, or are out of range, are ignored.
    let is_usable = illuminance > 0.0 && illuminance.is_finite();
    let radiance = if is_usable { illuminance / PI } else { f64::from(u8::from(!has_radiance)) };
    let white = radiance + f64::from(u8::from(has_radiance));
    file.film.exposure = rounded(-transcendental::log2(white), 10.0);
    // The filmic curve keeps the shape of surfaces near a light visible.
    file.film.tone = format::Tone::Aces;
    if !is_usable {
        let exposure = file.film.exposure;
        return format!(
            "The lights of the model do not illuminate it; the exposure is {exposure}, with a filmic tone curve."
        );
    }
    let illuminance = rounded(illuminance, illuminance.max(1.0));
    format!(
        "The model's lights give about {illuminance} lx; exposure {} and a filmic tone curve adapt the image to it.",
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
    let matte = Phong { diffuse: ColorTexture::Constant(Rgb::gray(0.5)), ..Phong::default() };
    file.materials.insert(name, written_phong(&matte, ColorTexture::ZERO, None));
}

/// Typical unshadowed illuminance in a box: the geometric mean of average and maximum. A spot may light a small part only, and
/// a light may be close to one point.
fn typical_illuminance(lights: &[DeltaLight], bounds: &Aabb) -> f64 {
    let bounds = if bounds.is_empty() { Aabb::new(DVec3::NEG_ONE, DVec3::ONE) } else { *bounds };
    // Distances below a tenth of the size are clamped: a light may coincide with a sample point.
    let nearest = (bounds.extent().length() * 0.1).max(f64::MIN_POSITIVE);
    let at = |place: DVec3| -> f64 {
        let lit = lights.iter().filter_map(|light| Some((light, light.sample_li(place)?)));
        lit.map(|(light, lit)| {
            let closeness = match light.kind {
                DeltaLightKind::Directional { .. } => 1.0,
                _ => (lit.distance / nearest).min(1.0),
            };
            lit.strength.luminance() * closeness * closeness
        })
        .sum()
    };
    let part = |i: u32| f64::from(i) * 0.25;
    let points =
        (0..125).map(|i| bounds.min + bounds.extent() * DVec3::new(part(i % 5), part(i / 5 % 5), part(i / 25)));
    let (sum, max) = points.map(at).fold((0.0, 0.0), |(sum, max), e: f64| (sum + e, e.max(max)));
    (sum / 125.0 * max).sqrt()
}

/// Camera of a scene file, with its motion while the shutter is open.
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
            written.fov_axis = Some(axis.into());
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

fn light(light: &DeltaLight) -> format::Light {
    let name = light.name.clone();
    let intensity = Color::from_rgb(light.intensity.to_array());
    let casts_shadows = light.casts_shadows;
    let units = light.units.into();
    match light.kind {
        DeltaLightKind::Point { position, falloff: f, shadow_near } => format::Light::Point {
            name,
            position: position.to_array(),
            intensity,
            units,
            falloff: f.into(),
            shadow_near,
            casts_shadows,
        },
        DeltaLightKind::Directional { direction } => {
            format::Light::Directional { name, direction: direction.to_array(), intensity, units, casts_shadows }
        }
        DeltaLightKind::Spot { position, direction, cos_inner, cos_outer, falloff: f } => format::Light::Spot {
            name,
            position: position.to_array(),
            direction: direction.to_array(),
            inner: transcendental::acos(cos_inner).to_degrees(),
            outer: transcendental::acos(cos_outer).to_degrees().min(90.0),
            intensity,
            units,
            falloff: f.into(),
            casts_shadows,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resolve::resolve_with;
    use crate::{Content, MaterialId, Scene, SceneNode};
    use rt_geometry::{Cuboid, Shape};
    use rt_shading::{Falloff, LightUnits};
    use std::path::Path;

    /// A box of side 2 around the origin, lit by these lights.
    fn lit(kinds: &[DeltaLightKind], intensity: f64) -> Model {
        let cube = Cuboid::new(DVec3::NEG_ONE, DVec3::ONE).unwrap();
        let light = |&kind| {
            let (name, units) = (String::new(), LightUnits::Physical);
            DeltaLight { name, kind, intensity: Rgb::gray(intensity), units, casts_shadows: true }
        };
        Model {
            materials: vec![Material::new("ground".to_owned(), Phong::default())],
            nodes: vec![SceneNode::new(Content::Shape(Shape::Cuboid(cube)), MaterialId(0))],
            lights: kinds.iter().map(light).collect(),
            is_photometric: true,
            ..Model::default()
        }
    }

    fn scene(model: Model, ground: bool) -> Scene {
        let (file, _) = scene_for_model(&model, &model, "a.glb", &LoadOptions { ground, ..LoadOptions::default() });
        resolve_with(&file, Path::new("a.glb"), &LoadOptions::default(), Some(("a.glb".to_owned(), model))).unwrap().0
    }

    fn point(position: DVec3) -> DeltaLightKind {
        DeltaLightKind::Point { position, falloff: Falloff::InverseSquare, shadow_near: 0.0 }
    }

    fn spot(direction: DVec3, cos_inner: f64, cos_outer: f64) -> DeltaLightKind {
        DeltaLightKind::Spot {
            position: DVec3::Y * 9.0,
            direction,
            cos_inner,
            cos_outer,
            falloff: Falloff::InverseSquare,
        }
    }

    /// Cosines of the inner and outer angle of the first light, which is a spot.
    fn cone(scene: &Scene) -> [f64; 2] {
        match scene.appearance.lights[0].kind {
            DeltaLightKind::Spot { cos_inner, cos_outer, .. } => [cos_inner, cos_outer],
            ref other => panic!("{other:?}"),
        }
    }

    #[test]
    fn exposure_takes_the_light_of_a_model_to_white() {
        let sun = DeltaLightKind::Directional { direction: DVec3::NEG_Y };
        let day = scene(lit(&[sun], 65_536.0), false);
        // log2(65536/π): white paper reflects 1/π of the illuminance.
        assert_eq!(day.film.development.exposure, -14.35);
        assert_eq!(day.appearance.ambient, Rgb::BLACK);
        assert_eq!(day.appearance.lights[0].intensity, Rgb::gray(65_536.0));
        // 8 candela, 4 away from the middle of a small box: half a lux.
        let near = scene(lit(&[point(DVec3::new(0.0, 4.0, 0.0))], 8.0), false);
        assert!((near.film.development.exposure - 2.65).abs() < 0.5, "{}", near.film.development.exposure);
        // A light in the very middle, or in a corner, does not blow up.
        for place in [DVec3::ZERO, DVec3::ONE] {
            let exposure = scene(lit(&[point(place)], 3.0), false).film.development.exposure;
            assert!((exposure - 1.65).abs() < 3.0, "{exposure}");
        }
    }

    #[test]
    fn lights_that_reach_nothing_leave_the_exposure_alone() {
        let scene = scene(lit(&[spot(DVec3::Y, 0.9, 0.8)], 100.0), false);
        assert_eq!(scene.film.development.exposure, 0.0);
        let [inner, outer] = cone(&scene);
        assert!((inner - 0.9).abs() < 1e-15 && (outer - 0.8).abs() < 1e-15);
    }

    #[test]
    fn spots_with_a_sharp_edge_are_written_and_read() {
        for degrees in 1..=90 {
            let cos_outer = transcendental::cos(f64::from(degrees).to_radians()).max(0.0);
            let sharp = spot(DVec3::NEG_Y, cos_outer.next_up(), cos_outer);
            let [inner, outer] = cone(&scene(lit(&[sharp], 100.0), false));
            assert!(outer < inner && inner - outer < 1e-9, "{degrees}°: {inner} {outer}");
            assert!((outer - cos_outer).abs() < 1e-9, "{degrees}°: {outer}");
        }
    }

    #[test]
    fn the_ground_keeps_out_of_the_way_of_a_material_of_its_name() {
        let mut model = lit(&[], 0.0);
        let grey = Phong { diffuse: ColorTexture::Constant(Rgb::gray(0.25)), ..Phong::default() };
        model.materials[0].model = grey.into();
        let scene = scene(model, true);
        let materials: Vec<_> = scene
            .appearance
            .materials
            .iter()
            .map(|material| (material.name.as_str(), material.to_phong().diffuse))
            .collect();
        let gray = |value| ColorTexture::Constant(Rgb::gray(value));
        assert_eq!(materials, [("ground", gray(0.25)), ("ground'", gray(0.5))]);
    }
}
