//! Things that must be there.

use std::fs;

use super::report::Report;
use crate::{error::TaskError, workspace::Workspace};

const FILES: [&str; 6] =
    ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"];

/// Golden images are small, so that hundreds of them render in seconds.
const LARGEST_GOLDEN: (u32, u32) = (160, 120);

pub(super) fn check(workspace: &Workspace) -> Result<Report, TaskError> {
    let mut report = Report::default();
    let absent = FILES.iter().filter(|file| !workspace.root.join(file).exists());
    report.breaches.extend(absent.map(|file| format!("there is no {file}")));
    for scene in workspace.files("scenes", ".ron")? {
        let text = fs::read_to_string(&scene).map_err(TaskError::file(&scene))?;
        if !text.starts_with("//") {
            report.breaches.push(format!("{}: no comment says what it shows", workspace.relative(&scene)));
        }
    }
    for case in workspace.files("tests/golden", "case.toml")? {
        let expected = case.with_file_name("expected.png");
        match image::image_dimensions(&expected) {
            Err(error) => report.breaches.push(format!("{}: {error}", workspace.relative(&expected))),
            Ok((width, height)) if width > LARGEST_GOLDEN.0 || height > LARGEST_GOLDEN.1 => {
                report.breaches.push(format!("{}: {width}×{height} is too large", workspace.relative(&expected)));
            }
            Ok(_) => {}
        }
    }
    Ok(report)
}
