//! Text to [`SceneFile`].

use std::path::Path;

use ron::extensions::Extensions;

use super::SceneFile;
use super::expected::Notation;
use super::parse_error::{Explainer, ParseError};
use crate::excerpt::{Excerpt, Position};
use crate::limits::NESTING;
use crate::{Diagnostic, LoadError, Location};

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
    ron_options()
        .from_str(text)
        .map_err(|error| located(text, name, Explainer::new(text, Notation::Ron).ron(error, text, 0)))
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
        located(text, name, Explainer::new(text, Notation::Json).json(message, error.line(), error.column()))
    })
}

/// A mistake with its line.
fn located(text: &str, name: &Path, ParseError { at, kind }: ParseError) -> LoadError {
    let Position { line, column } = Position::of(text, at);
    let excerpt = (!text.trim().is_empty()).then(|| Excerpt::of(text, at));
    let location = Location::Position(line, column);
    LoadError::from(Diagnostic { file: name.display().to_string(), location, kind, excerpt })
}
