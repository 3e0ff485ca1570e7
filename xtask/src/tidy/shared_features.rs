//! Features of crates that more than one build needs: they must agree, or cargo compiles these crates once more for each.

use std::collections::{BTreeMap, BTreeSet};

use crate::{
    error::TaskError,
    workspace::{Workspace, cargo, output_of},
};

/// Sets of features in which each version of a crate is built: one for programs and one for build scripts, if they differ.
type Builds<'t> = BTreeMap<&'t str, BTreeSet<&'t str>>;

pub(super) fn check(workspace: &Workspace) -> Result<Vec<String>, TaskError> {
    let tree = |arguments: &[&str]| {
        let mut command = cargo();
        command.args(["tree", "--locked", "--prefix", "none", "--format", "{p}|{f}"]).args(arguments);
        output_of(command.current_dir(&workspace.root))
    };
    // Packages of `cargo xtask`, and of `cargo test --workspace`.
    let task = tree(&["--package", "xtask", "--edges", "normal,build"])?;
    let tests = tree(&["--workspace", "--edges", "normal,build,dev"])?;
    Ok(disagreements(&builds(&task), &builds(&tests)))
}

fn builds(tree: &str) -> Builds<'_> {
    let mut builds = Builds::new();
    for line in tree.lines() {
        if let Some((package, features)) = line.trim_end_matches(" (*)").split_once('|') {
            builds.entry(package).or_default().insert(features);
        }
    }
    builds
}

/// A line for each crate that the task has with other features than the tests.
fn disagreements(task: &Builds<'_>, tests: &Builds<'_>) -> Vec<String> {
    let mut lines = Vec::new();
    for (package, features) in task {
        let known = tests.get(package).cloned().unwrap_or_default();
        for features in features.difference(&known) {
            let others: Vec<_> = known.iter().copied().collect();
            lines.push(format!(
                "{package} is compiled twice: list features in xtask/Cargo.toml that make [{features}] one of [{}]",
                others.join("] [")
            ));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regression: `cargo xtask regress` compiled all of rt-cli again after `cargo test`, for an unused feature of one
    /// crate.
    #[test]
    fn a_crate_with_other_features_is_a_breach() {
        let tests =
            builds("either v1.19.0|std,use_std\nlibc v0.2.191|std\nmemchr v2.8.3|std\nmemchr v2.8.3|alloc,std (*)\n");
        assert_eq!(disagreements(&builds("libc v0.2.191|std\nmemchr v2.8.3|alloc,std (*)\n"), &tests), [""; 0]);
        let lines = disagreements(&builds("either v1.19.0|\nlibc v0.2.191|std\n"), &tests);
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(
            lines[0].starts_with("either v1.19.0 is compiled twice") && lines[0].ends_with("[] one of [std,use_std]")
        );
    }
}
