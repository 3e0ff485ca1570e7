//! The folder of test data.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// Folder of test data; skips the test where it is missing.
#[track_caller]
pub(crate) fn data() -> Option<PathBuf> {
    rt_tests::shared_or_skip("data")
}

#[allow(dead_code, reason = "not every test looks for files")]
/// All files below a folder with one of these extensions, in order.
pub(crate) fn files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
            if path.is_dir() {
                folders.push(path);
            } else if extensions.contains(&extension) {
                found.push(path);
            }
        }
    }
    assert!(!found.is_empty());
    found.sort();
    found
}
