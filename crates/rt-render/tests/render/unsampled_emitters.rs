//! Emitters that are not sampled under `distributed`: shapes and textures without an area light, and moving ones.

use rt_geometry::{Shape, Torus};
use rt_image::Image;
use rt_math::{DVec3, Rgb, Transform};
use rt_scene_io::{Content, Group, GroupId, Integrator, RenderSettings, Scene, SceneNode};
use rt_shading::{
    Appearance, Background, ColorTexture, FloatTexture, LayeredBase, LayeredSurface, MaterialModel, Texture, TextureId,
};

use crate::support::{cuboid, diffuse_shapes, film, glowing, node, node_at, plane, sphere};

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

/// Shadow rays pass what stands before the emitter. Directions sampled by the surfaces below hit it.
#[test]
fn stretched_groups_without_shadow_hid_emitters_from_sampled_directions() {
    let shade = SceneNode { casts_shadow: false, ..node(sphere(0.0, 0.0, 0.0, 1.5), 2) };
    let emitter = node(cuboid([-2.0, 2.6, -2.0], [2.0, 2.7, 2.0]), 3);
    let at = |z: f64| Transform::translate(DVec3::new(0.0, 2.0, z));
    let flat = |z| at(z).compose(&Transform::scale(DVec3::new(1.0, 0.3, 1.0)).expect("regular"));
    let lit_by = |nodes: &[SceneNode]| {
        let black = Background::Constant(Rgb::BLACK);
        let mut scene = diffuse_shapes();
        scene.appearance = Appearance { lights: Vec::new(), background: black, ..scene.appearance };
        scene.appearance.materials[2] = glowing(Rgb::gray(1e-4));
        scene.appearance.materials.push(glowing(Rgb::WHITE));
        let floor = node(plane(DVec3::ZERO, DVec3::Y), 0);
        scene.nodes = [&[floor], nodes].concat();
        scene.settings = RenderSettings { integrator: Integrator::Path, spp: 16, depth: 1, ..scene.settings };
        scene
    };
    // Stretched spheres are not sampled, even if the group has the index of a light.
    let placed = |node: SceneNode, z| SceneNode { parent_from_local: flat(z), ..node };
    let by_themselves = lit_by(&[emitter.clone(), placed(shade.clone(), 0.0), placed(shade.clone(), 900.0)]);
    let instance = |z| placed(node(Content::Instance(GroupId(0)), 0), z);
    let mut stretched = lit_by(&[emitter.clone(), instance(0.0), instance(900.0)]);
    stretched.groups = vec![Group { name: "shade".into(), nodes: vec![shade.clone()] }];
    let off = difference(&film(&stretched), &film(&by_themselves));
    assert!(off < 1e-6, "the group differs by {off}");
}
