//! Animations, skins and morph targets.

use super::*;

#[test]
fn nodes_are_posed_at_a_moment() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let arrays = Arrays::triangle()
        .with("SCALAR", &[0.0, 2.0])
        .with("VEC3", &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0])
        .with("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]);
    let rest = format!(
        r#"{TRIANGLE}, "nodes": [{{"mesh": 0, "scale": [2, 2, 2]}}], "animations": [{{
            "channels": [{{"sampler": 0, "target": {{"node": 0, "path": "translation"}}}},
                         {{"sampler": 1, "target": {{"node": 0, "path": "rotation"}}}},
                         {{"sampler": 1, "target": {{"path": "pointer"}}}}],
            "samplers": [{{"input": 1, "output": 2}}, {{"input": 1, "output": 3, "interpolation": "STEP"}}]}}]"#
    );
    let place = |model: Model| model.nodes[0].parent_from_local.point(DVec3::X);
    let rest_model = arrays.model(&rest);
    assert_eq!(rest_model.notes, ["The model is animated: it is shown in its rest pose."]);
    assert_eq!(place(rest_model), DVec3::new(2.0, 0.0, 0.0));
    assert_eq!(place(arrays.at(1.0, &rest)), DVec3::new(4.0, 0.0, 0.0));
    assert!((place(arrays.at(9.0, &rest)) - DVec3::new(4.0, 2.0, 0.0)).length() < 1e-6);
    let options = LoadOptions { at_time: Some(1.0), ..LoadOptions::default() };
    let refused = |from: &str, to: &str| arrays.refused(&rest.replace(from, to), &options);
    assert!(
        refused(r#"{"node": 0, "path": "rot"#, r#"{"node": 1, "path": "rot"#)
            .contains("1 is not the index of a node; there are 1")
    );
    assert!(refused("\"sampler\": 1", "\"sampler\": 5").contains("5 is not the index of a sampler; there are 2"));
    assert!(refused("\"output\": 2", "\"output\": 3").contains("has 4 components, where 3 are needed"));
    assert!(refused("\"interpolation\": \"STEP\"", "\"interpolation\": \"CUBICSPLINE\"").contains("do not fit 2 keys"));
    assert!(
        refused("\"input\": 1, \"output\": 2", "\"input\": 9, \"output\": 2").contains("accessors[9]: does not exist")
    );
    let error = refused("\"scale\": [2, 2, 2]", "\"matrix\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]");
    assert!(error.contains("0 is a node with a matrix, which cannot be animated"), "{error}");
}

/// Options with the shutter open from a time on, for a second.
fn open_at(time: f64) -> LoadOptions {
    LoadOptions { at_time: Some(time), frame_time: Some(1.0), shutter: Some([0.0, 1.0]), ..LoadOptions::default() }
}

#[test]
fn nodes_and_cameras_move_while_the_shutter_is_open() {
    let arrays = Arrays::triangle().with("SCALAR", &[0.0, 4.0]).with("VEC3", &[0.0, 0.0, 0.0, 8.0, 0.0, 0.0]);
    let rest = format!(
        r#"{TRIANGLE}, "cameras": [{{"type": "orthographic", "orthographic": {{"xmag": 1, "ymag": 1, "zfar": 9, "znear": 0}}}}],
            "nodes": [{{"mesh": 0, "children": [1, 2]}}, {{"camera": 0, "translation": [0, 0, 3]}}, {{"mesh": 0}}],
            "animations": [{{"channels": [{{"sampler": 0, "target": {{"node": 0, "path": "PATH"}}}}],
                "samplers": [{{"input": 1, "output": 2}}]}}]"#
    );
    let moved = rest.replace("PATH", "translation");
    let model = arrays.load(&moved, &open_at(1.0)).expect("a model");
    let translation = |x: f64, z: f64| rt_math::Transform::translate(DVec3::new(x, 0.0, z));
    assert_eq!(model.nodes[0].parent_from_local, translation(2.0, 0.0));
    assert_eq!(model.nodes[0].moves_to, Some(translation(4.0, 0.0)));
    assert_eq!(model.nodes[0].children[1].moves_to, None, "it moves with its parent");
    let camera = model.cameras[0].settings;
    assert_eq!((camera.world_from_camera, camera.moves_to), (translation(2.0, 3.0), Some(translation(4.0, 3.0))));
    assert_eq!(model.warnings, []);
    let later = arrays.load(&moved, &open_at(4.0)).expect("a model");
    assert_eq!((later.nodes[0].moves_to, later.cameras[0].settings.moves_to), (None, None));
    let sharp = arrays.at(1.0, &moved);
    assert_eq!((sharp.nodes[0].moves_to, sharp.nodes[0].parent_from_local), (None, translation(2.0, 0.0)));
    // The camera of a bare model moves with its node.
    let (file, _) = crate::default_scene::scene_for_model(&model, &model, "m.glb", &open_at(1.0));
    let at_hand = Some(("m.glb".to_owned(), model));
    let scene = crate::resolve::resolve_with(&file, Path::new("m.glb"), &open_at(1.0), at_hand).expect("a scene").0;
    let seen = scene.cameras[0].settings;
    assert_eq!(
        (seen.world_from_camera, seen.moves_to, seen.shutter),
        (camera.world_from_camera, camera.moves_to, [0.0, 1.0])
    );
    // A node that is scaled to zero on its way stands still.
    let flat = arrays.load(&rest.replace("PATH", "scale"), &open_at(-1.0)).expect("a model");
    assert!(flat.nodes.is_empty() && flat.warnings[0].message.contains("left out"), "{:?}", flat.warnings);
}

#[test]
fn meshes_that_bones_or_weights_move_are_not_blurred_and_say_so() {
    let arrays = Arrays::triangle()
        .with("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0])
        .with("SCALAR", &[0.0, 4.0])
        .with("SCALAR", &[0.0, 8.0])
        .with_bytes("VEC4", &[0; 12])
        .with("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(3))
        .with("VEC3", &[0.0, 0.0, 0.0, 8.0, 0.0, 0.0]);
    let rest = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 1}]}]},
            {"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 4, "WEIGHTS_0": 5}}]}],
        "skins": [{"joints": [3]}], "nodes": [{"mesh": 0}, {"mesh": 0}, {"mesh": 1, "skin": 0}, {}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}},
            {"sampler": 1, "target": {"node": 3, "path": "translation"}}],
            "samplers": [{"input": 2, "output": 3}, {"input": 2, "output": 6}]}]"#;
    let model = arrays.load(rest, &open_at(1.0)).expect("a model");
    let message =
        "meshes with skins or morph targets have no motion blur: 2; their pose at the start of the shutter is used";
    assert_eq!(model.messages(), [message]);
    assert_eq!(arrays.load(rest, &open_at(4.0)).expect("a model").warnings, []);
    assert_eq!(model.mesh_data(0).positions[0].z, 2.0);
}

#[test]
fn morph_targets_are_added_by_their_weights() {
    let arrays = Arrays::triangle()
        .with("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0])
        .with("SCALAR", &[0.0, 1.0])
        .with("SCALAR", &[0.0, 8.0]);
    let rest = r#""meshes": [{"weights": [0.5], "primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 1}]}]}],
        "nodes": [{"mesh": 0}, {"mesh": 0, "weights": [2]}, {"mesh": 0}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 2, "path": "weights"}}],
            "samplers": [{"input": 2, "output": 3}]}]"#;
    let heights = |model: &Model| {
        let height = |node: &SceneNode| {
            let Some(Content::Mesh(MeshId(mesh))) = node.content else { panic!("a mesh") };
            model.mesh_data(mesh as usize).positions[1].z
        };
        model.nodes.iter().map(height).collect::<Vec<_>>()
    };
    let model = arrays.model(rest);
    assert_eq!((heights(&model), model.meshes.len()), (vec![0.5, 2.0, 0.5], 2));
    assert_eq!(heights(&arrays.at(0.25, rest)), [0.5, 2.0, 2.0]);
}

#[test]
fn skins_follow_their_joints_and_not_their_node() {
    let arrays = Arrays::triangle()
        .with_bytes("VEC4", &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0])
        .with("VEC4", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0])
        .with(
            "MAT4",
            &[
                [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
                [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 1.0],
            ]
            .concat(),
        );
    let rest = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}}]}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": 3}],
        "nodes": [{"mesh": 0, "skin": 0, "translation": [100, 0, 0], "children": [3]},
                  {"children": [2], "translation": [0, 0, 3]}, {"translation": [1, 2, 0]}, {"mesh": 0}]"#;
    let model = arrays.model(rest);
    let bound = model.nodes.iter().find(|node| node.content.is_some()).expect("the skinned mesh");
    assert_eq!(bound.parent_from_local, rt_math::Transform::IDENTITY);
    let Some(Content::Mesh(MeshId(mesh))) = bound.content else { panic!("a mesh") };
    let positions = &model.mesh_data(mesh as usize).positions;
    // The first joint lifts by 3, the second by (1, 2, 3) less its bind matrix, the last vertex has both by halves.
    assert_eq!(positions[..], [Vec3::new(0.0, 0.0, 3.0), Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.0, 2.0, 3.0)]);
    let child = model.nodes.iter().flat_map(|node| &node.children).find(|node| node.content.is_some());
    assert_eq!(
        child.map(|node| &node.content),
        Some(&Some(Content::Mesh(MeshId(mesh ^ 1)))),
        "at rest, as it has no skin"
    );
    let refused = |joints: &str| arrays.refused(&rest.replace("[1, 2]", joints), &LoadOptions::default());
    let error = refused("[1, 2, 3]");
    assert!(error.contains("2 inverse bind matrices are too few for 3 joints"), "{error}");
    let error = refused("[1]");
    assert!(error.contains("1 is not the index of a joint; there are 1"), "{error}");
}

#[test]
fn a_mirrored_node_of_a_skin_turns_its_triangles() {
    let arrays = Arrays::skinned();
    let rest = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}}]}],
        "skins": [{"joints": [1]}], "nodes": [{"scale": [-1, 1, 1], "children": [1, 2]}, {}, {"mesh": 0, "skin": 0}]"#;
    let model = arrays.model(rest);
    let data = model.mesh_data(0);
    assert_eq!((data.triangles[0], data.positions[1]), ([0, 2, 1], Vec3::new(-1.0, 0.0, 0.0)));
}

/// The second key of a step was the end of a motion, and the mesh was smeared on the line to it.
#[test]
fn steps_hold_their_pose_while_the_shutter_is_open() {
    let arrays = Arrays::triangle()
        .with("SCALAR", &[0.0, 1.0, 2.0])
        .with("VEC3", &[0.0, 0.0, 0.0, 8.0, 0.0, 0.0, 0.0, 8.0, 0.0]);
    let rest = format!(
        r#"{TRIANGLE}, "nodes": [{{"mesh": 0}}],
            "animations": [{{"channels": [{{"sampler": 0, "target": {{"node": 0, "path": "translation"}}}}],
                "samplers": [{{"input": 1, "output": 2, "interpolation": "MODE"}}]}}]"#
    );
    let model = |mode: &str, time| arrays.load(&rest.replace("MODE", mode), &open_at(time)).expect("a model");
    for time in [0.0, 0.5, 1.0] {
        let model = model("STEP", time);
        assert_eq!((model.nodes[0].moves_to, model.warnings), (None, vec![]), "{time}");
    }
    assert_eq!(model("STEP", 1.0).nodes[0].parent_from_local, rt_math::Transform::translate(DVec3::X * 8.0));
    assert_eq!(model("LINEAR", 0.0).nodes[0].moves_to, Some(rt_math::Transform::translate(DVec3::X * 8.0)));
}

/// They were put at the origin, though the warning said that only the skin is ignored.
#[test]
fn primitives_without_joints_stand_at_their_node_though_it_has_a_skin() {
    let arrays = Arrays::skinned();
    let rest = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}},
            {"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}}]}],
        "skins": [{"joints": [1]}],
        "nodes": [{"mesh": 0, "skin": 0, "translation": [2, 0, 0], "scale": [-1, 1, 1]}, {"translation": [0, 0, 3]}]"#;
    let model = arrays.model(rest);
    assert!(model.warnings[0].message.ends_with("the skin is ignored"), "{:?}", model.warnings);
    let found = |mesh: u32| model.nodes.iter().find(|node| node.content == Some(Content::Mesh(MeshId(mesh))));
    let (plain, skinned) = (found(0).expect("the part without joints"), found(1).expect("the part with joints"));
    assert_eq!(plain.parent_from_local.point(DVec3::X), DVec3::X, "mirrored at 0 and moved by 2");
    assert_eq!(model.mesh_data(0).triangles, [[0, 1, 2]], "its node mirrors it");
    assert_eq!(skinned.parent_from_local, rt_math::Transform::IDENTITY);
    let data = model.mesh_data(1);
    assert_eq!((data.positions[0], data.triangles[0]), (Vec3::new(0.0, 0.0, 3.0), [0, 2, 1]));
}

/// The mesh vanished with its node.
#[test]
fn skinned_meshes_ignore_a_singular_transform_of_their_node() {
    let arrays = Arrays::skinned();
    let rest = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}}]}],
        "skins": [{"joints": [1]}], "nodes": [{"mesh": 0, "skin": 0, "scale": [0, 0, 0]}, {"translation": [0, 0, 3]}]"#;
    let model = arrays.model(rest);
    let shown: Vec<&SceneNode> = model.nodes.iter().filter(|node| node.content.is_some()).collect();
    assert_eq!((shown.len(), shown[0].parent_from_local), (1, rt_math::Transform::IDENTITY));
    assert_eq!(model.mesh_data(0).positions[1], Vec3::new(1.0, 0.0, 3.0));
    assert_eq!(model.warnings, []);
    let rest = rest.replace(r#"[0, 0, 0]}, {"#, r#"[0, 0, 0], "children": [2]}, {"#).replace("3]}]", "3]}, {}]");
    let model = arrays.model(&rest);
    assert_eq!(model.nodes.len(), 2, "the mesh and the joint");
    let message = &model.warnings[0].message;
    assert!(message.contains("singular") && message.ends_with("all but its skinned meshes is left out"), "{message}");
}

/// They stood still, and nothing said so.
#[test]
fn lights_that_move_while_the_shutter_is_open_are_not_blurred_and_say_so() {
    let arrays = Arrays::triangle().with("SCALAR", &[0.0, 4.0]).with("VEC3", &[0.0, 0.0, 0.0, 8.0, 0.0, 0.0]);
    let rest = format!(
        r#"{TRIANGLE}, "extensions": {{"KHR_lights_punctual": {{"lights": [{{"type": "point"}}, {{"type": "directional"}}]}}}},
            "nodes": [{{"children": [1, 2, 3]}}, {{"extensions": {{"KHR_lights_punctual": {{"light": 0}}}}}},
                {{"extensions": {{"KHR_lights_punctual": {{"light": 1}}}}}}, {{"mesh": 0}}],
            "animations": [{{"channels": [{{"sampler": 0, "target": {{"node": 0, "path": "translation"}}}}],
                "samplers": [{{"input": 1, "output": 2}}]}}]"#
    );
    let model = arrays.load(&rest, &open_at(1.0)).expect("a model");
    let message = "lights have no motion blur: 1; their place at the start of the shutter is used";
    assert_eq!(model.messages(), [message]);
    let position = |model: &Model| match model.lights[0].kind {
        DeltaLightKind::Point { position, .. } => position,
        _ => panic!("a point light"),
    };
    assert_eq!(position(&model), DVec3::X * 2.0);
    assert_eq!(arrays.load(&rest, &open_at(4.0)).expect("a model").warnings, []);
}

/// Only the weights of meshes caused the warning.
#[test]
fn animated_weights_without_targets_are_a_warning() {
    let arrays = Arrays::triangle().with("SCALAR", &[0.0, 1.0]).with("SCALAR", &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    let rest = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}, {"POSITION": 0}]}]}],
        "nodes": [{"mesh": 0}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
            "samplers": [{"input": 1, "output": 2, "interpolation": "STEP"}]}]"#;
    let warnings = arrays.load(rest, &open_at(0.0)).expect("a model").warnings;
    let expected =
        "m.glb: animations[0].channels[0]: has [2] morph targets and 3 weights; what has no partner is left out";
    assert_eq!(warnings.iter().map(ToString::to_string).collect::<Vec<_>>(), [expected]);
}

/// Positions in the world were rounded to `f32`: at 1e7 to whole numbers.
#[test]
fn skinned_meshes_far_from_the_origin_of_the_world_keep_their_shape() {
    let arrays = Arrays::skinned();
    let primitive = r#"{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}}"#;
    for count in [1, 2] {
        let rest = format!(
            r#""meshes": [{{"primitives": [{}]}}], "skins": [{{"joints": [1]}}],
                "nodes": [{{"mesh": 0, "skin": 0}}, {{"translation": [1e7, -2e7, 0], "scale": [0.25, 0.25, 0.25]}}]"#,
            [primitive].repeat(count).join(",")
        );
        let model = arrays.model(&rest);
        let is_bound = |node: &&SceneNode| node.content.is_some() || !node.children.is_empty();
        let bound = model.nodes.iter().find(is_bound).expect("the skinned mesh");
        let parts = if count == 1 { std::slice::from_ref(bound) } else { &bound.children };
        assert_eq!(parts.len(), count);
        for part in parts {
            let Some(Content::Mesh(MeshId(mesh))) = part.content else { panic!("a mesh") };
            let positions = &model.mesh_data(mesh as usize).positions;
            for (position, offset) in positions.iter().zip([DVec3::ZERO, DVec3::X * 0.25, DVec3::Y * 0.25]) {
                let found = part.parent_from_local.point(position.as_dvec3());
                assert_eq!(found, DVec3::new(1e7, -2e7, 0.0) + offset);
            }
        }
    }
}
