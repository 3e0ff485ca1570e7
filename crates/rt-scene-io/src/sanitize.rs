//! Text from files in messages: on one line, and without orders for the terminal.

use std::fmt::{self, Display, Write};

/// Shows a value with its control characters written as escapes such as `\n` and `\u{1b}`. Names in a file may otherwise
/// forge messages, or control the terminal.
pub(crate) struct SingleLine<T>(pub(crate) T);

impl<T: Display> Display for SingleLine<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(Escaped(f), "{}", self.0)
    }
}

struct Escaped<'a, 'f>(&'a mut fmt::Formatter<'f>);

impl Write for Escaped<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for part in text.split_inclusive(char::is_control) {
            let mut chars = part.chars();
            match chars.next_back() {
                Some(last) if last.is_control() => write!(self.0, "{}{}", chars.as_str(), last.escape_default())?,
                _ => self.0.write_str(part)?,
            }
        }
        Ok(())
    }
}

/// Text of at most 40 characters for messages.
#[cfg(any(feature = "gltf", feature = "obj", feature = "ply", feature = "stl"))]
pub(crate) fn shortened(text: &str) -> String {
    if text.chars().count() <= 40 { text.to_owned() } else { text.chars().take(40).chain(['…']).collect() }
}

/// Reference or path of at most 200 characters for messages; of a longer one, its first and last 100. Exporters forget the scheme
/// of data URIs, whose content is then the name of a file.
#[cfg(feature = "format")]
pub(crate) fn shortened_reference(text: &str) -> String {
    const PART: usize = 100;
    let count = text.chars().count();
    if count <= 2 * PART {
        return text.to_owned();
    }
    text.chars().take(PART).chain(['…']).chain(text.chars().skip(count - PART)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_written_out() {
        assert_eq!(SingleLine("a\nb\u{1b}[2Jc\r").to_string(), "a\\nb\\u{1b}[2Jc\\r");
        assert_eq!(SingleLine("Würfel „1“ \u{9b}x").to_string(), "Würfel „1“ \\u{9b}x");
        assert_eq!(SingleLine("").to_string(), "");
    }
}
