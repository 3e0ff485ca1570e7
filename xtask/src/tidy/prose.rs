//! Words of comments and pages: how documentation opens, how long its sentences are, and which words it has.

use super::{
    banned_words::{BANNED, Scope},
    rust_tokens::{Kind, Token},
};

/// Openers of a relative clause where a noun or a verb should stand.
const OPENERS: [&str; 9] = ["What", "Where", "How", "Whether", "Who", "That", "Which", "Of", "As"];

const MAX_WORDS: usize = 25;

/// A line number, from 1, and text.
pub(super) type Line = (usize, String);

/// Comments of one kind that follow each other, without their markers.
pub(super) fn comment_blocks(tokens: &[Token<'_>], kind: Kind) -> Vec<Vec<Line>> {
    let mut blocks: Vec<Vec<Line>> = Vec::new();
    let mut marker = "";
    for token in tokens.iter().filter(|token| token.kind == kind) {
        let this = &token.text[..token.text.len().min(3)];
        let starts = token.text.trim_start_matches(['/', '*', '!']).strip_prefix(' ');
        let text = starts.unwrap_or_else(|| token.text.trim_start_matches(['/', '*', '!'])).to_owned();
        match blocks.last_mut() {
            Some(block) if block.last().is_some_and(|(line, _)| line + 1 == token.line) && this == marker => {
                block.push((token.line, text));
            }
            _ => blocks.push(vec![(token.line, text)]),
        }
        marker = this;
    }
    blocks
}

/// Lines of documentation that open with a relative clause.
pub(super) fn relative_openers(block: &[Line]) -> Vec<Line> {
    let opens = |text: &str| text.split_once(' ').is_some_and(|(first, _)| OPENERS.contains(&first));
    block
        .iter()
        .filter(|(_, text)| opens(text))
        .map(|(line, text)| (*line, format!("opens with a clause: {text}")))
        .collect()
}

/// Sentences of documentation or of a page that are too long; tables and headings are left out.
pub(super) fn long_sentences(block: &[Line]) -> Vec<Line> {
    let mut found = Vec::new();
    for (line, paragraph) in paragraphs(block) {
        if paragraph.starts_with(['|', '#']) {
            continue;
        }
        for sentence in sentences(&without_code(&paragraph)) {
            let words = sentence.split_whitespace().filter(|word| word.chars().any(char::is_alphanumeric)).count();
            if words > MAX_WORDS {
                found.push((line, format!("{words} words in a sentence: {}", sentence.trim())));
            }
        }
    }
    found
}

/// Banned words of a comment or a page.
pub(super) fn banned(block: &[Line]) -> Vec<Line> {
    let mut found = Vec::new();
    for (line, paragraph) in paragraphs(block) {
        let text = without_code(&paragraph).to_lowercase();
        let words: Vec<&str> =
            text.split(|c: char| !c.is_alphanumeric() && !"-'’".contains(c)).filter(|word| !word.is_empty()).collect();
        for (banned, instead, _) in BANNED.iter().filter(|(_, _, scope)| *scope != Scope::Names) {
            let sequence: Vec<&str> = banned.split(' ').collect();
            let times = words.windows(sequence.len()).filter(|window| *window == sequence).count();
            found.extend(std::iter::repeat_n((line, format!("\"{banned}\": rather {instead}")), times));
        }
    }
    found
}

/// Paragraphs, list items and rows of tables, each in one line; blocks of code are left out.
fn paragraphs(block: &[Line]) -> Vec<Line> {
    let mut paragraphs: Vec<Line> = Vec::new();
    let (mut is_code, mut is_open) = (false, false);
    for (line, text) in block {
        let text = text.trim();
        if text.starts_with("```") {
            is_code = !is_code;
        }
        let is_item = text.starts_with(['|', '#', '-', '*'])
            || text.trim_start_matches(|c: char| c.is_ascii_digit()).starts_with(". ") && !text.starts_with('.');
        match paragraphs.last_mut() {
            _ if is_code || text.is_empty() || text.starts_with("```") => is_open = false,
            Some((_, paragraph)) if is_open && !is_item => {
                paragraph.push(' ');
                paragraph.push_str(text);
            }
            _ => {
                paragraphs.push((*line, text.to_owned()));
                is_open = true;
            }
        }
    }
    paragraphs
}

/// Text with one word for each piece of code, and without the targets of links.
fn without_code(text: &str) -> String {
    let mut plain = String::new();
    for (number, piece) in text.split('`').enumerate() {
        plain.push_str(if number % 2 == 0 { piece } else { "X" });
    }
    let mut short = String::new();
    let mut rest = plain.as_str();
    while let Some(at) = rest.find("](") {
        short.push_str(&rest[..=at]);
        rest = rest[at..].split_once(')').map_or("", |(_, after)| after);
    }
    short + rest
}

/// Pieces that end with a full stop and are followed by a capital, a digit or the end.
fn sentences(text: &str) -> Vec<&str> {
    let mut sentences = Vec::new();
    let mut start = 0;
    for (at, mark) in text.match_indices(['.', '?', '!']) {
        let after = text[at + mark.len()..].trim_start_matches([')', '"', '*', '_', '”']);
        let next = after.trim_start();
        let ends = next.is_empty() || (after.len() > next.len() && !next.starts_with(char::is_lowercase));
        if ends {
            sentences.push(&text[start..=at]);
            start = at + mark.len();
        }
    }
    sentences.push(&text[start..]);
    sentences
}

#[cfg(test)]
mod tests {
    use super::{super::rust_tokens::tokens, *};

    fn documentation(source: &str) -> Vec<Vec<Line>> {
        comment_blocks(&tokens(source), Kind::Documentation)
    }

    #[test]
    fn an_opener_is_found_at_the_start_of_a_line() {
        let blocks = documentation("//! Offsets.\n\n/// What is left.\n/// Where it is.\nfn a() {}\n/// Whatever.\n");
        let found: Vec<usize> = blocks.iter().flat_map(|block| relative_openers(block)).map(|(line, _)| line).collect();
        assert_eq!(found, [3, 4]);
    }

    #[test]
    fn sentences_are_counted_across_lines_and_code_is_one_word() {
        let words = |count: usize| "word ".repeat(count);
        let long = |text: &str| {
            documentation(&format!("/// {text}\n/// end. Next.\nfn a() {{}}"))
                .iter()
                .map(|b| long_sentences(b).len())
                .sum::<usize>()
        };
        assert_eq!(long(&words(24)), 0);
        assert_eq!(long(&words(25)), 1);
        assert_eq!(long(&format!("{}`a b c d` [x](https://a.b c)", words(22))), 0);
        assert_eq!(long(&format!("{}e.g. {}", words(12), words(13))), 1);
        assert_eq!(long(&format!("{}one. A {}", words(12), words(13))), 0);
        assert_eq!(long(&format!("```text\n/// {}\n/// ```\n/// ", words(40))), 0);
    }

    #[test]
    fn a_sentence_of_a_page_has_at_most_25_words() {
        let page = |words: usize| {
            let sentence = "word ".repeat(words);
            let table = "word ".repeat(30);
            let text = format!("# Page\n\n* {sentence}\n  end. Next.\n\n| {table} |\n\n```sh\n{table}\n```\n");
            text.lines().zip(1..).map(|(text, line)| (line, text.to_owned())).collect::<Vec<Line>>()
        };
        assert_eq!(long_sentences(&page(24)), []);
        let found = long_sentences(&page(25));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].0, 3);
        assert!(found[0].1.starts_with("26 words"), "{}", found[0].1);
    }

    #[test]
    fn banned_words_are_whole_words_outside_of_code() {
        let block = |text: &str| vec![(1, text.to_owned())];
        assert_eq!(banned(&block("a lamp, Lamp; `lamp` lampshade")).len(), 2);
        // Names of cases are no words.
        assert_eq!(banned(&block("lights with, lamp-in-glass")).len(), 0);
        assert_eq!(banned(&[(1, "lights with".to_owned()), (2, "extent".to_owned())]).len(), 1);
    }
}
