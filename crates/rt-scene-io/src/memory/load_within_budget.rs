//! Loading of a model within the budget.

use std::path::Path;

use super::estimate::{FileSample, tree_bytes};
use crate::error::ErrorAt;
use crate::files::read_file;
use crate::{LoadError, LoadOptions, Model, NamedMesh};

/// Reads and loads a model if the budget has room for its estimated peak, and charges the budget for the result.
pub(crate) fn load_within_budget(
    path: &Path,
    options: &LoadOptions,
    peak: impl FnOnce(&FileSample) -> u64,
    load: impl FnOnce(Vec<u8>) -> Result<Model, LoadError>,
) -> Result<Model, LoadError> {
    let load = || load(read_file(path, options).at(path, "")?);
    let Some(sample) = options.memory.limit().and_then(|_| FileSample::of(path, options)) else { return load() };
    let what = format!("the model {}", path.display());
    let peak = peak(&sample);
    drop(sample);
    let loading = options.memory.reserve(&what, peak).at(path, "")?;
    let model = load()?;
    drop(loading);
    options.memory.keep(&what, memory(&model)).at(path, "")?;
    Ok(model)
}

/// Bytes of the meshes and nodes of a model; textures are counted when they are read.
fn memory(model: &Model) -> u64 {
    let meshes: usize = model.meshes.iter().map(|NamedMesh { mesh, .. }| mesh.memory()).sum();
    meshes as u64 + tree_bytes(&model.nodes)
}
