//! The first page of each crate's documentation.

use crate::{error::TaskError, files, workspace::Workspace};

/// Minimum number of lines for the tasks of a library and an example.
const MIN_LINES_OF_LIBRARY: usize = 25;
const MIN_LINES_OF_PROGRAM: usize = 8;

pub(super) fn check(workspace: &Workspace) -> Result<Vec<String>, TaskError> {
    let mut breaches = Vec::new();
    for package in &workspace.packages {
        let Some(folder) = package.manifest_path.parent() else { continue };
        if !folder.starts_with(workspace.root.join("crates")) {
            continue;
        }
        let library = folder.join("src/lib.rs");
        let (page, is_library) = if library.exists() { (library, true) } else { (folder.join("src/main.rs"), false) };
        let source = files::read(&page)?;
        let missing = missing(&source, is_library);
        breaches.extend(missing.into_iter().map(|what| format!("{}: {what}", workspace.relative(&page))));
    }
    Ok(breaches)
}

/// Missing parts of the front page of a crate.
fn missing(source: &str, is_library: bool) -> Vec<&'static str> {
    let page: Vec<&str> = source.lines().take_while(|line| line.starts_with("//!")).collect();
    let says = |words: &str| page.iter().any(|line| line.contains(words));
    let mut missing = Vec::new();
    if page.len() < if is_library { MIN_LINES_OF_LIBRARY } else { MIN_LINES_OF_PROGRAM } {
        missing.push("the front page is too short");
    }
    if !says("**Owns**") || !says("**Does not own**") {
        missing.push("the front page does not say what the crate owns and does not own");
    }
    if is_library && !has_example(&page) {
        missing.push("the front page has no example that runs");
    }
    missing
}

/// True if a code block opens without a language, which rustdoc takes for Rust and runs.
fn has_example(page: &[&str]) -> bool {
    let fences = page.iter().filter_map(|line| line.strip_prefix("//! ```"));
    // Every other fence closes a block.
    fences.step_by(2).any(str::is_empty)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(example: &str) -> String {
        let text = "//! text\n".repeat(MIN_LINES_OF_LIBRARY);
        format!("//! # c\n{text}//! **Owns** a. **Does not own** b.\n//! ```text\n//! picture\n//! ```\n{example}\n")
    }

    #[test]
    fn missing_parts_of_pages_are_named() {
        let no_example = "the front page has no example that runs";
        assert_eq!(missing(&page("//! ```\n//! code();\n//! ```"), true), [""; 0]);
        assert_eq!((missing(&page(""), true), missing(&page(""), false)), (vec![no_example], vec![]));
        assert_eq!(missing("//! # c\n", true).len(), 3);
    }
}
