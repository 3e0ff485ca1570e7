//! Text to [`SceneFile`].

use std::path::Path;

use serde::Deserialize;

use super::advice::{Explainer, ParseError};
use super::expected::Notation;
use super::named_fields::NamedFields;
use super::ron_options::ron_options;
use super::{SceneFile, deprecated};
use crate::excerpt::{Excerpt, Position};
use crate::{Diagnostic, LoadError, Location};

/// Parses a scene in RON. `name` is the file named in messages.
///
/// # Errors
/// If the text is no scene, with the line and column. Values are not checked yet: [`resolve`](crate::resolve) does.
pub fn parse_ron(text: &str, name: &Path) -> Result<SceneFile, LoadError> {
    let file = ron_options()
        .from_str(text)
        .map_err(|error| located(text, name, Explainer::new(text, Notation::Ron).ron(error, text, 0)))?;
    Ok(with_warnings(file, text, name))
}

/// Parses a scene in JSON. `name` is the file named in messages.
///
/// # Errors
/// Errors of [`parse_ron`].
pub fn parse_json(text: &str, name: &Path) -> Result<SceneFile, LoadError> {
    let file = scene_of_json(text).map_err(|error| {
        let message = error.to_string();
        // The location is reported apart from the message.
        let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(message, _)| message);
        located(text, name, Explainer::new(text, Notation::Json).json(message, error.line(), error.column()))
    })?;
    Ok(with_warnings(file, text, name))
}

fn scene_of_json(text: &str) -> serde_json::Result<SceneFile> {
    let mut reader = serde_json::Deserializer::from_str(text);
    let file = SceneFile::deserialize(NamedFields(&mut reader))?;
    reader.end()?;
    Ok(file)
}

fn with_warnings(file: SceneFile, text: &str, name: &Path) -> SceneFile {
    SceneFile { warnings: deprecated::warnings(text, &name.display().to_string()), ..file }
}

/// A mistake with its line.
fn located(text: &str, name: &Path, ParseError { at, kind }: ParseError) -> LoadError {
    let Position { line, column } = Position::of(text, at);
    let excerpt = (!text.trim().is_empty()).then(|| Excerpt::of(text, at));
    let location = Location::Position(line, column);
    LoadError::from(Diagnostic { file: name.display().to_string(), location, kind, excerpt })
}
