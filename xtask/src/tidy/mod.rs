//! `tidy`: rules of the project that no compiler checks.
//!
//! Each file holds the rules about one thing; a rule returns one line per breach.

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

/// Rules by name; each returns its breaches.
type Rule = fn(&Workspace) -> Result<Vec<String>, TaskError>;

const RULES: [(&str, Rule); 8] = [
    ("style", style::check),
    ("crate graph", crate_graph::check),
    ("front pages", front_pages::check),
    ("shared features", shared_features::check),
    ("source files", source_files::check),
    ("unsafe code", unsafe_code::check),
    ("text", tracked_text::check),
    ("stray files", no_stray_files::check),
];

/// Checks every rule and prints the breaches. True if there are none.
pub(crate) fn run(workspace: &Workspace) -> Result<bool, TaskError> {
    let mut count = 0;
    for (name, rule) in RULES {
        let breaches = rule(workspace)?;
        for line in &breaches {
            println!("error: {name}: {line}");
        }
        count += breaches.len();
    }
    println!("tidy: {count} breaches");
    Ok(count == 0)
}
