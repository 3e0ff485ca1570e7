//! Path to a position in the text of a scene: names of fields and choices, and indices of lists.
//!
//! Parsers report the position of an error as line and column only. This scanner reads the text before it once more: brackets,
//! names before colons, and commas. That text is known to be valid.

use std::ops::Range;

/// A part of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Key<'t> {
    /// A field, a choice, or a name in a map.
    Name(&'t str),
    /// An element of a list.
    Index(usize),
    /// A value between the parentheses of a choice.
    Argument(usize),
}

/// A value in the text, and the path to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct TextValue<'t> {
    pub(super) range: Range<usize>,
    pub(super) path: Vec<Key<'t>>,
}

/// A bracket that is open.
#[derive(Clone, Debug)]
pub(super) struct OpenBracket<'t> {
    /// The beginning of the value: of the name before the bracket, if there is one.
    pub(super) start: usize,
    pub(super) bracket: u8,
    pub(super) bracket_at: usize,
    name: Option<&'t str>,
    key: Option<&'t str>,
    pub(super) index: usize,
}

/// Last token before a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TokenClass {
    Start,
    Open,
    Close,
    Value,
    Mark,
}

/// Position between two tokens of the text.
#[derive(Clone, Debug)]
pub(super) struct Cursor<'t> {
    pub(super) brackets: Vec<OpenBracket<'t>>,
    /// The last complete value, the number of brackets around it, and its key and index in the innermost one.
    last: Option<(Range<usize>, usize, Option<&'t str>, usize)>,
    pub(super) last_token: TokenClass,
}

impl<'t> Cursor<'t> {
    /// Position behind all tokens that begin before a byte.
    pub(super) fn before(text: &'t str, byte: usize) -> Self {
        Self::walk(text, byte, |_, _, _| {})
    }

    /// Version of [`before`](Self::before) that visits the name and position of each field, map entry, and choice with parentheses.
    pub(super) fn walk(text: &'t str, byte: usize, mut visit: impl FnMut(&Self, &'t str, usize)) -> Self {
        let mut cursor = Self { brackets: Vec::new(), last: None, last_token: TokenClass::Start };
        let mut word: Option<Range<usize>> = None;
        let mut at = 0;
        while let Some((token, is_text)) = token(text, at) {
            if token.start >= byte {
                break;
            }
            at = token.end;
            match text.as_bytes()[token.start] {
                bracket @ (b'(' | b'[' | b'{') => {
                    let named = word.take().filter(|_| bracket == b'(');
                    if let Some(word) = &named {
                        visit(&cursor, &text[word.clone()], word.start);
                    }
                    let start = named.as_ref().map_or(token.start, |word| word.start);
                    let name = named.map(|word| &text[word]);
                    cursor.brackets.push(OpenBracket {
                        start,
                        bracket,
                        bracket_at: token.start,
                        name,
                        key: None,
                        index: 0,
                    });
                    cursor.last_token = TokenClass::Open;
                }
                b')' | b']' | b'}' => {
                    if let Some(frame) = cursor.brackets.pop() {
                        cursor.ends(frame.start..token.end);
                    }
                    cursor.last_token = TokenClass::Close;
                }
                b',' => {
                    if let Some(frame) = cursor.brackets.last_mut() {
                        frame.key = None;
                        frame.index += 1;
                    }
                    cursor.last_token = TokenClass::Mark;
                }
                b':' => {
                    if let (Some(frame), Some((last, ..))) = (cursor.brackets.last_mut(), &cursor.last) {
                        let (start, name) = (last.start, text[last.clone()].trim_matches('"'));
                        frame.key = Some(name);
                        visit(&cursor, name, start);
                    }
                    cursor.last_token = TokenClass::Mark;
                }
                _ => {
                    cursor.ends(token.clone());
                    cursor.last_token = TokenClass::Value;
                    word = (!is_text).then_some(token);
                    continue;
                }
            }
            word = None;
        }
        cursor
    }

    /// Records a complete value. Its path is built on demand: most texts have many values.
    fn ends(&mut self, range: Range<usize>) {
        let (key, index) = self.brackets.last().map_or((None, 0), |frame| (frame.key, frame.index));
        self.last = Some((range, self.brackets.len(), key, index));
    }

    /// The value that ended last.
    pub(super) fn last(&self) -> Option<TextValue<'t>> {
        let (range, depth, key, index) = self.last.clone()?;
        let mut brackets = self.brackets.get(..depth)?.to_vec();
        if let Some(frame) = brackets.last_mut() {
            (frame.key, frame.index) = (key, index);
        }
        Some(TextValue { range, path: path_of(&brackets) })
    }

    /// The beginning of the innermost list element around the cursor.
    pub(super) fn innermost_element(&self) -> Option<usize> {
        self.brackets.windows(2).rev().find(|pair| pair[0].key.is_none()).map(|pair| pair[1].start)
    }

    /// True behind the colon of a field, and in a list.
    pub(super) fn expects_value(&self) -> bool {
        self.brackets.last().is_some_and(|frame| frame.key.is_some() || frame.bracket == b'[')
    }

    /// The path to the value at the cursor, present or missing.
    pub(super) fn path(&self) -> Vec<Key<'t>> {
        path_of(&self.brackets)
    }

    /// The path to the innermost list or struct around the cursor.
    pub(super) fn container(&self) -> Vec<Key<'t>> {
        let mut path = self.path();
        path.pop();
        path
    }

    /// The value of the innermost bracket, up to its end in the text.
    pub(super) fn group(&self, text: &str) -> Option<TextValue<'t>> {
        let mut outer = self.clone();
        let frame = outer.brackets.pop()?;
        Some(TextValue { range: frame.start..value_end(text, frame.bracket_at), path: outer.path() })
    }
}

fn path_of<'t>(brackets: &[OpenBracket<'t>]) -> Vec<Key<'t>> {
    let mut path = Vec::new();
    for frame in brackets {
        path.extend(frame.name.map(Key::Name));
        path.push(match (frame.key, frame.name) {
            (Some(key), _) => Key::Name(key),
            (None, Some(_)) => Key::Argument(frame.index),
            (None, None) => Key::Index(frame.index),
        });
    }
    path
}

/// The end of the value that begins at a byte: of a word, a text, or all up to the bracket that closes.
pub(super) fn value_end(text: &str, start: usize) -> usize {
    let (mut at, mut depth) = (start, 0_usize);
    while let Some((range, is_text)) = token(text, at) {
        at = range.end;
        match text.as_bytes()[range.start] {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            // A word before a parenthesis belongs to it.
            _ if depth == 0 && !is_text && text[at..].starts_with('(') => continue,
            _ => {}
        }
        if depth == 0 {
            return at;
        }
    }
    text.len()
}

/// The beginning of the next token at or after a byte.
pub(super) fn next(text: &str, at: usize) -> Option<usize> {
    token(text, at).map(|(range, _)| range.start)
}

/// The next token at or after a byte: a bracket, a comma, a colon, a text in quotes, or a word. True for a text.
fn token(text: &str, mut at: usize) -> Option<(Range<usize>, bool)> {
    loop {
        let rest = text.get(at..)?;
        at += rest.len() - rest.trim_start().len();
        let rest = &text[at..];
        let first = rest.chars().next()?;
        if rest.starts_with("//") {
            at += rest.find('\n').unwrap_or(rest.len());
        } else if rest.starts_with("/*") {
            at += comment(rest);
        } else if first == '"' {
            return Some((at..at + quoted(rest), true));
        } else if let Some(length) = raw(rest) {
            return Some((at..at + length, true));
        } else if "()[]{},:".contains(first) {
            return Some((at..at + 1, false));
        } else {
            let ends = |c: char| c.is_whitespace() || "()[]{},:\"".contains(c);
            let length = rest.find(ends).unwrap_or(rest.len());
            return Some((at..at + length, false));
        }
    }
}

/// The length of the comment that a text begins with; such comments contain each other.
fn comment(text: &str) -> usize {
    let bytes = text.as_bytes();
    let (mut at, mut depth) = (0, 0_usize);
    while at + 1 < bytes.len() {
        match &bytes[at..at + 2] {
            b"/*" => (depth, at) = (depth + 1, at + 2),
            b"*/" if depth == 1 => return at + 2,
            b"*/" => (depth, at) = (depth.saturating_sub(1), at + 2),
            _ => at += 1,
        }
    }
    text.len()
}

/// The length of the text in quotes that a text begins with.
fn quoted(text: &str) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// The length of a raw text such as `r#"a"#`.
fn raw(text: &str) -> Option<usize> {
    let after = text.strip_prefix('r')?;
    let marks = after.len() - after.trim_start_matches('#').len();
    let content = after[marks..].strip_prefix('"')?;
    let end = format!("\"{}", "#".repeat(marks));
    let length = content.find(&end).map_or(content.len(), |at| at + end.len());
    Some(text.len() - content.len() + length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(text: &str) -> String {
        let byte = text.find('@').expect("a mark");
        let cursor = Cursor::before(text, byte);
        let part = |key: &Key<'_>| match key {
            Key::Name(name) => (*name).to_owned(),
            Key::Index(index) => index.to_string(),
            Key::Argument(index) => format!("#{index}"),
        };
        cursor.path().iter().map(part).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn paths_lead_to_places() {
        assert_eq!(path("(camera: (look_from: (1, @"), "camera look_from 1");
        assert_eq!(path("(nodes: [(), (shape: sphere(radius: @"), "nodes 1 shape sphere radius");
        assert_eq!(path(r#"{"nodes": [{"shape": {"sphere": {"radius": @"#), "nodes 0 shape sphere radius");
        assert_eq!(path("(lights: [ambient(@"), "lights 0 ambient #0");
        assert_eq!(
            path("// (\n(/* ( /* [ */ */ name: \"(\\\"[\", materials: {\"a b\": mix([(@"),
            "materials a b mix #0 0 0"
        );
        assert_eq!(path("(name: r#\"(\"\"#, fov: @"), "fov");
        assert_eq!(path("@"), "");
    }

    #[test]
    fn values_end_with_their_bracket() {
        for (text, value) in
            [("1.5, 2", "1.5"), ("\"a)\" ]", "\"a)\""), ("rgb(1, (2), 3), 4", "rgb(1, (2), 3)"), ("[(]", "[(]")]
        {
            assert_eq!(&text[..value_end(text, 0)], value);
        }
    }

    #[test]
    fn the_last_value_is_known_with_its_path() {
        let text = "(a: rgb(1, 2), b: 3)";
        let last = Cursor::before(text, 14).last().expect("a value");
        assert_eq!((&text[last.range], last.path), ("rgb(1, 2)", vec![Key::Name("a")]));
    }
}
