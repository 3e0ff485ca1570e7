//! `tidy`: rules of the project that no compiler checks.
//!
//! Each file holds the rules about one thing; a rule returns one line per breach.

use self::report::Report;
use crate::{error::TaskError, workspace::Workspace};

mod allowance;
mod banned_words;
mod crate_graph;
mod front_pages;
mod generated_pages;
mod import_graph;
mod names;
mod no_stray_files;
mod prose;
mod report;
mod rust_tokens;
mod shared_features;
mod source_files;
mod style;
mod tracked_text;
mod unsafe_code;

/// Options of `tidy`.
#[derive(Debug, clap::Args)]
pub(crate) struct TidyOptions {
    /// List the allowed breaches in these crates; `docs` selects the Markdown pages.
    packages: Vec<String>,
    /// Lower the counts in xtask/tidy-allowance.toml to those found.
    #[arg(long)]
    lower: bool,
}

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
    ("stray files", no_stray_files::check),
];

/// Checks every rule and prints the breaches. True if there are none.
pub(crate) fn run(workspace: &Workspace, options: &TidyOptions) -> Result<bool, TaskError> {
    let counted = style::breaches(workspace)?;
    for package in &options.packages {
        for (rule, lines) in counted.get(package).into_iter().flatten() {
            for line in lines {
                println!("{rule}: {line}");
            }
        }
    }
    let mut reports = vec![("style", allowance::check(workspace, &counted, options.lower)?)];
    for (name, rule) in RULES {
        reports.push((name, rule(workspace)?));
    }
    let mut breaches = 0;
    for (name, report) in reports {
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
