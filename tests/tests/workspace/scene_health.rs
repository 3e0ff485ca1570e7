//! Diagnostics of `check` for the scene files of the project.

use std::path::Path;

use rt_check::{Kind, Severity, check};
use rt_scene_io::LoadOptions;

/// Regression: the links of the chain in `transformations.ron` had their fronts in one plane, turned against each
/// other. Rounding chose one of two colours for each sample.
#[test]
fn no_scene_leaves_it_to_rounding_which_of_two_surfaces_is_seen() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let mut checked = 0;
    for chapter in ["report", "lecture", "gallery", "spd"] {
        for entry in std::fs::read_dir(scenes.join(chapter)).expect("the chapter's folder") {
            let file = entry.expect("an entry").path();
            if file.extension().is_none_or(|extension| extension != "ron" && extension != "nff" && extension != "pbrt")
            {
                continue;
            }
            let scene = rt_scene_io::load(&file, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
            let report = check(&scene);
            let visible = |kind: Kind, severity| kind == Kind::CoincidentSurfaces && severity >= Severity::Warning;
            let found: Vec<_> = report.findings.iter().filter(|f| visible(f.kind, f.severity)).collect();
            assert!(found.is_empty(), "{}: {found:?}", file.display());
            assert!(!report.more.iter().any(|more| visible(more.kind, more.severity)), "{}", file.display());
            checked += 1;
        }
    }
    assert!(checked >= 10, "only {checked} scene files");
}
