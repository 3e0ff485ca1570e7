//! Dependencies between the crates.
//!
//! Siblings are independent: shading does not depend on accelerators, nor cameras on light.

use std::collections::{BTreeMap, BTreeSet};

use crate::{
    error::TaskError,
    workspace::{Package, Workspace, cargo, output_of},
};

/// Normal dependencies within the workspace.
const GRAPH: [(&str, &[&str]); 10] = [
    ("rt-math", &[]),
    ("rt-geometry", &["rt-math"]),
    ("rt-accel", &["rt-geometry", "rt-math"]),
    ("rt-image", &["rt-math"]),
    ("rt-camera", &["rt-image", "rt-math"]),
    ("rt-shading", &["rt-geometry", "rt-math"]),
    ("rt-scene-io", &["rt-camera", "rt-geometry", "rt-image", "rt-math", "rt-shading"]),
    ("rt-render", &["rt-accel", "rt-camera", "rt-geometry", "rt-image", "rt-math", "rt-scene-io", "rt-shading"]),
    ("rt-check", &["rt-accel", "rt-camera", "rt-geometry", "rt-math", "rt-render", "rt-scene-io", "rt-shading"]),
    ("rt-cli", &["rt-camera", "rt-check", "rt-image", "rt-math", "rt-render", "rt-scene-io"]),
];

/// Crates that may use any other: no crate depends on them.
const ABOVE_ALL: [&str; 2] = ["xtask", "rt-tests"];

/// All packages of `rt-accel` without its default features.
const ACCEL_TREE: [&str; 14] = [
    "earcut",
    "glam",
    "libm",
    "num-traits",
    "proc-macro2",
    "quote",
    "robust",
    "rt-accel",
    "rt-geometry",
    "rt-math",
    "syn",
    "thiserror",
    "thiserror-impl",
    "unicode-ident",
];

pub(super) fn check(workspace: &Workspace) -> Result<Vec<String>, TaskError> {
    let mut breaches = edges(&workspace.packages);
    let mut command = cargo();
    command.args(["tree", "-p", "rt-accel", "-e", "normal", "--no-default-features", "--prefix", "none"]);
    let tree = output_of(command.current_dir(&workspace.root))?;
    let strangers = strangers(&tree);
    if !strangers.is_empty() {
        breaches.push(format!("rt-accel without default features brings {}", strangers.join(", ")));
    }
    Ok(breaches)
}

fn edges(packages: &[Package]) -> Vec<String> {
    let allowed: BTreeMap<&str, BTreeSet<&str>> =
        GRAPH.iter().map(|(name, below)| (*name, below.iter().copied().collect())).collect();
    let mut breaches = Vec::new();
    for package in packages.iter().filter(|package| !ABOVE_ALL.contains(&package.name.as_str())) {
        let Some(allowed) = allowed.get(package.name.as_str()) else {
            breaches.push(format!("{} has no place in the graph", package.name));
            continue;
        };
        let ours = package.dependencies.iter().filter(|dependency| dependency.path.is_some());
        let real: BTreeSet<&str> =
            ours.filter(|dependency| dependency.kind.is_none()).map(|dependency| dependency.name.as_str()).collect();
        for stranger in real.difference(allowed) {
            breaches.push(format!("{} must not depend on {stranger}", package.name));
        }
        for unused in allowed.difference(&real) {
            breaches.push(format!("{} no longer depends on {unused}: correct the graph", package.name));
        }
    }
    breaches
}

/// Packages in the output of `cargo tree` that are not allowed.
fn strangers(tree: &str) -> Vec<&str> {
    let names: BTreeSet<&str> = tree.lines().filter_map(|line| line.split_whitespace().next()).collect();
    names.into_iter().filter(|name| !ACCEL_TREE.contains(name)).collect()
}

#[cfg(test)]
mod tests {
    use crate::workspace::Dependency;

    use super::*;

    fn package(name: &str, below: &[(&str, Option<&str>)]) -> Package {
        let dependency = |(name, kind): &(&str, Option<&str>)| Dependency {
            name: (*name).to_owned(),
            kind: kind.map(str::to_owned),
            path: Some("here".into()),
        };
        Package {
            name: name.to_owned(),
            manifest_path: "Cargo.toml".into(),
            dependencies: below.iter().map(dependency).collect(),
        }
    }

    #[test]
    fn edges_between_siblings_missing_edges_and_unknown_crates_are_breaches() {
        let sibling = package("rt-shading", &[("rt-math", None), ("rt-geometry", None), ("rt-accel", None)]);
        let of_tests = package("rt-geometry", &[("rt-math", None), ("rt-accel", Some("dev"))]);
        assert_eq!(
            edges(&[sibling, of_tests, package("rt-camera", &[]), package("rt-more", &[])]),
            [
                "rt-shading must not depend on rt-accel",
                "rt-camera no longer depends on rt-image: correct the graph",
                "rt-camera no longer depends on rt-math: correct the graph",
                "rt-more has no place in the graph"
            ]
        );
    }

    #[test]
    fn a_crate_too_many_in_the_tree_is_named() {
        assert_eq!(strangers("rt-accel v0.1.0 (here)\nglam v0.34.0\nrayon v1.0.0\nglam v0.34.0 (*)\n"), ["rayon"]);
    }
}
