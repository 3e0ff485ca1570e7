//! `schema`: JSON Schema or reference page of scene files.

use rt_scene_io::format::{json_schema, reference_page};

use crate::console::print;
use crate::error::CliError;

pub(super) fn run(markdown: bool) -> Result<(), CliError> {
    let text = if markdown { reference_page() } else { json_schema().to_owned() };
    print(format_args!("{}\n", text.trim_end()))
}
