//! Location of the last checkpoint, and the options that continue from it.

use std::path::PathBuf;

/// Last checkpoint of an unfinished render.
#[derive(Debug)]
pub(crate) struct SavedCheckpoint {
    pub(crate) file: PathBuf,
    /// True in a fallback directory, where `--resume` alone does not find it.
    pub(crate) is_elsewhere: bool,
}

impl SavedCheckpoint {
    /// Options that continue from it, and their effect: `verb` is what they do.
    pub(crate) fn advice(&self, verb: &str) -> String {
        let file = self.file.display();
        if self.is_elsewhere {
            format!("--resume --checkpoint {file} {verb}")
        } else {
            format!("--resume {verb} from {file}")
        }
    }
}
