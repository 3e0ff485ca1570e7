//! Text that ties the project to one machine: absolute paths, and other places to fetch crates from.

/// Folders at the start of absolute paths.
const MACHINE_FOLDERS: [&str; 6] = ["work", "home", "tmp", "root", "mnt", "Users"];

/// Settings that replace the public registry.
const REGISTRIES: [&str; 4] = ["sparse+http", "[source.", "[registries", "replace-with"];

pub(super) fn breaches(path: &str, text: &str) -> Vec<String> {
    // This file contains the words that it searches for.
    if path.ends_with("tidy/tracked_text.rs") {
        return Vec::new();
    }
    let lines = text.lines().enumerate();
    lines.filter_map(|(number, line)| Some(format!("{path}:{}: {}", number + 1, tied(line)?))).collect()
}

/// Part of a line that is specific to one machine.
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
