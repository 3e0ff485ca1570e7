//! Text that ties the project to one machine: absolute paths, and other places to fetch crates from.

use std::fs;

use super::report::Report;
use crate::{error::TaskError, workspace::Workspace};

/// Folders that start an absolute path on somebody's machine.
const MACHINE_FOLDERS: [&str; 6] = ["work", "home", "tmp", "root", "mnt", "Users"];

/// Settings that replace the public registry.
const REGISTRIES: [&str; 4] = ["sparse+http", "[source.", "[registries", "replace-with"];

pub(super) fn check(workspace: &Workspace) -> Result<Report, TaskError> {
    let mut report = Report::default();
    for path in workspace.files("", "")? {
        let bytes = fs::read(&path).map_err(TaskError::file(&path))?;
        let Ok(text) = String::from_utf8(bytes) else { continue };
        // This file has to spell out what it looks for.
        if path.ends_with("tidy/tracked_text.rs") {
            continue;
        }
        for (number, line) in text.lines().enumerate() {
            if let Some(what) = tied(line) {
                report.breaches.push(format!("{}:{}: {what}", workspace.relative(&path), number + 1));
            }
        }
    }
    Ok(report)
}

/// What ties a line to one machine, if anything.
fn tied(line: &str) -> Option<&'static str> {
    if MACHINE_FOLDERS.iter().any(|folder| names_folder(line, folder)) {
        Some("an absolute path")
    } else if REGISTRIES.iter().any(|setting| line.contains(setting)) {
        Some("a registry of its own")
    } else {
        None
    }
}

/// True if the line has `/folder/` where a path begins.
fn names_folder(line: &str, folder: &str) -> bool {
    let path = format!("/{folder}/");
    line.match_indices(&path).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        !before.is_some_and(|c| c.is_alphanumeric() || "._-/~*$}".contains(c))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absolute_paths_are_found_where_a_path_begins() {
        assert!(tied("see /home/anna/scene.ron").is_some());
        assert!(tied("path = \"/tmp/a\"").is_some());
        assert!(tied("https://example.org/home/page").is_none());
        assert!(tied("../work/scene.ron and target/tmp/a").is_none());
    }

    #[test]
    fn registries_are_found() {
        assert!(tied("replace-with = \"mirror\"").is_some());
        assert!(tied("source = \"registry+https://github.com/rust-lang/crates.io-index\"").is_none());
    }
}
