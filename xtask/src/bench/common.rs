//! Output and arguments that all benchmarks share.

use std::fmt::Display;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use rt_accel::{AcceleratorKind, wide::Quality};
use serde::Serialize;

use crate::error::TaskError;

/// Prints the results as JSON on standard output, and the table on standard error.
pub(super) fn print(results: &impl Serialize, table: &impl Display) -> Result<(), TaskError> {
    let json = serde_json::to_string_pretty(results).map_err(TaskError::other)?;
    println!("{json}");
    eprint!("{table}");
    Ok(())
}

/// Parses the name of an accelerator.
pub(super) fn accelerator() -> impl TypedValueParser<Value = AcceleratorKind> {
    let names = PossibleValuesParser::new(AcceleratorKind::ALL.iter().map(|kind| kind.name()));
    names.try_map(|name| {
        AcceleratorKind::ALL.iter().copied().find(|kind| kind.name() == name).ok_or("no such accelerator")
    })
}

/// Parses the name of a build quality.
pub(super) fn quality() -> impl TypedValueParser<Value = Quality> {
    let names = PossibleValuesParser::new(Quality::ALL.iter().map(|quality| quality.name()));
    names.try_map(|name| Quality::ALL.iter().copied().find(|quality| quality.name() == name).ok_or("no such quality"))
}
