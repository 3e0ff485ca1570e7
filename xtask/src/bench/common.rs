//! Output and arguments that all benchmarks share.

use std::fmt::Display;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use rt_accel::AcceleratorKind;
use serde::Serialize;

use crate::error::TaskError;

/// Prints the results as JSON on standard output, and the table on standard error.
pub(super) fn print(results: &impl Serialize, table: &impl Display) -> Result<(), TaskError> {
    let json = serde_json::to_string_pretty(results).map_err(TaskError::other)?;
    println!("{json}");
    eprint!("{table}");
    Ok(())
}

/// Parses the name of one of these values.
pub(super) fn named<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let names = PossibleValuesParser::new(all.iter().map(|&value| name(value)));
    names.try_map(move |typed| all.iter().copied().find(|&value| name(value) == typed).ok_or("no such name"))
}

pub(super) fn accelerator() -> impl TypedValueParser<Value = AcceleratorKind> {
    named(AcceleratorKind::ALL, AcceleratorKind::name)
}
