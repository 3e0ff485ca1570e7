//! Diagnostics of `check` for the scene files of the project.

use std::path::Path;

use rt_check::{Kind, Severity, check};
use rt_scene_io::LoadOptions;
use rt_tests::files_below;

/// Regression: the links of the chain in `transformations.ron` had their fronts in one plane, turned against each
/// other. Rounding chose one of two colours for each sample.
#[test]
fn no_scene_leaves_it_to_rounding_which_of_two_surfaces_is_seen() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let files = files_below(&scenes, &["ron", "nff", "pbrt"]);
    assert!(files.len() >= 10, "only {} scene files", files.len());
    for file in files {
        let scene = rt_scene_io::load(&file, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let report = check(&scene);
        let visible = |kind: Kind, severity| kind == Kind::CoincidentSurfaces && severity >= Severity::Warning;
        let found: Vec<_> = report.findings.iter().filter(|f| visible(f.kind, f.severity)).collect();
        assert!(found.is_empty(), "{}: {found:?}", file.display());
        assert!(!report.more.iter().any(|more| visible(more.kind, more.severity)), "{}", file.display());
    }
}
