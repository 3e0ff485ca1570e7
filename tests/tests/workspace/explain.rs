//! Plans of all scene files: parts that they use and leave out, as text.

use std::path::{Path, PathBuf};

use rt_render::{PlanOptions, RenderPlan};
use rt_scene_io::LoadOptions;

fn scenes_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes")
}

fn scene_files() -> Vec<PathBuf> {
    let mut files = vec![];
    for chapter in ["report", "lecture", "gallery", "spd"] {
        let folder = std::fs::read_dir(scenes_folder().join(chapter)).expect("the chapter's folder");
        let paths = folder.map(|entry| entry.expect("an entry").path());
        let is_scene = |path: &PathBuf| {
            path.extension().is_some_and(|extension| ["ron", "nff", "pbrt"].iter().any(|known| extension == *known))
        };
        files.extend(paths.filter(is_scene));
    }
    files.sort();
    files
}

#[test]
fn the_plan_of_every_scene() {
    let files = scene_files();
    assert!(files.len() >= 10, "only {} scene files", files.len());
    for file in files {
        let scene = rt_scene_io::load(&file, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let plan = RenderPlan::compile(&scene, &PlanOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let name = file.strip_prefix(scenes_folder()).expect("below the folder").with_extension("");
        let name = name.to_string_lossy().replace(['/', '\\'], "-");
        // Predicted memory follows the layout of types, which is not the plan's business.
        let explanation = plan.explain().to_string();
        let (explanation, _) = explanation.split_once("\npredicted memory").expect("the last section");
        insta::with_settings!({ prepend_module_to_snapshot => false, omit_expression => true }, {
            insta::assert_snapshot!(name, explanation);
        });
    }
}
