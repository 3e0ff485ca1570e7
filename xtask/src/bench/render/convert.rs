//! Neutral descriptions to scene files, so that every renderer does equal work: the same size, samples, depth, lights.

use std::path::PathBuf;

use rt_scene_io::format::{
    Background, Camera, Color, ColorTexture, EmissionSides, Falloff, Film, Integrator, Light, LightUnits, Material,
    Node, Sampler, SceneFile, Settings, Shape,
};

use super::exchange_scene;
use crate::{error::TaskError, files};

#[derive(Debug, clap::Args)]
pub(in crate::bench) struct ConvertOptions {
    /// JSON scene description.
    #[arg(value_name = "JSON")]
    from: PathBuf,
    /// Scene file to write.
    #[arg(value_name = "SCENE.json")]
    to: PathBuf,
}

/// Converts a description to a scene file.
pub(in crate::bench) fn run(options: &ConvertOptions) -> Result<(), TaskError> {
    let text = convert(exchange_scene::read(&options.from)?).to_json();
    files::write(&options.to, text)
}

fn convert(scene: exchange_scene::ExchangeScene) -> SceneFile {
    let mut lights = vec![Light::Ambient(Color::from_rgb(scene.ambient))];
    lights.extend(scene.lights.iter().filter_map(light));
    let exchange_scene::Camera { eye, at, up, vfov } = scene.camera;
    let camera = Camera { look_from: Some(eye), look_at: Some(at), up: Some(up), fov: Some(vfov), ..Camera::default() };
    // Each level of the description is a ray, the one to the light among them for paths; ours are bounces.
    let depth = scene.depth.saturating_sub(if scene.gi { 2 } else { 1 });
    let checkers =
        scene.materials.iter().filter_map(|(name, material)| Some((name.as_str(), material.checker.as_ref()?)));
    let checkers: Vec<&str> = checkers.map(|(name, _)| name).collect();
    let has_area_light = scene.lights.iter().any(|light| matches!(light, exchange_scene::Light::Rect {}));
    let integrator = match (scene.gi, has_area_light) {
        (true, _) => Integrator::Path,
        (false, true) => Integrator::Distributed,
        (false, false) => Integrator::Whitted,
    };
    let nodes = scene.objects.into_iter().map(|object| {
        let has_checker = checkers.contains(&object.mat.as_str());
        node(object, has_checker)
    });
    SceneFile {
        name: Some(scene.name),
        camera: Some(camera),
        film: Film { size: (scene.w, scene.h), ..Film::default() },
        settings: Settings {
            integrator: Some(integrator),
            sampler: Sampler::Jittered,
            spp: scene.spp,
            max_depth: depth,
            ..Settings::default()
        },
        background: Some(Background::Constant(Color::from_rgb(scene.background))),
        lights: Some(lights),
        materials: scene.materials.iter().map(|(name, of)| (name.clone(), material(of))).collect(),
        ..SceneFile::of_nodes(nodes.collect())
    }
}

fn light(light: &exchange_scene::Light) -> Option<Light> {
    let (position, color, shadow_near) = match light {
        exchange_scene::Light::Point { p, color } => (*p, *color, 0.0),
        exchange_scene::Light::Sphere { p, r, color } => (*p, *color, *r),
        // The light is an object as well, with an emissive material.
        exchange_scene::Light::Rect {} => return None,
    };
    Some(Light::Point {
        name: String::new(),
        position,
        intensity: Color::from_rgb(color),
        units: LightUnits::Classical,
        falloff: Falloff::None,
        shadow_near,
        casts_shadows: true,
    })
}

fn material(of: &exchange_scene::Material) -> Material {
    if let Some(radiance) = of.radiance {
        let albedo = Color::from_rgb(of.color).into();
        let emitter =
            Material::Light { radiance: Color::from_rgb(radiance).into(), emission_sides: EmissionSides::Front };
        return Material::Mix(vec![
            (1.0, Material::Diffuse { albedo, roughness: 0.0, emission: None }),
            (1.0, emitter),
        ]);
    }
    let tint = |coefficient: f64| of.color.map(|channel| channel * coefficient);
    let gray = |coefficient: f64| Some(ColorTexture::Gray(coefficient));
    let color = match &of.checker {
        Some(exchange_scene::Checker { c2, size }) => {
            ColorTexture::Checker { even: Color::from_rgb(*c2), odd: Color::from_rgb(of.color), size: *size }
        }
        None => Color::from_rgb(of.color).into(),
    };
    Material::Phong {
        color: Some(color),
        ambient: gray(of.ka),
        diffuse: gray(of.kd),
        specular: gray(of.ks),
        exponent: Some(of.shin),
        highlight: None,
        emission: Some(Color::from_rgb(tint(of.emit)).into()),
        mirror: Some(if of.kr_tint { Color::from_rgb(tint(of.kr)).into() } else { ColorTexture::Gray(of.kr) }),
        // A material without transmission is opaque.
        transmission: gray(of.kt).filter(|_| of.kt > 0.0),
        ior: Some(of.ior).filter(|_| of.kt > 0.0),
        fresnel: None,
        absorption: None,
        priority: None,
        emission_sides: None,
    }
}

fn node(object: exchange_scene::Object, has_checker: bool) -> Node {
    let shape = match object.shape {
        exchange_scene::Shape::Sphere { c, r } => Shape::Sphere { center: c, radius: r },
        exchange_scene::Shape::Poly { pts } => {
            let corners = pts.len() as u32;
            let triangles = (2..corners).map(|last| [0, last - 1, last]).collect();
            let uvs = if has_checker { flat(&pts) } else { Vec::new() };
            Shape::Mesh { positions: pts, triangles, faces: Vec::new(), normals: Vec::new(), uvs }
        }
        exchange_scene::Shape::Mesh { positions, normals, triangles } => {
            Shape::Mesh { positions, triangles, faces: Vec::new(), normals, uvs: Vec::new() }
        }
    };
    Node { shape: Some(shape), material: Some(object.mat.into()), casts_shadow: !object.no_shadow, ..Node::default() }
}

/// Texture coordinates: the two world coordinates of the largest extent.
fn flat(points: &[[f32; 3]]) -> Vec<[f32; 2]> {
    let extent = |axis: usize| {
        let along = || points.iter().map(|point| point[axis]);
        along().fold(f32::NEG_INFINITY, f32::max) - along().fold(f32::INFINITY, f32::min)
    };
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| extent(*b).total_cmp(&extent(*a)));
    let [mut u, mut v, _] = axes;
    if u > v {
        std::mem::swap(&mut u, &mut v);
    }
    points.iter().map(|point| [point[u], point[v]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn description(lights: &str) -> String {
        format!(
            r#"{{"name": "s", "w": 8, "h": 4, "spp": 16, "depth": 6, "gi": false,
            "camera": {{"eye": [0, 1, 5], "at": [0, 0, 0], "up": [0, 1, 0], "vfov": 30}},
            "background": [0.1, 0.1, 0.2], "ambient": [1, 1, 1], "lights": [{lights}],
            "materials": {{
                "ball": {{"color": [1, 0.5, 0], "ka": 0.1, "kd": 0.7, "ks": 0.4, "shin": 40, "kr": 0.5, "kt": 0,
                    "ior": 1.5, "emit": 0.5, "checker": null, "kr_tint": true}},
                "floor": {{"color": [1, 1, 0], "ka": 0, "kd": 0.8, "ks": 0, "shin": 0, "kr": 0.2, "kt": 0, "ior": 1,
                    "emit": 0, "checker": {{"c2": [1, 0, 0], "size": 2}}, "kr_tint": false}}
            }},
            "objects": [
                {{"type": "sphere", "c": [0, 1, 0], "r": 1, "mat": "ball", "no_shadow": true}},
                {{"type": "poly", "pts": [[-6, 0, -14], [-6, 0, 4], [6, 0, 4], [6, 0, -14]], "mat": "floor"}}
            ]}}"#
        )
    }

    #[test]
    fn nothing_is_lost_on_the_way_to_a_scene_file() {
        let lights = r#"{"type": "point", "p": [1, 2, 3], "color": [0.7, 0.7, 0.7], "dref": 9},
                        {"type": "sphere_light", "obj": 1, "p": [3, 2, 1], "r": 2, "color": [1, 0, 0], "dref": null}"#;
        let text = description(lights);
        let file = convert(serde_json::from_str(&text).unwrap());
        assert_eq!(
            rt_scene_io::format::parse_json(&file.to_json(), "s.json".as_ref()).unwrap(),
            file,
            "it is a scene file"
        );
        assert_eq!((file.film.size, file.settings.spp, file.settings.max_depth), ((8, 4), 16, 5));
        let lights = file.lights.unwrap();
        let radius = |light: &Light| match light {
            Light::Point { shadow_near, .. } => Some(*shadow_near),
            _ => None,
        };
        assert_eq!(lights.iter().map(radius).collect::<Vec<_>>(), [None, Some(0.0), Some(2.0)]);
        let Material::Phong { mirror, emission, .. } = &file.materials["ball"] else { panic!("a classical material") };
        assert_eq!(*mirror, Some(ColorTexture::Rgb(0.5, 0.25, 0.0)), "tinted");
        assert_eq!(*emission, Some(ColorTexture::Rgb(0.5, 0.25, 0.0)));
        assert_eq!(file.nodes.iter().map(|node| node.casts_shadow).collect::<Vec<_>>(), [false, true]);
        let Some(Shape::Mesh { triangles, uvs, .. }) = &file.nodes[1].shape else { panic!("a mesh") };
        assert_eq!((triangles.as_slice(), uvs[2]), (&[[0, 1, 2], [0, 2, 3]][..], [6.0, 4.0]));
    }

    #[test]
    fn area_lights_use_the_distributed_integrator() {
        let emitter = r#"{"type": "rect", "p": [0, 0, 0], "u": [1, 0, 0], "v": [0, 1, 0], "radiance": [1, 1, 1], "color": [1, 1, 1]}"#;
        let file = convert(serde_json::from_str(&description(emitter)).unwrap());
        assert_eq!(file.settings.integrator, Some(Integrator::Distributed));
    }
}
