//! Every good file at hand, cut off and with bytes changed: whatever becomes of it, the answer comes in time and in words.
//!
//! `MUTATIONS=100 cargo test -p rt-scene-io --test scene_io damaged_files` tries a hundred times as much.

use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use rt_math::random::hash;
use rt_scene_io::{LoadOptions, decode_numbers, decode_texture, load};
use tempfile::TempDir;

/// Folders of good files, relative to this crate: of the project, and the first inputs of its fuzz targets. Test data that not
/// everybody has comes on top.
const FOLDERS: [&str; 3] = ["../../scenes", "../../tests/golden", "../../fuzz/seeds"];

/// Extensions of images.
const IMAGES: [&str; 4] = ["png", "jpg", "hdr", "exr"];

/// Longer files teach little and take long.
const LONGEST: u64 = 50_000;

/// Files up to this size are cut at every length.
const SHORT: usize = 50;

/// An answer may take that long on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

#[test]
fn damaged_scenes() {
    damage_all(&["ron", "json"]);
}

#[test]
fn damaged_gltf_and_its_buffers() {
    damage_all(&["gltf", "bin"]);
}

#[test]
fn damaged_glb() {
    damage_all(&["glb"]);
}

#[test]
fn damaged_obj_and_mtl() {
    damage_all(&["obj", "mtl"]);
}

#[test]
fn damaged_nff_ply_stl_and_pbrt() {
    damage_all(&["nff", "ply", "stl", "pbrt"]);
}

#[test]
fn damaged_images() {
    damage_all(&IMAGES);
}

/// Damages all files with one of these extensions.
fn damage_all(extensions: &[&str]) {
    let more = std::env::var("MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let files = good_files(extensions);
    assert!(!files.is_empty());
    let mut loads = 0;
    for file in &files {
        let damaged = Damaged::of(file);
        loads += damaged.truncate() + damaged.mutate(more);
    }
    println!("{} files, loaded {loads} times with damage", files.len());
}

/// All files with these extensions that are neither empty nor long.
#[track_caller]
fn good_files(extensions: &[&str]) -> Vec<PathBuf> {
    let mut folders = Vec::from(FOLDERS.map(|folder| Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)));
    folders.extend(rt_tests::shared_or_skip("data"));
    let files = folders.iter().flat_map(|folder| rt_tests::files_below(folder, extensions));
    files.filter(|path| (1..=LONGEST).contains(&fs::metadata(path).unwrap().len())).collect()
}

fn extension(path: &Path) -> &str {
    path.extension().and_then(|extension| extension.to_str()).unwrap_or_default()
}

/// A good file, and a folder in which a damaged one stands in its place.
struct Damaged<'a> {
    file: &'a Path,
    bytes: Vec<u8>,
    folder: TempDir,
    /// The names of the files that are loaded: itself, or those next to it that it belongs to.
    loaded: Vec<String>,
}

impl<'a> Damaged<'a> {
    fn of(file: &'a Path) -> Self {
        let folder = tempfile::tempdir().unwrap();
        copy_below(file.parent().unwrap(), folder.path(), 3);
        let name = file.file_name().unwrap().to_str().unwrap();
        let owner = match extension(file) {
            "mtl" => Some("obj"),
            "bin" => Some("gltf"),
            _ => None,
        };
        let loaded = match owner {
            None => vec![name.to_owned()],
            Some(owner) => {
                let siblings = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
                let refers = |path: &PathBuf| {
                    extension(path) == owner && String::from_utf8_lossy(&fs::read(path).unwrap()).contains(name)
                };
                let owners = siblings.filter(refers).map(|path| path.file_name().unwrap().to_str().unwrap().to_owned());
                owners.take(1).collect()
            }
        };
        Self { file, bytes: fs::read(file).unwrap(), folder, loaded }
    }

    /// Loads the file cut off at many lengths: everywhere in a short file or near the ends, here and there in between.
    fn truncate(&self) -> usize {
        let count = self.bytes.len();
        let ends = (0..count.min(4)).chain(count.saturating_sub(4)..count);
        let step = if count <= SHORT { 1 } else { count / 5 };
        let lengths: Vec<usize> = ends.chain((0..count).step_by(step)).collect();
        for &length in &lengths {
            self.load(&self.bytes[..length], &format!("cut at {length}"));
        }
        lengths.len()
    }

    /// Loads the file with a few bytes changed, long files less often than short ones.
    fn mutate(&self, more: u64) -> usize {
        let rounds = (50_000 / (self.bytes.len() as u64 + 1000)).clamp(2, 10) * more;
        for seed in 0..rounds {
            let mut bytes = self.bytes.clone();
            for change in 0..1 + seed % 4 {
                let random = |purpose: u64| hash(&[seed, change, purpose]);
                let at = (random(0) % bytes.len() as u64) as usize;
                let other = (random(1) % bytes.len() as u64) as usize;
                match random(2) % 5 {
                    0 => bytes[at] = random(3) as u8,
                    1 => bytes[at] = b"0123456789-.e/\"[]{},"[(random(3) % 20) as usize],
                    2 => bytes[at] = bytes[other],
                    3 => bytes[at] ^= 1 << (random(3) % 8),
                    _ if bytes.len() > 1 => drop(bytes.remove(at)),
                    _ => {}
                }
            }
            self.load(&bytes, &format!("mutated with seed {seed}"));
        }
        rounds as usize
    }

    /// Whatever the outcome, it must come in time, without a panic, and name the file if it is an error.
    fn load(&self, bytes: &[u8], damage: &str) {
        let what = format!("{} {damage}", self.file.display());
        let start = Instant::now();
        if IMAGES.contains(&extension(self.file)) {
            // Both differ after decoding only, and take turns.
            let decode = if bytes.len().is_multiple_of(2) { decode_texture } else { decode_numbers };
            let decoded = catch_unwind(|| drop(decode(bytes)));
            assert!(decoded.is_ok(), "{what}: panicked");
        } else {
            fs::write(self.folder.path().join(self.file.file_name().unwrap()), bytes).unwrap();
            self.loaded.iter().for_each(|name| self.load_scene(name, &what));
        }
        assert!(start.elapsed() < PATIENCE, "{what}: took {:?}", start.elapsed());
    }

    fn load_scene(&self, name: &str, what: &str) {
        let place = self.folder.path().join(name);
        let outcome = catch_unwind(AssertUnwindSafe(|| load(&place, &LoadOptions::default()).map(drop)));
        let Ok(outcome) = outcome else { panic!("{what}: panicked") };
        if let Err(error) = outcome {
            let message = error.to_string();
            // The message of the net below the checks of glTF: nothing should fall into it.
            assert!(!message.contains("not understood"), "{what}: panicked within");
            let folder = self.folder.path().display().to_string();
            // The indented lines below a message show the place in the file.
            let mut messages = message.lines().filter(|line| !line.starts_with(' '));
            assert!(messages.all(|line| line.contains(&folder)), "{what}: {message}");
        }
    }
}

/// Copies what a file may refer to: all that is not long, some levels deep. Images of more than 4 kB become one of a few pixels,
/// because they are decoded each time.
fn copy_below(from: &Path, to: &Path, levels: u32) {
    for path in fs::read_dir(from).unwrap().map(|entry| entry.unwrap().path()) {
        let copy = to.join(path.file_name().unwrap());
        if path.is_dir() && levels > 0 {
            fs::create_dir(&copy).unwrap();
            copy_below(&path, &copy, levels - 1);
        } else if IMAGES.contains(&extension(&path)) && fs::metadata(&path).unwrap().len() > 4096 {
            fs::write(copy, include_bytes!("../../../../fuzz/seeds/texture/LA.png")).unwrap();
        } else if path.is_file() && fs::metadata(&path).unwrap().len() < 1 << 20 {
            fs::copy(&path, copy).unwrap();
        }
    }
}
