//! Real and hostile glTF files. Without the folder of test data next to the repository these tests have nothing to do.

use std::path::Path;

use rt_scene_io::{Content, LoadOptions, SceneNode, load_model};
use rt_tests::{files_below, shared_or_skip};

/// Triangles in the scene, counting each instance.
fn instanced(nodes: &[SceneNode], sizes: &[usize]) -> usize {
    let own = |node: &SceneNode| match node.content {
        Some(Content::Mesh(id)) => sizes[id.0 as usize],
        _ => 0,
    };
    nodes.iter().map(|node| own(node) + instanced(&node.children, sizes)).sum()
}

#[test]
fn well_formed_files_have_all_of_their_triangles() {
    let Some(folder) = shared_or_skip("data") else { return };
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
    let Some(folder) = shared_or_skip("data") else { return };
    let files = files_below(&folder.join("gltf-unsupported/gltf-1.1"), &["gltf", "glb"]);
    assert!(!files.is_empty());
    for file in files {
        let message = load_model(&file, &LoadOptions::default()).expect_err("unsupported").to_string();
        println!("{message}");
        assert!(message.contains("glTF version 1.") && message.contains("not supported"), "{message}");
    }
}

#[test]
fn compressed_files_are_decoded() {
    let Some(folder) = shared_or_skip("data") else { return };
    let box_of = [-0.5, 0.5];
    for (name, count, [low, high]) in [
        ("BoxDraco.gltf", 12, box_of),
        ("Box_Draco.glb", 12, box_of),
        ("BoxMeshopt.glb", 12, box_of),
        ("BoxMeshopt.gltf", 12, box_of),
        ("DenseSphere.glb", 30720, [-0.93, 0.93]),
    ] {
        let file = folder.join("gltf-unsupported/compressed").join(name);
        let scene = rt_scene_io::load(&file, &LoadOptions::default()).expect(name);
        let triangles: usize = scene.meshes.iter().map(|mesh| mesh.mesh.data().triangles.len()).sum();
        assert_eq!(triangles, count, "{name}");
        let bounds = scene.bounds();
        let ends = [bounds.min.x, bounds.min.y, bounds.min.z, -bounds.max.x, -bounds.max.y, -bounds.max.z];
        assert!(ends.iter().all(|end| (end - low).abs() < 0.01) && high == -low, "{name}: {bounds:?}");
        assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
    }
}

/// Errors of the validator in spite of which files load, and why.
const HARMLESS: [(&str, &str); 20] = [
    ("BUFFER_DATA_URI_MIME_TYPE_INVALID", "the bytes are what they are, whatever their type is called"),
    ("BUFFER_MISSING_GLB_DATA", "nothing reads the buffer; who reads it is refused"),
    ("BUFFER_VIEW_TARGET_OVERRIDE", "targets are hints for graphics processors"),
    ("EMPTY_ENTITY", "an empty list holds as much as none"),
    ("GLB_CHUNK_LENGTH_UNALIGNED", "bytes are read wherever they are"),
    ("GLB_DUPLICATE_CHUNK", "what follows the second chunk is ignored"),
    ("GLB_UNEXPECTED_BIN_CHUNK", "what follows the second chunk is ignored"),
    ("INVALID_JSON", "a byte order mark before the text is skipped"),
    ("INVALID_URI", "the parameter that is empty has no meaning"),
    ("MESH_INVALID_WEIGHTS_COUNT", "a warning: weights without a target are left out"),
    ("MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT", "a warning: primitives with fewer targets stay at rest"),
    ("MESH_PRIMITIVE_ACCESSOR_UNALIGNED", "bytes are read wherever they are"),
    ("MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE", "elements are packed where no stride is given"),
    ("MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT", "attributes of applications are not read"),
    ("MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY", "each set is read by its own number"),
    ("MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE", "the stride is followed"),
    ("MESH_PRIMITIVE_INVALID_ATTRIBUTE", "attributes of unknown names are not read"),
    ("MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH", "a warning: sets without a partner are left out"),
    ("MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR", "there is nothing to add the differences to"),
    ("MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS", "bounds are computed"),
];

/// More of the same, for what only matters where it is used.
const UNUSED: [(&str, &str); 3] = [
    ("MESH_PRIMITIVE_TOO_FEW_TEXCOORDS", "a warning where the mesh is shown"),
    ("UNDEFINED_PROPERTY", "a buffer without a length is refused by who reads it"),
    ("VALUE_NOT_IN_RANGE", "an empty buffer is refused by who reads it"),
];

/// Files that the validator lets pass and that are refused, and why.
const STRICTER: [(&str, &str); 2] = [
    ("non_relative_uri.gltf", "files come from the folder of the model, never from a network"),
    ("primitive_no_position.gltf", "there is nothing to draw"),
];

/// Codes of the errors in the report next to a file; `None` without a report.
fn errors_of(file: &Path) -> Option<Vec<String>> {
    let report = std::fs::read(format!("{}.report.json", file.display())).ok()?;
    let report: serde_json::Value = serde_json::from_slice(&report).expect("a report");
    let messages = report["issues"]["messages"].as_array().cloned().unwrap_or_default();
    let errors = messages.iter().filter(|message| message["severity"] == 0);
    Some(errors.map(|message| message["code"].as_str().unwrap_or_default().to_owned()).collect())
}

#[test]
fn nasty_files_load_or_are_refused_in_words() {
    let Some(folder) = shared_or_skip("data") else { return };
    let files = files_below(&folder.join("gltf-nasty"), &["gltf", "glb"]);
    assert!(!files.is_empty());
    for file in files {
        let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let errors = errors_of(&file);
        match load_model(&file, &LoadOptions::default()) {
            Ok(model) => {
                println!("{name}: accepted, {} warnings; the validator: {errors:?}", model.warnings.len());
                for error in errors.unwrap_or_default() {
                    let known = HARMLESS.iter().chain(&UNUSED).any(|(code, _)| *code == error);
                    assert!(known, "{name} loads in spite of {error}");
                }
            }
            Err(error) => {
                let message = error.to_string();
                println!("{name}: refused; the validator: {errors:?}\n    {message}");
                assert!(message.lines().all(|line| line.starts_with(&file.display().to_string())), "{message}");
                if errors.is_some_and(|errors| errors.is_empty()) {
                    assert!(STRICTER.iter().any(|(known, _)| *known == name), "{name} is valid: {message}");
                }
            }
        }
    }
}
