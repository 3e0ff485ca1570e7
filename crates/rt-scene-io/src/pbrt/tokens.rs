//! The words of a scene file, each with its line.

use crate::flaw::Flaw;
use crate::limits;

/// A piece of the text and the number of its line, counted from 1.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token<'a> {
    pub(super) line: usize,
    pub(super) kind: Kind<'a>,
}

/// What a token is.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind<'a> {
    /// A directive, a number, `true` or `false`.
    Word(&'a str),
    /// What stands between quotes.
    Text(String),
    /// `[`
    Open,
    /// `]`
    Close,
}

/// The tokens of a text, one after the other.
pub(super) struct Tokens<'a> {
    rest: &'a str,
    line: usize,
    next: Option<Result<Token<'a>, Flaw>>,
}

impl<'a> Tokens<'a> {
    pub(super) fn of(text: &'a str) -> Self {
        let mut tokens = Self { rest: text, line: 1, next: None };
        tokens.next = tokens.scan();
        tokens
    }

    /// The line that is read.
    pub(super) const fn line(&self) -> usize {
        self.line
    }

    /// The kind of the next token, which stays; `None` at the end, and before what is no token.
    pub(super) fn peek(&self) -> Option<&Kind<'a>> {
        self.next.as_ref()?.as_ref().ok().map(|token| &token.kind)
    }

    /// The next token; `None` at the end of the text.
    pub(super) fn take(&mut self) -> Result<Option<Token<'a>>, Flaw> {
        let next = self.next.take();
        self.next = self.scan();
        next.transpose()
    }

    /// Passes over everything before the next word that begins as directives do.
    pub(super) fn skip_to_directive(&mut self) {
        while let Some(next) = &self.next {
            if let Ok(Token { kind: Kind::Word(word), .. }) = next
                && word.starts_with(|first: char| first.is_ascii_uppercase())
            {
                break;
            }
            self.next = self.scan();
        }
    }

    /// The next token as the text between quotes.
    pub(super) fn text(&mut self, what: &str) -> Result<String, Flaw> {
        match self.next_kind(what)? {
            (_, Kind::Text(text)) => Ok(text),
            (line, other) => {
                Err(Flaw::new(line, shown(&other), format!("stands where {what} should: put it in quotes")))
            }
        }
    }

    /// The next token as a number of magnitude at most 10⁶⁰.
    pub(super) fn number(&mut self, what: &str) -> Result<f64, Flaw> {
        // A directive begins the next statement.
        if let Some(Kind::Word(word)) = self.peek()
            && word.parse::<f64>().is_err()
        {
            let rule = format!("stands where {what} should: give a number");
            return Err(Flaw::new(self.line, format_args!("`{word}`"), rule));
        }
        let (line, kind) = self.next_kind(what)?;
        number(line, &kind, what)
    }

    /// So many numbers, which may stand in brackets.
    pub(super) fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f64; N], Flaw> {
        let bracketed = self.peek() == Some(&Kind::Open);
        if bracketed {
            self.take()?;
        }
        let mut numbers = [0.0; N];
        for one in &mut numbers {
            *one = self.number(what)?;
        }
        if bracketed {
            match self.next_kind("the closing bracket")? {
                (_, Kind::Close) => {}
                (line, other) => {
                    return Err(Flaw::new(line, shown(&other), format!("follows {what}: {N} numbers are enough")));
                }
            }
        }
        Ok(numbers)
    }

    pub(super) fn next_kind(&mut self, what: &str) -> Result<(usize, Kind<'a>), Flaw> {
        match self.take()? {
            Some(Token { line, kind }) => Ok((line, kind)),
            None => Err(Flaw::new(self.line, "the end of the file", format!("comes before {what}"))),
        }
    }

    fn scan(&mut self) -> Option<Result<Token<'a>, Flaw>> {
        self.skip_blank();
        let (line, first) = (self.line, self.rest.chars().next()?);
        let kind = match first {
            '[' | ']' => {
                self.rest = &self.rest[1..];
                if first == '[' { Kind::Open } else { Kind::Close }
            }
            '"' => match self.quoted() {
                Ok(text) => Kind::Text(text),
                Err(flaw) => return Some(Err(flaw)),
            },
            _ => {
                let is_end = |c: char| c.is_whitespace() || matches!(c, '[' | ']' | '"' | '#');
                let end = self.rest.find(is_end).unwrap_or(self.rest.len());
                let (word, rest) = self.rest.split_at(end);
                self.rest = rest;
                Kind::Word(word)
            }
        };
        Some(Ok(Token { line, kind }))
    }

    /// Passes over white space and comments.
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

    /// A text in quotes, which ends in its line; `\` makes the character after it ordinary.
    fn quoted(&mut self) -> Result<String, Flaw> {
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
        Err(Flaw::new(line, format_args!("`\"{shown}`"), "has no closing quote in its line"))
    }
}

/// A token as a number of magnitude at most 10⁶⁰.
pub(super) fn number(line: usize, kind: &Kind<'_>, what: &str) -> Result<f64, Flaw> {
    let parsed = match kind {
        Kind::Word(word) => word.parse::<f64>().ok(),
        _ => None,
    };
    match parsed {
        // A NaN fails the comparison.
        Some(number) if number.abs() <= limits::NUMBER => Ok(number),
        Some(_) => Err(Flaw::new(line, shown(kind), format!("as {what} is not a number of magnitude at most 1e60"))),
        None => Err(Flaw::new(line, shown(kind), format!("stands where {what} should: give a number"))),
    }
}

/// A token as the file shows it.
pub(super) fn shown(kind: &Kind<'_>) -> String {
    match kind {
        Kind::Word(word) => format!("`{word}`"),
        Kind::Text(text) => format!("`\"{text}\"`"),
        Kind::Open => "`[`".to_owned(),
        Kind::Close => "`]`".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_know_their_lines_and_comments_are_passed_over() {
        let mut tokens = Tokens::of("# c \"\nShape \"sp\\\"here\"#x\r\n \"float r\"[.5]\n");
        let mut all = Vec::new();
        while let Some(Token { line, kind }) = tokens.take().unwrap() {
            all.push((line, shown(&kind)));
        }
        let expected =
            [(2, "`Shape`"), (2, "`\"sp\"here\"`"), (3, "`\"float r\"`"), (3, "`[`"), (3, "`.5`"), (3, "`]`")];
        assert_eq!(all, expected.map(|(line, text)| (line, text.to_owned())));
    }

    #[test]
    fn quotes_end_in_their_line() {
        let mut tokens = Tokens::of("\n\"open\nShape");
        let flaw = tokens.take().unwrap_err();
        assert_eq!((flaw.line, flaw.reason.to_string().as_str()), (2, "`\"open` has no closing quote in its line"));
        assert_eq!(tokens.take().unwrap().unwrap().kind, Kind::Word("Shape"));
    }

    #[test]
    fn numbers_are_checked() {
        let message = |text: &str| Tokens::of(text).numbers::<2>("a factor").unwrap_err().reason.to_string();
        assert_eq!(Tokens::of("[1 -2e1]").numbers::<2>("a factor").unwrap(), [1.0, -20.0]);
        assert_eq!(message("1"), "the end of the file comes before a factor");
        assert_eq!(message("1 Shape"), "`Shape` stands where a factor should: give a number");
        assert_eq!(message("[1 2 3]"), "`3` follows a factor: 2 numbers are enough");
        assert_eq!(message("1 nan"), "`nan` as a factor is not a number of magnitude at most 1e60");
    }
}
