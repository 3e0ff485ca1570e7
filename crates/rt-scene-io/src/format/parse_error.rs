//! Errors of the parsers of RON and JSON, translated to mistakes with advice.

use ron::error::SpannedError;
use serde::de::Deserialize;

use super::advice::{Explainer, ParseError};
use super::cursor::{Cursor, Key, TextValue, TokenClass, next, value_end};
use super::material::NodeMaterial;
use super::ron_options::ron_options;
use super::spelling::{Choice, NO_SPELLING};
use super::{Color, ColorTexture};
use crate::LoadErrorKind;
use crate::excerpt::{Position, floor, line_start};
use crate::limits::NESTING;

impl<'t> Explainer<'t> {
    /// An error of `ron` in `part` of the text, which begins at the byte `base`.
    pub(super) fn ron(&self, error: SpannedError, part: &str, base: usize) -> ParseError {
        use ron::Error as Ron;
        let end = Position { line: error.span.end.line, column: error.span.end.col };
        let mut at = base + end.byte(part);
        let mut cursor = Cursor::before(self.text, at);
        // Within a word that may have been something else: `r` begins a raw text.
        if let Some(start) = cursor.last().filter(|last| last.range.end > at).map(|last| last.range.start) {
            (at, cursor) = (start, Cursor::before(self.text, start));
        }
        if let Some(comma) = self.stray_comma(at) {
            return ParseError::new(comma, "unexpected `,`: remove it");
        }
        match error.code {
            Ron::Message(message) if message == NO_SPELLING => self.no_spelling(&cursor, at),
            Ron::Message(message) => ParseError::new(at, message),
            // The parser has read past a word by the time it finds it unknown.
            Ron::NoSuchStructField { expected, found, .. } => {
                self.unknown_field(at.saturating_sub(found.len()), &found, expected)
            }
            Ron::NoSuchEnumVariant { expected, found, .. } => {
                self.unknown_choice(at.saturating_sub(found.len()), &found, expected)
            }
            Ron::MissingStructField { field, .. } => self.missing_field(&cursor, at, field),
            Ron::DuplicateStructField { field, .. } => self.duplicate_field(&cursor, at, field),
            Ron::InvalidIdentifier(word) | Ron::SuggestRawIdentifier(word)
                if word.contains('-') && word.starts_with(char::is_alphabetic) =>
            {
                let advice = format!("names have underscores: write `{}` instead of `{word}`", word.replace('-', "_"));
                ParseError::new(at, advice)
            }
            Ron::InvalidIdentifier(word) | Ron::SuggestRawIdentifier(word) => self.no_name(&cursor, at, &word),
            Ron::ExceededRecursionLimit => ParseError { at, kind: too_deep() },
            Ron::Eof => self.early_end(),
            Ron::ExpectedStringEnd => ParseError::new(at, "a string has no closing quote"),
            Ron::ExpectedMapColon if self.text[at..].starts_with('=') => {
                ParseError::new(at, "expected `:` after the name of a field, found `=`")
            }
            Ron::ExpectedMapColon => ParseError::new(at, "expected `:` after a name"),
            Ron::TrailingCharacters => ParseError::new(at, "unexpected text after the end of the scene: remove it"),
            Ron::ExpectedArrayEnd | Ron::ExpectedMapEnd | Ron::ExpectedStructLikeEnd | Ron::ExpectedComma => {
                self.end_of_group(&cursor, at)
            }
            Ron::ExpectedDifferentLength { .. } => self.wrong_value(self.group_at(&cursor, at), at),
            Ron::InvalidValueForType { .. } | Ron::UnexpectedChar(_) if self.stands_behind_value(&cursor, at) => {
                self.wrong_value(cursor.last(), at)
            }
            Ron::IntegerOutOfBounds if self.stands_behind_value(&cursor, at) => self.wrong_value(cursor.last(), at),
            code @ (Ron::InvalidEscape(_)
            | Ron::InvalidIntegerDigit { .. }
            | Ron::NoSuchExtension(_)
            | Ron::UnclosedBlockComment
            | Ron::UnclosedLineComment
            | Ron::FloatUnderscore
            | Ron::UnderscoreAtBeginning
            | Ron::ExpectedAttribute
            | Ron::ExpectedAttributeEnd
            | Ron::Utf8Error(_)) => ParseError::new(at, lower(&code.to_string())),
            _ => self.other_type(&cursor, at),
        }
    }

    /// Translates an error of `serde_json`: its message without the location.
    pub(super) fn json(&self, message: &str, line: usize, column: usize) -> ParseError {
        // Columns of serde_json count the bytes of the line that have been read.
        let at = floor(self.text, line_start(self.text, line) + column);
        let cursor = Cursor::before(self.text, at);
        let last = cursor.last().map_or(at, |value| value.range.start);
        let words = || message.split('`').skip(1).step_by(2);
        let known = || words().skip(1).collect::<Vec<_>>();
        let found = || words().next().unwrap_or_default();
        let starts = |start: &str| message.starts_with(start);
        if let ("expected value" | "trailing comma", Some(error)) = (message, self.second_choice(at)) {
            error
        } else if message.contains("unit variant, expected") {
            // The parser reports it after the object around the value.
            self.wrong_value(Cursor::before(self.text, at.saturating_sub(1)).last(), at)
        } else if (starts("invalid type: map") || starts("invalid type: sequence"))
            && let Some(start) = next(self.text, at).filter(|start| self.text[*start..].starts_with(['{', '[']))
        {
            // The parser reports the bracket that it has not read yet.
            let value = TextValue { range: start..value_end(self.text, start), path: cursor.path() };
            self.wrong_value(Some(value), start)
        } else if message == NO_SPELLING || starts("invalid type") || starts("invalid value") {
            let value = match cursor.last_token {
                TokenClass::Open => cursor.group(self.text),
                _ => cursor.last(),
            };
            self.wrong_value(value, at)
        } else if starts("invalid length") || self.is_too_long(&cursor) {
            let value = if cursor.last_token == TokenClass::Close { cursor.last() } else { cursor.group(self.text) };
            self.wrong_value(value, at)
        } else if starts("unknown field `") {
            self.unknown_field(last, found(), &known())
        } else if starts("unknown variant `") {
            self.unknown_choice(last, found(), &known())
        } else if starts("missing field `") {
            self.missing_field(&cursor, at, found())
        } else if starts("duplicate field `") {
            self.duplicate_field(&cursor, last, found())
        } else if starts("recursion limit exceeded") {
            ParseError { at: at.saturating_sub(1), kind: too_deep() }
        } else if starts("EOF") {
            self.early_end()
        } else if message == "expected value" && self.stands_before_value(at) {
            // The parser reports the first byte of a value of another type.
            let start = at.saturating_sub(1);
            let path = Cursor::before(self.text, start).path();
            self.wrong_value(Some(TextValue { range: start..value_end(self.text, start), path }), start)
        } else {
            let message = match message {
                "trailing comma" => "trailing comma before a closing bracket: remove it",
                "expected `:`" => "expected `:` after a name",
                "expected value" if next(self.text, 0) == Some(at.saturating_sub(1)) => return self.no_scene(),
                "expected value" => "expected a value",
                "key must be a string" => "expected the name of a field in double quotes",
                "trailing characters" => "unexpected text after the end of the scene: remove it",
                message if starts("expected `,` or") => {
                    let bracket = message.chars().rev().nth(1).unwrap_or_default();
                    return ParseError::new(
                        at.saturating_sub(1),
                        format!("expected a comma or `{bracket}` before this"),
                    );
                }
                other => other,
            };
            ParseError::new(at.saturating_sub(1), message)
        }
    }

    /// Error of a JSON object with two choices. The parser has reached the comma between them, or read it.
    fn second_choice(&self, at: usize) -> Option<ParseError> {
        let is_comma = |at: &usize| self.text.as_bytes().get(*at) == Some(&b',');
        let comma = [at, at.saturating_sub(1)].into_iter().find(is_comma)?;
        let cursor = Cursor::before(self.text, comma);
        let path = cursor.path();
        let Key::Name(first) = path.last()? else { return None };
        let start = next(self.text, comma + 1).filter(|start| self.text[*start..].starts_with('"'))?;
        let second = self.text[start..value_end(self.text, start)].trim_matches('"');
        let choices = self.schema.slot(&cursor.container())?.choices();
        choices.iter().any(|(name, _)| name == first).then(|| {
            let message = format!("`{first}` and `{second}` are two choices in one object: remove one of them");
            ParseError::new(start, message)
        })
    }

    /// A value that has none of its spellings has been read.
    fn no_spelling(&self, cursor: &Cursor<'t>, at: usize) -> ParseError {
        let Some(value) = cursor.last() else { return ParseError::new(at, "expected another value") };
        let given = &self.text[value.range.clone()];
        let is_choice = given.starts_with(|c: char| c.is_alphabetic() || c == '_') && !given.starts_with("r\"");
        let definition = self.schema.slot(&value.path).and_then(|slot| slot.definition);
        if is_choice && given.ends_with(')') {
            let inner = match definition {
                Some("Color") => error_of::<Choice<Color>>(given),
                Some("ColorTexture") => error_of::<Choice<ColorTexture>>(given),
                _ => error_of::<Choice<NodeMaterial>>(given),
            };
            if let Some(error) = inner {
                return self.ron(error, given, value.range.start);
            }
        }
        if is_choice && definition == Some("NodeMaterial") {
            let message =
                format!("`{given}` is not a kind of material; put the name of a material in quotes: \"{given}\"");
            return ParseError::new(value.range.start, message);
        }
        self.wrong_value(Some(value), at)
    }

    /// A comma at the position that follows another one, or an opening bracket.
    fn stray_comma(&self, at: usize) -> Option<usize> {
        let comma = next(self.text, at).filter(|comma| self.text[*comma..].starts_with(','))?;
        self.text[..comma].trim_end().ends_with([',', '(', '[', '{']).then_some(comma)
    }

    /// True if the byte before `at` begins a number, a word or a bracket of JSON.
    fn stands_before_value(&self, at: usize) -> bool {
        let byte = at.checked_sub(1).and_then(|at| self.text.as_bytes().get(at));
        byte.is_some_and(|byte| byte.is_ascii_digit() || b"-[tfn".contains(byte))
    }

    /// The innermost group, or the one that has just ended.
    fn group_at(&self, cursor: &Cursor<'t>, at: usize) -> Option<TextValue<'t>> {
        let goes_on = next(self.text, at).is_some_and(|next| self.text[next..].starts_with([')', ']']));
        if cursor.last_token == TokenClass::Close && !goes_on { cursor.last() } else { cursor.group(self.text) }
    }

    fn is_too_long(&self, cursor: &Cursor<'t>) -> bool {
        let (Some(frame), Some(slot)) = (cursor.brackets.last(), self.schema.slot(&cursor.container())) else {
            return false;
        };
        frame.bracket == b'[' && slot.fixed_length().is_some_and(|length| frame.index >= length)
    }
}

/// The error of a value that is read by itself.
fn error_of<'de, T: Deserialize<'de>>(text: &'de str) -> Option<SpannedError> {
    ron_options().from_str::<T>(text).err()
}

fn lower(message: &str) -> String {
    let mut rest = message.chars();
    let first = rest.next().map(|c| c.to_lowercase().to_string()).unwrap_or_default();
    first + rest.as_str()
}

fn too_deep() -> LoadErrorKind {
    LoadErrorKind::Syntax(format!("brackets are nested deeper than {NESTING}; flatten the tree or use groups"))
}
