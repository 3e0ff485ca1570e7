//! Scenes that cannot be rendered are refused with the name of what is wrong.

use crate::support::{sphere, spheres};
use rt_camera::Projection;
use rt_math::{DVec3, Transform};
use rt_render::{Crop, PlanOptions, RenderError, RenderPlan};
use rt_scene_io::{Content, Group, GroupId, MaterialId, MeshId, Node, Scene};

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
    let named = |content, material| Node { name: "chair".into(), ..Node::new(content, MaterialId(material)) };
    for (node, what) in [
        (named(sphere(0.0, 0.0, 0.0, 1.0), 7), "material number 7"),
        (named(Content::Mesh(MeshId(3)), 0), "mesh number 3"),
        (named(Content::Instance(GroupId(9)), 0), "group number 9"),
    ] {
        let message = message(|scene| scene.nodes.push(node));
        assert!(message.contains("chair") && message.contains(what), "{message}");
    }
}

#[test]
fn groups_that_contain_themselves_are_refused() {
    let instance = || Node::new(Content::Instance(GroupId(0)), MaterialId(0));
    let message = message(|scene| {
        scene.groups.push(Group { name: "ouroboros".into(), nodes: vec![instance()] });
        scene.nodes.push(instance());
    });
    assert!(message.contains("contains itself"), "{message}");
}

#[test]
fn trees_that_are_too_deep_are_refused() {
    let message = message(|scene| {
        let mut node = Node::new(sphere(0.0, 0.0, 0.0, 1.0), MaterialId(0));
        for _ in 0..2000 {
            node = Node { children: vec![node], ..Node::new(sphere(0.0, 0.0, 0.0, 1.0), MaterialId(0)) };
        }
        scene.nodes.push(node);
    });
    assert!(message.contains("1024"), "{message}");
}

#[test]
fn products_of_transforms_that_flatten_space_are_refused() {
    let thin = Transform::scale(DVec3::new(1.0, 1.0, 1e-9)).expect("regular by itself");
    let message = message(|scene| {
        let inner = Node { name: "foil".into(), parent_from_local: thin, ..scene.nodes[0].clone() };
        scene.nodes[0].parent_from_local = thin;
        scene.nodes[0].children.push(inner);
    });
    assert!(message.contains("foil") && message.contains("flattens"), "{message}");
}

#[test]
fn unusable_settings_are_refused() {
    assert!(message(|scene| scene.settings.spp = 0).contains("1 sample"));
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
