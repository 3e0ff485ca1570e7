//! Generated pages: they must be up to date.

use rt_scene_io::format::{json_schema, reference_page};

use super::report::Report;
use crate::{error::TaskError, files, workspace::Workspace};

/// A file, the command that writes it, and the function that does.
type Page = (&'static str, &'static str, fn() -> String);

const PAGES: [Page; 2] = [
    ("scenes/scene.schema.json", "rt-cli schema", || json_schema().to_owned()),
    ("docs/SCENE-FORMAT.md", "rt-cli schema --markdown", reference_page),
];

pub(super) fn check(workspace: &Workspace) -> Result<Report, TaskError> {
    let mut report = Report::default();
    for (name, command, make) in PAGES {
        let path = workspace.root.join(name);
        let text = files::read_if_present(&path)?;
        report.breaches.extend(breach(name, command, &text, &make()));
    }
    Ok(report)
}

/// First difference of a page from its source.
fn breach(name: &str, command: &str, text: &str, expected: &str) -> Option<String> {
    // Line ends depend on how the files were checked out.
    let differing = text.lines().zip(expected.lines()).position(|(text, expected)| text != expected);
    let shorter = text.lines().count().min(expected.lines().count());
    if differing.is_none() && text.lines().count() == expected.lines().count() {
        return None;
    }
    let line = 1 + differing.unwrap_or(shorter);
    Some(format!("{name}:{line} is not what the source says: write it with `{command} > {name}`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_is_out_of_date_is_a_breach() {
        assert_eq!(breach("a", "b", "1\n2\n", "1\n2\n"), None);
        assert_eq!(breach("a", "b", "1\r\n2\r\n", "1\n2\n"), None);
        for (text, line) in [("1\n3\n", 2), ("1\n", 2), ("1\n2\n3\n", 3), ("", 1)] {
            let said = breach("a", "b", text, "1\n2\n").expect("a breach");
            assert!(said.starts_with(&format!("a:{line} ")), "{said}");
        }
    }
}
