//! `--limits`: table of all limits on input.

use bytesize::ByteSize;
use comfy_table::{CellAlignment, Table, presets};
use rt_image::{Image, MAX_READ_PIXELS};
use rt_render::{MAX_DIELECTRICS, MAX_NULL_INTERFACES};
use rt_scene_io::limits::{self, Amount};

use crate::args;
use crate::console::print;
use crate::error::CliError;
use crate::memory;

pub(super) fn run() -> Result<(), CliError> {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(["limit", "at most", "applies to", "changed by"]);
    let memory = args::Amount::default().of(memory::available_bytes());
    let memory = memory.map_or_else(|| "no limit".to_owned(), |bytes| ByteSize(bytes).to_string());
    table.add_row([
        "predicted memory",
        &memory,
        "render, view, explain, check, convert, converge, merge, compare, develop",
        "--memory",
    ]);
    for limit in limits::ALL {
        let flag = limit.flag.unwrap_or_default();
        table.add_row([limit.what, &limit.max.to_string(), limit.applies_to, flag]);
    }
    for (what, max) in [
        ("dielectrics around a point", MAX_DIELECTRICS as u64),
        ("null interfaces in a row, before each costs a bounce", MAX_NULL_INTERFACES.into()),
    ] {
        table.add_row([what, &Amount::Count(max).to_string(), "every scene and model", ""]);
    }
    let read = Amount::Count(MAX_READ_PIXELS).to_string();
    table.add_row(["pixels of an input image", &read, "compare, develop", ""]);
    let joined = Amount::Count(Image::MAX_PIXELS).to_string();
    table.add_row(["pixels of a merged image", &joined, "merge", ""]);
    if let Some(column) = table.column_mut(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    print(format_args!("{table}\n"))
}
