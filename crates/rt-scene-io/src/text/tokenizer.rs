//! Tokens of NFF and pbrt files, each with its line. `#` begins a comment.

use crate::error::LineError;
use crate::limits;

/// A token and its line, counted from 1.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Token<'a> {
    pub(crate) line: usize,
    pub(crate) kind: TokenKind<'a>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TokenKind<'a> {
    /// A keyword or a number.
    Word(&'a str),
    /// Text between quotes, without escapes.
    Text(String),
    /// `[`
    Open,
    /// `]`
    Close,
}

/// A word and its line, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Word<'a> {
    pub(crate) line: usize,
    pub(crate) text: &'a str,
}

/// Iterator over the tokens of a text, with one token of lookahead.
pub(crate) struct Tokenizer<'a> {
    rest: &'a str,
    line: usize,
    next: Option<Result<Token<'a>, LineError>>,
    /// Brackets and quotes are ordinary characters.
    words_only: bool,
}

impl<'a> Tokenizer<'a> {
    /// Tokens of pbrt: words, texts in quotes, brackets.
    #[cfg(feature = "pbrt")]
    pub(crate) fn new(text: &'a str) -> Self {
        Self::with_syntax(text, false)
    }

    /// Tokens of NFF: words between white space.
    #[cfg(feature = "nff")]
    pub(crate) fn words(text: &'a str) -> Self {
        Self::with_syntax(text, true)
    }

    fn with_syntax(text: &'a str, words_only: bool) -> Self {
        let mut tokens = Self { rest: text, line: 1, next: None, words_only };
        tokens.next = tokens.scan();
        tokens
    }

    /// Line of the next token; the last line at the end of the text.
    #[cfg(feature = "pbrt")]
    pub(crate) const fn line(&self) -> usize {
        self.line
    }

    /// Kind of the next token, which is not consumed; `None` at the end, and before a malformed token.
    pub(crate) fn peek(&self) -> Option<&TokenKind<'a>> {
        self.next.as_ref()?.as_ref().ok().map(|token| &token.kind)
    }

    /// The next token if it is a word; it is not consumed.
    pub(crate) fn peek_word(&self) -> Option<Word<'a>> {
        match &self.next {
            Some(Ok(Token { line, kind: TokenKind::Word(text) })) => Some(Word { line: *line, text }),
            _ => None,
        }
    }

    /// Consumes the next token; `None` at the end of the text.
    pub(crate) fn take(&mut self) -> Result<Option<Token<'a>>, LineError> {
        let next = self.next.take();
        self.next = self.scan();
        next.transpose()
    }

    /// Consumes the next token if it is a word.
    #[cfg(feature = "nff")]
    pub(crate) fn take_word(&mut self) -> Option<Word<'a>> {
        let word = self.peek_word()?;
        self.next = self.scan();
        Some(word)
    }

    /// Skips to the next word that begins with a capital letter, as directives of pbrt do.
    #[cfg(feature = "pbrt")]
    pub(crate) fn skip_to_directive(&mut self) {
        while self.next.is_some()
            && !self.peek_word().is_some_and(|word| word.text.starts_with(|first: char| first.is_ascii_uppercase()))
        {
            self.next = self.scan();
        }
    }

    /// Consumes a text in quotes.
    #[cfg(feature = "pbrt")]
    pub(crate) fn text(&mut self, what: &str) -> Result<String, LineError> {
        match self.next_kind(what)? {
            (_, TokenKind::Text(text)) => Ok(text),
            (line, other) => {
                Err(LineError::new(line, shown(&other), format!("is not a string in quotes; expected {what}")))
            }
        }
    }

    /// Consumes a number of magnitude at most 10⁶⁰. Any other word stays: it may begin the next statement.
    pub(crate) fn number(&mut self, what: &str) -> Result<f64, LineError> {
        if let Some(Word { line, text }) = self.peek_word()
            && text.parse::<f64>().is_err()
        {
            let rule = format!("is not a number; expected {what}");
            return Err(LineError::new(line, format_args!("`{text}`"), rule));
        }
        let (line, kind) = self.next_kind(what)?;
        number(line, &kind, what)
    }

    /// Consumes `N` numbers, optionally in brackets.
    pub(crate) fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f64; N], LineError> {
        let bracketed = self.peek() == Some(&TokenKind::Open);
        if bracketed {
            self.take()?;
        }
        let mut numbers = [0.0; N];
        for one in &mut numbers {
            *one = self.number(what)?;
        }
        if bracketed {
            match self.next_kind("the closing bracket")? {
                (_, TokenKind::Close) => {}
                (line, other) => {
                    return Err(LineError::new(
                        line,
                        shown(&other),
                        format!("follows {what}, which has {N} numbers: remove it"),
                    ));
                }
            }
        }
        Ok(numbers)
    }

    /// Consumes a number from 0 up.
    #[cfg(feature = "nff")]
    pub(crate) fn non_negative(&mut self, what: &str) -> Result<f64, LineError> {
        let line = self.line;
        let number = self.number(what)?;
        if number >= 0.0 {
            Ok(number)
        } else {
            Err(LineError::new(line, format_args!("{what}: {number}"), "must not be negative"))
        }
    }

    /// Consumes a colour: three numbers from 0 up.
    #[cfg(feature = "nff")]
    pub(crate) fn color(&mut self, what: &str) -> Result<[f64; 3], LineError> {
        Ok([self.non_negative(what)?, self.non_negative(what)?, self.non_negative(what)?])
    }

    /// Consumes any token; the end of the text is an error.
    pub(crate) fn next_kind(&mut self, what: &str) -> Result<(usize, TokenKind<'a>), LineError> {
        match self.take()? {
            Some(Token { line, kind }) => Ok((line, kind)),
            None => Err(LineError::new(self.line, "the end of the file", format!("comes before {what}"))),
        }
    }

    fn scan(&mut self) -> Option<Result<Token<'a>, LineError>> {
        self.skip_blank();
        let (line, first) = (self.line, self.rest.chars().next()?);
        let kind = match first {
            '[' | ']' if !self.words_only => {
                self.rest = &self.rest[1..];
                if first == '[' { TokenKind::Open } else { TokenKind::Close }
            }
            '"' if !self.words_only => match self.quoted() {
                Ok(text) => TokenKind::Text(text),
                Err(error) => return Some(Err(error)),
            },
            _ => {
                let is_mark = |c: char| !self.words_only && matches!(c, '[' | ']' | '"');
                let is_end = |c: char| c.is_whitespace() || c == '#' || is_mark(c);
                let end = self.rest.find(is_end).unwrap_or(self.rest.len());
                let (word, rest) = self.rest.split_at(end);
                self.rest = rest;
                TokenKind::Word(word)
            }
        };
        Some(Ok(Token { line, kind }))
    }

    /// Skips white space and comments.
    fn skip_blank(&mut self) {
        loop {
            let blank = self.rest.find(|c: char| !c.is_whitespace()).unwrap_or(self.rest.len());
            self.line += self.rest[..blank].matches('\n').count();
            self.rest = &self.rest[blank..];
            if !self.rest.starts_with('#') {
                return;
            }
            self.rest = &self.rest[self.rest.find('\n').unwrap_or(self.rest.len())..];
        }
    }

    /// Text in quotes, which ends in its line; `\` escapes the next character.
    fn quoted(&mut self) -> Result<String, LineError> {
        let mut text = String::new();
        let mut characters = self.rest.char_indices().skip(1);
        while let Some((at, c)) = characters.next() {
            match c {
                '"' => {
                    self.rest = &self.rest[at + 1..];
                    return Ok(text);
                }
                '\n' => break,
                '\\' => match characters.next() {
                    Some((_, 'n')) => text.push('\n'),
                    Some((_, 't')) => text.push('\t'),
                    Some((_, other)) if other != '\n' => text.push(other),
                    _ => break,
                },
                _ => text.push(c),
            }
        }
        let line = self.line;
        self.rest = &self.rest[self.rest.find('\n').unwrap_or(self.rest.len())..];
        let shown: String = text.chars().take(40).collect();
        Err(LineError::new(line, format_args!("`\"{shown}`"), "has no closing quote in its line"))
    }
}

/// Value of a token that must be a number of magnitude at most 10⁶⁰.
pub(crate) fn number(line: usize, kind: &TokenKind<'_>, what: &str) -> Result<f64, LineError> {
    let parsed = match kind {
        TokenKind::Word(word) => word.parse::<f64>().ok(),
        _ => None,
    };
    match parsed {
        // NaN fails the comparison.
        Some(number) if number.abs() <= limits::NUMBER => Ok(number),
        Some(_) => Err(LineError::new(
            line,
            format_args!("{what}: {}", shown(kind)),
            "is not a number of magnitude at most 1e60",
        )),
        None => Err(LineError::new(line, shown(kind), format!("is not a number; expected {what}"))),
    }
}

/// Token as written in the file.
pub(crate) fn shown(kind: &TokenKind<'_>) -> String {
    match kind {
        TokenKind::Word(word) => format!("`{word}`"),
        TokenKind::Text(text) => format!("`\"{text}\"`"),
        TokenKind::Open => "`[`".to_owned(),
        TokenKind::Close => "`]`".to_owned(),
    }
}

#[cfg(all(test, feature = "nff", feature = "pbrt"))]
mod tests {
    use super::*;

    #[test]
    fn tokens_carry_their_lines_and_comments_are_skipped() {
        let mut tokens = Tokenizer::new("# c \"\nShape \"sp\\\"here\"#x\r\n \"float r\"[.5]\n");
        let mut all = Vec::new();
        while let Some(Token { line, kind }) = tokens.take().unwrap() {
            all.push((line, shown(&kind)));
        }
        let expected =
            [(2, "`Shape`"), (2, "`\"sp\"here\"`"), (3, "`\"float r\"`"), (3, "`[`"), (3, "`.5`"), (3, "`]`")];
        assert_eq!(all, expected.map(|(line, text)| (line, text.to_owned())));
        let mut words = Tokenizer::words("# c\ns 1 2# x\r\n\n 3e1[\"a #\n");
        let all: Vec<_> = std::iter::from_fn(|| words.take_word()).map(|word| (word.line, word.text)).collect();
        assert_eq!(all, [(2, "s"), (2, "1"), (2, "2"), (4, "3e1[\"a")]);
    }

    #[test]
    fn quotes_end_in_their_line() {
        let mut tokens = Tokenizer::new("\n\"open\nShape");
        let error = tokens.take().unwrap_err();
        assert_eq!((error.line, error.kind.to_string().as_str()), (2, "`\"open` has no closing quote in its line"));
        assert_eq!(tokens.take().unwrap().unwrap().kind, TokenKind::Word("Shape"));
    }

    #[test]
    fn numbers_are_checked_and_other_words_stay() {
        let message = |text: &str| Tokenizer::new(text).numbers::<2>("a factor").unwrap_err().kind.to_string();
        assert_eq!(Tokenizer::new("[1 -2e1]").numbers::<2>("a factor").unwrap(), [1.0, -20.0]);
        assert_eq!(message("1"), "the end of the file comes before a factor");
        assert_eq!(message("1 Shape"), "`Shape` is not a number; expected a factor");
        assert_eq!(message("[1 2 3]"), "`3` follows a factor, which has 2 numbers: remove it");
        assert_eq!(message("1 nan"), "a factor: `nan` is not a number of magnitude at most 1e60");
        let message = |text: &str| Tokenizer::words(text).non_negative("the radius").unwrap_err().kind.to_string();
        assert_eq!(Tokenizer::words("2.5").non_negative("the radius").unwrap(), 2.5);
        assert_eq!(message(""), "the end of the file comes before the radius");
        assert_eq!(message("-1"), "the radius: -1 must not be negative");
        for bad in ["nan", "1e61", "-inf"] {
            assert!(message(bad).contains("is not a number of magnitude at most 1e60"), "{bad}");
        }
        let mut words = Tokenizer::words("s 1");
        assert!(words.number("the radius").is_err());
        assert_eq!(words.take_word(), Some(Word { line: 1, text: "s" }));
    }
}
