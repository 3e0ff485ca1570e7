//! Options of loading.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use rt_math::Rgb;

use crate::{Integrator, MemoryBudget};

/// Condition for adding studio lights: a key light, a fill light, ambient light and a backdrop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StudioLights {
    /// Added to scenes without a light of any kind: no light of the file, no emissive material, no environment image.
    /// Under integrators that take light from the background, a background is a light, too.
    #[default]
    Auto,
    /// Never added.
    None,
    /// Added to all scenes, in addition to their own lights.
    Studio,
}

impl StudioLights {
    /// All choices.
    pub const ALL: [Self; 3] = [Self::Auto, Self::None, Self::Studio];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::None => "none",
            Self::Studio => "studio",
        }
    }
}

/// Options of the caller.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// The folder below which all files must lie that the scene refers to; by default the folder of the scene.
    pub root: Option<PathBuf>,
    /// Puts a ground plane under a bare model.
    pub ground: bool,
    /// Width and height of the image; override those of the file. The default camera depends on their ratio.
    pub size: Option<[u32; 2]>,
    /// Condition for adding studio lights.
    pub studio_lights: StudioLights,
    /// Integrator of the caller; overrides that of the scene. Other defaults depend on it.
    pub integrator: Option<Integrator>,
    /// Samples per pixel of the caller; override those of the scene. The least number of adaptive sampling depends on them.
    pub spp: Option<u32>,
    /// True if the caller overrides the adaptive sampling of the scene, which is then not checked.
    pub overrides_adaptive: bool,
    /// Background of the caller; overrides that of the scene. Studio lights and exposure depend on it.
    pub background: Option<Rgb>,
    /// True if the caller adds an environment image. Studio lights, exposure and integrator depend on it.
    pub has_environment: bool,
    /// Time of an animation, in seconds, at which scenes and models are posed. Without it, models are at rest and scenes at
    /// time 0.
    pub at_time: Option<f64>,
    /// Seconds between two frames of an animation; 1/24 by default. Camera shutters are open for a part of it.
    pub frame_time: Option<f64>,
    /// Times at which all shutters open and close, from 0 to 1; override those of the scene.
    pub shutter: Option<[f64; 2]>,
    /// Animation that poses a model: name, index, or `all`; by default the first. Used with [`at_time`](Self::at_time) only.
    pub animation: Option<String>,
    /// The variant of the materials of a model that have several; by default none, which shows the model's own.
    pub variant: Option<String>,
    /// Maximum size of a file in bytes; [`limits::FILE_BYTES`](crate::limits::FILE_BYTES) by default.
    pub max_file_bytes: Option<u64>,
    /// Memory budget of loading; unlimited by default.
    pub memory: MemoryBudget,
    /// A file that is not on the disk, such as the scene itself if it came through a pipe.
    pub in_memory: Option<InMemoryFile>,
    /// Receives the time of the last key of all animations.
    pub animation_end: AnimationEnd,
    /// Receives the files that the loaded file refers to.
    pub referenced: ReferencedFiles,
    /// Receives the hashes of all files that loading reads.
    pub input_hashes: InputHashes,
}

/// Content of a file that is not on the disk. Its references are relative to the folder of its path.
#[derive(Clone, Debug)]
pub struct InMemoryFile {
    /// Path for messages; its extension selects the format.
    pub path: PathBuf,
    /// Its content.
    pub bytes: Arc<[u8]>,
}

/// The time of the last key of animations, in seconds. Clones share it.
///
/// Scene files have it at any time; models have it where [`LoadOptions::at_time`] poses them.
#[derive(Clone, Debug, Default)]
pub struct AnimationEnd(Arc<Mutex<Option<f64>>>);

impl AnimationEnd {
    /// The time; `None` without animations.
    pub fn seconds(&self) -> Option<f64> {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Extends it to the time of a key.
    pub(crate) fn extend(&self, time: f64) {
        let mut end = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *end = Some(end.map_or(time, |end| end.max(time)));
    }
}

/// Files that other files refer to: textures, models, material libraries and buffers. Clones share one list.
///
/// Programs use it to avoid overwriting the inputs of a scene.
#[derive(Clone, Debug, Default)]
pub struct ReferencedFiles(Arc<Mutex<BTreeSet<PathBuf>>>);

impl ReferencedFiles {
    /// Files read so far: canonical paths, sorted.
    pub fn paths(&self) -> Vec<PathBuf> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).iter().cloned().collect()
    }

    pub(crate) fn add(&self, path: PathBuf) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(path);
    }
}

/// Function that hashes the content of a file.
pub type Hasher = fn(&[u8]) -> [u8; 16];

/// Hashes of input files, computed from the bytes that loading reads, so that no file is read twice. Clones share one list.
///
/// The default computes none.
#[derive(Clone, Debug, Default)]
pub struct InputHashes {
    hasher: Option<Hasher>,
    hashes: Arc<Mutex<BTreeMap<PathBuf, [u8; 16]>>>,
}

impl InputHashes {
    /// An empty list that grows by the hash of each file that is read.
    pub fn new(hasher: Hasher) -> Self {
        Self { hasher: Some(hasher), ..Self::default() }
    }

    /// Hash of a file; `None` if it was not read.
    pub fn get(&self, path: &Path) -> Option<[u8; 16]> {
        let path = path.canonicalize().ok()?;
        self.hashes.lock().unwrap_or_else(PoisonError::into_inner).get(&path).copied()
    }

    pub(crate) fn record(&self, path: &Path, bytes: &[u8]) {
        if let (Some(hasher), Ok(path)) = (self.hasher, path.canonicalize()) {
            let hash = hasher(bytes);
            self.hashes.lock().unwrap_or_else(PoisonError::into_inner).insert(path, hash);
        }
    }
}

impl LoadOptions {
    /// Default number of frames per second.
    pub const DEFAULT_FPS: f64 = 24.0;

    /// Times at which the shutter opens and closes, in seconds; both equal to [`at_time`](Self::at_time) without a shutter.
    /// `None` without a time.
    pub(crate) fn shutter_interval(&self) -> Option<[f64; 2]> {
        let frame_time = self.frame_time.unwrap_or(1.0 / Self::DEFAULT_FPS);
        let shutter = self.shutter.unwrap_or([0.0; 2]);
        self.at_time.map(|time| shutter.map(|part| time + part * frame_time))
    }

    /// The content of a file that is not on the disk.
    pub(crate) fn content_of(&self, path: &Path) -> Option<&[u8]> {
        self.in_memory.as_ref().filter(|file| file.path == path).map(|file| &*file.bytes)
    }

    /// These options with the root resolved: as given, or else the folder of `file`.
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
