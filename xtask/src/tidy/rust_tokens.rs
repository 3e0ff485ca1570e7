//! Tokens of Rust source, as far as `tidy` reads them.

/// Kinds of tokens; comments are tokens, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Word,
    Punctuation,
    Literal,
    Lifetime,
    Comment,
    Documentation,
}

/// A piece of source and the line that it begins on, from 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Token<'s> {
    pub kind: Kind,
    pub text: &'s str,
    pub line: usize,
}

/// All tokens of a file. Source that does not compile gives some tokens as well.
pub(super) fn tokens(source: &str) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let (mut rest, mut line) = (source, 1);
    while let Some(first) = rest.chars().next() {
        let (kind, length) = if first.is_whitespace() { (None, first.len_utf8()) } else { token(rest, first) };
        let (text, after) = rest.split_at(length);
        if let Some(kind) = kind {
            tokens.push(Token { kind, text, line });
        }
        line += text.matches('\n').count();
        rest = after;
    }
    tokens
}

/// Kind and length in bytes of the token at the start of `rest`.
fn token(rest: &str, first: char) -> (Option<Kind>, usize) {
    let line = rest.split_inclusive('\n').next().unwrap_or_default().trim_end();
    if rest.starts_with("//") {
        let documents = line.starts_with("//!") || (line.starts_with("///") && !line.starts_with("////"));
        return (Some(if documents { Kind::Documentation } else { Kind::Comment }), line.len());
    }
    if rest.starts_with("/*") {
        return (Some(Kind::Comment), block_comment(rest));
    }
    if first == '_' || first.is_alphabetic() {
        let length = word(rest);
        let (prefix, after) = rest.split_at(length);
        return match (prefix, after.chars().next()) {
            ("b" | "c", Some('"')) => (Some(Kind::Literal), length + quoted(after, '"')),
            ("b", Some('\'')) => (Some(Kind::Literal), length + quoted(after, '\'')),
            ("r" | "br" | "cr", Some('"' | '#')) => match raw_string(after) {
                Some(end) => (Some(Kind::Literal), length + end),
                None => (Some(Kind::Word), length + 1 + word(&after[1..])),
            },
            _ => (Some(Kind::Word), length),
        };
    }
    if first.is_ascii_digit() {
        return (Some(Kind::Literal), number(rest));
    }
    match first {
        '"' => (Some(Kind::Literal), quoted(rest, '"')),
        '\'' => {
            let mut after = rest[1..].chars();
            let is_character = matches!(after.next(), Some('\\')) || after.next() == Some('\'');
            if is_character {
                (Some(Kind::Literal), quoted(rest, '\''))
            } else {
                (Some(Kind::Lifetime), 1 + word(&rest[1..]))
            }
        }
        _ if rest.starts_with("::") => (Some(Kind::Punctuation), 2),
        _ => (Some(Kind::Punctuation), first.len_utf8()),
    }
}

fn word(text: &str) -> usize {
    text.find(|c: char| c != '_' && !c.is_alphanumeric()).unwrap_or(text.len())
}

/// Length of a number; the dots of a range and of a method call are not part of it.
fn number(text: &str) -> usize {
    let whole = word(text);
    let fraction = text[whole..].strip_prefix('.').filter(|after| after.starts_with(|c: char| c.is_ascii_digit()));
    fraction.map_or(whole, |after| whole + 1 + word(after))
}

/// Length of a literal in quotes, with both quotes.
fn quoted(text: &str, quote: char) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            _ if c == quote => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// Length of `#"..."#` with any number of `#`; `None` for a raw identifier.
fn raw_string(text: &str) -> Option<usize> {
    let hashes = text.find(|c| c != '#')?;
    let body = text[hashes..].strip_prefix('"')?;
    let end = format!("\"{}", "#".repeat(hashes));
    Some(body.find(&end).map_or(text.len(), |at| hashes + 1 + at + end.len()))
}

/// Length of a comment in `/* */`, which may hold others.
fn block_comment(text: &str) -> usize {
    let mut depth = 0_usize;
    let mut at = 0;
    while at < text.len() {
        if text[at..].starts_with("/*") {
            (depth, at) = (depth + 1, at + 2);
        } else if text[at..].starts_with("*/") {
            (depth, at) = (depth - 1, at + 2);
            if depth == 0 {
                return at;
            }
        } else {
            at += text[at..].chars().next().map_or(1, char::len_utf8);
        }
    }
    text.len()
}

/// Code alone: without comments, and without the items that only tests have.
pub(super) fn code_outside_tests<'s>(tokens: &[Token<'s>]) -> Vec<Token<'s>> {
    let is_code = |token: &&Token<'_>| !matches!(token.kind, Kind::Comment | Kind::Documentation);
    let code: Vec<Token<'s>> = tokens.iter().filter(is_code).copied().collect();
    let mut kept = Vec::new();
    let mut at = 0;
    while at < code.len() {
        match test_attribute(&code[at..]) {
            Some((_, true)) => return Vec::new(),
            Some((length, false)) => at += length + item_length(&code[at + length..]),
            None => {
                kept.push(code[at]);
                at += 1;
            }
        }
    }
    kept
}

/// Length of `#[cfg(test)]` or the like at the start of `code`, and true if it is about the whole file.
fn test_attribute(code: &[Token<'_>]) -> Option<(usize, bool)> {
    let text = |at: usize| code.get(at).map_or("", |token| token.text);
    let inner = text(1) == "!";
    let start = 1 + usize::from(inner);
    if text(0) != "#" || text(start) != "[" || text(start + 1) != "cfg" {
        return None;
    }
    let length = start + 1 + code[start..].iter().position(|token| token.text == "]")?;
    let words = &code[start..length];
    let has = |word: &str| words.iter().any(|token| token.text == word);
    (has("test") && !has("not") && !has("any")).then_some((length, inner))
}

/// Length of the item at the start of `code`, with further attributes.
fn item_length(code: &[Token<'_>]) -> usize {
    let mut depth = 0_usize;
    let mut ends_with_block = true;
    let mut starts = true;
    for (at, token) in code.iter().enumerate() {
        if depth == 0 && starts && ["use", "const", "static", "type"].contains(&token.text) {
            // A function may be constant.
            ends_with_block = code.get(at + 1).is_some_and(|next| next.text == "fn");
            starts = false;
        }
        match token.text {
            _ if token.kind != Kind::Punctuation => {}
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => {
                depth = depth.saturating_sub(1);
                if depth == 0 && token.text == "}" && ends_with_block {
                    return at + 1;
                }
            }
            ";" if depth == 0 => return at + 1,
            _ => {}
        }
    }
    code.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts<'s>(tokens: &[Token<'s>]) -> Vec<&'s str> {
        tokens.iter().map(|token| token.text).collect()
    }

    #[test]
    fn strings_characters_and_lifetimes_are_told_apart() {
        let source = r##"f::<'a>('b', '\'', "c \" d", r#"e " f"#, b"g", 1.5e3, 0..n, r#type) // h"##;
        let all = tokens(source);
        let of = |kind| texts(&all.iter().filter(|token| token.kind == kind).copied().collect::<Vec<_>>());
        assert_eq!(
            of(Kind::Literal),
            ["'b'", r"'\''", r#""c \" d""#, "r#\"e \" f\"#", "b\"g\"", "1.5e3", "0"],
            "{all:?}"
        );
        assert_eq!((of(Kind::Lifetime), of(Kind::Comment)), (vec!["'a"], vec!["// h"]));
        assert_eq!(of(Kind::Word), ["f", "n", "r#type"]);
    }

    #[test]
    fn lines_are_counted_in_comments_and_strings() {
        let all = tokens("/* a\n /* b */ */ \"c\nd\"\n/// e\nf");
        assert_eq!(all.iter().map(|token| token.line).collect::<Vec<_>>(), [1, 2, 4, 5]);
        assert_eq!(all[2].kind, Kind::Documentation);
    }

    #[test]
    fn items_of_tests_are_no_code() {
        let source = "a; #[cfg(test)] #[x] mod t { fn b() { c[0]; } } d; #[cfg(test)] use e::{f}; g \
                      #[cfg(not(test))] h #[cfg(test)] const fn i() {} j";
        let code = code_outside_tests(&tokens(source));
        assert_eq!(texts(&code).concat(), "a;d;g#[cfg(not(test))]hj");
        assert!(code_outside_tests(&tokens("#![cfg(test)] a")).is_empty());
    }
}
