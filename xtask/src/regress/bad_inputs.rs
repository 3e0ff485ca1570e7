//! Bad input ends in one clear message, the right exit code, and no output file.

use std::{fs, path::Path};

use super::unit::{Context, Findings, Unit};
use crate::{error::TaskError, renderer::Exit};

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

const CASES: [BadInput; 12] = [
    BadInput { name: "missing-file", scene: None, args: &[], code: BAD_INPUT, message: "scene.ron" },
    BadInput { name: "empty-file", scene: Some(""), args: &[], code: BAD_INPUT, message: "empty" },
    BadInput {
        name: "unknown-field",
        scene: Some("(\n  nodes: [\n    (shape: sphere(raduis: 1))])"),
        args: &[],
        code: BAD_INPUT,
        message: "did you mean `radius`",
    },
    BadInput {
        name: "unclosed",
        scene: Some("(nodes: [\n(shape: sphere())"),
        args: &[],
        code: BAD_INPUT,
        message: "scene.ron:2:",
    },
    BadInput {
        name: "nan",
        scene: Some("(nodes: [(shape: sphere(center: (NaN, 0, 0)))])"),
        args: &[],
        code: BAD_INPUT,
        message: "NaN",
    },
    BadInput {
        name: "negative-radius",
        scene: Some("(nodes: [(shape: sphere(radius: -1))])"),
        args: &[],
        code: BAD_INPUT,
        message: "-1",
    },
    BadInput {
        name: "zero-size",
        scene: Some("(film: (size: (0, 48)), nodes: [(shape: sphere())])"),
        args: &[],
        code: BAD_INPUT,
        message: "0",
    },
    BadInput {
        name: "camera-along-up",
        scene: Some("(camera: (look_from: (0, 5, 0)), nodes: [(shape: sphere())])"),
        args: &[],
        code: BAD_INPUT,
        message: "up",
    },
    BadInput {
        name: "missing-texture",
        scene: Some(
            "(materials: {\"a\": phong(color: image(file: \"none.png\"))}, nodes: [(shape: sphere(), material: \"a\")])",
        ),
        args: &[],
        code: BAD_INPUT,
        message: "none.png",
    },
    BadInput {
        name: "unwritable-output",
        scene: Some(SPHERE),
        args: &["-o", "no-such-folder/output.png"],
        code: BAD_OUTPUT,
        message: "no-such-folder",
    },
    BadInput {
        name: "unknown-option",
        scene: Some(SPHERE),
        args: &["--no-such-option"],
        code: USAGE,
        message: "--no-such-option",
    },
    BadInput { name: "zero-spp", scene: Some(SPHERE), args: &["--spp", "0"], code: USAGE, message: "0" },
];

/// One unit per case.
pub(super) fn units() -> impl Iterator<Item = Box<dyn Unit>> {
    CASES.into_iter().map(|case| Box::new(case) as Box<dyn Unit>)
}

impl Unit for BadInput {
    fn name(&self) -> String {
        format!("bad-input/{}", self.name)
    }

    fn run(&self, context: &Context, folder: &Path) -> Result<Findings, TaskError> {
        // The output goes to a folder of its own, where nothing must appear.
        let output = folder.join("output");
        fs::create_dir(&output).map_err(TaskError::file(&output))?;
        if let Some(scene) = self.scene {
            let path = folder.join("scene.ron");
            fs::write(&path, scene).map_err(TaskError::file(&path))?;
        }
        let mut args = vec!["render", "scene.ron"];
        if !self.args.contains(&"-o") {
            args.extend(["-o", "output/picture.png"]);
        }
        args.extend(self.args);
        let run = context.renderer.run(folder, args)?;

        let mut findings = Findings::default();
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
        Ok(findings)
    }
}
