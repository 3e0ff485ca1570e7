//! Files of a folder.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// All files below a folder with one of these extensions, sorted; none if the folder cannot be read.
pub fn files_below(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let (mut folders, mut found) = (vec![folder.to_owned()], Vec::new());
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| extensions.iter().any(|extension| e == *extension)) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}
