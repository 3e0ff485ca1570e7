//! Thin dielectrics whose index of refraction is 1.

use rt_image::Image;
use rt_math::{DVec3, Rgb};
use rt_scene_io::{Integrator, RenderSettings};
use rt_shading::{
    Appearance, Background, ColorTexture, FloatTexture, LayeredBase, LayeredSurface, Material, MaterialModel,
};

use crate::support::{cuboid, diffuse_shapes, film, glowing, node, plane, sphere};

fn thin_glass(ior: f64) -> MaterialModel {
    MaterialModel::ThinGlass { ior, transmittance: ColorTexture::Constant(Rgb::WHITE) }
}

/// Thin transmission of glTF.
fn layered(roughness: f64, clearcoat: f64) -> MaterialModel {
    let base_color = ColorTexture::Constant(Rgb::WHITE);
    let [metallic, roughness] = [0.0, roughness].map(FloatTexture::Constant);
    let base = LayeredBase::MetallicRoughness { base_color, metallic, roughness };
    let [transmission, clearcoat] = [1.0, clearcoat].map(FloatTexture::Constant);
    MaterialModel::Layered(Box::new(LayeredSurface { ior: 1.0, transmission, clearcoat, ..LayeredSurface::new(base) }))
}

/// A floor below an emissive box and sphere, and a thin dielectric between them.
fn below(thin: Option<MaterialModel>, integrator: Integrator) -> Image {
    let mut scene = diffuse_shapes();
    let materials = vec![
        scene.appearance.materials.swap_remove(0),
        glowing(Rgb::WHITE),
        Material::new("thin".into(), thin.clone().unwrap_or(MaterialModel::Black)),
    ];
    let black = Background::Constant(Rgb::BLACK);
    scene.appearance = Appearance { materials, background: black, lights: Vec::new(), ..scene.appearance };
    scene.nodes = vec![
        node(plane(DVec3::NEG_Y, DVec3::Y), 0),
        node(cuboid([-1.0, 2.6, -1.0], [1.0, 2.7, 1.0]), 1),
        node(sphere(2.5, 2.0, 0.0, 0.3), 1),
    ];
    scene.nodes.extend(thin.map(|_| node(plane(DVec3::Y, DVec3::Y), 2)));
    scene.settings = RenderSettings { integrator, spp: 16, depth: 2, ..scene.settings };
    film(&scene)
}

fn mean(image: &Image) -> f64 {
    let values = image.pixels().iter().flatten();
    values.clone().map(|value| f64::from(*value)).sum::<f64>() / values.count() as f64
}

/// Shadow rays passed the surface, and paths through it found the same light once more.
#[test]
fn light_behind_invisible_surfaces_counted_twice() {
    let mix = MaterialModel::Mix(vec![(0.25, thin_glass(1.0)), (0.75, thin_glass(1.0))]);
    for integrator in [Integrator::Path, Integrator::PathReference, Integrator::Direct, Integrator::Distributed] {
        let expected = mean(&below(None, integrator));
        for thin in [thin_glass(1.0), layered(0.0, 0.0), mix.clone()] {
            let seen = mean(&below(Some(thin.clone()), integrator));
            assert!((seen / expected - 1.0).abs() < 1e-4, "{integrator:?}, {thin:?}: {seen} not {expected}");
        }
    }
}

/// The conversion to Phong leaves out all that is seen of them, so that they seemed to be clear.
#[test]
fn rough_and_coated_surfaces_cast_shadows() {
    for thin in [layered(0.4, 0.0), layered(0.0, 1.0)] {
        let material = Material::new("thin".into(), thin.clone());
        assert!(!material.is_air() && !material.is_clear(), "{thin:?}");
        let by = |integrator| mean(&below(Some(thin.clone()), integrator));
        // Light arrives only by paths that pass it and hit an emitter.
        let (path, reference) = (by(Integrator::Path), by(Integrator::PathReference));
        assert!((path / reference - 1.0).abs() < 1e-4 && path < 1.2 * mean(&below(None, Integrator::Path)), "{path}");
    }
    let clear = Material::new("thin".into(), layered(0.0, 0.0));
    assert!(clear.is_air());
}
