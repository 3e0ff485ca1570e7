//! Real and hostile glTF files. Without the folder of test data beside the repository these tests have nothing to do.

#![cfg(feature = "gltf")]

mod data;

use data::{data, files, is_small, mutate, truncate};
use rt_scene_io::{Content, LoadOptions, Node, load_model};

/// Triangles in the scene, counting each instance.
fn instanced(nodes: &[Node], sizes: &[usize]) -> usize {
    let own = |node: &Node| match node.content {
        Some(Content::Mesh(id)) => sizes[id.0 as usize],
        _ => 0,
    };
    nodes.iter().map(|node| own(node) + instanced(&node.children, sizes)).sum()
}

#[test]
fn well_formed_files_have_all_of_their_triangles() {
    let Some(folder) = data() else { return };
    let expected = [
        ("AlphaBlendModeTest/AlphaBlendModeTest.glb", 61, 61),
        ("Box/separate/Box.gltf", 12, 12),
        ("Box/embedded/Box.gltf", 12, 12),
        ("Box/binary/Box.glb", 12, 12),
        ("BoxInterleaved/BoxInterleaved.glb", 12, 12),
        ("BoxSparse/box_sparse.gltf", 12, 12),
        ("BoxSparse/box_sparse.glb", 12, 12),
        ("BoxTextured/separate/BoxTextured.gltf", 12, 12),
        ("BoxTextured/specgloss/BoxTextured.gltf", 12, 12),
        ("BoxTextured/binary/BoxTextured.glb", 12, 12),
        ("BoxVertexColors/BoxVertexColors.glb", 12, 12),
        ("Cameras/Cameras.gltf", 2, 2),
        ("CesiumMilkTruck/CesiumMilkTruck.glb", 2856, 3624),
        ("Duck/separate/Duck.gltf", 4212, 4212),
        ("Duck/binary/Duck.glb", 4212, 4212),
        ("Fox/Fox.gltf", 576, 576),
        ("GeometryCameraLight/geometry-camera-light.glb", 14, 14),
        ("GeometryCameraLight/Lights.glb", 12, 12),
        ("InterpolationTest/InterpolationTest.gltf", 110, 110),
        ("MultiUVTest/MultiUVTest.gltf", 12, 12),
        ("NormalTangentTest/NormalTangentTest.glb", 7774, 7774),
        ("ShapeCollection/ShapeCollection.glb", 2390, 3542),
        ("ShapeCollection/many-cubes.gltf", 6012, 6012),
        ("SimpleSparseAccessor/SimpleSparseAccessor.gltf", 12, 12),
        ("SpecGlossVsMetalRough/SpecGlossVsMetalRough.gltf", 9028, 9028),
        ("SphereLights/sphere_lights.gltf", 224, 224),
        ("Suzanne/02_suzanne.gltf", 3936, 3936),
        ("TextureSettingsTest/TextureSettingsTest.gltf", 72, 72),
        ("TextureTransformTest/TextureTransformTest.gltf", 18, 24),
        ("Triangle/Triangle.gltf", 1, 1),
        ("TriangleWithoutIndices/triangle-without-indices.gltf", 1, 1),
        ("TwoSidedPlane/TwoSidedPlane.gltf", 2, 2),
        ("UnlitTest/UnlitTest.gltf", 88, 88),
        ("VertexColorTest/VertexColorTest.gltf", 36, 36),
    ];
    for (name, stored, placed) in expected {
        let model = load_model(&folder.join("gltf").join(name), &LoadOptions::default()).expect(name);
        let sizes: Vec<usize> = model.meshes.iter().map(|m| m.mesh.data().triangles.len()).collect();
        println!("{name}: {} cameras, {} lights", model.cameras.len(), model.lights.len());
        for warning in &model.warnings {
            println!("  {}: {}", warning.place, warning.message);
        }
        assert_eq!((sizes.iter().sum::<usize>(), instanced(&model.nodes, &sizes)), (stored, placed), "{name}");
    }
}

#[test]
fn unsupported_files_are_refused_by_name() {
    let Some(folder) = data() else { return };
    for file in files(&folder.join("gltf-unsupported"), &["gltf", "glb"]) {
        let message = load_model(&file, &LoadOptions::default()).expect_err("unsupported").to_string();
        println!("{message}");
        let named = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "glTF version 1."];
        assert!(named.iter().any(|name| message.contains(name)), "{message}");
        assert!(message.contains("not supported"), "{message}");
    }
}

#[test]
fn nasty_files_load_or_are_refused_in_words() {
    let Some(folder) = data() else { return };
    for file in files(&folder.join("gltf-nasty"), &["gltf", "glb"]) {
        match load_model(&file, &LoadOptions::default()) {
            Ok(model) => println!("{}: ok, {} warnings", file.display(), model.warnings.len()),
            Err(error) => {
                let message = error.to_string();
                println!("{message}");
                assert!(message.lines().all(|line| line.starts_with(&file.display().to_string())), "{message}");
            }
        }
    }
}

#[test]
fn damaged_files_never_panic() {
    let Some(folder) = data() else { return };
    for file in files(&folder.join("gltf"), &["gltf", "glb"]).iter().filter(|file| is_small(file)) {
        truncate(file);
        mutate(file, 60);
    }
    for file in files(&folder.join("gltf-nasty"), &["gltf", "glb"]) {
        mutate(&file, 5);
    }
}
