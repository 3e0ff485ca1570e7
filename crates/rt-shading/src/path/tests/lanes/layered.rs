//! Layered surfaces in lanes, compared with the reference.

use super::*;
use crate::{FloatTexture, LayeredBase, LayeredSurface};
use core::f64::consts::TAU;
use rt_math::transcendental::sincos;

type SurfaceChange = fn(LayeredSurface) -> LayeredSurface;

/// A base of these colour, metallic part and roughness under layers.
fn layered(
    color: Rgb,
    [metallic, roughness]: [f64; 2],
    change: impl FnOnce(LayeredSurface) -> LayeredSurface,
) -> Material {
    let [metallic, roughness] = [metallic, roughness].map(FloatTexture::Constant);
    let base = LayeredBase::MetallicRoughness { base_color: ColorTexture::Constant(color), metallic, roughness };
    let model = MaterialModel::Layered(change(LayeredSurface::new(base)).into());
    Material::new(String::new(), model)
}

fn with_clearcoat(surface: LayeredSurface, strength: f64, roughness: f64) -> LayeredSurface {
    let [clearcoat, clearcoat_roughness] = [strength, roughness].map(FloatTexture::Constant);
    LayeredSurface { clearcoat, clearcoat_roughness, ..surface }
}

fn with_sheen(surface: LayeredSurface, color: Rgb, roughness: f64) -> LayeredSurface {
    let sheen_roughness = FloatTexture::Constant(roughness);
    LayeredSurface { sheen_color: ColorTexture::Constant(color), sheen_roughness, ..surface }
}

/// Clearcoats smooth and rough, sheen, a tinted reflection, and metal.
pub(super) fn layers() -> [Material; 5] {
    let (blue, gold) = (Rgb::new(0.1, 0.3, 0.8), Rgb::new(1.0, 0.8, 0.4));
    let tint = ColorTexture::Constant(Rgb::new(1.0, 0.6, 0.4));
    [
        layered(blue, [0.0, 0.5], |surface| with_clearcoat(surface, 1.0, 0.0)),
        layered(gold, [1.0, 0.3], |surface| with_clearcoat(surface, 0.7, 0.2)),
        layered(blue, [0.2, 0.8], |surface| with_sheen(surface, gold, 0.3)),
        layered(gold, [0.0, 0.4], |surface| {
            let specular = FloatTexture::Constant(0.8);
            LayeredSurface { ior: 2.0, specular, specular_color: tint, ..surface }
        }),
        layered(Rgb::gray(0.5), [0.5, 0.1], |surface| with_sheen(with_clearcoat(surface, 0.4, 0.0), blue, 1.0)),
    ]
}

/// Layers that reflect nothing, or nearly nothing: a single lobe is left, or none.
pub(super) fn black_layers() -> [Material; 5] {
    let dark = |surface| LayeredSurface { specular: FloatTexture::Constant(0.0), ..surface };
    [
        layered(Rgb::BLACK, [0.0, 0.5], dark),
        layered(Rgb::BLACK, [0.0, 0.5], |surface| with_clearcoat(dark(surface), 1.0, 0.0)),
        layered(Rgb::BLACK, [0.0, 0.5], |surface| with_sheen(dark(surface), Rgb::new(0.0, 0.7, 0.0), 0.0)),
        layered(Rgb::new(1e-6, 0.0, 0.0), [1.0, 1.0], |surface| with_clearcoat(surface, 1e-9, 0.5)),
        layered(Rgb::WHITE, [0.0, 1.0], |surface| LayeredSurface { ior: 0.0, ..surface }),
    ]
}

#[test]
fn layered_surfaces_that_need_more_than_lanes_have_are_shaded_one_by_one() {
    let in_lanes = |material| TestScene::new(LIT_BY[1], 1.0).has_in_lanes(material);
    let plain =
        |roughness, change: fn(LayeredSurface) -> LayeredSurface| layered(Rgb::gray(0.5), [0.0, roughness], change);
    let kept_out: [(f64, SurfaceChange); 6] = [
        (0.05, |surface| with_clearcoat(surface, 0.5, 0.0)),
        (0.5, |surface| with_clearcoat(surface, 0.5, 0.05)),
        (0.5, |surface| with_clearcoat(surface, 1e-20, 0.0)),
        (0.5, |surface| with_sheen(surface, Rgb::gray(1e-20), 0.5)),
        (0.5, |surface| LayeredSurface { transmission: FloatTexture::Constant(0.5), ..surface }),
        (0.5, |surface| LayeredSurface { specular_color: ColorTexture::Constant(Rgb::gray(1e-20)), ..surface }),
    ];
    assert!(in_lanes(plain(0.5, |surface| with_clearcoat(surface, 0.5, 0.5))));
    for (roughness, change) in kept_out {
        let material = plain(roughness, change);
        assert!(!in_lanes(material.clone()), "{material:?}");
    }
}

/// Regression: lanes without a clearcoat had the numbers of a clearcoat of roughness 0, which gave NaN, unless an earlier hit had written
/// others.
#[test]
fn different_surfaces_that_share_vectors_do_not_change_each_other() {
    // With the default index, the first would not be layered.
    let plain = layered(Rgb::gray(0.5), [0.0, 0.4], |surface| LayeredSurface { ior: 2.0, ..surface });
    let coated = layered(Rgb::gray(0.5), [0.0, 0.4], |surface| with_clearcoat(surface, 0.5, 0.4));
    let [mixes, glass] = [specular::mirror_mixes(), specular::rough_glass()].map(Vec::from);
    let all = [layers().to_vec(), specular::metals().to_vec(), mixes.clone(), glass.clone()].concat();
    for materials in [vec![plain, coated], [layers(), black_layers()].concat(), mixes, glass, all] {
        let (mut scene, rays) = spheres_of(materials);
        let (seen, _) = assert_same_at_all_levels(|level| in_f32(&mut scene, level, settings(3), &rays), "spheres");
        assert!(seen.iter().all(|seen| seen.hit && seen.radiance.is_finite()), "all are hit");
    }
}

/// A ring of spheres, one of each material, and rays that hit another sphere than their neighbours.
fn spheres_of(materials: Vec<Material>) -> (TestScene, Vec<(Ray, Interval)>) {
    let mut scene = TestScene::new(LIT_BY[4], 1.0);
    let count = materials.len() as u32;
    let centre = |at: u32| {
        let (sin, cos) = sincos(TAU * f64::from(at) / f64::from(count));
        DVec3::new(2.0 * cos, 2.0 * sin, 0.0)
    };
    let primitive = |at: u32| {
        let shape = TestShape::Sphere(Sphere::new(centre(at), 0.3).expect("a sphere"));
        TestPrimitive { shape, material: at, light: None }
    };
    scene.world = ShapeWorld((0..count).map(primitive).collect());
    scene.appearance.materials = materials;
    let ray = |at: u32| {
        let eye = DVec3::new(0.0, 0.5, 7.0);
        let target = centre(at * 7 % count) + vector(u64::from(at), 7) * 0.1;
        (Ray::new(eye, target - eye), Interval::FORWARD)
    };
    (scene, (0..512).map(ray).collect())
}
