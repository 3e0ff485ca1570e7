//! One picture: neither thread count, nor structure, nor what the plan leaves out changes a bit of the image.

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::{Context, Findings, Unit};
use crate::error::TaskError;

/// What must not matter. The first is what the others are compared with.
const VARIANTS: [&[&str]; 8] = [
    &["--threads", "1"],
    &["--threads", "2"],
    &["--threads", "3"],
    &["--threads", "8"],
    &["--threads", "2", "--accel", "linear"],
    &["--threads", "2", "--accel", "grid"],
    &["--threads", "2", "--accel", "bvh"],
    &["--threads", "2", "--full-plan"],
];

/// Enough for several tiles, and for every kind of ray that the scene has; brute force stays bearable.
const REDUCED: [&str; 4] = ["--size", "48x36", "--spp", "4"];

struct OnePicture {
    scene: PathBuf,
    name: String,
}

/// One unit per scene file of the gallery and of the golden images.
pub(super) fn units(context: &Context) -> Result<Vec<Box<dyn Unit>>, TaskError> {
    let workspace = &context.workspace;
    let mut scenes = workspace.files("scenes", ".ron")?;
    scenes.extend(workspace.files("tests/golden", ".ron")?);
    Ok(scenes
        .into_iter()
        .map(|scene| {
            let name = format!("one-picture/{}", workspace.relative(&scene.with_extension("")));
            Box::new(OnePicture { scene, name }) as Box<dyn Unit>
        })
        .collect())
}

impl Unit for OnePicture {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn run(&self, context: &Context, folder: &Path) -> Result<Findings, TaskError> {
        let mut findings = Findings::default();
        let mut first: Option<Vec<u8>> = None;
        for variant in VARIANTS {
            let size: &[&str] = if context.full { &[] } else { &REDUCED };
            let args = size.iter().chain(variant).copied();
            let run = context.renderer.render(folder, &self.scene, "linear.pfm", args)?;
            let variant = variant.join(" ");
            if let Err(problem) = run.succeeded() {
                findings.problem(format!("{variant}: {problem}"));
                continue;
            }
            let path = folder.join("linear.pfm");
            let bytes = fs::read(&path).map_err(TaskError::file(&path))?;
            match &first {
                None => first = Some(bytes),
                Some(first) if *first == bytes => {}
                Some(first) => findings.problem(format!("{variant}: {}", difference(first, &bytes))),
            }
        }
        Ok(findings)
    }
}

/// How two files of linear 32-bit values differ.
fn difference(expected: &[u8], actual: &[u8]) -> String {
    if expected.len() != actual.len() {
        return format!("{} bytes instead of {}", actual.len(), expected.len());
    }
    let differing = expected.iter().zip(actual).filter(|(a, b)| a != b).count();
    format!("{differing} of {} bytes differ from `{}`", expected.len(), VARIANTS[0].join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differing_bytes_are_counted() {
        assert_eq!(difference(&[1, 2, 3, 4], &[1, 9, 3, 9]), "2 of 4 bytes differ from `--threads 1`");
        assert_eq!(difference(&[1, 2], &[1]), "1 bytes instead of 2");
    }
}
