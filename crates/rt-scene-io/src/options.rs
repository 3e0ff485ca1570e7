//! How to load a file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use rt_math::Rgb;

use crate::{Integrator, MemoryBudget};

/// Condition for adding studio lights: a key light, a fill light, ambient light and a backdrop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StudioLights {
    /// Added to scenes without a light of any kind: no light of the file, no emissive material, no image around it, and
    /// under integrators that take light from it no background.
    #[default]
    Auto,
    /// Never added.
    None,
    /// Added to all scenes, beside their own lights.
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
    /// Condition for adding studio lights.
    pub studio_lights: StudioLights,
    /// The integrator that the caller sets in place of the scene's. Defaults that depend on the integrator suit it.
    pub integrator: Option<Integrator>,
    /// The background that the caller sets in place of the scene's. Studio lights and exposure suit it.
    pub background: Option<Rgb>,
    /// Whether the caller puts an image around the scene. Studio lights, exposure and integrator suit it.
    pub has_environment: bool,
    /// The moment of an animation, in seconds, at which scenes and models are posed. Without it models rest as their nodes say,
    /// and scene files are as at 0.
    pub at_time: Option<f64>,
    /// Seconds from one frame of an animation to the next, of which the shutters of cameras are open for a part; a 24th by
    /// default.
    pub frame_time: Option<f64>,
    /// When the shutters of all cameras open and close, from 0 to 1, in place of what the scene says.
    pub shutter: Option<[f64; 2]>,
    /// Which animation poses a model: its name, its index, or `all`; by default the first. It matters with
    /// [`at_time`](Self::at_time) alone.
    pub animation: Option<String>,
    /// The variant of the materials of a model that have several; by default none, which shows the model's own.
    pub variant: Option<String>,
    /// Most bytes that a file may have; [`limits::FILE_BYTES`](crate::limits::FILE_BYTES) by default.
    pub max_file_bytes: Option<u64>,
    /// How much memory loading may take; by default, as much as it wants.
    pub memory: MemoryBudget,
    /// A file that is not on the disk, such as the scene itself if it came through a pipe.
    pub in_memory: Option<InMemoryFile>,
    /// Receives the time of the last key of all animations that loading meets.
    pub animation_end: AnimationEnd,
    /// Receives the files that loading meets beside the one that it is given.
    pub referenced: ReferencedFiles,
    /// Receives the hashes of all files that loading reads.
    pub input_hashes: InputHashes,
}

/// The content of a file that is not on the disk. What it refers to is looked for beside its path.
#[derive(Clone, Debug)]
pub struct InMemoryFile {
    /// The path that it is loaded by, whose ending tells the format.
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
    /// The time; `None` if nothing was animated.
    pub fn seconds(&self) -> Option<f64> {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Extends it to the time of a key.
    pub(crate) fn extend(&self, time: f64) {
        let mut end = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *end = Some(end.map_or(time, |end| end.max(time)));
    }
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

/// Hashes of input files, computed from the bytes that loading reads, so that no file is read twice. Clones share one list.
///
/// The default computes none.
#[derive(Clone, Debug, Default)]
pub struct InputHashes {
    hasher: Option<fn(&[u8]) -> [u8; 32]>,
    hashes: Arc<Mutex<BTreeMap<PathBuf, [u8; 32]>>>,
}

impl InputHashes {
    /// An empty list that grows by the hash of each file that is read.
    pub fn new(hasher: fn(&[u8]) -> [u8; 32]) -> Self {
        Self { hasher: Some(hasher), ..Self::default() }
    }

    /// Hash of a file; `None` if it was not read.
    pub fn get(&self, path: &Path) -> Option<[u8; 32]> {
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
    /// Frames of a second, unless the options say otherwise.
    pub const DEFAULT_FPS: f64 = 24.0;

    /// The moments at which the shutter opens and closes, in seconds: of the shutter that is given, or else both
    /// [`at_time`](Self::at_time). `None` if there is no such time.
    pub(crate) fn shutter_interval(&self) -> Option<[f64; 2]> {
        let frame_time = self.frame_time.unwrap_or(1.0 / Self::DEFAULT_FPS);
        let shutter = self.shutter.unwrap_or([0.0; 2]);
        self.at_time.map(|time| shutter.map(|part| time + part * frame_time))
    }

    /// The content of a file that is not on the disk.
    pub(crate) fn content_of(&self, path: &Path) -> Option<&[u8]> {
        self.in_memory.as_ref().filter(|file| file.path == path).map(|file| &*file.bytes)
    }

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
