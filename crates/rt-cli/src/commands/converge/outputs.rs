//! The files that are written, each of them whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::Failure;
use crate::output::{OutputError, OutputFile};

/// The folder, and the files in it.
#[derive(Debug)]
pub(super) struct Outputs {
    pub(super) folder: PathBuf,
    pub(super) csv: OutputFile,
    pub(super) json: OutputFile,
    pub(super) svg: OutputFile,
    pub(super) png: OutputFile,
    pub(super) html: OutputFile,
}

impl Outputs {
    /// Makes the folder if it is missing, and sees that it takes the files.
    pub(super) fn prepare(folder: &Path, inputs: &[PathBuf]) -> Result<Self, Failure> {
        if !folder.is_dir() {
            fs::create_dir(folder).map_err(|error| OutputError::Write {
                path: folder.to_owned(),
                reason: format!("the folder cannot be made: {error}"),
            })?;
        }
        let file = |ending: &str| OutputFile::prepare(&folder.join(format!("converge.{ending}")), inputs);
        let [csv, json, svg, png, html] = ["csv", "json", "svg", "png", "html"].map(file);
        Ok(Self { folder: folder.to_owned(), csv: csv?, json: json?, svg: svg?, png: png?, html: html? })
    }
}
