//! Picking of objects by pixel.

use std::collections::HashSet;

use rt_math::{DVec3, Transform};
use rt_scene_io::{Content, Group, GroupId, Scene, SceneNode};

use crate::support::{compile, compile_with, everything, full, spheres};

fn name_all(nodes: &mut [SceneNode], prefix: &str) {
    for (index, node) in nodes.iter_mut().enumerate() {
        node.name = format!("{prefix}{index}");
        name_all(&mut node.children, &format!("{prefix}{index}."));
    }
}

fn named(mut scene: Scene) -> Scene {
    name_all(&mut scene.nodes, "node ");
    for group in &mut scene.groups {
        name_all(&mut group.nodes, &format!("{} ", group.name));
    }
    scene
}

/// The untrimmed plan stores a name per instance; the trimmed one finds the node by the index of its shape.
#[test]
fn trimmed_and_full_plans_pick_the_same() {
    let mut nested = spheres();
    let inner = nested.nodes.split_off(20);
    nested.groups = vec![Group { name: "group".into(), nodes: inner }];
    let mut place = SceneNode::new(Content::Instance(GroupId(0)), nested.nodes[0].material);
    place.children = nested.nodes.split_off(12);
    nested.nodes.insert(5, place);
    for scene in [spheres(), nested, everything()].map(named) {
        let (plan, full) = (compile(&scene), compile_with(&scene, full()));
        let mut names = HashSet::new();
        for (x, y) in (0..43).flat_map(|y| (0..61).map(move |x| (x, y))) {
            let picked = plan.pick(x, y);
            assert_eq!(picked, full.pick(x, y), "{}, {x}, {y}", scene.name);
            names.extend(picked.map(|picked| picked.object));
        }
        assert!(names.len() > 10, "{names:?}");
    }
}

#[test]
fn the_hit_point_of_a_sphere_is_exact() {
    let mut scene = spheres();
    scene.nodes.truncate(1);
    scene.nodes[0].name = "ball".into();
    // Sphere of centre (−1, −1, −1) and radius 0.45; the image has an odd size, so that its centre is a pixel centre.
    let centre = DVec3::splat(-1.0);
    let eye = centre + DVec3::Z * 4.0;
    scene.cameras[0].settings.world_from_camera = Transform::look_at(eye, centre, DVec3::Y).expect("a view");
    for offset in [0.0, 1e7] {
        scene.nodes[0].parent_from_local = Transform::translate(DVec3::X * offset);
        scene.cameras[0].settings.world_from_camera =
            Transform::look_at(eye + DVec3::X * offset, centre + DVec3::X * offset, DVec3::Y).expect("a view");
        let plan = compile(&scene);
        let picked = plan.pick(30, 21).expect("the sphere");
        assert_eq!((picked.object, picked.material.as_str()), (vec!["ball".to_owned()], "grey"));
        assert!((picked.distance - 3.55).abs() < 1e-8, "{}", picked.distance);
        assert!((picked.point - DVec3::new(offset - 1.0, -1.0, -0.55)).length() < 1e-8, "{}", picked.point);
        assert!((picked.normal - DVec3::Z).length() < 1e-8, "{}", picked.normal);
        assert_eq!((plan.pick(0, 0), plan.pick(u32::MAX, 0)), (None, None));
    }
}

#[test]
fn instances_precede_the_names_of_their_objects() {
    let scene = named(everything());
    let plan = compile(&scene);
    let all = (0..43).flat_map(|y| (0..61).map(move |x| (x, y)));
    let deep: HashSet<_> = all.filter_map(|(x, y)| plan.pick(x, y)).map(|picked| picked.object.len()).collect();
    assert_eq!(deep, HashSet::from([1, 2]));
}
