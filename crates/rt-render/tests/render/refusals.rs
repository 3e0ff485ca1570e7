//! Errors of invalid scenes name the offending object.

use rt_camera::Projection;
use rt_geometry::MeshData;
use rt_math::{DVec3, Transform, Vec3};
use rt_render::{Crop, PlanOptions, RenderError, RenderPlan, RenderSpace, SceneGeometry};
use rt_scene_io::{Accel, Content, Group, GroupId, MeshId, Scene, SceneNode};

use crate::support::{compile, mesh, node, sphere, spheres};

fn refusal(scene: &Scene, options: &PlanOptions) -> RenderError {
    RenderPlan::compile(scene, options).expect_err("the scene must be refused")
}

fn message(change: impl FnOnce(&mut Scene)) -> String {
    let mut scene = spheres();
    change(&mut scene);
    refusal(&scene, &PlanOptions::default()).to_string()
}

#[test]
fn dangling_indices_are_named() {
    let named = |content, material| SceneNode { name: "chair".into(), ..node(content, material) };
    for (node, what) in [
        (named(sphere(0.0, 0.0, 0.0, 1.0), 7), "material index 7"),
        (named(Content::Mesh(MeshId(3)), 0), "mesh index 3"),
        (named(Content::Instance(GroupId(9)), 0), "group index 9"),
    ] {
        let message = message(|scene| scene.nodes.push(node));
        assert!(message.contains("chair") && message.contains(what), "{message}");
    }
}

#[test]
fn groups_that_contain_themselves_are_refused() {
    let instance = || node(Content::Instance(GroupId(0)), 0);
    let message = message(|scene| {
        scene.groups.push(Group { name: "ouroboros".into(), nodes: vec![instance()] });
        scene.nodes.push(instance());
    });
    assert!(message.contains("contains itself"), "{message}");
}

#[test]
fn trees_that_are_too_deep_are_refused() {
    let message = message(|scene| {
        let round = || node(sphere(0.0, 0.0, 0.0, 1.0), 0);
        let tree = (0..2000).fold(round(), |inner, _| SceneNode { children: vec![inner], ..round() });
        scene.nodes.push(tree);
    });
    assert!(message.contains("1024"), "{message}");
}

/// `length` groups, each with an instance of the next: a recursion would overflow the stack of a thread.
fn chain_of_groups(length: u32) -> Scene {
    let mut scene = spheres();
    let instance = |id: u32| node(Content::Instance(GroupId(id)), 0);
    let inner = |id: u32| {
        if id + 1 < length { instance(id + 1) } else { node(sphere(0.0, 0.0, 0.0, 1.0), 0) }
    };
    scene.groups = (0..length).map(|id| Group { name: format!("group {id}"), nodes: vec![inner(id)] }).collect();
    scene.nodes = vec![instance(0), instance(0)];
    scene
}

#[test]
fn long_chains_of_groups_fit_the_stack_of_a_thread() {
    let compile = || {
        compile(&chain_of_groups(1023));
        let message = refusal(&chain_of_groups(1024), &PlanOptions::default()).to_string();
        assert!(message.contains("1024"), "{message}");
    };
    let small = std::thread::Builder::new().stack_size(1 << 20).spawn(compile).expect("a thread");
    small.join().expect("no overflow");
}

#[test]
fn a_forest_of_more_triangles_than_32_bits_can_number_is_accepted() {
    const TRIANGLES: usize = 1 << 16;
    let data = MeshData {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]; TRIANGLES],
        ..MeshData::default()
    };
    let mut scene = spheres();
    scene.settings.accel = Accel::Linear;
    scene.meshes = vec![mesh("tree", data)];
    scene.nodes = vec![node(Content::Mesh(MeshId(0)), 0); TRIANGLES + 1];
    compile(&scene);
    // Within a group that is placed twice, each triangle needs its own index.
    scene.groups = vec![Group { name: "forest".into(), nodes: std::mem::take(&mut scene.nodes) }];
    scene.nodes = vec![node(Content::Instance(GroupId(0)), 0); 2];
    assert!(matches!(refusal(&scene, &PlanOptions::default()), RenderError::TooManyObjects));
}

#[test]
fn singular_products_of_transforms_are_refused() {
    let thin = Transform::scale(DVec3::new(1.0, 1.0, 1e-9)).expect("regular by itself");
    let message = message(|scene| {
        let inner = SceneNode { name: "foil".into(), parent_from_local: thin, ..scene.nodes[0].clone() };
        scene.nodes[0].parent_from_local = thin;
        scene.nodes[0].children.push(inner);
    });
    assert!(message.contains("foil") && message.contains("is singular"), "{message}");
}

#[test]
fn unusable_settings_are_refused() {
    assert!(message(|scene| scene.settings.spp = 0).contains("at least 1"));
    assert!(message(|scene| scene.film.width = 0).contains("film"));
    assert!(message(|scene| scene.cameras.clear()).contains("camera"));
    let flat = Projection::Orthographic { height: 0.0 };
    assert!(message(|scene| scene.cameras[0].settings.projection = flat).contains("main"));
    for crop in [(0, 0, 0, 5), (60, 0, 2, 1), (0, 43, 1, 1), (u32::MAX, 0, 2, 1)] {
        let (x, y, width, height) = crop;
        let options = PlanOptions { crop: Some(Crop { x, y, width, height }), ..PlanOptions::default() };
        assert!(matches!(refusal(&spheres(), &options), RenderError::Crop { .. }), "{crop:?}");
    }
}

/// By plans, and by the geometry for scene lints.
#[test]
fn groups_that_multiply_beyond_memory_are_refused_at_once() {
    let mut scene = spheres();
    scene.groups = vec![Group { name: "0".into(), nodes: vec![node(sphere(0.0, 0.0, 0.0, 1.0), 0)] }];
    for level in 1..60 {
        let inner = node(Content::Instance(GroupId(level - 1)), 0);
        scene.groups.push(Group { name: level.to_string(), nodes: vec![inner.clone(), inner] });
    }
    let outer = node(Content::Instance(GroupId(59)), 0);
    scene.nodes = vec![outer.clone(), outer];
    let geometry = SceneGeometry::build(&scene, RenderSpace::WORLD).expect_err("too many objects");
    for error in [refusal(&scene, &PlanOptions::default()), geometry] {
        assert!(error.to_string().contains(&(1u64 << 59).to_string()), "{error}");
    }
}
