//! Emitters that are not sampled under `distributed`: shapes and textures without an area light, and moving ones.

use rt_geometry::{Shape, Torus};
use rt_image::Image;
use rt_math::{DVec3, Rgb, Transform};
use rt_scene_io::{Content, Group, GroupId, Integrator, RenderSettings, Scene, SceneNode};
use rt_shading::{
    Background, ColorTexture, FloatTexture, LayeredBase, LayeredSurface, MaterialModel, Texture, TextureId,
};

use crate::support::{diffuse_shapes, film, node, node_at, sphere};

/// Diffuse surfaces and one emitter, in place of the emissive polygon.
fn lit_by(emitter: SceneNode) -> Scene {
    let mut scene = diffuse_shapes();
    scene.appearance.background = Background::Constant(Rgb::BLACK);
    scene.nodes[2] = SceneNode { name: "emitter".into(), ..emitter };
    scene.settings = RenderSettings { integrator: Integrator::Distributed, spp: 16, depth: 0, ..scene.settings };
    scene
}

fn emitters() -> Vec<(&'static str, Scene)> {
    let above = Transform::translate(DVec3::new(0.0, 3.0, 0.5));
    let at_rest = || node_at(sphere(0.0, 0.0, 0.0, 0.6), 2, above);
    let torus = Content::Shape(Shape::Torus(Torus::new(0.5, 0.2).expect("a torus")));
    let stretched = above.compose(&Transform::scale(DVec3::new(1.0, 0.5, 1.0)).expect("regular"));
    let moving = SceneNode { moves_to: Some(Transform::translate(DVec3::new(0.5, 3.0, 0.5))), ..at_rest() };
    let mut textured = lit_by(at_rest());
    textured.appearance.textures =
        vec![Texture::Checker { even: Rgb::WHITE, odd: Rgb::new(0.7, 0.1, 0.1), size: 0.25 }];
    textured.appearance.materials[2].emission = ColorTexture::Textured(TextureId(0), Rgb::gray(6.0));
    let base_color = ColorTexture::Constant(Rgb::BLACK);
    let (metallic, roughness) = (FloatTexture::Constant(0.0), FloatTexture::Constant(1.0));
    let layered = LayeredSurface::new(LayeredBase::MetallicRoughness { base_color, metallic, roughness });
    let layered = LayeredSurface { clearcoat: FloatTexture::Constant(1.0), ..layered };
    let mut coated = lit_by(at_rest());
    coated.appearance.materials[2].model = MaterialModel::Layered(Box::new(layered));
    let mut group = lit_by(node_at(Content::Instance(GroupId(0)), 0, stretched));
    group.groups = vec![Group { name: "emitters".into(), nodes: vec![node(sphere(0.0, 0.0, 0.0, 0.6), 2)] }];
    vec![
        ("torus", lit_by(SceneNode { content: Some(torus), ..at_rest() })),
        ("stretched", lit_by(SceneNode { parent_from_local: stretched, ..at_rest() })),
        ("moving", lit_by(moving)),
        ("textured", textured),
        ("coated", coated),
        ("group", group),
    ]
}

fn difference(a: &Image, b: &Image) -> f64 {
    let pixels = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    let sums = pixels.fold([0.0; 2], |[off, sum], (a, b)| [off + f64::from((a - b).abs()), sum + f64::from(*b)]);
    sums[0] / sums[1]
}

#[test]
fn emitters_that_are_not_sampled_gave_diffuse_surfaces_no_light() {
    for (name, scene) in emitters() {
        let direct =
            Scene { settings: RenderSettings { integrator: Integrator::Direct, ..scene.settings }, ..scene.clone() };
        let off = difference(&film(&scene), &film(&direct));
        assert!(off < 1e-4, "{name} differs by {off}");
    }
}

/// Lanes, single hits and the reference have the same emission and the same weights.
#[test]
fn path_tracing_of_them_is_that_of_the_reference() {
    for (name, scene) in emitters() {
        let by = |integrator| {
            let settings = RenderSettings { integrator, spp: 4, depth: 2, ..scene.settings };
            film(&Scene { settings, ..scene.clone() })
        };
        let off = difference(&by(Integrator::Path), &by(Integrator::PathReference));
        assert!(off < 1e-3, "{name} differs by {off}");
    }
}

/// A texture of one colour is not sampled, and has the same image: explicit samples would not count the coat.
#[test]
fn emission_below_a_clearcoat_is_not_sampled() {
    let coated = emitters().into_iter().find_map(|(name, scene)| (name == "coated").then_some(scene)).expect("coated");
    let settings = RenderSettings { integrator: Integrator::Path, spp: 4, depth: 2, ..coated.settings };
    let coated = Scene { settings, ..coated };
    let mut textured = coated.clone();
    let emission = &mut textured.appearance.materials[2].emission;
    *emission = ColorTexture::Textured(TextureId(0), emission.factor());
    textured.appearance.textures = vec![Texture::Checker { even: Rgb::WHITE, odd: Rgb::WHITE, size: 1.0 }];
    let off = difference(&film(&coated), &film(&textured));
    assert!(off < 1e-6, "they differ by {off}");
}

#[test]
fn their_rays_find_no_background_where_ambient_light_stands_for_it() {
    for (name, black) in emitters() {
        let mut white = black.clone();
        white.appearance.background = Background::Constant(Rgb::WHITE);
        let hits = |scene: &Scene| Scene {
            settings: RenderSettings { integrator: Integrator::Depth, ..scene.settings },
            ..scene.clone()
        };
        let (in_black, in_white, depth) = (film(&black), film(&white), film(&hits(&black)));
        let pixels = in_black.pixels().iter().zip(in_white.pixels()).zip(depth.pixels());
        let inside: Vec<_> = pixels.filter(|(_, depth)| depth[0] > 0.0).map(|(both, _)| both).collect();
        let changed = inside.iter().filter(|(black, white)| black != white).count();
        // Some pixels are partly covered.
        assert!(inside.len() > 1000 && changed < inside.len() / 10, "{name}: {changed} of {}", inside.len());
    }
}
