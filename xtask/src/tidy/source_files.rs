//! The length of source files: one idea per file.

use crate::{error::TaskError, files, workspace::Workspace};

const LONG: usize = 400;
const TOO_LONG: usize = 700;

pub(super) fn check(workspace: &Workspace) -> Result<Vec<String>, TaskError> {
    let mut breaches = Vec::new();
    for path in workspace.files("", ".rs")? {
        let source = files::read(&path)?;
        let lines = source.lines().count();
        let line = format!("{}: {lines} lines", workspace.relative(&path));
        if lines > TOO_LONG {
            breaches.push(format!("{line}, the limit is {TOO_LONG}"));
        } else if lines > LONG {
            println!("warning: source files: {line}");
        }
    }
    Ok(breaches)
}
