//! Text files, with errors that name them.

use std::{fs, path::Path};

use serde::de::DeserializeOwned;

use crate::error::TaskError;

pub(crate) fn read(path: &Path) -> Result<String, TaskError> {
    fs::read_to_string(path).map_err(TaskError::file(path))
}

/// Contents of a file; an empty text if there is none.
pub(crate) fn read_if_present(path: &Path) -> Result<String, TaskError> {
    if path.exists() { read(path) } else { Ok(String::new()) }
}

pub(crate) fn write(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), TaskError> {
    fs::write(path, contents).map_err(TaskError::file(path))
}

pub(crate) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, TaskError> {
    serde_json::from_str(&read(path)?).map_err(TaskError::file(path))
}

/// Replaces the part of a page between `<!-- NAME -->` and `<!-- /NAME -->`, each on a line of its own.
pub(crate) fn replace_block(path: &Path, name: &str, text: &str) -> Result<(), TaskError> {
    let replaced = with_block(&read(path)?, name, text);
    let replaced = replaced.map_err(|problem| TaskError::Other(format!("{}: {problem}", path.display())))?;
    write(path, replaced)
}

fn with_block(page: &str, name: &str, text: &str) -> Result<String, String> {
    let (start, end) = (format!("<!-- {name} -->\n"), format!("<!-- /{name} -->\n"));
    let parts = page.split_once(&start).and_then(|(before, rest)| Some((before, rest.split_once(&end)?.1)));
    let (before, after) = parts.ok_or_else(|| format!("there are no lines {} and {}", start.trim(), end.trim()))?;
    Ok(format!("{before}{start}{text}{end}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_block_is_replaced() {
        let page = "a\n<!-- table1 -->\nold\n<!-- /table1 -->\nb\n";
        assert_eq!(with_block(page, "table1", "new\n").unwrap(), "a\n<!-- table1 -->\nnew\n<!-- /table1 -->\nb\n");
        assert!(with_block("no markers", "table1", "new").is_err());
        assert!(with_block("<!-- table1 -->\n", "table1", "new").is_err());
    }
}
