//! One picture: neither thread count, nor structure, nor what the plan leaves out changes a bit of the image.

use std::{
    fs,
    path::{Path, PathBuf},
};

use rt_accel::StructureKind;

use super::{Context, Findings, Unit};
use crate::{error::TaskError, workspace::Workspace};

/// What must not matter beside the structure. The first is what the others are compared with.
const VARIANTS: [&[&str]; 5] = [
    &["--threads", "1"],
    &["--threads", "2"],
    &["--threads", "3"],
    &["--threads", "8"],
    &["--threads", "2", "--full-plan"],
];

/// Brute force apart: at full quality it would take hours.
const BRUTE_FORCE: [&[&str]; 2] = [&["--threads", "2"], &["--threads", "2", "--accel", "linear"]];

/// All variants but brute force.
fn variants() -> Vec<Vec<&'static str>> {
    let structures = StructureKind::ALL.iter().filter(|kind| **kind != StructureKind::Linear);
    let structures = structures.map(|kind| vec!["--threads", "2", "--accel", kind.name()]);
    VARIANTS.iter().map(|variant| variant.to_vec()).chain(structures).collect()
}

/// Enough for several tiles, and for every kind of ray that the scene has.
const REDUCED: &[&str] = &["--size", "48x36", "--spp", "4"];

struct OnePicture {
    scene: PathBuf,
    name: String,
}

/// One unit per scene file that comes along, and per golden image.
pub(super) fn units(workspace: &Workspace) -> Result<Vec<Box<dyn Unit>>, TaskError> {
    let mut scenes = workspace.files("scenes", ".ron")?;
    scenes.extend(workspace.files("scenes/spd", ".nff")?);
    scenes.extend(workspace.files("scenes/gallery", ".pbrt")?);
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
        let (quality, brute_force_quality): (&[&str], &[&str]) =
            if context.full { (&[], &["--spp", "1"]) } else { (REDUCED, REDUCED) };
        self.compare(context, folder, quality, &variants(), &mut findings)?;
        self.compare(context, folder, brute_force_quality, &BRUTE_FORCE, &mut findings)?;
        Ok(findings)
    }
}

impl OnePicture {
    /// Renders all variants and compares the bytes with those of the first.
    fn compare(
        &self,
        context: &Context,
        folder: &Path,
        quality: &[&str],
        variants: &[impl AsRef<[&'static str]>],
        findings: &mut Findings,
    ) -> Result<(), TaskError> {
        let mut first: Option<Vec<u8>> = None;
        for variant in variants {
            let variant = variant.as_ref();
            let args = quality.iter().chain(variant).copied();
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
        Ok(())
    }
}

/// How two files of linear 32-bit values differ.
fn difference(expected: &[u8], actual: &[u8]) -> String {
    if expected.len() != actual.len() {
        return format!("{} bytes instead of {}", actual.len(), expected.len());
    }
    let differing = expected.iter().zip(actual).filter(|(a, b)| a != b).count();
    format!("{differing} of {} bytes differ from the first variant", expected.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differing_bytes_are_counted() {
        assert_eq!(difference(&[1, 2, 3, 4], &[1, 9, 3, 9]), "2 of 4 bytes differ from the first variant");
        assert_eq!(difference(&[1, 2], &[1]), "1 bytes instead of 2");
    }
}
