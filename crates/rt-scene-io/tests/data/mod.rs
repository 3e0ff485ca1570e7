//! The folder of test data, and ways to damage its files.

#![allow(clippy::print_stdout, reason = "a skipped test says so")]

use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use rt_scene_io::{LoadOptions, load_model};

/// The folder of test data; prints a line where it is missing.
pub(crate) fn data() -> Option<PathBuf> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data"));
    if !folder.is_dir() {
        println!("skipped: there is no {}", folder.display());
        return None;
    }
    Some(folder.to_owned())
}

/// All files below a folder with one of these endings, in order.
pub(crate) fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
            if path.is_dir() {
                folders.push(path);
            } else if endings.contains(&ending) {
                found.push(path);
            }
        }
    }
    assert!(!found.is_empty());
    found.sort();
    found
}

/// Whether a file is small enough to be loaded some hundred times.
pub(crate) fn is_small(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|about| about.len() < 40_000)
}

/// Loads `bytes` in place of `file`, beside copies of the other files of its folder. Whatever the outcome, it must
/// come in time and without a panic.
fn load_damaged(file: &Path, folder: &Path, bytes: &[u8], what: &str) {
    let place = folder.join(file.file_name().expect("a name"));
    fs::write(&place, bytes).expect("written");
    let start = Instant::now();
    let outcome = catch_unwind(AssertUnwindSafe(|| load_model(&place, &LoadOptions::default()).map(|_| ())));
    let Ok(outcome) = outcome else { panic!("{} {what}: panicked", file.display()) };
    // The message of the net below the checks: nothing should fall into it.
    let caught = outcome.is_err_and(|error| error.to_string().contains("not understood"));
    assert!(!caught, "{} {what}: panicked within", file.display());
    assert!(start.elapsed() < Duration::from_secs(5), "{} {what}: took {:?}", file.display(), start.elapsed());
}

fn beside(file: &Path) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for entry in fs::read_dir(file.parent().expect("a folder")).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_file() && fs::metadata(&path).expect("a size").len() < 1 << 20 {
            fs::copy(&path, folder.path().join(path.file_name().expect("a name"))).expect("copied");
        }
    }
    folder
}

/// Loads the file cut off at many lengths: everywhere near its ends, here and there in between.
pub(crate) fn truncate(file: &Path) {
    let bytes = fs::read(file).expect("a file");
    let folder = beside(file);
    let step = (bytes.len() / 30).max(1);
    let ends = (0..bytes.len().min(12)).chain(bytes.len().saturating_sub(12)..bytes.len());
    for length in ends.chain((0..bytes.len()).step_by(step)) {
        load_damaged(file, folder.path(), &bytes[..length], &format!("cut at {length}"));
    }
}

/// Loads the file with a few bytes changed, `rounds` times.
pub(crate) fn mutate(file: &Path, rounds: u64) {
    let original = fs::read(file).expect("a file");
    if original.is_empty() {
        return;
    }
    let folder = beside(file);
    for seed in 0..rounds {
        let mut bytes = original.clone();
        for change in 0..1 + seed % 4 {
            let random = |purpose: u64| rt_math::random::hash(&[seed, change, purpose]);
            let at = (random(0) % bytes.len() as u64) as usize;
            let other = (random(1) % bytes.len() as u64) as usize;
            match random(2) % 4 {
                0 => bytes[at] = random(3) as u8,
                1 => bytes[at] = b"0123456789-.e/\"[]{},"[(random(3) % 20) as usize],
                2 => bytes[at] = bytes[other],
                _ => bytes[at] ^= 1 << (random(3) % 8),
            }
        }
        load_damaged(file, folder.path(), &bytes, &format!("mutated with seed {seed}"));
    }
}
