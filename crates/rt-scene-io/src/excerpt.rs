//! The line of a text in which a mistake is, with a caret below it.

use std::fmt;

/// Maximum number of characters of a line in a message.
const SHOWN: usize = 100;

/// Characters before the caret that are shown of a line that is too long.
const BEFORE: usize = 60;

/// Line of a text with a caret. Printed on two lines, without a final line break.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excerpt {
    /// Counted from 1.
    line: usize,
    /// Text as shown: control characters become spaces, distant parts are left out.
    text: String,
    /// Characters of `text` before the caret.
    before: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Position {
    /// Counted from 1.
    pub(crate) line: usize,
    /// Characters, counted from 1.
    pub(crate) column: usize,
}

impl Position {
    /// The position of a byte, which is moved back to the beginning of its character.
    pub(crate) fn of(text: &str, byte: usize) -> Self {
        let before = &text[..floor(text, byte)];
        let start = before.rfind('\n').map_or(0, |end| end + 1);
        Self { line: 1 + before.matches('\n').count(), column: 1 + before[start..].chars().count() }
    }

    /// The byte at a position; the end of its line if that is shorter.
    pub(crate) fn byte(self, text: &str) -> usize {
        let start = line_start(text, self.line);
        let line = text[start..].split('\n').next().unwrap_or_default();
        start + line.char_indices().nth(self.column.saturating_sub(1)).map_or(line.len(), |(byte, _)| byte)
    }
}

/// The byte at which a line begins, counted from 1.
pub(crate) fn line_start(text: &str, line: usize) -> usize {
    match line {
        0 | 1 => 0,
        _ => text.match_indices('\n').nth(line - 2).map_or(text.len(), |(end, _)| end + 1),
    }
}

/// Largest character boundary up to a byte.
pub(crate) fn floor(text: &str, byte: usize) -> usize {
    let mut byte = byte.min(text.len());
    while !text.is_char_boundary(byte) {
        byte -= 1;
    }
    byte
}

impl Excerpt {
    /// The line of a byte, with the caret at that byte.
    pub(crate) fn of(text: &str, byte: usize) -> Self {
        let Position { line, column } = Position::of(text, byte);
        let start = line_start(text, line);
        let whole = text[start..].split('\n').next().unwrap_or_default().trim_end();
        let length = whole.chars().count();
        let before = column - 1;
        let skipped = if length > SHOWN { before.saturating_sub(BEFORE) } else { 0 };
        let mut shown: String = if skipped > 0 { "...".to_owned() } else { String::new() };
        let cut = shown.len();
        shown.extend(whole.chars().skip(skipped).take(SHOWN).map(|c| if c.is_control() { ' ' } else { c }));
        if length > skipped + SHOWN {
            shown.push_str("...");
        }
        Self { line, text: shown, before: cut + before - skipped }
    }
}

impl fmt::Display for Excerpt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line, text, before } = self;
        let line = line.to_string();
        writeln!(f, "    {line} | {text}")?;
        write!(f, "    {:1$} | {2:3$}^", "", line.len(), "", before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_and_bytes_are_each_other() {
        let text = "a\nßb\r\n\nc";
        for (byte, line, column) in [(0, 1, 1), (1, 1, 2), (2, 2, 1), (4, 2, 2), (7, 3, 1), (8, 4, 1), (9, 4, 2)] {
            let position = Position { line, column };
            assert_eq!(Position::of(text, byte), position, "{byte}");
            assert_eq!(position.byte(text), byte, "{position:?}");
        }
        assert_eq!(Position::of(text, 3), Position { line: 2, column: 1 }, "within a character");
        assert_eq!(Position { line: 2, column: 99 }.byte(text), 6);
        assert_eq!(Position { line: 99, column: 1 }.byte(text), text.len());
    }

    #[test]
    fn the_caret_is_below_its_byte() {
        assert_eq!(Excerpt::of("(\n\tß: 1,\n)", 6).to_string(), "    2 |  ß: 1,\n      |    ^");
        assert_eq!(Excerpt::of("", 0).to_string(), "    1 | \n      | ^");
    }
}
