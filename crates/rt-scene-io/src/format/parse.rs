//! Text to [`SceneFile`].

use std::path::Path;

use ron::extensions::Extensions;

use super::SceneFile;
use crate::limits::NESTING;
use crate::{LoadError, Place, Reason};

/// The limit that RON's parser needs for it: it counts each bracket twice.
const RON_RECURSION_LIMIT: usize = NESTING * 2;

/// RON as scene files use it: optional values are written without `Some`.
pub(super) fn ron_options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME).with_recursion_limit(RON_RECURSION_LIMIT)
}

/// Parses a scene in RON. `name` is the file named in messages.
///
/// # Errors
/// If the text is no scene, with the line and column. Values are not checked yet: [`resolve`](crate::resolve) does.
pub fn parse_ron(text: &str, name: &Path) -> Result<SceneFile, LoadError> {
    ron_options().from_str(text).map_err(|error| {
        let (line, column) = (error.span.end.line, error.span.end.col);
        let reason = ron_reason(error.code);
        // The parser has read past a word by the time it finds it unknown.
        let back = if let Reason::UnknownWord { found, .. } = &reason { found.chars().count() } else { 0 };
        reason.at(name, Place::Position(line, column.saturating_sub(back)))
    })
}

/// Parses a scene in JSON. `name` is the file named in messages.
///
/// # Errors
/// As [`parse_ron`].
pub fn parse_json(text: &str, name: &Path) -> Result<SceneFile, LoadError> {
    serde_json::from_str(text).map_err(|error| {
        let message = error.to_string();
        // The place is told apart from the message here.
        let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(message, _)| message);
        let reason = json_reason(message);
        // As above, with two quotes around the word. Columns of serde_json count what has been read.
        let back = if let Reason::UnknownWord { found, .. } = &reason { found.len() + 1 } else { 0 };
        reason.at(name, Place::Position(error.line(), error.column().saturating_sub(back).max(1)))
    })
}

fn ron_reason(error: ron::Error) -> Reason {
    let words = |known: &[&str]| known.iter().map(|&word| word.to_owned()).collect();
    match error {
        ron::Error::NoSuchStructField { expected, found, .. } => {
            Reason::UnknownWord { kind: "field", found, known: words(expected) }
        }
        ron::Error::NoSuchEnumVariant { expected, found, .. } => {
            Reason::UnknownWord { kind: "choice", found, known: words(expected) }
        }
        ron::Error::MissingStructField { field, outer } => Reason::Syntax(match outer {
            Some(outer) => format!("`{outer}` needs the field `{field}`"),
            None => format!("the field `{field}` is needed"),
        }),
        ron::Error::InvalidIdentifier(word) | ron::Error::SuggestRawIdentifier(word) => {
            Reason::Syntax(format!("`{word}` is not the name of a field (decimals are written with a point)"))
        }
        ron::Error::ExceededRecursionLimit => too_deep(),
        other => {
            let message = other.to_string();
            let mut rest = message.chars();
            let first = rest.next().map(|c| c.to_lowercase().to_string()).unwrap_or_default();
            Reason::Syntax(first + rest.as_str())
        }
    }
}

/// Serde's messages for JSON quote the words in backticks: "unknown field `a`, expected one of `b`, `c`".
fn json_reason(message: &str) -> Reason {
    let kind = if message.starts_with("unknown field `") {
        "field"
    } else if message.starts_with("unknown variant `") {
        "choice"
    } else if message.starts_with("recursion limit exceeded") {
        return too_deep();
    } else {
        return Reason::Syntax(message.to_owned());
    };
    let mut words = message.split('`').skip(1).step_by(2).map(str::to_owned);
    Reason::UnknownWord { kind, found: words.next().unwrap_or_default(), known: words.collect() }
}

fn too_deep() -> Reason {
    Reason::Syntax(format!("brackets are nested deeper than {NESTING}; flatten the tree or use groups"))
}
