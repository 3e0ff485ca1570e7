//! Earlier spellings of fields and choices, which are still read, each with a warning that names the present one.

use super::cursor::{Cursor, Key};
use crate::Warning;
use crate::error::times;
use crate::excerpt::Position;

/// An earlier spelling of a field, or of a choice for a field.
struct Deprecated {
    /// Fields or choices that have the field.
    parents: &'static [&'static str],
    /// Field of the choice; `None` if the spelling is that of a field.
    choice_of: Option<&'static str>,
    old: &'static str,
    new: &'static str,
}

const DEPRECATED: [Deprecated; 9] = [
    field(&["quad", "disk", "light", "phong"], "shines", "emission_sides"),
    field(&["point"], "lamp_radius", "shadow_near"),
    field(&["settings"], "depth", "max_depth"),
    field(&["settings"], "roulette_from", "rr_start_depth"),
    field(&["object_space"], "least", "min_spp"),
    choice("integrator", "caustics", "path_caustics"),
    choice("accel", "wide", "bvh8"),
    choice("accel", "spheres", "sphere_tree"),
    choice("accel", "cylinders", "cylinder_tree"),
];

const fn field(parents: &'static [&'static str], old: &'static str, new: &'static str) -> Deprecated {
    Deprecated { parents, choice_of: None, old, new }
}

/// Spelling of a choice for a field of `settings`.
const fn choice(field: &'static str, old: &'static str, new: &'static str) -> Deprecated {
    Deprecated { parents: &["settings"], choice_of: Some(field), old, new }
}

/// Present spellings of a deprecated field: several if parents differ, none for all other words.
pub(super) fn present_spellings(old: &str) -> impl Iterator<Item = &'static str> {
    let deprecated = DEPRECATED.iter().filter(move |spelling| spelling.choice_of.is_none() && spelling.old == old);
    deprecated.map(|spelling| spelling.new)
}

/// Word after the colon that follows the key at this byte, and its byte; empty for a value that is not a word.
fn choice_after(text: &str, key: usize) -> (usize, &str) {
    let start = text[key..].find(':').map_or(text.len(), |colon| key + colon + 1);
    let value = text[start..].trim_start_matches(|c: char| c.is_whitespace() || c == '"');
    let end = value.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(value.len());
    (text.len() - value.len(), &value[..end])
}

/// True if the word occurs before or after a colon, or next to a comment, and not only as part of a longer word.
fn has_word(text: &str, word: &str) -> bool {
    let is_mark = |byte: u8| matches!(byte, b':' | b'/');
    text.match_indices(word).any(|(start, _)| {
        let (before, after) = (&text.as_bytes()[..start], &text.as_bytes()[start + word.len()..]);
        let is_part = |byte: Option<&u8>| byte.is_some_and(|&byte| byte.is_ascii_alphanumeric() || byte == b'_');
        let is_blank = |byte: &&u8| byte.is_ascii_whitespace() || **byte == b'"';
        let next = after.iter().find(|byte| !is_blank(byte));
        let last = before.iter().rfind(|byte| !is_blank(byte));
        !is_part(before.last())
            && !is_part(after.first())
            && [last, next].into_iter().flatten().any(|&byte| is_mark(byte))
    })
}

/// One warning per deprecated spelling in the sound text of a scene. `file` is named in them.
pub(super) fn warnings(text: &str, file: &str) -> Vec<Warning> {
    let mut found: [Option<(usize, usize)>; DEPRECATED.len()] = [None; DEPRECATED.len()];
    // Most scenes have none, and a search is faster than the scanner.
    if !DEPRECATED.iter().any(|spelling| has_word(text, spelling.old)) {
        return Vec::new();
    }
    Cursor::walk(text, text.len(), |cursor, name, at| {
        for (spelling, found) in DEPRECATED.iter().zip(&mut found) {
            let (at, word) = match spelling.choice_of {
                None => (at, name),
                Some(field) if field == name => choice_after(text, at),
                Some(_) => continue,
            };
            if word == spelling.old
                && matches!(cursor.container().last(), Some(Key::Name(parent)) if spelling.parents.contains(parent))
            {
                let (_, count) = found.get_or_insert((at, 0));
                *count += 1;
            }
        }
    });
    let warning = |(spelling, found): (&Deprecated, Option<(usize, usize)>)| {
        let (at, count) = found?;
        let Position { line, column } = Position::of(text, at);
        let message =
            format!("the spelling `{}` is deprecated: write `{}`{}", spelling.old, spelling.new, times(count));
        Some(Warning { place: format!("{file}:{line}:{column}"), message })
    };
    DEPRECATED.iter().zip(found).filter_map(warning).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{SceneFile, parse_json, parse_ron};

    /// A scene with all deprecated spellings, a rectangle with a depth, and a material named like a spelling.
    const OLD: &str = r#"(
    settings: (depth: 3, roulette_from: 2, adaptive: object_space(least: 2), integrator: depth),
    lights: [point(position: (0, 1, 0), lamp_radius: 0.5), quad(corner: (0, 1, 0), edges: ((1, 0, 0), (0, 0, 1)), shines: both)],
    materials: {"shines": phong(shines: front), "lamp": light(shines: both)},
    nodes: [(shape: rectangle(width: 1, depth: 2), material: "shines")],
)"#;

    fn with_new_spellings(text: &str) -> String {
        text.replace("shines: ", "emission_sides: ")
            .replace("lamp_radius", "shadow_near")
            .replace("(depth", "(max_depth")
            .replace("roulette_from", "rr_start_depth")
            .replace("least", "min_spp")
    }

    #[test]
    fn deprecated_spellings_are_read_with_a_warning_each() {
        let path = Path::new("s.ron");
        let old = parse_ron(OLD, path).expect("a scene");
        let new = parse_ron(&with_new_spellings(OLD), path).expect("a scene");
        let messages: Vec<String> = old.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(
            messages,
            [
                "s.ron:3:115: the spelling `shines` is deprecated: write `emission_sides` (3 times, this is the first)",
                "s.ron:3:41: the spelling `lamp_radius` is deprecated: write `shadow_near`",
                "s.ron:2:16: the spelling `depth` is deprecated: write `max_depth`",
                "s.ron:2:26: the spelling `roulette_from` is deprecated: write `rr_start_depth`",
                "s.ron:2:67: the spelling `least` is deprecated: write `min_spp`",
            ]
        );
        assert!(new.warnings.is_empty(), "{:?}", new.warnings);
        assert_eq!(SceneFile { warnings: Vec::new(), ..old }, new);
    }

    #[test]
    fn deprecated_choices_are_read_with_a_warning_each() {
        for (field, old, new, column) in [
            ("integrator", "caustics", "path_caustics", 36),
            ("accel", "wide", "bvh8", 31),
            ("accel", "spheres", "sphere_tree", 31),
            ("accel", "cylinders", "cylinder_tree", 31),
        ] {
            let ron = |choice: &str| format!("(nodes: [], settings: ({field}: {choice}))");
            let parsed = |text: &str| parse_ron(text, Path::new("s.ron")).expect("a scene");
            let (read, present) = (parsed(&ron(old)), parsed(&ron(new)));
            let messages: Vec<String> = read.warnings.iter().map(ToString::to_string).collect();
            let place = format!("s.ron:1:{column}");
            assert_eq!(messages, [format!("{place}: the spelling `{old}` is deprecated: write `{new}`")]);
            assert!(present.warnings.is_empty());
            assert_eq!(SceneFile { warnings: Vec::new(), ..read }, present);
            let json = format!(r#"{{"nodes": [], "settings": {{"{field}" : "{old}"}}}}"#);
            assert_eq!(parse_json(&json, Path::new("s.json")).expect("a scene").warnings.len(), 1);
        }
    }

    #[test]
    fn parts_of_words_are_no_words() {
        use super::has_word;
        for text in ["(depth: 3)", "{\"depth\" : 3}", "integrator:depth,", "depth/* c */: 3"] {
            assert!(has_word(text, "depth"), "{text}");
        }
        for text in ["max_depth: 3", "depths: 3", "(\"depth\", 3)", "depth of field, (fov: 3)", ""] {
            assert!(!has_word(text, "depth"), "{text}");
        }
    }

    #[test]
    fn json_and_ron_warn_alike() {
        let text = r#"{"nodes": [], "settings": {"depth": 3}, "materials": {"shines": {"phong": {"shines": "both"}}}}"#;
        let file = parse_json(text, Path::new("s.json")).expect("a scene");
        let places: Vec<&str> = file.warnings.iter().map(|warning| warning.place.as_str()).collect();
        assert_eq!(places, ["s.json:1:76", "s.json:1:28"]);
        assert!(parse_json(&file.to_json(), Path::new("s.json")).expect("a scene").warnings.is_empty());
    }
}
