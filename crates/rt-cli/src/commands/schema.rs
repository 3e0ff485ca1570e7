//! `schema`: what scene files may hold, for editors or for people.

use rt_scene_io::format::{json_schema, reference_page};

use crate::console::print;
use crate::error::Failure;

pub(super) fn run(markdown: bool) -> Result<(), Failure> {
    let text = if markdown { reference_page() } else { json_schema() };
    print(format_args!("{}\n", text.trim_end()))
}
