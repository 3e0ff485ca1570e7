//! Mistakes in scene files, with advice: what is wrong, and what to write instead.

use super::cursor::{Cursor, Key, TextValue, TokenClass, next, value_end};
use super::deprecated;
use super::expected::{Notation, Schema, Slot};
use super::synonyms::{Meant, meant};
use crate::excerpt::Position;
use crate::{LoadErrorKind, error::suggestion};

/// Characters of a wrong value that a message shows.
const SHOWN: usize = 40;

/// A mistake, and the byte at which it is.
pub(super) struct ParseError {
    pub(super) at: usize,
    pub(super) kind: LoadErrorKind,
}

impl ParseError {
    pub(super) fn new(at: usize, message: impl Into<String>) -> Self {
        Self { at, kind: LoadErrorKind::Syntax(message.into()) }
    }
}

/// Finds words for the errors of one text.
pub(super) struct Explainer<'t> {
    pub(super) text: &'t str,
    notation: Notation,
    pub(super) schema: Schema,
}

impl<'t> Explainer<'t> {
    pub(super) fn new(text: &'t str, notation: Notation) -> Self {
        Self { text, notation, schema: Schema::new() }
    }

    /// A word or number stands where the name of a field or a choice is expected.
    pub(super) fn no_name(&self, cursor: &Cursor<'t>, at: usize, word: &str) -> ParseError {
        if cursor.expects_value() {
            return self.other_type(cursor, at);
        }
        let is_digit = |c: char| c.is_ascii_digit();
        let is_decimal = word.starts_with(is_digit)
            && self.text[..at].trim_end().strip_suffix(',').is_some_and(|before| before.ends_with(is_digit));
        let hint = if is_decimal {
            " (decimals are written with a point)".to_owned()
        } else {
            let fields = self.schema.slot(&cursor.container()).map(|slot| slot.fields()).unwrap_or_default();
            if fields.is_empty() { String::new() } else { suggestion(None, &fields) }
        };
        ParseError::new(at, format!("expected the name of a field, found `{word}`{hint}"))
    }

    /// A field is given twice, perhaps under a deprecated name.
    pub(super) fn duplicate_field(&self, cursor: &Cursor<'t>, at: usize, field: &str) -> ParseError {
        let spelling = cursor.group(self.text).and_then(|group| {
            let container = cursor.container();
            let parent =
                container.last().and_then(|key| if let Key::Name(parent) = key { Some(*parent) } else { None });
            let end = group.range.end;
            let mut found = None;
            Cursor::walk(self.text, end, |inner, name, start| {
                if start >= group.range.start
                    && inner.container() == container
                    && deprecated::present_spellings(name, parent).any(|present| present == field)
                {
                    found = Some((start, name));
                }
            });
            found
        });
        match spelling {
            Some((start, old)) => {
                ParseError::new(start, format!("`{old}` and `{field}` are the same field: remove `{old}`"))
            }
            None => ParseError::new(at, format!("the field `{field}` is given twice")),
        }
    }

    pub(super) fn unknown_field(&self, at: usize, found: &str, known: &[&str]) -> ParseError {
        let path = Cursor::before(self.text, at).container();
        let slot = self.schema.slot(&path);
        let context = slot.as_ref().map(|slot| slot.context).unwrap_or_default();
        let place = if context.is_empty() { String::new() } else { format!(" in {}", called(context)) };
        // The parser lists aliases as well, the schema does not.
        let in_schema = |word: &&&str| slot.as_ref().is_some_and(|slot| slot.has_field(word));
        let named: Vec<&str> = known.iter().filter(in_schema).copied().collect();
        let hint = self.hint(context, found, if named.is_empty() { known } else { &named });
        ParseError::new(at, format!("unknown field `{found}`{place}{hint}"))
    }

    pub(super) fn unknown_choice(&self, at: usize, found: &str, known: &[&str]) -> ParseError {
        let path = Cursor::before(self.text, at).path();
        // In JSON a choice is the name of a field within an object, where it is a path of its own.
        let path = match (path.last(), self.notation) {
            (Some(Key::Index(_)), Notation::Json) => &path[..path.len() - 1],
            _ => &path[..],
        };
        let slot = self.schema.slot(path);
        let context = slot.as_ref().and_then(|slot| slot.definition).unwrap_or_default();
        let place = field_of(path).map_or_else(String::new, |field| format!(" for `{field}`"));
        // The parser lists aliases as well, the schema does not.
        let choices = slot.map(|slot| slot.choices()).unwrap_or_default();
        let is_alias = |word: &&&str| !choices.is_empty() && !choices.iter().any(|(name, _)| name == *word);
        let named: Vec<&str> = known.iter().filter(|word| !is_alias(word)).copied().collect();
        let hint = self.hint(context, found, if named.is_empty() { known } else { &named });
        ParseError::new(at, format!("unknown choice `{found}`{place}{hint}"))
    }

    /// Most likely word, and the valid ones.
    fn hint(&self, context: &str, found: &str, known: &[&str]) -> String {
        let known: Vec<String> =
            known.iter().filter(|word| !word.starts_with('$')).map(|&word| word.to_owned()).collect();
        match meant(context, found) {
            Some(Meant::Word(word)) if known.iter().any(|known| known == word) => suggestion(Some(word), &known),
            Some(Meant::Written(form)) if self.notation == Notation::Ron => format!("; write {form}"),
            Some(Meant::Written(form)) => format!("; in the notation of .ron files, write {form}"),
            Some(Meant::Word(_)) | None => suggestion(crate::error::nearest(found, &known), &known),
        }
    }

    pub(super) fn missing_field(&self, cursor: &Cursor<'t>, at: usize, field: &str) -> ParseError {
        // Only JSON's parser has read the closing bracket by then.
        let value = match (cursor.last_token, self.notation) {
            (TokenClass::Close, Notation::Json) => cursor.last(),
            _ => cursor.group(self.text),
        };
        let Some(TextValue { range, mut path }) = value else {
            return ParseError::new(at, format!("the scene needs the field `{field}`"));
        };
        // A choice stands before its parenthesis.
        let name = self.text[range.clone()].split('(').next().map(str::trim).filter(|name| !name.is_empty());
        if let (Some(name), Notation::Ron) = (name, self.notation) {
            path.push(Key::Name(name));
        }
        let context = match self.schema.slot(&path).map(|slot| slot.context) {
            Some("Scene") => "the scene".to_owned(),
            Some(context) => format!("`{}`", called(context)),
            None => "this".to_owned(),
        };
        ParseError::new(range.start, format!("{context} needs the field `{field}`"))
    }

    /// A value of another type is here, or has just been read.
    pub(super) fn other_type(&self, cursor: &Cursor<'t>, at: usize) -> ParseError {
        let Some(start) = next(self.text, at) else { return self.early_end() };
        // A name in braces without quotes.
        if let Some(frame) = cursor.brackets.last().filter(|frame| frame.bracket == b'{')
            && matches!(cursor.last_token, TokenClass::Open | TokenClass::Mark)
            && self.text[frame.start..].starts_with('{')
            && self.schema.slot(&cursor.container()).is_some_and(|slot| slot.is_map())
        {
            let word = &self.text[start..value_end(self.text, start)];
            let after = next(self.text, start + word.len()).map_or("", |next| &self.text[next..]);
            if after.starts_with(':') {
                return ParseError::new(start, format!("put the name in quotes: \"{word}\""));
            }
        }
        if self.stands_behind_value(cursor, at) || self.text[start..].starts_with([')', ']', '}', ',']) {
            return self.wrong_value(cursor.last(), at);
        }
        let value = TextValue { range: start..value_end(self.text, start), path: cursor.path() };
        self.wrong_value(Some(value), at)
    }

    /// True if the last token before the position is a complete value.
    pub(super) fn stands_behind_value(&self, cursor: &Cursor<'t>, at: usize) -> bool {
        let is_key = next(self.text, at).is_some_and(|next| self.text[next..].starts_with(':'));
        matches!(cursor.last_token, TokenClass::Value | TokenClass::Close) && !is_key
    }

    /// Notation of a choice with fields or a value, and the words for that value.
    fn form_of<'n>(&self, path: &[Key<'n>], name: &'n str) -> (String, Option<String>) {
        let inner = self.schema.slot(&[path, &[Key::Name(name)]].concat());
        let required = inner.as_ref().and_then(Slot::required_fields);
        let given = |fields: &[&str], quote: &str| -> String {
            let given: Vec<String> = fields.iter().map(|field| format!("{quote}{field}{quote}: ...")).collect();
            given.join(", ")
        };
        match (required, self.notation) {
            (Some(fields), Notation::Ron) => (format!("{name}({})", given(&fields, "")), None),
            (Some(fields), Notation::Json) => (format!("{{\"{name}\": {{{}}}}}", given(&fields, "\"")), None),
            (None, notation) => {
                let outer = self.schema.slot(path).filter(|_| notation == Notation::Ron);
                if let Some((_, count)) = outer.and_then(|outer| outer.value_count(name)) {
                    return (format!("{name}(...)"), Some(format!("{count} values")));
                }
                let words = inner.map_or_else(|| "a value".to_owned(), |inner| inner.words(notation));
                let form = match notation {
                    Notation::Ron => format!("{name}(...)"),
                    Notation::Json => format!("{{\"{name}\": ...}}"),
                };
                (form, Some(words))
            }
        }
    }

    /// Reports a value at a place where the schema has nothing, such as that of a choice without values.
    fn no_value_of(&self, path: &[Key<'t>], start: usize, at: usize) -> ParseError {
        if let Some((Key::Name(name), outer)) = path.split_last()
            && let Some(slot) = self.schema.slot(outer)
            && slot.choices().contains(&(*name, false))
        {
            return ParseError::new(start, format!("`{name}` takes no value: write \"{name}\" instead of the object"));
        }
        match self.text[at..].chars().next() {
            Some(bracket @ (')' | ']' | '}')) => ParseError::new(at, format!("unexpected `{bracket}`: remove it")),
            _ => ParseError::new(at, "unexpected value"),
        }
    }

    /// Reports a value of the wrong type or form.
    pub(super) fn wrong_value(&self, value: Option<TextValue<'t>>, at: usize) -> ParseError {
        let Some(TextValue { range, path }) = value else { return self.early_end() };
        let given = &self.text[range.clone()];
        let Some(slot) = self.schema.slot(&path) else { return self.no_value_of(&path, range.start, at) };
        let word = given.trim_matches('"');
        let chosen = slot.choices().into_iter().find(|(name, _)| *name == word);
        if self.notation == Notation::Ron
            && let Some((name, count)) = given.split_once('(').and_then(|(name, _)| slot.value_count(name.trim_end()))
        {
            return ParseError::new(range.start, format!("`{name}` takes {count} values, found {}", shown(given)));
        }
        let place = field_of(&path).map_or_else(String::new, |field| format!(" for `{field}`"));
        let hint = match (chosen, self.notation) {
            (Some((name, true)), Notation::Ron) if given == word => {
                let (form, value) = self.form_of(&path, name);
                let is_empty = next(self.text, range.end).is_some_and(|next| self.text[next..].starts_with('('));
                let message = match value {
                    Some(value) if is_empty => format!("`{name}` needs a value in its parentheses: {value}"),
                    Some(value) => format!("`{name}` needs a value in parentheses, `{form}`: {value}"),
                    None => format!("`{name}` needs parentheses: `{form}`"),
                };
                return ParseError::new(range.start, message);
            }
            (Some((name, false)), Notation::Ron) => format!("; write `{name}` without quotes"),
            (Some((name, true)), notation) => {
                let (form, value) = self.form_of(&path, name);
                let with = value.map(|value| format!(", with {value}")).unwrap_or_default();
                match notation {
                    Notation::Ron => {
                        let form = form.strip_suffix("()").unwrap_or(&form);
                        format!("; write `{form}` without quotes{with}")
                    }
                    Notation::Json => format!("; write {form}{with}"),
                }
            }
            _ if path.is_empty() => hint_of_notation(given, self.notation).to_owned(),
            _ => hint_of_brackets(&slot, given, self.notation).to_owned(),
        };
        let expected = slot.words(self.notation);
        ParseError::new(range.start, format!("expected {expected}{place}, found {}{hint}", shown(given)))
    }

    /// A group should end here, or go on after a comma.
    pub(super) fn end_of_group(&self, cursor: &Cursor<'t>, at: usize) -> ParseError {
        let Some(frame) = cursor.brackets.last() else {
            return ParseError::new(at, "unexpected text after the end of the scene: remove it");
        };
        let Some(start) = next(self.text, at) else { return self.early_end() };
        let length = self.schema.slot(&cursor.container()).and_then(|slot| slot.fixed_length());
        if length.is_some_and(|length| frame.index >= length) {
            return self.wrong_value(cursor.group(self.text), at);
        }
        let closing = closing(frame.bracket);
        match self.text.as_bytes()[start] {
            bracket @ (b')' | b']' | b'}') => {
                ParseError::new(start, format!("`{closing}` is missing before `{}`", char::from(bracket)))
            }
            b'=' => ParseError::new(start, "expected `:` after the name of a field, found `=`"),
            b'(' if self.is_plain_choice(cursor) => {
                ParseError::new(start, "this choice takes no value: remove the parentheses")
            }
            // A value may stand here, but not this one.
            _ if matches!(cursor.last_token, TokenClass::Open | TokenClass::Mark) => self.unfit_value(cursor, start),
            _ => ParseError::new(start, format!("expected a comma or `{closing}` before this")),
        }
    }

    /// True behind the name of a choice without fields and values.
    fn is_plain_choice(&self, cursor: &Cursor<'t>) -> bool {
        cursor.last_token == TokenClass::Value
            && cursor.last().is_some_and(|TextValue { range, path }| {
                let slot = self.schema.slot(&path);
                slot.is_some_and(|slot| slot.choices().contains(&(&self.text[range], false)))
            })
    }

    /// A value whose beginning fits, such as 1.5 where a whole number is expected, or one too many for a choice.
    fn unfit_value(&self, cursor: &Cursor<'t>, start: usize) -> ParseError {
        let path = cursor.path();
        let is_further = matches!(path.last(), Some(Key::Argument(1..)));
        let name = cursor.brackets.last().filter(|frame| frame.bracket == b'(' && is_further);
        match name.map(|frame| &self.text[frame.start..frame.bracket_at]) {
            Some(name) if !name.is_empty() => {
                ParseError::new(start, format!("`{name}` takes one value: remove this one"))
            }
            _ => self.wrong_value(Some(TextValue { range: start..value_end(self.text, start), path }), start),
        }
    }

    /// The text begins with something else than a scene.
    pub(super) fn no_scene(&self) -> ParseError {
        let opening = if self.notation == Notation::Ron { '(' } else { '{' };
        let expected = format!("expected a scene, which begins with `{opening}`");
        let start = next(self.text, 0).unwrap_or(self.text.len());
        let Some(word) = self.text[start..].split_whitespace().next() else {
            return ParseError::new(start, expected);
        };
        let hint = hint_of_notation(word, self.notation);
        ParseError::new(start, format!("{expected}, found {}{hint}", shown(word)))
    }

    /// The text ends where more is needed.
    pub(super) fn early_end(&self) -> ParseError {
        let end = self.text.trim_end().len();
        let cursor = Cursor::before(self.text, self.text.len());
        match cursor.brackets.last() {
            None if end == 0 => ParseError::new(0, "the file contains no scene"),
            None => self.no_scene(),
            Some(frame) => {
                let Position { line, .. } = Position::of(self.text, frame.bracket_at);
                let (opening, closing) = (char::from(frame.bracket), closing(frame.bracket));
                let message = format!("the file ends too early: `{closing}` is missing for `{opening}` of line {line}");
                ParseError::new(end, message)
            }
        }
    }
}

/// The field that a path leads into.
fn field_of<'t>(path: &[Key<'t>]) -> Option<&'t str> {
    path.iter().rev().find_map(|key| match key {
        Key::Name(name) => Some(*name),
        Key::Index(_) | Key::Argument(_) => None,
    })
}

/// A type or choice as it is called in messages.
fn called(context: &str) -> String {
    let mut name = String::new();
    for (i, c) in context.char_indices() {
        if c.is_uppercase() && i > 0 {
            name.push(' ');
        }
        name.extend(c.to_lowercase());
    }
    name
}

/// Hint for a scene in the other notation.
fn hint_of_notation(given: &str, notation: Notation) -> &'static str {
    match notation {
        Notation::Ron if given.starts_with('{') => "; this is JSON: name the file .json",
        Notation::Json if given.starts_with('(') => "; this is RON: name the file .ron",
        _ => "",
    }
}

/// Hint for vectors in the brackets of the other notation.
fn hint_of_brackets(slot: &Slot<'_>, given: &str, notation: Notation) -> &'static str {
    match notation {
        Notation::Ron if slot.fixed_length().is_some() && given.starts_with('[') => "; write vectors in parentheses",
        _ => "",
    }
}

const fn closing(bracket: u8) -> char {
    match bracket {
        b'(' => ')',
        b'[' => ']',
        _ => '}',
    }
}

/// A value on one line, not too long.
fn shown(given: &str) -> String {
    let words: Vec<&str> = given.split_whitespace().collect();
    let given = words.join(" ");
    match given.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}...", &given[..end]),
        None => given,
    }
}
