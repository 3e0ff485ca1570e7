//! How to load a file.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// What the caller decides about loading.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// The folder below which all files must lie that the scene refers to; by default the folder of the scene.
    pub root: Option<PathBuf>,
    /// Puts a ground plane under a bare model.
    pub ground: bool,
    /// Width and height of the image in place of the file's. A camera that is put where it sees everything depends on
    /// their ratio.
    pub size: Option<[u32; 2]>,
    /// The moment of an animation, in seconds, at which a model is posed. Without it the model rests as its nodes say.
    pub at_time: Option<f64>,
    /// Which animation poses a model: its name, its index, or `all`; by default the first. It matters with
    /// [`at_time`](Self::at_time) alone.
    pub animation: Option<String>,
    /// The variant of the materials of a model that have several; by default none, which shows the model's own.
    pub variant: Option<String>,
    /// Receives the files that loading meets beside the one that it is given.
    pub referenced: ReferencedFiles,
}

/// Files that other files refer to: textures, models, their material libraries and buffers. Clones share one list.
///
/// Whoever writes a file after loading a scene can tell by it that nothing is overwritten which the scene needs.
#[derive(Clone, Debug, Default)]
pub struct ReferencedFiles(Arc<Mutex<BTreeSet<PathBuf>>>);

impl ReferencedFiles {
    /// The files met so far: canonical paths, sorted.
    pub fn paths(&self) -> Vec<PathBuf> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).iter().cloned().collect()
    }

    /// Adds a canonical path.
    pub(crate) fn add(&self, path: PathBuf) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(path);
    }
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
