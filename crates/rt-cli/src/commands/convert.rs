//! `convert`: a scene file to edit.

use std::io::Write;
use std::path::Path;
use std::slice;

use rt_scene_io::{Converted, convert};

use crate::args::ConvertArgs;
use crate::console::Console;
use crate::error::Failure;
use crate::input;
use crate::output::OutputFile;

pub(super) fn run(args: &ConvertArgs) -> Result<(), Failure> {
    if !is_scene_file(&args.output) {
        let message = format!("cannot tell the format of `{}`: use .ron or .json", args.output.display());
        return Err(Failure::Usage(message));
    }
    let output = OutputFile::prepare(&args.output, slice::from_ref(&args.input.scene))?;
    let Converted { text, warnings } = convert(&args.input.scene, &args.output, &input::load_options(&args.input)?)?;
    input::warn(&warnings, Console { quiet: false });
    if args.strict {
        input::refuse_warnings(&args.input.scene, &warnings)?;
    }
    Ok(output.write(|file| file.write_all(text.as_bytes()))?)
}

fn is_scene_file(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ["ron", "json"].iter().any(|known| ending.eq_ignore_ascii_case(known)))
}
