//! Bad input ends in one clear message, the right exit code, and no output file.

use std::{fs, path::Path};

use super::unit::{Context, Findings, Unit};
use crate::{error::TaskError, files, renderer::Exit};

const USAGE: i32 = 2;
const BAD_INPUT: i32 = 3;
const BAD_OUTPUT: i32 = 4;

/// A scene or a command that must be refused.
struct BadInput {
    name: &'static str,
    /// Written to `scene.ron`; no such file without.
    scene: Option<&'static str>,
    args: &'static [&'static str],
    code: i32,
    /// Text that the message must contain.
    message: &'static str,
}

const SPHERE: &str = "(nodes: [(shape: sphere())])";

/// Name, scene, options, exit code, and text that the message must contain.
const CASES: [BadInput; 12] = [
    bad("missing-file", None, &[], BAD_INPUT, "scene.ron"),
    bad("empty-file", Some(""), &[], BAD_INPUT, "empty"),
    bad(
        "unknown-field",
        Some("(\n  nodes: [\n    (shape: sphere(raduis: 1))])"),
        &[],
        BAD_INPUT,
        "did you mean `radius`",
    ),
    bad("unclosed", Some("(nodes: [\n(shape: sphere())"), &[], BAD_INPUT, "scene.ron:2:"),
    bad("nan", Some("(nodes: [(shape: sphere(center: (NaN, 0, 0)))])"), &[], BAD_INPUT, "NaN"),
    bad("negative-radius", Some("(nodes: [(shape: sphere(radius: -1))])"), &[], BAD_INPUT, "-1"),
    bad("zero-size", Some("(film: (size: (0, 48)), nodes: [(shape: sphere())])"), &[], BAD_INPUT, "0"),
    bad("camera-along-up", Some("(camera: (look_from: (0, 5, 0)), nodes: [(shape: sphere())])"), &[], BAD_INPUT, "up"),
    bad("missing-texture", Some(TEXTURED), &[], BAD_INPUT, "none.png"),
    bad("unwritable-output", Some(SPHERE), &["-o", "no-such-folder/output.png"], BAD_OUTPUT, "no-such-folder"),
    bad("unknown-option", Some(SPHERE), &["--no-such-option"], USAGE, "--no-such-option"),
    bad("zero-spp", Some(SPHERE), &["--spp", "0"], USAGE, "0"),
];

const TEXTURED: &str =
    "(materials: {\"a\": phong(color: image(file: \"none.png\"))}, nodes: [(shape: sphere(), material: \"a\")])";

const fn bad(
    name: &'static str,
    scene: Option<&'static str>,
    args: &'static [&'static str],
    code: i32,
    message: &'static str,
) -> BadInput {
    BadInput { name, scene, args, code, message }
}

/// One unit per case.
pub(super) fn units() -> impl Iterator<Item = Box<dyn Unit>> {
    CASES.into_iter().map(|case| Box::new(case) as Box<dyn Unit>)
}

impl Unit for BadInput {
    fn name(&self) -> String {
        format!("bad-input/{}", self.name)
    }

    fn run(&self, context: &Context, folder: &Path, findings: &mut Findings) -> Result<(), TaskError> {
        // The output goes to a folder of its own, where nothing must appear.
        let output = folder.join("output");
        fs::create_dir(&output).map_err(TaskError::file(&output))?;
        if let Some(scene) = self.scene {
            let path = folder.join("scene.ron");
            files::write(&path, scene)?;
        }
        let mut args = vec!["render", "scene.ron"];
        if !self.args.contains(&"-o") {
            args.extend(["-o", "output/picture.png"]);
        }
        args.extend(self.args);
        let run = context.renderer.run(folder, args)?;

        if run.exit != Exit::Code(self.code) {
            findings.problem(format!("{} instead of exit code {}", run.exit, self.code));
        }
        if !run.log.contains(self.message) {
            findings.problem(format!("the message does not contain `{}`", self.message));
        }
        if run.log.contains("panicked") {
            findings.problem("it panicked");
        }
        if fs::read_dir(&output).map_err(TaskError::file(&output))?.next().is_some() {
            findings.problem("it left an output file");
        }
        if !findings.problems.is_empty() {
            findings.note(run.log.trim());
        }
        Ok(())
    }
}
