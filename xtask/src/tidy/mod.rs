//! `tidy`: the rules of the house that no compiler checks.
//!
//! Each file holds the rules about one thing; a rule returns one line per breach.

use crate::{error::TaskError, workspace::Workspace};

mod crate_graph;
mod front_pages;
mod generated_pages;
mod shared_features;
mod source_files;
mod tracked_text;
mod unsafe_code;
mod whole;

/// Rules by name.
type Rule = fn(&Workspace) -> Result<Report, TaskError>;

const RULES: [(&str, Rule); 8] = [
    ("crate graph", crate_graph::check),
    ("front pages", front_pages::check),
    ("generated pages", generated_pages::check),
    ("shared features", shared_features::check),
    ("source files", source_files::check),
    ("unsafe code", unsafe_code::check),
    ("text", tracked_text::check),
    ("completeness", whole::check),
];

/// What a rule found.
#[derive(Debug, Default)]
struct Report {
    breaches: Vec<String>,
    warnings: Vec<String>,
}

/// Checks every rule and prints the breaches. True if there are none.
pub(crate) fn run(workspace: &Workspace) -> Result<bool, TaskError> {
    let mut breaches = 0;
    for (name, rule) in RULES {
        let report = rule(workspace)?;
        for line in &report.breaches {
            println!("error: {name}: {line}");
        }
        for line in &report.warnings {
            println!("warning: {name}: {line}");
        }
        breaches += report.breaches.len();
    }
    println!("tidy: {breaches} breaches");
    Ok(breaches == 0)
}
