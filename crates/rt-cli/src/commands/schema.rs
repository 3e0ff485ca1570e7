//! `schema`: what scene files may hold.

use rt_scene_io::format::json_schema;

use crate::console::print;
use crate::error::Failure;

pub(super) fn run() -> Result<(), Failure> {
    print(format_args!("{}\n", json_schema().trim_end()))
}
