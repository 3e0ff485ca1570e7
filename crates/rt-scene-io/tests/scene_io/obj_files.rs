//! Real and hostile OBJ files. Without the folder of test data next to the repository these tests have nothing to do.

use rt_scene_io::{LoadOptions, load_model};
use rt_tests::{files_below, shared_or_skip};

#[test]
fn well_formed_files_have_all_of_their_triangles() {
    let Some(folder) = shared_or_skip("data") else { return };
    let expected = [
        ("cornell-box-measured/cornell_box.obj", 36),
        ("cornell-box-measured/cornell_box_multimaterial.obj", 36),
        ("cornell-mcguire/cornell_box.obj", 36),
        ("cornell-suzanne/cornellbox_suzanne.obj", 980),
        ("spot/spot_triangulated.obj", 5856),
        ("spot/spot_quadrangulated.obj", 5856),
        ("spot/spot_control_mesh.obj", 372),
        ("stanford-bunny/stanford-bunny.obj", 69451),
        ("suzanne-uv/suzanne_uv.obj", 968),
        ("utah-teapot/teapot.obj", 6320),
    ];
    for (name, triangles) in expected {
        let model = load_model(&folder.join("obj").join(name), &LoadOptions::default()).expect(name);
        let loaded: usize = model.meshes.iter().map(|m| m.mesh.data().triangles.len()).sum();
        assert_eq!(loaded, triangles, "{name}");
        // The control mesh is a cage for subdivision; its pentagons are bent.
        let bent = usize::from(name.ends_with("control_mesh.obj"));
        assert_eq!(model.warnings.len(), bent, "{name}: {:?}", model.warnings);
    }
}

/// Each face with n corners becomes n − 2 triangles, of which those that are left out are counted in a warning. Faces are
/// counted here by the rules of the format alone.
#[test]
fn no_face_is_lost_in_silence() {
    let Some(folder) = shared_or_skip("data") else { return };
    let files = files_below(&folder, &["obj"]);
    assert!(!files.is_empty());
    for file in files {
        let Ok(model) = load_model(&file, &LoadOptions::default()) else { continue };
        let text = String::from_utf8_lossy(&std::fs::read(&file).expect("a file")).replace("\r\n", "\n");
        let text = text.replace("\\\n", " ");
        let corners = |line: &str| {
            let mut words = line.trim_start_matches('\u{feff}').split_whitespace();
            let is_face = matches!(words.next(), Some("f" | "fo"));
            is_face.then(|| words.take_while(|word| !word.starts_with('#')).count())
        };
        let there: usize = text.lines().filter_map(corners).map(|n| n.saturating_sub(2)).sum();
        let shown: usize = model.meshes.iter().map(|m| m.mesh.data().triangles.len()).sum();
        let dropped = model.warnings.iter().filter(|w| w.message.contains("were dropped"));
        let count = |message: &str| message.rsplit(": ").next()?.split(' ').next()?.parse::<usize>().ok();
        let dropped: usize = dropped.filter_map(|warning| count(&warning.message)).sum();
        assert_eq!(shown + dropped, there, "{}: {:?}", file.display(), model.warnings);
    }
}

#[test]
fn nasty_files_load_or_are_refused_in_words() {
    let Some(folder) = shared_or_skip("data") else { return };
    let files = files_below(&folder.join("obj-nasty"), &["obj"]);
    assert!(!files.is_empty());
    for file in files {
        match load_model(&file, &LoadOptions::default()) {
            Ok(model) => {
                println!("{}: ok, {} warnings", file.display(), model.warnings.len());
                assert!(!model.nodes.is_empty(), "{}", file.display());
            }
            Err(error) => {
                let message = error.to_string();
                println!("{message}");
                assert!(message.starts_with(&file.display().to_string()), "{message}");
            }
        }
    }
}
