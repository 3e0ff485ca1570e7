//! Things that must be there.

use crate::{error::TaskError, files, workspace::Workspace};

const FILES: [&str; 6] =
    ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"];

/// Golden images are small, so that hundreds of them render in seconds.
const LARGEST_GOLDEN: (u32, u32) = (160, 120);

pub(super) fn check(workspace: &Workspace) -> Result<Vec<String>, TaskError> {
    let absent = FILES.iter().filter(|file| !workspace.root.join(file).exists());
    let mut breaches: Vec<String> = absent.map(|file| format!("there is no {file}")).collect();
    for scene in workspace.files("scenes", ".ron")? {
        let text = files::read(&scene)?;
        if !text.starts_with("//") {
            breaches.push(format!("{}: no comment says what it shows", workspace.relative(&scene)));
        }
    }
    for case in workspace.files("tests/golden", "case.toml")? {
        let expected = case.with_file_name("expected.png");
        match image::image_dimensions(&expected) {
            Err(error) => breaches.push(format!("{}: {error}", workspace.relative(&expected))),
            Ok((width, height)) if width > LARGEST_GOLDEN.0 || height > LARGEST_GOLDEN.1 => {
                breaches.push(format!("{}: {width}×{height} is too large", workspace.relative(&expected)));
            }
            Ok(_) => {}
        }
    }
    Ok(breaches)
}
