//! Plans of all scene files: parts that they use and leave out, as text.

use std::path::{Path, PathBuf};

use rt_render::{PlanOptions, RenderPlan};
use rt_scene_io::LoadOptions;
use rt_tests::files_below;

fn scenes_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes")
}

#[test]
fn the_plan_of_every_scene() {
    let files = files_below(&scenes_folder(), &["ron", "nff", "pbrt"]);
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
