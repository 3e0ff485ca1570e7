//! Panes without thickness whose index of refraction is 1.

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

/// A floor below a lamp and a glowing sphere, and a pane between them.
fn below(pane: Option<MaterialModel>, integrator: Integrator) -> Image {
    let mut scene = diffuse_shapes();
    let materials = vec![
        scene.appearance.materials.swap_remove(0),
        glowing(Rgb::WHITE),
        Material::new("pane".into(), pane.clone().unwrap_or(MaterialModel::Black)),
    ];
    let black = Background::Constant(Rgb::BLACK);
    scene.appearance = Appearance { materials, background: black, lights: Vec::new(), ..scene.appearance };
    scene.nodes = vec![
        node(plane(DVec3::NEG_Y, DVec3::Y), 0),
        node(cuboid([-1.0, 2.6, -1.0], [1.0, 2.7, 1.0]), 1),
        node(sphere(2.5, 2.0, 0.0, 0.3), 1),
    ];
    scene.nodes.extend(pane.map(|_| node(plane(DVec3::Y, DVec3::Y), 2)));
    scene.settings = RenderSettings { integrator, spp: 16, depth: 2, ..scene.settings };
    film(&scene)
}

fn mean(image: &Image) -> f64 {
    let values = image.pixels().iter().flatten();
    values.clone().map(|value| f64::from(*value)).sum::<f64>() / values.count() as f64
}

/// Shadow rays passed the pane, and paths through it found the same light once more.
#[test]
fn light_behind_invisible_panes_counted_twice() {
    let mix = MaterialModel::Mix(vec![(0.25, thin_glass(1.0)), (0.75, thin_glass(1.0))]);
    for integrator in [Integrator::Path, Integrator::PathReference, Integrator::Direct, Integrator::Distributed] {
        let expected = mean(&below(None, integrator));
        for pane in [thin_glass(1.0), layered(0.0, 0.0), mix.clone()] {
            let seen = mean(&below(Some(pane.clone()), integrator));
            assert!((seen / expected - 1.0).abs() < 1e-4, "{integrator:?}, {pane:?}: {seen} not {expected}");
        }
    }
}

/// Of rough and coated panes, the conversion to Phong leaves out all that is seen, so that they seemed to be as clear.
#[test]
fn rough_and_coated_panes_of_index_1_cast_shadows() {
    for pane in [layered(0.4, 0.0), layered(0.0, 1.0)] {
        let material = Material::new("pane".into(), pane.clone());
        assert!(!material.is_air() && !material.is_clear(), "{pane:?}");
        let by = |integrator| mean(&below(Some(pane.clone()), integrator));
        // Light arrives only through the pane, by paths that hit the lamps.
        let (path, reference) = (by(Integrator::Path), by(Integrator::PathReference));
        assert!((path / reference - 1.0).abs() < 1e-4 && path < 1.2 * mean(&below(None, Integrator::Path)), "{path}");
    }
    let clear = Material::new("pane".into(), layered(0.0, 0.0));
    assert!(clear.is_air());
}
