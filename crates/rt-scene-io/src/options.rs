//! How to load a file.

use std::path::{Path, PathBuf};

/// What the caller decides about loading.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadOptions {
    /// The folder below which all files must lie that the scene refers to; by default the folder of the scene.
    pub root: Option<PathBuf>,
    /// Puts a ground plane under a bare model.
    pub ground: bool,
    /// Width and height of the image in place of the file's. A camera that is put where it sees everything depends on
    /// their ratio.
    pub size: Option<[u32; 2]>,
}

impl LoadOptions {
    /// These options with the root settled: as given, or else the folder of `file`.
    pub fn rooted_at(&self, file: &Path) -> Self {
        let root = self.root.clone().unwrap_or_else(|| folder_of(file).to_path_buf());
        Self { root: Some(root), ..self.clone() }
    }
}

/// The folder that a file lies in: `.` for a bare file name.
pub(crate) fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}
