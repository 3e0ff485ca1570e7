//! The words of an NFF file, each with its line.

use crate::flaw::Flaw;
use crate::limits;

/// A word and the number of its line, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Word<'a> {
    pub(super) line: usize,
    pub(super) text: &'a str,
}

/// The words of a text without its comments, one after the other. Where lines end does not matter to the format: the
/// generators of the databases themselves write the two ends of a cone in one line, against the description.
pub(super) struct Words<'a> {
    lines: std::str::Split<'a, char>,
    current: std::str::SplitWhitespace<'a>,
    line: usize,
    next: Option<Word<'a>>,
}

impl<'a> Words<'a> {
    /// The words of a text whose lines end in `\n` or `\r\n`.
    pub(super) fn of(text: &'a str) -> Self {
        let mut words = Self { lines: text.split('\n'), current: "".split_whitespace(), line: 0, next: None };
        words.advance();
        words
    }

    fn advance(&mut self) {
        self.next = loop {
            if let Some(text) = self.current.next() {
                break Some(Word { line: self.line, text });
            }
            let Some(line) = self.lines.next() else { break None };
            self.line += 1;
            let content = line.split_once('#').map_or(line, |(content, _)| content);
            self.current = content.split_whitespace();
        };
    }

    /// The next word, which stays.
    pub(super) const fn peek(&self) -> Option<Word<'a>> {
        self.next
    }

    /// The next word; `None` at the end of the file.
    pub(super) fn take(&mut self) -> Option<Word<'a>> {
        let word = self.next;
        self.advance();
        word
    }

    /// The next word as a number of magnitude at most 10⁶⁰. A word that is none stays, since it may begin the next
    /// statement. `what` is missing if there is none.
    pub(super) fn number(&mut self, what: &str) -> Result<f64, Flaw> {
        let Some(Word { line, text }) = self.next else {
            return Err(Flaw::new(self.line, "the end of the file", format!("comes before {what}")));
        };
        let Ok(number) = text.parse::<f64>() else {
            return Err(Flaw::new(
                line,
                format_args!("`{text}`"),
                format!("stands where {what} should: give a number"),
            ));
        };
        self.advance();
        // A NaN fails the comparison.
        if number.abs() <= limits::NUMBER {
            Ok(number)
        } else {
            Err(Flaw::new(
                line,
                format_args!("`{text}`"),
                format!("as {what} is not a number of magnitude at most 1e60"),
            ))
        }
    }

    /// The next words as so many numbers.
    pub(super) fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f64; N], Flaw> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number(what)?;
        }
        Ok(numbers)
    }

    /// The next word as a number from 0 up.
    pub(super) fn share(&mut self, what: &str) -> Result<f64, Flaw> {
        let line = self.next.map_or(self.line, |word| word.line);
        let number = self.number(what)?;
        if number >= 0.0 { Ok(number) } else { Err(Flaw::new(line, number, format!("as {what} is less than 0"))) }
    }

    /// The next words as a colour of three numbers from 0 up.
    pub(super) fn colour(&mut self, what: &str) -> Result<[f64; 3], Flaw> {
        Ok([self.share(what)?, self.share(what)?, self.share(what)?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_know_their_lines_and_comments_are_passed_over() {
        let mut words = Words::of("# c\ns 1 2# x\r\n\n 3e1 #\n");
        let all: Vec<_> = std::iter::from_fn(|| words.take()).map(|word| (word.line, word.text)).collect();
        assert_eq!(all, [(2, "s"), (2, "1"), (2, "2"), (4, "3e1")]);
        assert_eq!(words.peek(), None);
    }

    #[test]
    fn numbers_are_checked_and_foreign_words_stay() {
        let message = |text: &str| Words::of(text).share("the radius").unwrap_err().reason.to_string();
        assert_eq!(Words::of("2.5").share("the radius").unwrap(), 2.5);
        assert_eq!(message(""), "the end of the file comes before the radius");
        assert_eq!(message("-1"), "-1 as the radius is less than 0");
        for bad in ["nan", "1e61", "-inf"] {
            assert!(message(bad).contains("is not a number of magnitude at most 1e60"), "{bad}");
        }
        let mut words = Words::of("s 1");
        assert!(words.number("the radius").is_err());
        assert_eq!(words.take(), Some(Word { line: 1, text: "s" }));
    }
}
