//! Names in code: banned words in identifiers, and types of the same name in one crate.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    banned_words::{BANNED, ESTABLISHED, MAX_WORDS_OF_NAME, Scope},
    rust_tokens::{Kind, Token},
};

/// Identifiers with a banned word, and the terms to use.
pub(super) fn banned<'s>(tokens: &[Token<'s>]) -> BTreeMap<&'s str, (usize, &'static str)> {
    let (mut found, mut seen) = (BTreeMap::new(), BTreeSet::new());
    for token in tokens.iter().filter(|token| token.kind == Kind::Word) {
        if !seen.insert(token.text) {
            continue;
        }
        let words = words(token.text).join(" ");
        let words = ESTABLISHED.iter().fold(words, |words, established| words.replace(established, ""));
        let words: Vec<&str> = words.split_whitespace().collect();
        let is_checked = |scope: Scope| match scope {
            Scope::Prose => false,
            Scope::Names => words.len() <= MAX_WORDS_OF_NAME,
            Scope::Everywhere => true,
        };
        let hit = BANNED.iter().filter(|(_, _, scope)| is_checked(*scope)).find(|(banned, _, _)| {
            let sequence: Vec<&str> = banned.split(' ').collect();
            words.windows(sequence.len()).any(|window| window == sequence)
        });
        if let Some((_, instead, _)) = hit {
            found.insert(token.text, (token.line, *instead));
        }
    }
    found
}

/// Words of an identifier, in lower case.
fn words(identifier: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut after_lower = false;
    for c in identifier.chars() {
        if c == '_' || (c.is_uppercase() && after_lower) {
            words.push(String::new());
        }
        if c != '_' {
            words.last_mut().expect("never empty").extend(c.to_lowercase());
        }
        after_lower = c.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Types that the modules of a file declare; those within functions are left out.
pub(super) fn types<'s>(code: &[Token<'s>]) -> BTreeSet<&'s str> {
    let mut types = BTreeSet::new();
    // One entry per open brace: true if it is that of a module.
    let mut braces = Vec::new();
    let mut opens_module = false;
    for (at, token) in code.iter().enumerate() {
        match token.text {
            "{" => {
                braces.push(opens_module);
                opens_module = false;
            }
            "}" => {
                braces.pop();
            }
            "mod" => opens_module = true,
            ";" => opens_module = false,
            "struct" | "enum" | "union" | "trait" | "type" if braces.iter().all(|is_module| *is_module) => {
                types.extend(code.get(at + 1).filter(|name| name.kind == Kind::Word).map(|name| name.text));
            }
            _ => {}
        }
    }
    types
}

#[cfg(test)]
mod tests {
    use super::{super::rust_tokens::tokens, *};

    #[test]
    fn words_of_identifiers() {
        assert_eq!(words("NodeRef"), ["node", "ref"]);
        assert_eq!(words("OWN_BOX_PAD"), ["own", "box", "pad"]);
        assert_eq!(words("_own_boxes_in"), ["own", "boxes", "in"]);
    }

    #[test]
    fn banned_words_are_found_within_identifiers_alone() {
        let source = "fn lamp_at() { OwnBox; own_box_of; \"a lamp\"; at_least; lampshade; picture; f_of_a_picture_c; g_of_a_lamp_c } // lamp";
        let found: Vec<_> = banned(&tokens(source)).into_keys().collect();
        assert_eq!(found, ["OwnBox", "g_of_a_lamp_c", "lamp_at", "own_box_of", "picture"]);
    }

    #[test]
    fn types_of_modules_are_found_and_those_of_functions_are_not() {
        let source =
            "struct A; mod m { pub enum B {} fn f() { struct C; } impl D { type E = u8; } } trait F {} type G = A;";
        assert_eq!(types(&tokens(source)).into_iter().collect::<String>(), "ABFG");
    }
}
