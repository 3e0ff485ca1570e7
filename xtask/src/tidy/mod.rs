//! `tidy`: rules of the project that no compiler checks.
//!
//! Each file holds the rules about one thing; a rule returns one line per breach.

use std::fs;

use crate::{error::TaskError, workspace::Workspace};

mod banned_words;
mod crate_graph;
mod front_pages;
mod import_graph;
mod names;
mod no_stray_files;
mod prose;
mod rust_tokens;
mod shared_features;
mod source_files;
mod style;
mod tracked_text;
mod unsafe_code;

/// Rules about the whole project by name; each returns its breaches.
type Rule = fn(&Workspace) -> Result<Vec<String>, TaskError>;

const RULES: [(&str, Rule); 5] = [
    ("style", style::check),
    ("crate graph", crate_graph::check),
    ("front pages", front_pages::check),
    ("shared features", shared_features::check),
    ("stray files", no_stray_files::check),
];

/// Rules about a text file, of which they get the path from the root and the text.
type FileRule = fn(&str, &str) -> Vec<String>;

const FILE_RULES: [(&str, FileRule); 3] = [
    ("source files", source_files::breaches),
    ("unsafe code", unsafe_code::breaches),
    ("text", tracked_text::breaches),
];

/// Checks every rule and prints the breaches. True if there are none.
pub(crate) fn run(workspace: &Workspace) -> Result<bool, TaskError> {
    let mut breaches = Vec::new();
    for (name, rule) in RULES {
        breaches.extend(rule(workspace)?.into_iter().map(|breach| (name, breach)));
    }
    for path in workspace.files("", "")? {
        let bytes = fs::read(&path).map_err(TaskError::file(&path))?;
        let (Ok(text), path) = (String::from_utf8(bytes), workspace.relative(&path).to_string()) else { continue };
        for (name, rule) in FILE_RULES {
            breaches.extend(rule(&path, &text).into_iter().map(|breach| (name, breach)));
        }
    }
    for (name, breach) in &breaches {
        println!("error: {name}: {breach}");
    }
    println!("tidy: {} breaches", breaches.len());
    Ok(breaches.is_empty())
}
