//! The length of source files: one idea per file.

use std::fs;

use super::report::Report;
use crate::{error::TaskError, workspace::Workspace};

const LONG: usize = 400;
const TOO_LONG: usize = 700;

pub(super) fn check(workspace: &Workspace) -> Result<Report, TaskError> {
    let mut report = Report::default();
    for path in workspace.files("", ".rs")? {
        let source = fs::read_to_string(&path).map_err(TaskError::file(&path))?;
        let lines = source.lines().count();
        let line = format!("{}: {lines} lines", workspace.relative(&path));
        if lines > TOO_LONG {
            report.breaches.push(format!("{line}, the limit is {TOO_LONG}"));
        } else if lines > LONG {
            report.warnings.push(line);
        }
    }
    Ok(report)
}
