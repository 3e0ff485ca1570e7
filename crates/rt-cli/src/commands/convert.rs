//! `convert`: writes a scene file.

use std::path::{Path, PathBuf};
use std::slice;

use rt_scene_io::{Converted, StudioLights, convert};

use crate::args::{ConvertArgs, InputArgs};
use crate::console::Console;
use crate::error::{CliError, usage};
use crate::input;
use crate::output_file::OutputFile;
use crate::stdin::is_dash;

pub(super) fn run(args: &ConvertArgs) -> Result<(), CliError> {
    // The extension gives the format; references are relative to the directory.
    let name = match (&args.output_format, is_dash(&args.output)) {
        (Some(format), _) => args.output.with_file_name(format!("scene.{format}")),
        (None, true) => PathBuf::from("scene.ron"),
        (None, false) => args.output.clone(),
    };
    let contradicts = |format: &&String| {
        let extension = args.output.extension();
        is_scene_file(&args.output) && extension.is_some_and(|extension| !extension.eq_ignore_ascii_case(format))
    };
    if let Some(format) = args.output_format.as_ref().filter(contradicts) {
        let output = args.output.display();
        return usage(format!(
            "--output-format {format} contradicts the extension of {output}; remove it, or rename the file"
        ));
    }
    if !is_scene_file(&name) {
        return usage(format!("unknown format of `{}`: use .ron or .json", args.output.display()));
    }
    if args.input.piped.is_some() && !is_scene_file(&args.input.scene) {
        return usage(
            "a model from standard input cannot be converted, because the scene refers to its file; save it to a file first",
        );
    }
    refuse_options_of_renders(&args.input)?;
    let output = OutputFile::prepare(&args.output, slice::from_ref(&args.input.scene))?.for_text();
    let Converted { text, warnings, notes } = convert(&args.input.scene, &name, &input::load_options(&args.input)?)?;
    let console = Console { quiet: args.quiet };
    input::warn(&warnings, console);
    if args.strict {
        input::refuse_warnings(&args.input.scene, &warnings)?;
    }
    output.write(|file| file.write_all(text.as_bytes()))?;
    notes.iter().try_for_each(|note| console.println(format_args!("note: {note}")))?;
    if output.is_stdout() { Ok(()) } else { console.println(format_args!("wrote {}", output.path().display())) }
}

/// Refuses options that choose what a render shows of a model or an animation: a scene file keeps all of it.
fn refuse_options_of_renders(input: &InputArgs) -> Result<(), CliError> {
    let given = [
        ("--at-time", input.at_time.is_some()),
        ("--shutter", input.timing.shutter.is_some()),
        ("--animation", input.animation.is_some()),
        ("--variant", input.variant.is_some()),
        ("--lights", input.lights != StudioLights::Auto && is_scene_file(&input.scene)),
    ];
    let given: Vec<_> = given.iter().filter(|(_, is_given)| *is_given).map(|(option, _)| *option).collect();
    if given.is_empty() {
        return Ok(());
    }
    let options = given.join(", ");
    usage(format!("a converted scene does not depend on {options}: use `render` with {options}"))
}

fn is_scene_file(path: &Path) -> bool {
    path.extension().is_some_and(|extension| ["ron", "json"].iter().any(|known| extension.eq_ignore_ascii_case(known)))
}
