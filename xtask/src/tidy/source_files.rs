//! The length of source files: one idea per file.

const LONG: usize = 400;
const TOO_LONG: usize = 700;

/// Breach of a file that is too long; a warning for a long one.
pub(super) fn breaches(path: &str, source: &str) -> Vec<String> {
    match source.lines().count() {
        lines if !path.ends_with(".rs") || lines <= LONG => Vec::new(),
        lines if lines > TOO_LONG => vec![format!("{path}: {lines} lines, the limit is {TOO_LONG}")],
        lines => {
            println!("warning: source files: {path}: {lines} lines");
            Vec::new()
        }
    }
}
