//! Files that a scene refers to.

use std::path::Path;

use crate::LoadOptions;

/// Resolution of references: relative to the first file.
#[derive(Clone, Copy)]
pub(super) struct FileScope<'a> {
    pub(super) root_file: &'a Path,
    pub(super) options: &'a LoadOptions,
}
